// SPDX-License-Identifier: Apache-2.0
// What a hard case leaves behind for docs/hard-cases.md: the input, and what naive code and ours made
// of it. tools/hard_cases_page.py reads it from the test's JSON.
#pragma once

#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace seaway::hard_cases {

/// `measure` is what the two figures are, with its unit.
inline void record(const std::string& input, const std::string& measure, double figure_naive,
                   double figure_ours) {
    testing::Test::RecordProperty("input", input);
    testing::Test::RecordProperty("unit", measure);
    testing::Test::RecordProperty("figure_naive", fmt::format("{:.2g}", figure_naive));
    testing::Test::RecordProperty("figure_ours", fmt::format("{:.2g}", figure_ours));
}

/// Where no naive code was run.
inline void record(const std::string& input, const std::string& measure, double figure_ours) {
    testing::Test::RecordProperty("input", input);
    testing::Test::RecordProperty("unit", measure);
    testing::Test::RecordProperty("figure_ours", fmt::format("{:.2g}", figure_ours));
}

} // namespace seaway::hard_cases
