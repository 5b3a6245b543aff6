// SPDX-License-Identifier: Apache-2.0
// Tables of measured seas: their peak, the frame of their coefficients, how bins join, the forms in
// which buoys are published.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include <fmt/format.h>

#include "sea/scene/scene.h"
#include "sea/spectrum/measured.h"
#include "sea/spectrum/ndbc.h"
#include "sea/waves/statistics/moments.h"
#include "tests/sea/csv.h"
#include "tests/sea/warnings_of.h"
#include "tests/support/folder.h"

namespace seaway::sea {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using testing::Table;

MeasuredSpectrum spectrum_of(const std::string& csv,
                             CoefficientFrame frame = CoefficientFrame::from_clockwise_north) {
    Result<MeasuredSpectrum> spectrum = parse_measured(csv, "t", frame);
    EXPECT_TRUE(spectrum) << (spectrum ? "" : spectrum.error().message);
    return spectrum ? *spectrum : MeasuredSpectrum{};
}

/// Integral of D e^{i n phi}: a smooth density over a whole circle, so equal steps are exact.
std::complex<double> moment(const MeasuredDirections& directions, int n) {
    constexpr int steps = 3600;
    std::complex<double> sum;
    for (int i = 0; i < steps; ++i) {
        const double towards_rad = two_pi * i / steps;
        sum += directions(towards_rad) * std::polar(two_pi / steps, n * towards_rad);
    }
    return sum;
}

Result<Scene> scene_with(const std::string& csv, const std::string& keys,
                         const std::string& base_dir = "") {
    return parse_scene("[sea]\n[[sea.system]]\ntype = \"measured\"\n" + keys +
                           (csv.empty() ? "" : "data = '''\n" + csv + "'''\n"),
                       "s", base_dir);
}

std::string table_of(const Table& spectra, const std::string& buoy) {
    std::string csv = "f_hz,df_hz,s_m2_hz\n";
    for (std::size_t r = 0; r < spectra.size(); ++r)
        if (spectra.text(r, spectra.header()[0]) == buoy)
            csv += spectra.text(r, "f_Hz") + "," + spectra.text(r, "df_Hz") + "," +
                   spectra.text(r, "S_m2_Hz") + "\n";
    return csv;
}

// CDIP's published Tp is the middle of the highest bin. The parabola moves within half a bin of it:
// 0.0025 Hz of 0.085 Hz.
TEST(Measured, P07_the_bins_tp_is_the_published_one_and_the_parabolas_lies_within_half_a_bin) {
    const Table spectra("P07_cdip_spectra");
    const Table expected("P07_cdip_expected");
    for (const char* buoy : {"CDiP1", "CDiP6"}) {
        const double published = expected.number(expected.find(buoy, "Tp"), "value");
        const auto scene = scene_with(table_of(spectra, buoy), "from_deg = 0\n");
        ASSERT_TRUE(scene);
        const SeaSummary summary = summarize(scene->sea, *realize(*scene));
        EXPECT_NEAR(summary.peak_bin_period_s / published, 1.0, 1e-9);
        EXPECT_NEAR(1.0 / summary.requested.peak_period_s, 1.0 / published, 0.0025);
    }
}

TEST(Measured, a_peak_between_bins_is_found_by_the_parabola_through_three) {
    const double peak_hz = 0.1037;
    std::string csv = "f_hz,df_hz,s_m2_hz\n";
    for (int i = 0; i < 9; ++i) {
        const double f = 0.08 + 0.005 * i;
        csv += fmt::format("{},0.005,{}\n", f, 10.0 - 9000.0 * std::pow(f - peak_hz, 2));
    }
    EXPECT_NEAR(spectrum_of(csv).peak_omega_radps() / (two_pi * peak_hz), 1.0, 1e-9);
    const auto scene = scene_with(csv, "from_deg = 0\n");
    const SeaSummary summary = summarize(scene->sea, *realize(*scene));
    EXPECT_NEAR(summary.requested.peak_period_s * peak_hz, 1.0, 1e-9);
    EXPECT_NEAR(summary.peak_bin_period_s * 0.105, 1.0, 1e-9);
}

TEST(Measured, where_bins_do_not_allow_a_parabola_the_peak_is_the_middle_of_the_highest) {
    const std::string header = "f_hz,df_hz,s_m2_hz\n";
    for (const char* rows : {"0.1,0.01,5\n0.11,0.01,4\n",                 // the first
                             "0.09,0.01,4\n0.1,0.01,5\n",                 // the last
                             "0.08,0.01,3\n0.1,0.01,5\n0.11,0.01,4\n",    // a gap before it
                             "0.085,0.02,3\n0.1,0.01,5\n0.115,0.02,4\n"}) // others are wide
        EXPECT_NEAR(spectrum_of(header + rows).peak_omega_radps() / (two_pi * 0.1), 1.0, 1e-12)
            << rows;
    // Two bins of one height: the top of the parabola is the edge between them.
    EXPECT_NEAR(spectrum_of(header + "0.08,0.01,3\n0.09,0.01,5\n0.1,0.01,5\n0.11,0.01,3\n")
                        .peak_omega_radps() /
                    (two_pi * 0.095),
                1.0, 1e-12);
}

// A narrow bin between coarse ones is thinner than any fixed step of a search.
TEST(Measured, a_very_narrow_peak_is_not_overlooked) {
    const auto scene = scene_with("f_hz,f_lo_hz,f_hi_hz,s_m2_hz\n0.09,0.08,0.099999,1\n"
                                  "0.1,0.099999,0.100001,50\n0.11,0.100001,0.12,1\n",
                                  "from_deg = 0\n");
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_NEAR(summarize(scene->sea, *realize(*scene)).requested.peak_period_s, 10.0, 1e-3);
}

// One buoy says "from, clockwise from north", the other "towards, anticlockwise from east"; both
// saw waves that go to the north-east, 45 degrees from east, so from 225.
TEST(Measured, coefficients_of_both_frames_give_the_same_sea) {
    const double r1 = 0.8, r2 = 0.5, from = 225 * pi / 180, towards = 45 * pi / 180;
    const auto csv = [&](double angle) {
        return fmt::format("f_hz,df_hz,s_m2_hz,a1,b1,a2,b2\n0.1,0.02,5,{},{},{},{}\n",
                           r1 * std::cos(angle), r1 * std::sin(angle), r2 * std::cos(2 * angle),
                           r2 * std::sin(2 * angle));
    };
    const MeasuredSpectrum bearing = spectrum_of(csv(from));
    const MeasuredSpectrum going =
        spectrum_of(csv(towards), CoefficientFrame::towards_anticlockwise_east);
    for (const MeasuredSpectrum* s : {&bearing, &going}) {
        EXPECT_NEAR(std::abs(s->bins[0].directions->first_moment() - std::polar(r1, towards)), 0,
                    1e-12);
        EXPECT_NEAR(std::abs(moment(*s->bins[0].directions, 2) - std::polar(r2, 2 * towards)), 0,
                    1e-12);
    }
    const auto scene = scene_with(csv(towards), "coefficients = \"towards_anticlockwise_east\"\n");
    ASSERT_TRUE(scene);
    EXPECT_NEAR(summarize(scene->sea, *realize(*scene)).requested.mean_towards_rad, towards, 1e-9);
    // Nobody said which: a warning, and the words that end it.
    const auto unsaid = scene_with(csv(from), "");
    EXPECT_THAT(testing::warnings_of(*unsaid),
                Contains(HasSubstr("coefficients = \"from_clockwise")));
    EXPECT_THAT(testing::warnings_of(*scene), ::testing::Not(Contains(HasSubstr("coefficients"))));
    EXPECT_THAT(scene_with("f_hz,df_hz,s_m2_hz\n0.1,0.01,1\n",
                           "from_deg = 0\ncoefficients = \"from_clockwise_north\"\n")
                    .error()
                    .message,
                HasSubstr("coefficients: only for a table with the columns a1,b1"));
}

// NDBC: D(A) = (1/pi) (1/2 + r1 cos(A - alpha1) + r2 cos 2(A - alpha2)), A clockwise from north,
// where waves come from. Its moments over "towards", by quadrature of that formula.
TEST(Measured, polar_columns_are_ndbcs_formula) {
    const double r1 = 0.4, alpha1 = 310, r2 = 0.1, alpha2 = 295;
    std::complex<double> first, second;
    const int n = 3600; // a trigonometric polynomial: exact
    for (int i = 0; i < n; ++i) {
        const double bearing = two_pi * i / n;
        const double density = (0.5 + r1 * std::cos(bearing - alpha1 * pi / 180) +
                                r2 * std::cos(2 * (bearing - alpha2 * pi / 180))) /
                               pi * (two_pi / n);
        const double towards = 1.5 * pi - bearing;
        first += density * std::polar(1.0, towards);
        second += density * std::polar(1.0, 2 * towards);
    }
    const MeasuredSpectrum s = spectrum_of(
        fmt::format("f_hz,df_hz,s_m2_hz,r1,alpha1_deg,r2,alpha2_deg\n0.1,0.02,5,{},{},{},{}\n", r1,
                    alpha1, r2, alpha2));
    EXPECT_NEAR(std::abs(s.bins[0].directions->first_moment() - first), 0.0, 1e-12);
    EXPECT_NEAR(std::abs(moment(*s.bins[0].directions, 2) - second), 0.0, 1e-12);
    EXPECT_FALSE(s.bins[0].directions->changed());
    const MeasuredSpectrum beam =
        spectrum_of("f_hz,df_hz,s_m2_hz,r1,alpha1_deg\n0.1,0.02,5,0.7,270\n");
    EXPECT_NEAR(std::abs(beam.bins[0].directions->first_moment() - 0.7), 0.0, 1e-12);
    EXPECT_THAT(parse_measured("f_hz,df_hz,s_m2_hz,r1,alpha1_deg\n0.1,0.02,5,70,270\n", "t")
                    .error()
                    .message,
                HasSubstr("hundredths"));
}

TEST(Measured, energy_that_is_counted_twice_or_dropped_is_told) {
    // 0.01 Hz wide bins, 0.008 Hz apart: a quarter of the sum of S df but the last is told twice.
    const std::string header = "f_hz,df_hz,s_m2_hz\n";
    const auto overlap = scene_with(header + "0.1,0.01,5\n0.108,0.01,5\n", "from_deg = 0\n");
    const MeasuredQuality& twice = std::get<MeasuredSea>(overlap->sea.systems[0]).spectrum->quality;
    EXPECT_EQ(twice.overlaps, 1);
    EXPECT_NEAR(twice.overlapped_share, 0.002 * 5 / (0.02 * 5), 1e-9);
    EXPECT_THAT(testing::warnings_of(*overlap), Contains(HasSubstr("counted twice")));
    // m0 stays what the sum says.
    EXPECT_NEAR(
        std::pow(summarize(overlap->sea, *realize(*overlap)).requested.significant_height_m / 4, 2),
        0.1, 1e-9);
    const auto gap = scene_with(header + "0.1,0.01,5\n0.13,0.01,3\n0.14,0.01,3\n", "from_deg=0\n");
    const MeasuredQuality& dropped = std::get<MeasuredSea>(gap->sea.systems[0]).spectrum->quality;
    EXPECT_EQ(dropped.gaps, 1);
    EXPECT_NEAR(dropped.gap_share, 0.02 * 4 / 0.11, 1e-9);
    EXPECT_THAT(testing::warnings_of(*gap),
                Contains(AllOf(HasSubstr("1 gaps between bins"), HasSubstr("0.105 .. 0.125 Hz"))));
    const auto whole = scene_with(header + "0.1,0.01,5\n0.11,0.01,5\n", "from_deg = 0\n");
    EXPECT_THAT(testing::warnings_of(*whole), ::testing::Not(Contains(HasSubstr("bins"))));
    EXPECT_THAT(parse_measured(header + "0.1,0.01,5\n0.102,0.01,5\n", "t").error().message,
                HasSubstr("t:3: f_hz = 0.102: frequencies must ascend and bins must not cover"));
}

// Naive: 1 Hz to the power of minus 160, whose wave is longer than a double says.
TEST(Measured, frequencies_are_those_of_waves) {
    for (const char* f_hz : {"1e-300", "9.9e-5", "101"}) {
        const auto buoy = parse_measured(
            fmt::format("f_hz,f_lo_hz,f_hi_hz,s_m2_hz\n{0},1e-301,150,1\n", f_hz), "t");
        ASSERT_FALSE(buoy);
        EXPECT_THAT(buoy.error().message, ::testing::HasSubstr("t:2: f_hz = "));
        EXPECT_THAT(buoy.error().message, ::testing::HasSubstr("0.0001 .. 100 Hz"));
    }
    std::string directions = "f_hz,dir_from_deg,e_m2_hz_deg\n";
    for (const char* f_hz : {"9.9e-5", "0.1"})
        for (int from_deg = 0; from_deg < 360; from_deg += 90)
            directions += fmt::format("{},{},1\n", f_hz, from_deg);
    const auto table = parse_measured(directions, "t");
    ASSERT_FALSE(table);
    EXPECT_THAT(table.error().message, ::testing::HasSubstr("t:2: f_hz must ascend, 0.0001"));
    EXPECT_TRUE(parse_measured("f_hz,df_hz,s_m2_hz\n1e-4,1e-5,1\n", "t"));
}

// 24 directions, as wave models have them, of beams cos^2s(a/2); degrees from sums in double precision elsewhere.
TEST(Measured, a_table_that_is_read_wider_than_its_rows_says_by_how_much) {
    struct Beam {
        double s, rows_deg, read_deg;
        bool warned;
    };
    for (const Beam& beam :
         {Beam{150, 5.436, 8.173, true}, {75, 9.228, 11.049, true}, {10, 24.431, 25.117, false}}) {
        std::string csv = "f_hz,dir_from_deg,e_m2_hz_deg\n";
        for (const char* f_hz : {"0.1", "0.11"})
            for (int from_deg = 0; from_deg < 360; from_deg += 15)
                csv += fmt::format(
                    "{},{},{}\n", f_hz, from_deg,
                    std::pow(std::abs(std::cos(0.5 * (from_deg - 120) * pi / 180)), 2 * beam.s));
        const auto table = parse_measured(csv, "t");
        ASSERT_TRUE(table) << table.error().message;
        EXPECT_NEAR(table->quality.spread_of_rows_rad * 180 / pi, beam.rows_deg, 0.005);
        EXPECT_NEAR(table->quality.spread_read_rad * 180 / pi, beam.read_deg, 0.005);
        const Result<Scene> scene = scene_with(csv, "");
        ASSERT_TRUE(scene) << scene.error().message;
        const auto widened = Contains(HasSubstr("has few directions for so narrow a sea"));
        EXPECT_THAT(testing::warnings_of(*scene),
                    ::testing::Conditional(beam.warned, widened, ::testing::Not(widened)));
    }
}

TEST(Measured, a_table_without_a_header_says_so) {
    EXPECT_THAT(scene_with("0.1,0.01,5\n0.11,0.01,4\n", "from_deg = 0\n").error().message,
                HasSubstr("data:1: no header"));
}

// Two records of NDBC's real-time form, newest first, as its header names it; units and blank lines may
// stand between.
const char* const density_text =
    "#YY  MM DD hh mm Sep_Freq  < spec_1 (freq_1) spec_2 (freq_2) spec_3 (freq_3) ... >\n"
    "#yr  mo dy hr mn Hz         m*m/Hz Hz       m*m/Hz Hz       m*m/Hz Hz\n\n"
    "2014 09 11 17 00 0.176 0.000 (0.033) 4.000 (0.043) 9.000 (0.053) 2.000 (0.073) \n"
    "2014 09 11 16 00 9.999 0.000 (0.033) 1.000 (0.043) 1.000 (0.053) MM (0.073) \n";
const char* const alpha1_text =
    "#YY  MM DD hh mm alpha1_1 (freq_1) alpha1_2 (freq_2) alpha1_3 (freq_3) ... >\n"
    "2014 09 11 17 00 999.0 (0.033) 270.0 (0.043) 290.0 (0.053) 999.0 (0.073) \n"
    "2014 09 11 16 00 999.0 (0.033) 100.0 (0.043) 90.0 (0.053) 80.0 (0.073) \n";
const char* const r1_text =
    "#YY  MM DD hh mm r1_1 (freq_1) r1_2 (freq_2) r1_3 (freq_3) ... >\n"
    "2014 09 11 17 00 999.00 (0.033) 0.80 (0.043) 0.90 (0.053) 999.00 (0.073) \n"
    "2014 09 11 16 00 999.00 (0.033) 0.50 (0.043) 0.50 (0.053) 0.50 (0.073) \n";

TEST(Ndbc, the_newest_record_becomes_a_table_and_another_by_its_time) {
    ASSERT_TRUE(is_ndbc(density_text));
    EXPECT_FALSE(is_ndbc("f_hz,df_hz,s_m2_hz\n0.1,0.01,5\n"));
    NdbcTexts texts{{density_text, "x.data_spec"},
                    NdbcText{alpha1_text, "x.swdir"},
                    {},
                    NdbcText{r1_text, "x.swr1"},
                    {}};
    const auto csv = ndbc_to_csv(texts, "");
    ASSERT_TRUE(csv) << csv.error().message;
    const MeasuredSpectrum s = spectrum_of(*csv);
    ASSERT_EQ(s.bins.size(), 4u);
    // Bins meet halfway: 0.043 reaches from 0.038 to 0.048, 0.053 to 0.063.
    EXPECT_NEAR(s.bins[1].omega_lo_radps / two_pi, 0.038, 1e-12);
    EXPECT_NEAR(s.bins[2].omega_hi_radps / two_pi, 0.063, 1e-12);
    EXPECT_NEAR(s.bins[2].density * two_pi, 9.0, 1e-12);
    EXPECT_EQ(s.quality.gaps + s.quality.overlaps, 0);
    EXPECT_NEAR(std::abs(s.bins[1].directions->first_moment() - 0.8), 0.0, 1e-12); // from the west
    EXPECT_EQ(s.quality.undirected_bins, 1); // 0.073 Hz; 0.033 Hz has no energy
    const auto older = ndbc_to_csv(texts, "2014-09-11T16:00");
    EXPECT_THAT(older.error().message, AllOf(HasSubstr("x.data_spec"), HasSubstr("0.073 Hz")));
    EXPECT_THAT(ndbc_to_csv(texts, "2014-09-11T15:00").error().message,
                HasSubstr("no record of 2014-09-11T15:00"));
    EXPECT_THAT(ndbc_to_csv(texts, "yesterday").error().message, HasSubstr("YYYY-MM-DDThh:mm"));
}

TEST(Ndbc, all_four_quantities_of_an_archive_stand_in_their_columns_shares_as_shares) {
    const auto file = [](const std::string& values, const std::string& name) {
        return NdbcText{"#YY  MM DD hh mm   .0400  .0500\n2023 01 01 00 40 " + values + "\n", name};
    };
    const NdbcTexts texts{file("1.0 5.0", "w"), file("180 190", "d"), file("20 30", "i"),
                          file("40.0 80.0", "j"), file("25.0 50.0", "k")};
    const auto csv = ndbc_to_csv(texts, "");
    ASSERT_TRUE(csv) << csv.error().message;
    EXPECT_THAT(*csv, HasSubstr("f_hz,f_lo_hz,f_hi_hz,s_m2_hz,r1,alpha1_deg,r2,alpha2_deg\n"));
    EXPECT_THAT(*csv, HasSubstr(",1,0.4,180,0.25,20\n"));
    EXPECT_THAT(*csv, HasSubstr(",5,0.8,190,0.5,30\n"));
}

// A peak as high in two bins lies on their edge.
TEST(Measured, two_bins_of_one_height_have_their_peak_between_them) {
    const MeasuredSpectrum s =
        spectrum_of("f_hz,df_hz,s_m2_hz\n0.10,0.02,2\n0.12,0.02,5\n0.14,0.02,5\n0.16,0.02,2\n");
    EXPECT_NEAR(s.peak_omega_radps() / two_pi, 0.13, 1e-9);
}

// A direction without its spread, or the reverse, is none: neither is made up.
TEST(Ndbc, a_frequency_with_half_of_its_directions_has_none) {
    const std::string header = "#YY  MM DD hh mm ... >\n2014 09 11 17 00 ";
    const NdbcTexts texts{
        {"#YY  MM DD hh mm Sep_Freq < >\n2014 09 11 17 00 0.2 1.0 (0.04) 4.0 (0.05) 9.0 (0.06) "
         "2.0 (0.07)\n",
         "d"},
        NdbcText{header + "250.0 (0.04) 999.0 (0.05) 290.0 (0.06) MM (0.07)\n", "a"},
        {},
        NdbcText{header + "0.70 (0.04) 0.80 (0.05) 999.0 (0.06) MM (0.07)\n", "r"},
        {}};
    const auto csv = ndbc_to_csv(texts, "");
    ASSERT_TRUE(csv) << csv.error().message;
    EXPECT_EQ(csv->substr(0, csv->find('\n')), "f_hz,f_lo_hz,f_hi_hz,s_m2_hz,r1,alpha1_deg");
    EXPECT_THAT(*csv, HasSubstr(",1,0.7,250\n"));
    for (const char* none : {",4,0,0\n", ",9,0,0\n", ",2,0,0\n"})
        EXPECT_THAT(*csv, HasSubstr(none));
}

// Long swell of a narrow band is as dense: 1005.5 m2/Hz was published.
TEST(Ndbc, densities_of_a_thousand_are_densities) {
    const std::string header = "#YY  MM DD hh mm Sep_Freq  < spec_1 (freq_1) ... >\n";
    const NdbcTexts now{
        {header + "2014 09 11 17 00 9.999 999.0 (0.04) 1005.5 (0.05) 9999.0 (0.06) \n", "s"},
        {},
        {},
        {},
        {}};
    const auto csv = ndbc_to_csv(now, "");
    ASSERT_TRUE(csv) << csv.error().message;
    for (const char* density : {",999\n", ",1005.5\n", ",9999\n"})
        EXPECT_THAT(*csv, HasSubstr(density));
    const NdbcTexts then{
        {"#YY  MM DD hh mm   .0400  .0500\n2023 01 01 00 40  1005.50  998.99\n", "w"},
        {},
        {},
        {},
        {}};
    const auto archived = ndbc_to_csv(then, "");
    ASSERT_TRUE(archived) << archived.error().message;
    for (const char* density : {",1005.5\n", ",998.99\n"})
        EXPECT_THAT(*archived, HasSubstr(density));
}

TEST(Ndbc, what_archives_fill_in_is_no_density) {
    for (const char* fill : {"999", "999.0", "999.00", "9999.00", "MM"}) {
        const NdbcTexts texts{
            {"#YY  MM DD hh mm   .0400  .0500\n2023 01 01 00 40  1.00  " + std::string(fill) + "\n",
             "w"},
            {},
            {},
            {},
            {}};
        EXPECT_THAT(ndbc_to_csv(texts, "").error().message, HasSubstr("no density at 0.05 Hz"))
            << fill;
    }
}

// Archives have one column a frequency, and r1, r2 in hundredths.
TEST(Ndbc, archived_files_hold_shares_in_hundredths) {
    NdbcTexts texts{
        {"#YY  MM DD hh mm   .0400  .0500  .0600\n2023 01 01 00 40   0.10   5.00   1.00\n", "w"},
        NdbcText{"#YY  MM DD hh mm   .0400  .0500  .0600\n"
                 "2023 01 01 00 40    180    180    180\n",
                 "d"},
        {},
        NdbcText{"#YY  MM DD hh mm   .0400  .0500  .0600\n"
                 "2023 01 01 00 40   12.0   80.0   70.0\n",
                 "j"},
        {}};
    const auto csv = ndbc_to_csv(texts, "");
    ASSERT_TRUE(csv) << csv.error().message;
    const MeasuredSpectrum s = spectrum_of(*csv);
    EXPECT_NEAR(std::abs(s.bins[0].directions->first_moment()), 0.12, 1e-12);
    EXPECT_NEAR(std::abs(s.bins[1].directions->first_moment() - std::complex(0.0, 0.8)), 0.0,
                1e-12);
    texts.r1->text.replace(texts.r1->text.find(".0600"), 5, ".0700");
    EXPECT_THAT(ndbc_to_csv(texts, "").error().message, HasSubstr("j: record of 2023-01-01T00:40"));
}

// The files of 1998 and before: the last two digits of the year, no minutes.
TEST(Ndbc, years_of_two_digits_are_of_the_nineteen_hundreds) {
    const NdbcTexts texts{{"YY MM DD hh .0400 .0500 .0600\n"
                           "98 01 01 00 0.10 5.00 1.00\n"
                           "98 01 01 01 0.10 7.00 1.00\n",
                           "w"},
                          {},
                          {},
                          {},
                          {}};
    const auto csv = ndbc_to_csv(texts, "1998-01-01T00:00");
    ASSERT_TRUE(csv) << csv.error().message;
    EXPECT_NEAR(spectrum_of(*csv).bins[1].density * two_pi, 5.0, 1e-12);
    EXPECT_THAT(ndbc_to_csv(texts, "2098-01-01T00:00").error().message, HasSubstr("no record of"));
}

TEST(Ndbc, a_scene_names_the_files_and_its_effective_form_holds_the_record) {
    const std::string folder = tests::folder().file("");
    for (const auto& [name, text] :
         {std::pair{"x.data_spec", density_text}, {"x.swdir", alpha1_text}, {"x.swr1", r1_text}})
        tests::folder().write(name, text);
    const auto scene = scene_with(
        "", "file = \"x.data_spec\"\nalpha1_file = \"x.swdir\"\nr1_file = \"x.swr1\"\n", folder);
    const auto half = scene_with("", "file = \"x.data_spec\"\nr1_file = \"x.swr1\"\n", folder);
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_THAT(testing::warnings_of(*scene),
                Contains(HasSubstr("1 of 4 frequencies have energy but no")));
    const auto again = parse_scene(to_toml(*scene), "again", "");
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(to_toml(*again), to_toml(*scene));
    EXPECT_EQ(realize(*again)->cascades[0].h0, realize(*scene)->cascades[0].h0);
    EXPECT_THAT(half.error().message, HasSubstr("directions need alpha1_file and r1_file"));
    EXPECT_THAT(scene_with("f_hz,df_hz,s_m2_hz\n0.1,0.01,5\n", "from_deg=1\nr1_file = \"a\"\n")
                    .error()
                    .message,
                HasSubstr("r1_file: only beside a file of densities as NDBC publishes it"));
}

} // namespace
} // namespace seaway::sea
