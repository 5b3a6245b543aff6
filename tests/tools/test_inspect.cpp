// SPDX-License-Identifier: Apache-2.0
// seaway-inspect as its users meet it: a process with flags, streams and an exit status.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "sea/scene/scene.h"
#include "sea/scene/scene_names.h"
#include "sea/waves/statistics/moments.h"
#include "tests/sea/csv.h"
#include "tests/support/program.h"
#include "tests/support/read_file.h"
#include "tests/tools/inspect_json.h"

namespace seaway {
namespace {

using nlohmann::json;
using testing::report_of;
using testing::Table;
using tests::folder;
using tests::Output;
using tests::run_program;

const std::string gale = std::string(SEAWAY_SOURCE_DIR) + "/scenes/north_sea_gale.toml";

/// S(w) as the program prints it.
double density_of(const std::string& scene, double omega) {
    const Output output =
        run_program("seaway-inspect", fmt::format("{} --spectrum {:.17g}", scene, omega));
    EXPECT_EQ(output.status, 0) << output.err;
    std::istringstream lines(output.out);
    std::string header, row;
    std::getline(lines, header);
    std::getline(lines, row);
    EXPECT_EQ(header, "omega_radps,s_m2s");
    const auto comma = row.find(',');
    EXPECT_EQ(std::strtod(row.c_str(), nullptr), omega);
    return comma == std::string::npos ? NAN : std::strtod(row.c_str() + comma + 1, nullptr);
}

std::string swell_scene(const std::string& spectrum, double height, double period, double gamma) {
    return folder().write(
        "swell.toml",
        fmt::format("[sea]\n[[sea.system]]\ntype = \"swell\"\nspectrum = \"{}\"\n"
                    "significant_height_m = {}\npeak_period_s = {:.17g}\n{}"
                    "from_deg = 270\n",
                    spectrum, height, period,
                    spectrum == "jonswap" ? fmt::format("gamma = {}\n", gamma) : std::string()));
}

TEST(Inspect, json_report_holds_what_the_design_promises) {
    const json report = report_of(gale);
    for (const char* part : {"requested", "realised"})
        for (const char* key :
             {"hs_m", "tp_s", "tz_s", "tm01_s", "mean_from_deg", "spread_deg", "mss"})
            EXPECT_TRUE(report.at(part).at(key).is_number()) << part << '.' << key;
    ASSERT_EQ(report.at("cascades").size(), 3u);
    for (const char* key : {"length_m", "size", "k_lo_radpm", "k_hi_radpm", "requested_m2",
                            "realised_m2", "hs_scatter_expected"})
        EXPECT_TRUE(report.at("cascades").at(0).at(key).is_number()) << key;
    EXPECT_TRUE(report.at("warnings").is_array());
}

TEST(Inspect, names_the_sea_state_of_wmo_code_table_3700) {
    const json report = report_of(gale); // Hs 6.6 m: 6 .. 9 m are high
    EXPECT_EQ(report.at("wmo_sea_state").at("code"), 7);
    EXPECT_EQ(report.at("wmo_sea_state").at("name"), "high");
    EXPECT_NE(run_program("seaway-inspect", gale).out.find("WMO sea state 7: high\n"),
              std::string::npos);
}

TEST(Inspect, says_which_foam_a_sea_has_and_by_which_wind) {
    const json foam = report_of(gale).at("foam");
    EXPECT_NEAR(foam.at("mean_coverage").get<double>(), 0.0445, 0.0001);
    EXPECT_TRUE(foam.at("threshold").is_number());
    EXPECT_EQ(foam.at("observed").at("wind_speed_10m_mps"), 19.0);
    EXPECT_TRUE(foam.at("observed").at("wind_is_given").get<bool>());
    EXPECT_NE(foam.at("says").get<std::string>().find("4.45 % at 19 m/s"), std::string::npos);
    const std::string scenes = SEAWAY_SOURCE_DIR "/scenes/";
    const json crossing = report_of(scenes + "crossing_seas.toml").at("foam");
    EXPECT_FALSE(crossing.at("observed").at("wind_is_given").get<bool>());
    EXPECT_GT(crossing.at("mean_coverage").get<double>(), 0.005);
    const json by_hand = report_of(scenes + "gerstner_toy.toml").at("foam");
    EXPECT_EQ(by_hand.at("mean_coverage"), 0.0);
    EXPECT_TRUE(by_hand.at("threshold").is_null());
    EXPECT_NE(by_hand.at("says").get<std::string>().find("by hand"), std::string::npos);
    EXPECT_TRUE(report_of(scenes + "calm.toml").at("foam").is_null()) << "not allowed there";
}

TEST(Inspect, json_report_is_what_the_library_computes) {
    const json report = report_of(gale);
    const Result<sea::Scene> scene = sea::read_scene(gale);
    ASSERT_TRUE(scene);
    const Result<sea::Realization> realization = realize(*scene);
    ASSERT_TRUE(realization);
    const sea::SeaSummary summary = summarize(scene->sea, *realization);
    const auto check = [](const json& part, const sea::SeaStatistics& s) {
        // JSON carries doubles in full: nothing may differ.
        EXPECT_EQ(part.at("hs_m"), s.significant_height_m);
        EXPECT_EQ(part.at("tp_s"), s.peak_period_s);
        EXPECT_EQ(part.at("tz_s"), s.zero_crossing_period_s);
        EXPECT_EQ(part.at("tm01_s"), s.mean_period_s);
        EXPECT_EQ(part.at("mean_from_deg"), sea::bearing_from_towards(s.mean_towards_rad));
        EXPECT_EQ(part.at("spread_deg"), s.spread_rad * (180.0 / sea::pi));
        EXPECT_EQ(part.at("mss"), s.mean_square_slope);
    };
    check(report.at("requested"), summary.requested);
    check(report.at("realised"), summary.realised);
}

TEST(Inspect, the_text_says_what_the_json_says_requested_and_realised) {
    const Output text = run_program("seaway-inspect", gale);
    ASSERT_EQ(text.status, 0) << text.err;
    const json report = report_of(gale);
    const std::pair<const char*, const char*> rows[] = {{"significant height Hs", "hs_m"},
                                                        {"peak period Tp", "tp_s"},
                                                        {"zero-crossing period Tz", "tz_s"},
                                                        {"mean period Tm01", "tm01_s"},
                                                        {"mean direction, from", "mean_from_deg"},
                                                        {"directional spread", "spread_deg"},
                                                        {"mean square slope", "mss"}};
    for (const auto& [name, key] : rows) {
        const std::size_t row = text.out.find(std::string("\n") + name);
        ASSERT_NE(row, std::string::npos) << name;
        double requested = 0, realised = 0;
        const std::string numbers = text.out.substr(row + 1 + 28, 24);
        ASSERT_EQ(std::sscanf(numbers.c_str(), "%lf %lf", &requested, &realised), 2) << numbers;
        const double asked = report["requested"][key], made = report["realised"][key];
        // Four digits are printed.
        const double rounding = 0.51 * std::pow(10.0, std::floor(std::log10(made)) - 3);
        EXPECT_NEAR(requested, asked, rounding) << name;
        EXPECT_NEAR(realised, made, rounding) << name;
        EXPECT_GT(std::abs(asked - made), 2 * rounding) << name << ": told apart";
    }
}

TEST(Inspect, variances_of_cascades_and_losses_add_up_to_the_whole) {
    const json report = report_of(gale);
    double carried = 0.0;
    double realised = 0.0;
    for (const json& cascade : report.at("cascades")) {
        carried += cascade.at("requested_m2").get<double>();
        realised += cascade.at("realised_m2").get<double>();
    }
    const json& variance = report.at("variance");
    const double whole = variance.at("requested_m2");
    const double lost = variance.at("lost_longer_m2").get<double>() +
                        variance.at("lost_shorter_m2").get<double>() +
                        variance.at("lost_fade_m2").get<double>();
    // Quadratures of the same spectrum with different ends: they agree to about 1e-9.
    EXPECT_NEAR(carried + lost, whole, 1e-6 * whole);
    EXPECT_NEAR(realised, variance.at("realised_m2").get<double>(), 1e-12 * realised);
    EXPECT_NEAR(std::pow(report.at("realised").at("hs_m").get<double>() / 4.0, 2), realised,
                1e-12 * realised);
}

TEST(Inspect, realised_height_lies_within_four_predicted_deviations_of_the_request) {
    const json report = report_of(gale);
    const double scatter = report.at("hs_scatter_expected");
    const double requested = report.at("requested").at("hs_m");
    const double realised = report.at("realised").at("hs_m");
    EXPECT_GT(scatter, 0.005);
    // The seed is fixed, so this passes or fails once for all; 4 deviations miss one seed in 16000.
    EXPECT_LT(std::abs(realised / requested - 1.0), 4.0 * scatter);
}

TEST(Inspect, small_tile_is_warned_of_with_the_scatter_of_hs) {
    const std::string scene = folder().write(
        "small.toml", "[sea]\nseed = 3\n[[sea.system]]\ntype = \"swell\"\nsignificant_height_m = "
                      "2\npeak_period_s = 15\nfrom_deg = 0\n[[cascade]]\nlength_m = 700\nsize = "
                      "256\n");
    const json report = report_of(scene);
    bool found = false;
    for (const json& warning : report.at("warnings"))
        found |= warning.get<std::string>().find("peak wavelengths") != std::string::npos &&
                 warning.get<std::string>().find("scatters by") != std::string::npos;
    EXPECT_TRUE(found);
    const Output text = run_program("seaway-inspect", scene);
    EXPECT_NE(text.out.find("warning: the largest cascade"), std::string::npos);
}

// The server says it when it starts; who looks before wants to know too.
TEST(Inspect, foam_that_no_threshold_makes_as_much_as_is_observed_is_warned_of) {
    const auto warned = [](const std::string& foam) {
        const json report = report_of(folder().write(
            "foam.toml",
            "[sea]\nseed = 3\n[[sea.system]]\ntype = \"wind\"\nspectrum = \"jonswap\"\n"
            "wind_speed_10m_mps = 20\nfetch_m = 300e3\nfrom_deg = 0\nspreading = "
            "\"hasselmann\"\n[[cascade]]\nlength_m = 2000\nsize = 128\n" +
                foam));
        bool found = false;
        for (const json& warning : report.at("warnings"))
            found |= warning.get<std::string>().find("no threshold") != std::string::npos;
        return found;
    };
    EXPECT_TRUE(warned("[foam]\ngain_per_s = 1e-4\n"));
    EXPECT_FALSE(warned("[foam]\ngain_per_s = 1e-4\n[effects]\nfoam = false\n"));
    EXPECT_FALSE(warned(""));
}

TEST(Inspect, flat_sea_is_all_zeros_and_valid_json) {
    const json report = report_of(folder().write("calm.toml", "[sea]\nseed = 1\n"));
    EXPECT_EQ(report.at("requested").at("hs_m"), 0.0);
    EXPECT_EQ(report.at("realised").at("tp_s"), 0.0);
    EXPECT_TRUE(report.at("depth_m").is_null()); // infinite
}

/// A swell with one more line under [sea], on tiles that hold its tail.
std::string swell_with(const std::string& line) {
    return folder().write("controls.toml",
                          "[sea]\nseed = 5\n" + line +
                              "\n[[sea.system]]\ntype = \"swell\"\nsignificant_height_m = 2\n"
                              "peak_period_s = 6\nfrom_deg = 200\n[[cascade]]\nlength_m = 512\n"
                              "size = 256\n[[cascade]]\nlength_m = 101\nsize = 256\n");
}

const std::string one_change = "[[weather]]\nat_s = 3600\nset = { sea.depth_m = 20 }\n";

TEST(Inspect, a_sea_that_changes_is_reported_as_it_begins_with_a_warning) {
    const json warnings =
        report_of(folder().write("changes.toml", "[sea]\n" + one_change)).at("warnings");
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_NE(warnings[0].get<std::string>().find("[[weather]]: from 3600 s on"),
              std::string::npos);
}

TEST(Inspect, height_scale_multiplies_heights) {
    const json plain = report_of(swell_with(""));
    const json scaled = report_of(swell_with("height_scale = 1.5"));
    for (const char* part : {"requested", "realised"}) {
        const double ratio =
            scaled.at(part).at("hs_m").get<double>() / plain.at(part).at("hs_m").get<double>();
        EXPECT_NEAR(ratio, 1.5, 1e-9) << part;
    }
}

TEST(Inspect, T19_short_wave_fade_acts_on_the_spectrum_and_is_reported_as_lost) {
    const double fade_m = 1.3;
    const json plain = report_of(swell_with(""));
    const json faded = report_of(swell_with(fmt::format("short_wave_fade_m = {}", fade_m)));
    // Deep water, k = w^2/g but for surface tension (1e-5 here): what exp(-(kl)^2) leaves of S,
    // summed by the trapezoid rule over the program's own S(w).
    std::string list;
    const double step = 0.01;
    for (double omega = 0.3; omega < 12.0; omega += step)
        list += fmt::format("{}{:.17g}", list.empty() ? "" : ",", omega);
    const Output rows = run_program("seaway-inspect", swell_with("") + " --spectrum " + list);
    std::istringstream lines(rows.out);
    std::string line;
    std::getline(lines, line);
    double kept = 0.0;
    double whole = 0.0;
    while (std::getline(lines, line)) {
        const double omega = std::strtod(line.c_str(), nullptr);
        const double density = std::strtod(line.c_str() + line.find(',') + 1, nullptr);
        const double kl = omega * omega / 9.81 * fade_m;
        kept += density * std::exp(-kl * kl) * step;
        whole += density * step;
    }
    const json& variance = faded.at("variance");
    // What lies beyond the finest band is counted there. The trapezoid rule and the tail beyond
    // 12 rad/s cost about 1e-4 of the variance.
    const double lost =
        variance.at("lost_fade_m2").get<double>() + variance.at("lost_shorter_m2").get<double>();
    EXPECT_NEAR(lost, whole - kept, 3e-4 * whole);
    EXPECT_GT(whole - kept, 0.02 * whole);
    const double realised = faded.at("variance").at("realised_m2").get<double>() /
                            plain.at("variance").at("realised_m2").get<double>();
    // The same numbers were drawn, so only how they fall on the faded waves differs.
    EXPECT_NEAR(realised, kept / whole, 0.02);
}

TEST(Inspect, cut_offs_leave_out_what_lies_beyond_them) {
    const json cut =
        report_of(swell_with("wavenumber_min_radpm = 0.08\nwavenumber_max_radpm = 0.3"));
    const json plain = report_of(swell_with(""));
    // omega^2 = g k: 0.886 and 1.716 rad/s bound what is left.
    EXPECT_GT(cut.at("realised").at("tz_s").get<double>(), sea::two_pi / 1.72);
    EXPECT_LT(cut.at("realised").at("tz_s").get<double>(), sea::two_pi / 0.885);
    EXPECT_LT(cut.at("realised").at("hs_m").get<double>(),
              plain.at("realised").at("hs_m").get<double>());
    EXPECT_GT(cut.at("variance").at("lost_fade_m2").get<double>(), 0.0);
    double carried = 0.0;
    for (const json& cascade : cut.at("cascades"))
        carried += cascade.at("requested_m2").get<double>();
    const Result<sea::Scene> scene = sea::read_scene(swell_with(""));
    ASSERT_TRUE(scene);
    const sea::Dispersion dispersion = scene->sea.dispersion();
    const double between =
        requested_variance(scene->sea, dispersion.omega(0.08), dispersion.omega(0.3));
    // A quadrature panel that the cut-off crosses resolves it to about its width, 12 %/32 of w.
    EXPECT_NEAR(carried / between, 1.0, 0.02);
}

TEST(Inspect, spectrum_equals_the_published_values_of_xdyn) {
    const Table published("P01_xdyn_spectra");
    const Table integrals("D05_jonswap_integrals");
    const double exact = integrals.number(integrals.find("3.3"), "A_gamma_exact=1/(5 I0)");
    for (std::size_t row = 0; row < published.size(); ++row) {
        const bool jonswap = published.text(row, "spectrum") == "jonswap";
        const double gamma = published.number(row, "gamma");
        const std::string scene =
            swell_scene(jonswap ? "jonswap" : "bretschneider", published.number(row, "Hs_m"),
                        published.number(row, "Tp_s"), gamma);
        // xdyn normalises by DNV's fit of the factor that we integrate.
        const double convention = jonswap ? exact / (1.0 - 0.287 * std::log(gamma)) : 1.0;
        const double expected = published.number(row, "S_m2s_rad") * convention;
        // The table's own tolerance, or the 12 digits of D05.
        EXPECT_NEAR(density_of(scene, published.number(row, "omega_rad_s")), expected,
                    published.number(row, "abs_tol") + 1e-11 * expected)
            << "row " << row;
    }
}

TEST(Inspect, pierson_moskowitz_scene_has_the_closed_form_heights_and_periods) {
    const Table closed("D04_pm_closed_form");
    for (std::size_t row = 0; row < closed.size(); ++row) {
        const double wind = closed.number(row, "U19.5=1.026U10");
        const std::string scene = folder().write(
            "pm.toml",
            fmt::format("[sea]\n[[sea.system]]\ntype = \"wind\"\nspectrum = "
                        "\"pierson_moskowitz\"\nwind_speed_19m5_mps = {}\nfrom_deg = 0\n",
                        wind));
        const json requested = report_of(scene).at("requested");
        // Quadrature ends at 1000 peaks: 1e-12 of m0, 1e-6 of m2; the peak is found on a grid of
        // 5e-4.
        EXPECT_NEAR(requested.at("hs_m").get<double>() / closed.number(row, "Hs_m"), 1.0, 1e-8);
        EXPECT_NEAR(requested.at("tz_s").get<double>() / closed.number(row, "Tz_s"), 1.0, 1e-6);
        EXPECT_NEAR(requested.at("tm01_s").get<double>() / closed.number(row, "Tm01_s"), 1.0, 1e-6);
        EXPECT_NEAR(requested.at("tp_s").get<double>() / closed.number(row, "Tp_s"), 1.0, 5e-4);
        const double g = 9.81;
        const double omega = 1.3 * closed.number(row, "omega_p");
        const double expected = 8.1e-3 * g * g * std::pow(omega, -5) *
                                std::exp(-0.74 * std::pow(g / (wind * omega), 4));
        EXPECT_NEAR(density_of(scene, omega) / expected, 1.0, 1e-9); // U10 and back: rounding
    }
}

TEST(Inspect, spectrum_prints_one_row_a_frequency_and_sums_the_systems) {
    const std::string system = "[[sea.system]]\ntype = \"swell\"\nsignificant_height_m = 2\n"
                               "peak_period_s = 9\nfrom_deg = 10\n";
    const std::string one = folder().write("one.toml", "[sea]\n" + system);
    const std::string two = folder().write("two.toml", "[sea]\n" + system + system);
    EXPECT_EQ(density_of(two, 0.8), 2.0 * density_of(one, 0.8));
    const Output output = run_program("seaway-inspect", one + " --spectrum 0,0.5,1e3");
    EXPECT_EQ(std::count(output.out.begin(), output.out.end(), '\n'), 4);
    EXPECT_NE(output.out.find("\n0,0\n"), std::string::npos); // S(0) = 0, not NaN
}

TEST(Inspect, plot_is_a_png_of_1200_by_700) {
    const std::string path = folder().file("gale.png");
    const Output output = run_program("seaway-inspect", gale + " --plot " + path);
    EXPECT_EQ(output.status, 0) << output.err;
    const std::string png = tests::read_file(path);
    ASSERT_GT(png.size(), 30000u); // a blank picture packs into a tenth of that
    EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
    const auto number_at = [&png](std::size_t at) {
        int value = 0;
        for (std::size_t i = at; i < at + 4; ++i)
            value = value << 8 | static_cast<unsigned char>(png[i]);
        return value;
    };
    EXPECT_EQ(number_at(16), 1200);
    EXPECT_EQ(number_at(20), 700);
}

TEST(Inspect, help_and_version_go_to_stdout) {
    const Output help = run_program("seaway-inspect", "--help");
    EXPECT_EQ(help.status, 0);
    for (const char* flag : {"--format", "--spectrum", "--eval", "--plot"})
        EXPECT_NE(help.out.find(flag), std::string::npos) << flag;
    const Output version = run_program("seaway-inspect", "--version");
    EXPECT_EQ(version.status, 0);
    EXPECT_EQ(version.out.find("seaway-inspect " SEAWAY_VERSION " (protocol "), 0u) << version.out;
}

struct BadUse {
    const char* what;
    std::string arguments;
    std::string expected; ///< somewhere in the line on stderr
};

TEST(Inspect, every_mistake_is_one_line_on_stderr_and_exit_status_2) {
    const std::string broken = folder().write("broken.toml", "[sea]\nseed = = 3\n");
    const std::string unknown = folder().write("unknown.toml", "[sea]\nseed = 1\nsede = 2\n");
    const std::string range = folder().write("range.toml", "[sea]\ndepth_m = -5\n");
    const std::string words = folder().write("words.csv", "x_m,y_m,t_s\n1,2,3\n\nnorth,2,3\n");
    const std::string two = folder().write("two.csv", "1,2\n");
    const std::string four = folder().write("four.csv", "1,2,3\n1,2,3,4\n");
    const std::string nan = folder().write("nan.csv", "0,nan,0\n");
    const std::string late = folder().write("late.csv", "0,0,1e300\n");
    const std::string header = folder().write("header.csv", "x,y,t\n0,0,0\n");
    const std::string changing = folder().write("changing.toml", "[sea]\n" + one_change);
    const BadUse uses[] = {
        {"no scene", "", "scene"},
        {"missing scene", folder().file("none.toml"), "none.toml"},
        {"a folder", folder().file(""), "cannot read scene"},
        {"broken TOML", broken, "broken.toml:2:"},
        {"unknown key", unknown, "unknown.toml:3: sea.sede"},
        {"out of range", range, "range.toml:2: sea.depth_m"},
        {"unknown flag", gale + " --loud", "--loud"},
        {"unknown format", gale + " --format xml", "xml"},
        {"negative frequency", gale + " --spectrum 1,-1", "1,-1"},
        {"empty list", gale + " --spectrum ''", "--spectrum"},
        {"no name for the plot", gale + " --plot ''", "--plot"},
        {"a plot of another kind", gale + " --plot " + folder().file("x.jpg"), "ends in .png"},
        {"no points", gale + " --eval ''", "--eval"},
        {"a form of points", gale + " --format json --eval -", "--format"},
        {"a picture before nonsense", gale + " --plot /nowhere/p.png --spectrum abc", "--spectrum"},
        {"no time", gale + " --images " + folder().file("i") + " --time nan", "--time"},
        {"no frequency", gale + " --spectrum 1,,2", "1,,2"},
        {"word for a frequency", gale + " --spectrum peak", "peak"},
        {"missing points", gale + " --eval " + folder().file("none.csv"), "none.csv"},
        {"words for points", gale + " --eval " + words, "words.csv:4: x_m = 'north'"},
        {"two fields", gale + " --eval " + two, "two.csv:1:"},
        {"four fields", gale + " --eval " + four, "four.csv:2:"},
        {"not a number", gale + " --eval " + nan, "nan.csv:1: y_m"},
        {"end of time", gale + " --eval " + late, "late.csv:1: t_s"},
        {"another header", gale + " --eval " + header, "header.csv:1: x_m = 'x'"},
        {"two outputs", gale + " --eval - --spectrum 1", "--"},
        {"points and pictures", gale + " --eval - --images " + folder().file("i"), "--images"},
        {"a sea that changes at a point", changing + " --eval -", "[[weather]]"},
        {"a sea that changes, drawn", changing + " --images " + folder().file("i"), "[[weather]]"},
        {"no place for the plot", gale + " --plot " + folder().file("no/where.png"), "where.png"},
    };
    for (const BadUse& use : uses) {
        const Output output = run_program("seaway-inspect", use.arguments);
        EXPECT_EQ(output.status, 2) << use.what;
        EXPECT_EQ(output.error_lines(), 1) << use.what << ": " << output.err;
        EXPECT_EQ(output.out, "") << use.what;
        EXPECT_NE(output.err.find(use.expected), std::string::npos)
            << use.what << ": " << output.err;
    }
}

} // namespace
} // namespace seaway
