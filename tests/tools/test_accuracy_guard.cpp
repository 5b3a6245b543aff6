// SPDX-License-Identifier: Apache-2.0
// The guard against errors that grow: what it measures today against tests/data/accuracy_baseline.csv,
// and the comparison itself against files that were tampered with. `seaway-bench guard --renew` writes
// that file anew, where errors are meant to be others.
#include <cstdio>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "base/text_file.h"
#include "tools/bench/accuracy/guard.h"

namespace seaway::bench {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::string baseline_path = SEAWAY_SOURCE_DIR "/tests/data/accuracy_baseline.csv";

std::string baseline_text() {
    const auto text = read_text_file(baseline_path, 1 << 20);
    return text ? *text : text.error().message;
}

/// The committed figures, with the one of this place in the file multiplied.
std::vector<GuardedFigure> tampered(std::size_t at, double factor) {
    auto figures = *parse_guard_csv(baseline_text(), baseline_path);
    figures.at(at).value *= factor;
    return figures;
}

std::size_t row_of(const std::vector<GuardedFigure>& figures, const std::string& configuration,
                   const std::string& metric) {
    for (std::size_t i = 0; i < figures.size(); ++i)
        if (figures[i].configuration == configuration && figures[i].metric == metric)
            return i;
    ADD_FAILURE() << configuration << ' ' << metric;
    return 0;
}

// The guard. Figures repeat to 1e-6 of themselves on one machine, and to a few percent where another
// instruction set rounds other bits of the transform; a fifth is the change that shall not pass unseen.
TEST(AccuracyGuard, no_error_has_grown_by_more_than_a_fifth) {
    const auto baseline = parse_guard_csv(baseline_text(), baseline_path);
    ASSERT_TRUE(baseline) << baseline.error().message;
    const auto measured = guarded_figures();
    ASSERT_TRUE(measured) << measured.error().message;
    const GuardFindings findings = compare_with_baseline(*baseline, *measured);
    for (const std::string& line : findings.told)
        std::printf("told: %s; renew with seaway-bench guard --renew\n", line.c_str());
    for (const std::string& line : findings.failures)
        ADD_FAILURE() << line;
}

TEST(AccuracyGuard, guards_presets_and_each_kernel_on_native_and_on_vulkan) {
    const auto figures = *parse_guard_csv(baseline_text(), baseline_path);
    for (const char* preset : {"precise", "balanced", "fast"})
        for (const char* metric : {"rms_m", "p99_m", "crest_rms_m", "slope_rms"})
            row_of(figures, preset, metric);
    for (const char* one : {"grids of 64", "keyframes 0.5 s apart", "codec 0.02 m",
                            "all waves summed", "choppiness 1.3"})
        row_of(figures, one, "rms_m");
    row_of(figures, "transform native", "transform_error");
    row_of(figures, "transform lavapipe", "transform_error");
}

TEST(AccuracyGuard, a_figure_grown_by_more_than_a_fifth_fails_with_name_old_and_new) {
    const auto today = tampered(0, 1);
    const std::size_t row = row_of(today, "balanced", "rms_m");
    const std::vector<GuardedFigure> before = {{"gale_deep", "balanced", "rms_m", 1e-3}};
    EXPECT_THAT(compare_with_baseline(
                    before, std::vector<GuardedFigure>{{"gale_deep", "balanced", "rms_m", 1.21e-3}})
                    .failures,
                ElementsAre("gale_deep, balanced: rms_m has grown: 0.00121, was 0.001 (+21 %)"));
    // A baseline that says a fifth less than what is so: today's figures are 25 % above it.
    const GuardFindings grown = compare_with_baseline(tampered(row, 0.8), today);
    EXPECT_THAT(grown.failures, ElementsAre(HasSubstr("gale_deep, balanced: rms_m has grown")));
    EXPECT_THAT(grown.told, IsEmpty());
    EXPECT_THAT(compare_with_baseline(tampered(row, 0.85), today).failures, IsEmpty());
}

TEST(AccuracyGuard, a_figure_fallen_by_more_than_a_fifth_is_told_and_does_not_fail) {
    const auto today = tampered(0, 1);
    const std::size_t row = row_of(today, "codec 0.02 m", "slope_rms");
    const GuardFindings fallen = compare_with_baseline(tampered(row, 1.3), today);
    EXPECT_THAT(fallen.failures, IsEmpty());
    EXPECT_THAT(fallen.told,
                ElementsAre(HasSubstr("gale_deep, codec 0.02 m: slope_rms has fallen")));
    EXPECT_THAT(compare_with_baseline(tampered(row, 1.2), today).told, IsEmpty());
}

TEST(AccuracyGuard, what_was_nothing_may_not_become_something_or_no_number) {
    const std::vector<GuardedFigure> nothing = {{"gale_deep", "fast", "beyond_bound_pct", 0}};
    for (const double now : {1e-9, std::numeric_limits<double>::quiet_NaN()}) {
        const std::vector<GuardedFigure> something = {
            {"gale_deep", "fast", "beyond_bound_pct", now}};
        EXPECT_EQ(compare_with_baseline(nothing, something).failures.size(), 1u) << now;
    }
}

TEST(AccuracyGuard, figures_that_stand_in_one_list_only_fail) {
    const auto today = tampered(0, 1);
    auto fewer = today;
    fewer.pop_back();
    EXPECT_THAT(compare_with_baseline(today, fewer).failures,
                ElementsAre(HasSubstr("is not measured any more")));
    EXPECT_THAT(compare_with_baseline(fewer, today).failures,
                ElementsAre(HasSubstr("has no figure to compare with")));
}

TEST(AccuracyGuard, a_baseline_that_is_not_one_is_refused_by_line) {
    const std::string header = "# note\nstate,configuration,metric,value\n";
    const std::pair<std::string, std::string> bad[] = {
        {"", "no figures"},
        {"state,metric\n", "x:1: not"},
        {header + "gale_deep,fast,rms_m\n", "x:3: not a row"},
        {header + "gale_deep,fast,rms_m,-1\n", "x:3: not a row"},
        {header + "gale_deep,fast,rms_m,nan\n", "x:3: not a row"},
        {header + "gale_deep,fast,rms_m,1 m\n", "x:3: not a row"},
        {header + "a,b,c,1\na,b,c,2\n", "x:4: stands there twice"}};
    for (const auto& [text, why] : bad) {
        const auto read = parse_guard_csv(text, "x");
        ASSERT_FALSE(read) << text;
        EXPECT_THAT(read.error().message, HasSubstr(why));
    }
    const auto written = guard_csv(tampered(0, 1));
    EXPECT_EQ(written, baseline_text()); // what is written reads back, and is what stands there
}

} // namespace
} // namespace seaway::bench
