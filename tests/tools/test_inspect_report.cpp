// SPDX-License-Identifier: Apache-2.0
// seaway-inspect's report: every figure in it is the one that stands under its name in the library, in
// seas where no two figures are equal.
#include <gtest/gtest.h>

#include <cmath>
#include <regex>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "sea/certificate/certificate.h"
#include "sea/foam/foam_law.h"
#include "sea/scene/scene.h"
#include "sea/scene/scene_names.h"
#include "sea/scene/scene_warnings.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/waves/statistics/moments.h"
#include "tests/support/program.h"
#include "tests/tools/inspect_json.h"

namespace seaway {
namespace {

using nlohmann::json;
using testing::report_of;
using tests::folder;
using tests::Output;
using tests::run_program;

constexpr double degrees = 180.0 / sea::pi;

/// A wind sea and a swell in shallow water, with losses of all three kinds and foam of a given law.
const std::string crossing = R"(
[sea]
seed = 7
depth_m = 35
choppiness = [1.1, 0.7]
short_wave_fade_m = 0.3
[[sea.system]]
type = "wind"
wind_speed_10m_mps = 14
from_deg = 200
fetch_m = 80e3
[[sea.system]]
type = "swell"
significant_height_m = 1.7
peak_period_s = 15
from_deg = 110
gamma = 5
[[cascade]]
length_m = 151
size = 64
[[cascade]]
length_m = 29
size = 64
[[cascade]]
length_m = 7
size = 32
[foam]
threshold = 0.8
decay_s = 7
gain_per_s = 0.3
bias = 0.02
[accuracy]
height_error_m = 0.05
certificate = "crossing.json"
)";

/// Deep water, a measured spectrum with its peak in a bin, and foam as it is observed.
const std::string measured = R"(
[sea]
seed = 8
[[sea.system]]
type = "measured"
from_deg = 310
data = """
f_hz,df_hz,s_m2_hz
0.08,0.02,2.0
0.10,0.02,11.0
0.12,0.02,6.0
0.14,0.02,2.5
0.16,0.02,1.0
"""
[[cascade]]
length_m = 700
size = 64
)";

/// A scene with what the library computes of it.
struct Seen {
    sea::Scene scene;
    sea::Realization sea;
    sea::SeaSummary summary;
    sea::ErrorBudget budget;
    sea::FoamLawPtr foam;
    sea::CertificatePtr certificate;
    std::string path;
};

Seen see(const std::string& name, const std::string& text) {
    Seen seen;
    seen.path = folder().write(name, text);
    seen.scene = sea::read_scene(seen.path).value();
    seen.sea = sea::realize(seen.scene).value();
    seen.summary = summarize(seen.scene.sea, seen.sea);
    seen.budget = plan_budget(seen.sea, seen.scene.accuracy.height_error_m);
    seen.foam = sea::foam_law_of(seen.scene, seen.sea);
    const Result<sea::CertificatePtr> certificate = sea::load_certificate(seen.scene);
    EXPECT_TRUE(certificate) << certificate.error().message;
    seen.certificate = certificate ? *certificate : nullptr;
    return seen;
}

/// Writes the certificate of `crossing`, which holds there or, of another wind, does not.
void certify(double wind_speed_10m_mps) {
    folder().write("crossing.json", "{}");
    sea::Scene scene = sea::parse_scene(crossing, "crossing.toml", ".").value();
    const sea::SeaSummary summary = summarize(scene.sea, sea::realize(scene).value());
    sea::Certificate c;
    c.cascades = scene.cascades;
    c.height_error_m = scene.accuracy.height_error_m;
    c.configuration_hash = configuration_hash(scene);
    c.spectrum_hash = spectrum_hash(scene);
    sea::SeaPoint point = sea_point(scene, summary.requested);
    point.wind_speed_10m_mps = wind_speed_10m_mps;
    c.envelope = sea::envelope_of(point);
    c.promised_m = 0.07;
    c.percentile = 97;
    c.measured = {{.sea = "as given",
                   .seed = 3,
                   .hs_m = 2.5,
                   .rms_m = 0.011,
                   .p99_m = 0.031,
                   .max_m = 0.047,
                   .waves_left_out_m = 0.013,
                   .total_rms_m = 0.017,
                   .total_m = 0.053,
                   .slope_rms = 0.03}};
    c.machine = "a machine";
    c.commit = "0123abc";
    c.date_utc = "2024-02-03";
    folder().write("crossing.json", to_json(c));
}

json expected_statistics(const sea::SeaStatistics& s) {
    return {{"hs_m", s.significant_height_m},
            {"tp_s", s.peak_period_s},
            {"tz_s", s.zero_crossing_period_s},
            {"tm01_s", s.mean_period_s},
            {"mean_from_deg", sea::bearing_from_towards(s.mean_towards_rad)},
            {"spread_deg", s.spread_rad * degrees},
            {"mss", s.mean_square_slope}};
}

double m0(const sea::SeaStatistics& s) {
    return std::pow(s.significant_height_m, 2) / 16;
}

/// Cascades are drawn apart from each other: their variances of m0 add up, and Hs is 4 sqrt(m0).
double hs_scatter(const Seen& seen) {
    double variance = 0, whole = 0;
    for (const sea::CascadeVariance& c : seen.summary.cascades) {
        variance += std::pow(c.expected_scatter * c.requested_m2, 2);
        whole += c.requested_m2;
    }
    return std::sqrt(variance) / whole;
}

json expected_report(const Seen& seen, bool certificate_holds) {
    const sea::SeaSummary& s = seen.summary;
    json cascades = json::array(), lattice = json::array();
    for (std::size_t c = 0; c < seen.sea.cascades.size(); ++c)
        cascades.push_back(
            {{"length_m", seen.scene.cascades[c].length_m},
             {"size", seen.scene.cascades[c].size},
             {"k_lo_radpm", seen.sea.cascades[c].band.k_lo_radpm},
             {"k_hi_radpm", seen.sea.cascades[c].band.k_hi_radpm},
             {"requested_m2", s.cascades[c].requested_m2},
             {"expected_m2", s.cascades[c].expected_m2},
             {"realised_m2", s.cascades[c].realised_m2},
             {"hs_scatter_expected", s.cascades[c].expected_scatter},
             {"keyframe_interval_s", 1e-6 * double(seen.budget.cascades[c].interval_us)}});
    for (const sea::LatticeBias& bias : s.lattice) // bearings turn clockwise, angles the other way
        lattice.push_back({{"system", bias.system + 1},
                           {"m0_ratio", bias.energy},
                           {"turned_deg", -bias.turned_rad * degrees},
                           {"spread_ratio", bias.spread}});
    const bool given = seen.scene.foam.threshold.has_value();
    json foam = {{"mean_coverage", seen.foam->mean_coverage},
                 {"threshold", seen.foam->threshold},
                 {"bias", seen.scene.foam.bias},
                 {"decay_s", seen.scene.foam.decay_s},
                 {"gain_per_s", seen.scene.foam.gain_per_s},
                 {"observed", nullptr},
                 {"says", describe(*seen.foam)}};
    if (!given)
        foam["observed"] = {{"coverage", seen.foam->observed->share},
                            {"wind_speed_10m_mps", seen.foam->observed->wind.speed_10m_mps},
                            {"wind_is_given", false}};
    json certificate = nullptr;
    if (seen.certificate)
        certificate = {{"file", "crossing.json"},
                       {"says", describe(*seen.certificate)},
                       {"height_error_m", 0.07},
                       {"percentile", 97.0},
                       {"holds", certificate_holds}};
    const bool deep = std::isinf(seen.scene.sea.depth_m);
    return {{"scene", seen.path},
            {"seed", seen.scene.sea.seed},
            {"depth_m", deep ? json(nullptr) : json(seen.scene.sea.depth_m)},
            {"requested", expected_statistics(s.requested)},
            {"realised", expected_statistics(s.realised)},
            {"hs_scatter_expected", hs_scatter(seen)},
            {"tp_bin_s", s.peak_bin_period_s > 0 ? json(s.peak_bin_period_s) : json(nullptr)},
            {"longest_peak_wavelength_m", s.longest_peak_wavelength_m},
            {"variance",
             {{"requested_m2", m0(s.requested)},
              {"realised_m2", m0(s.realised)},
              {"lost_longer_m2", s.lost_below_m2},
              {"lost_shorter_m2", s.lost_above_m2},
              {"lost_fade_m2", s.lost_fade_m2}}},
            {"lattice_bias", lattice},
            {"cascades", cascades},
            {"foam", foam},
            {"certificate", certificate}};
}

/// Words and lists of words have tests of their own.
json without_words(json report) {
    for (const char* key : {"wmo_sea_state", "tp_definition", "warnings"})
        EXPECT_EQ(report.erase(key), 1u) << key;
    return report;
}

/// Where two documents differ by more than rounding of the last bits, as text.
std::string differences(const json& found, const json& expected) {
    std::string all;
    const json a = found.flatten(), b = expected.flatten();
    for (const auto& [key, value] : b.items()) {
        const auto at = a.find(key);
        const bool near = at != a.end() && value.is_number_float() && at->is_number() &&
                          std::abs(at->get<double>() - value.get<double>()) <=
                              1e-14 * std::abs(value.get<double>());
        if (at == a.end() || (*at != value && !near))
            all += fmt::format("{}: {} in place of {}\n", key,
                               at == a.end() ? std::string("nothing") : at->dump(), value.dump());
    }
    for (const auto& [key, value] : a.items())
        if (!b.contains(key))
            all += fmt::format("{}: {} that nobody expects\n", key, value.dump());
    return all;
}

void expect_no_two_equal(const json& report) {
    std::vector<double> figures;
    const json flat = report.flatten();
    for (const auto& [key, value] : flat.items())
        if (value.is_number_float() && !key.ends_with("k_lo_radpm")) // where the band before ends
            figures.push_back(value.get<double>());
    std::sort(figures.begin(), figures.end());
    const auto same = std::adjacent_find(figures.begin(), figures.end());
    EXPECT_TRUE(same == figures.end()) << *same << " stands twice: one can be told as the other";
}

TEST(InspectReport, every_figure_of_the_json_is_the_one_of_its_name) {
    certify(14);
    const Seen seen = see("crossing.toml", crossing);
    ASSERT_GT(seen.summary.lost_below_m2, 0);
    ASSERT_GT(seen.summary.lost_above_m2, 0);
    ASSERT_GT(seen.summary.lost_fade_m2, 0);
    const json report = without_words(report_of(seen.path));
    EXPECT_EQ(differences(report, expected_report(seen, true)), "");
    json figures = report;
    figures.erase("certificate"); // figures of its own
    figures.erase("foam");
    expect_no_two_equal(figures);
}

TEST(InspectReport, a_certificate_of_another_wind_does_not_hold_and_says_so) {
    certify(11);
    const Seen seen = see("crossing.toml", crossing);
    const json report = report_of(seen.path);
    EXPECT_FALSE(report.at("certificate").at("holds").get<bool>());
    int said = 0;
    for (const json& warning : report.at("warnings"))
        said += warning.get<std::string>().find("wind 14 m/s, measured 11 .. 11 m/s") !=
                std::string::npos;
    EXPECT_EQ(said, 1) << report.at("warnings").dump(1);
}

TEST(InspectReport, a_measured_peak_deep_water_and_observed_foam_are_told) {
    const Seen seen = see("measured.toml", measured);
    ASSERT_GT(seen.summary.peak_bin_period_s, 0);
    ASSERT_FALSE(seen.foam->calm());
    const json report = without_words(report_of(seen.path));
    EXPECT_EQ(differences(report, expected_report(seen, false)), "");
    EXPECT_NEAR(report.at("tp_bin_s").get<double>(), 1 / 0.10, 1e-12); // the middle of the highest
    EXPECT_NE(report.at("tp_bin_s"), report.at("requested").at("tp_s"));
}

TEST(InspectReport, the_sea_state_is_that_of_the_height_that_was_asked_for) {
    // Just below 2.5 m, where moderate ends; a few waves on a small tile make it more or less.
    for (int seed = 1; seed < 40; ++seed) {
        const Seen seen =
            see("label.toml", fmt::format("[sea]\nseed = {}\n[[sea.system]]\ntype = \"swell\"\n"
                                          "significant_height_m = 2.45\npeak_period_s = 8\n"
                                          "from_deg = 20\n[[cascade]]\nlength_m = 300\nsize = 64\n",
                                          seed));
        if (seen.summary.realised.significant_height_m < 2.6)
            continue;
        const json label = report_of(seen.path).at("wmo_sea_state");
        EXPECT_EQ(label.at("code"), 4);
        EXPECT_EQ(label.at("name"), "moderate");
        EXPECT_NE(run_program("seaway-inspect", seen.path).out.find("WMO sea state 4: moderate\n"),
                  std::string::npos);
        return;
    }
    FAIL() << "no seed makes more of it";
}

// Naive: null for what is not finite.
TEST(InspectReport, waves_of_hardly_any_energy_have_numbers_for_all_that_is_asked_of_them) {
    for (const char* energy : {"1e-310", "3e-308", "1e-200"}) {
        std::string table = "f_hz,dir_from_deg,e_m2_hz_deg\n";
        for (const char* f_hz : {"0.1", "0.2"})
            for (int from_deg = 0; from_deg < 360; from_deg += 5)
                table += fmt::format("{},{},{}\n", f_hz, from_deg, from_deg == 90 ? energy : "0");
        const json report = report_of(folder().write(
            "faint.toml", "[sea]\n[[sea.system]]\ntype = \"measured\"\ndata = \"\"\"\n" + table +
                              "\"\"\"\n[[cascade]]\nlength_m = 300\nsize = 64\n"));
        for (const char* part : {"requested", "realised"})
            for (const auto& [key, value] : report.at(part).items())
                EXPECT_TRUE(value.is_number()) << energy << ' ' << part << '.' << key;
        EXPECT_TRUE(report.at("longest_peak_wavelength_m").is_number()) << energy;
    }
}

/// The numbers of a line, each with half a unit of its last digit.
struct Printed {
    double value;
    double half_unit;
};
std::vector<Printed> numbers_of(const std::string& line) {
    static const std::regex number(R"([-+]?(\d+)(?:\.(\d+))?(?:e([-+]?\d+))?)");
    std::vector<Printed> all;
    for (std::sregex_iterator at(line.begin(), line.end(), number), end; at != end; ++at) {
        const int exponent = (*at)[3].matched ? std::stoi((*at)[3].str()) : 0;
        all.push_back({std::stod(at->str()),
                       0.501 * std::pow(10.0, exponent - static_cast<int>((*at)[2].length()))});
    }
    return all;
}

/// The first line that begins so says these numbers, and no other.
void expect_line(const std::string& text, const std::string& begin,
                 const std::vector<double>& expected) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        if (line.rfind(begin, 0) != 0)
            continue;
        const std::vector<Printed> found = numbers_of(line.substr(begin.size()));
        ASSERT_EQ(found.size(), expected.size()) << line;
        for (std::size_t i = 0; i < expected.size(); ++i)
            EXPECT_NEAR(found[i].value, expected[i], found[i].half_unit) << line;
        return;
    }
    ADD_FAILURE() << "no line begins with '" << begin << "' in\n" << text;
}

TEST(InspectReport, every_line_of_the_text_says_the_figures_of_the_json) {
    certify(14);
    const Seen seen = see("crossing.toml", crossing);
    const Output ran = run_program("seaway-inspect", seen.path);
    ASSERT_EQ(ran.status, 0) << ran.err;
    const sea::SeaSummary& s = seen.summary;
    expect_line(ran.out, seen.path + ":", {7, 35});
    expect_line(ran.out, "Hs of one seed scatters by", {100 * hs_scatter(seen)});
    ASSERT_EQ(s.lattice.size(), 2u);
    for (const sea::LatticeBias& bias : s.lattice)
        expect_line(ran.out, fmt::format("system {} on these tiles", bias.system + 1),
                    {100 * (bias.energy - 1), -bias.turned_rad * degrees, 100 * (bias.spread - 1)});
    for (std::size_t c = 0; c < 3; ++c) {
        const sea::Band& band = seen.sea.cascades[c].band;
        const double tile_m = seen.scene.cascades[c].length_m;
        // The longest wave of the first band is the tile, half a step inside it.
        expect_line(ran.out, fmt::format("{:>9g}", tile_m),
                    {double(seen.scene.cascades[c].size),
                     c == 0 ? tile_m : sea::two_pi / band.k_lo_radpm, sea::two_pi / band.k_hi_radpm,
                     s.cascades[c].requested_m2, s.cascades[c].realised_m2,
                     100 * s.cascades[c].expected_scatter,
                     1e-6 * double(seen.budget.cascades[c].interval_us)});
    }
    // "not carried, of m0 m2: ..."
    const double whole = m0(s.requested);
    expect_line(ran.out, "not carried, of",
                {whole, 2, 100 * s.lost_below_m2 / whole, 100 * s.lost_above_m2 / whole,
                 100 * s.lost_fade_m2 / whole});
    for (const std::string& line :
         {"foam: " + describe(*seen.foam), "certified: " + describe(*seen.certificate)})
        EXPECT_NE(ran.out.find("\n" + line + "\n"), std::string::npos) << line << "\n" << ran.out;
    for (const std::string& warning :
         scene_warnings(seen.scene, seen.sea, seen.summary, seen.budget))
        EXPECT_NE(ran.out.find("\nwarning: " + warning + "\n"), std::string::npos) << warning;
}

} // namespace
} // namespace seaway
