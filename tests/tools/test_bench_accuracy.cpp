// SPDX-License-Identifier: Apache-2.0
// `seaway-bench accuracy` on one small sea with few points: the journal's form, that a stopped run goes
// on, and that measured errors follow the laws that were known before.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "tests/support/lines_of.h"
#include "tests/support/program.h"
#include "tests/support/read_file.h"
#include "tests/support/server_process.h"

namespace seaway {
namespace {

using ::testing::HasSubstr;
using tests::Output;

const std::string few = " --states calm_shallow --points 32 --times 8 ";

/// Into a folder of its own; truths, whose names say what they are of, lie in one for all.
Output run(const std::string& folder, const std::string& arguments, int seed = 7) {
    const std::string out = tests::folder().file(folder), truths = tests::folder().file("summed");
    std::filesystem::create_directories(out);
    std::filesystem::create_directories(truths);
    if (!std::filesystem::exists(out + "/truth"))
        std::filesystem::create_directory_symlink(truths, out + "/truth");
    return tests::run_program("seaway-bench", "accuracy --out " + out + few + arguments +
                                                  " --seed " + std::to_string(seed));
}

std::string csv(const std::string& folder) {
    return tests::folder().file(folder + "/accuracy.csv");
}

/// Commas inside quotes part nothing.
std::vector<std::string> fields(const std::string& line) {
    std::vector<std::string> parts(1);
    bool quoted = false;
    for (const char c : line) {
        if (c == '"')
            quoted = !quoted;
        else if (c == ',' && !quoted)
            parts.emplace_back();
        else
            parts.back() += c;
    }
    return parts;
}

using Trial = std::map<std::string, double>; // figures by metric

/// By "knob value".
std::map<std::string, Trial> trials(const std::string& folder) {
    std::map<std::string, Trial> all;
    const std::vector<std::string> rows = tests::lines_of(tests::read_file(csv(folder)));
    for (std::size_t i = 2; i < rows.size(); ++i) {
        const std::vector<std::string> row = fields(rows[i]);
        all[row.at(1) + ' ' + row.at(2)][row.at(3)] = std::stod(row.at(4));
    }
    return all;
}

/// Of this knob in quick runs, which go on in one file.
std::map<std::string, Trial> quick_trials(const std::string& knob) {
    EXPECT_EQ(run("quick", "--quick --knobs " + knob).status, 0) << knob;
    std::map<std::string, Trial> all = trials("quick");
    std::erase_if(all, [&](const auto& one) { return one.first.rfind(knob + ' ', 0) != 0; });
    return all;
}

TEST(BenchAccuracy, journal_has_its_form_and_every_trial_ends_with_done) {
    const Output ran = run("form", "--knobs format,tile");
    ASSERT_EQ(ran.status, 0) << ran.err;
    const std::vector<std::string> rows = tests::lines_of(tests::read_file(csv("form")));
    ASSERT_GT(rows.size(), 20u);
    EXPECT_EQ(
        rows[0],
        "# seaway-bench accuracy, seed 7, 32 points at each of 8 times; named configurations on "
        "seeds 7 to 9");
    EXPECT_EQ(rows[1],
              "state,knob,value,metric,figure,ci_low,ci_high,device,driver,machine,commit");
    for (std::size_t i = 2; i < rows.size(); ++i) {
        const std::vector<std::string> row = fields(rows[i]);
        ASSERT_EQ(row.size(), 11u) << rows[i];
        EXPECT_EQ(row[0], "calm_shallow");
        EXPECT_LE(std::stod(row[5]), std::stod(row[4])) << rows[i];
        EXPECT_GE(std::stod(row[6]), std::stod(row[4])) << rows[i];
        const bool last = i + 1 == rows.size() || fields(rows[i + 1])[2] != row[2];
        EXPECT_EQ(row[3] == "done", last) << rows[i];
    }
    // What the reference says of itself: the sum's own error and its tolerance.
    for (const char* trial : {"format f32", "format f16", "format snorm16"})
        EXPECT_LT(trials("form")[trial]["truth_error_m"], 1e-8) << trial;
}

TEST(BenchAccuracy, a_stopped_run_goes_on_without_measuring_again) {
    ASSERT_EQ(run("stopped", "--quick --knobs format").status, 0);
    const std::string whole = tests::read_file(csv("stopped"));
    const std::size_t second_trial = whole.find(",format,f16,");
    ASSERT_NE(second_trial, std::string::npos);
    // Stopped in the middle of a row of the second of three trials.
    tests::folder().write("stopped/accuracy.csv", whole.substr(0, second_trial + 40));
    const Output again = run("stopped", "--quick --knobs format");
    EXPECT_EQ(again.status, 0) << again.err;
    EXPECT_THAT(again.out, HasSubstr("2 trials measured, 1 were there already"));
    const std::string first = whole.substr(0, whole.rfind('\n', second_trial));
    const std::string now = tests::read_file(csv("stopped"));
    EXPECT_EQ(now.substr(0, first.size()), first);
    EXPECT_EQ(trials("stopped").size(), 3u);
    EXPECT_THAT(run("stopped", "--quick --knobs format").out,
                HasSubstr("0 trials measured, 3 were there"));
    // Points of another seed are other points: they do not belong into this file.
    const Output other = run("stopped", "--quick --knobs format", 8);
    EXPECT_EQ(other.status, 2);
    EXPECT_EQ(other.error_lines(), 1) << other.err;
    EXPECT_THAT(other.err, HasSubstr("is of another run"));
}

TEST(BenchAccuracy, unknown_knobs_and_states_are_refused_by_name) {
    for (const char* arguments : {"--knobs wind", "--states doldrums"}) {
        const Output ran = run("refused", arguments);
        EXPECT_EQ(ran.status, 2);
        EXPECT_EQ(ran.error_lines(), 1) << ran.err;
        EXPECT_THAT(ran.err, HasSubstr("there are"));
    }
}

// Naive: the address is looked at by the first batch over a socket, many minutes later, and not at all where there is none.
TEST(BenchAccuracy,
     a_server_that_is_none_or_that_no_knob_asks_is_refused_before_anything_is_measured) {
    const std::pair<const char*, const char*> rows[] = {
        {"--knobs batch --server foo", "--server: address 'foo': write it as ws://HOST:PORT"},
        {"--knobs codec,grid --server ws://127.0.0.1:1",
         "--server ws://127.0.0.1:1: none of these"}};
    for (const auto& [arguments, what] : rows) {
        const Output ran = run("asked_nothing", arguments);
        EXPECT_EQ(ran.status, 2) << arguments;
        EXPECT_EQ(ran.error_lines(), 1) << ran.err;
        EXPECT_THAT(ran.err, HasSubstr(what));
        EXPECT_FALSE(std::filesystem::exists(csv("asked_nothing"))) << arguments;
    }
}

// Naive: "were there already", whoever had answered.
TEST(BenchAccuracy, figures_of_one_server_are_not_taken_for_those_of_another) {
    const std::vector<std::string> words = {"tests/load/small_sea.toml", "--listen", "127.0.0.1:0",
                                            "--device", "native"};
    tests::ServerProcess one(words), other(words);
    const std::string batches = "--quick --knobs batch";
    const std::string of_one = batches + " --server " + one.wait_until_ready();
    const std::string of_other = batches + " --server " + other.wait_until_ready();
    const std::pair<std::string, const char*> runs[] = {
        {batches, "20 trials measured, 0 were there already"},
        {of_one, "4 trials measured, 20 were there already"},
        {of_one, "0 trials measured, 24 were there already"},
        {of_other, "4 trials measured, 20 were there already"}};
    for (const auto& [arguments, said] : runs) {
        const Output ran = run("servers", arguments);
        EXPECT_EQ(ran.status, 0) << ran.err;
        EXPECT_THAT(ran.out, HasSubstr(said)) << arguments;
    }
}

/// Measured over predicted rms, of trials whose name begins so and where more than `floor` is expected.
void expect_law(const std::map<std::string, Trial>& all, const std::string& name, double factor,
                double floor, int least, const std::string& metric = "rms_m") {
    int seen = 0;
    for (const auto& [trial, figures] : all) {
        if (trial.rfind(name, 0) != 0 || figures.at("predicted_" + metric) < floor)
            continue;
        ++seen;
        const double ratio = figures.at(metric) / figures.at("predicted_" + metric);
        EXPECT_GT(ratio, 1 / factor) << trial << ' ' << metric;
        EXPECT_LT(ratio, factor) << trial << ' ' << metric;
    }
    EXPECT_GE(seen, least) << name;
}

// 128 points anywhere, at 8 times: an rms scatters by a tenth or two, far below the factor of 2 that is
// promised. Below a micrometre float maps round.
TEST(BenchAccuracy, interpolation_in_space_follows_its_law_within_a_factor_of_two) {
    const std::map<std::string, Trial> all = quick_trials("grid");
    expect_law(all, "grid bilinear", 2.0, 1e-6, 4);
    expect_law(all, "grid spline", 2.0, 1e-6, 2);
    expect_law(all, "grid spline", 1.5, 1e-5, 3, "slope_rms");
}

TEST(BenchAccuracy, interpolation_in_time_follows_its_law_within_a_factor_of_two) {
    const std::map<std::string, Trial> all = quick_trials("interval");
    for (const char* rule : {"interval hermite", "interval linear", "interval hold"})
        expect_law(all, rule, 2.0, 1e-6, 5);
    for (const char* rule : {"interval hermite", "interval linear"})
        expect_law(all, rule, 1.5, 1e-5, 5, "slope_rms");
}

TEST(BenchAccuracy, codec_never_errs_by_more_than_its_bound_and_follows_its_law) {
    const std::map<std::string, Trial> all = quick_trials("codec");
    for (const auto& [trial, figures] : all) {
        ASSERT_TRUE(figures.contains("codec_over_bound")) << trial;
        // A float of rounding beside a bound of up to a metre; half of it is reached all the time.
        EXPECT_LE(figures.at("codec_over_bound"), 1.0 + 1e-6) << trial;
        EXPECT_GT(figures.at("codec_over_bound"), 0.5) << trial;
    }
    for (const char* form : {"codec bound", "codec compact bound", "codec predicted bound"})
        expect_law(all, form, 2.0, 1e-6, 6);
    // A bound of 1 m is larger than the waves: their slopes end where they do.
    for (const char* bound : {"codec bound@0.1", "codec bound@0.0", "codec bound@0.00"})
        expect_law(all, bound, 1.5, 1e-5, 1, "slope_rms");
}

TEST(BenchAccuracy, phases_in_float_lose_the_sea_and_fixed_point_phases_do_not) {
    const std::map<std::string, Trial> all = quick_trials("phase");
    // Single precision: error in proportion to time, until the waves are others than they should be. The
    // rounding of the time itself is a single draw, which may be near zero: only too much would be wrong.
    for (const auto& [trial, figures] : all)
        EXPECT_LT(figures.at("rms_m"), 3.0 * figures.at("predicted_rms_m") + 1e-6) << trial;
    const double hs_m = all.at("phase float32@1e+09").at("hs_m");
    EXPECT_GT(all.at("phase float32@1e+09").at("rms_m"), 0.1 * hs_m);
    for (const auto& [trial, figures] : all) {
        if (trial.rfind("phase fixed point", 0) != 0)
            continue;
        EXPECT_LT(figures.at("rms_m"), 1e-6 * hs_m) << trial;
    }
}

TEST(BenchAccuracy, sums_of_few_waves_miss_what_they_leave_out) {
    // 32 points anywhere: the scatter of an rms is up to a quarter.
    expect_law(quick_trials("modes"), "modes kept", 2.0, 1e-4, 4);
    expect_law(quick_trials("cutoff"), "cutoff cut", 2.0, 1e-4, 4);
}

} // namespace
} // namespace seaway
