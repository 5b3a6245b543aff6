// SPDX-License-Identifier: Apache-2.0
// seaway-inspect's report of a scene as JSON.
#pragma once

#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/program.h"

namespace seaway::testing {

inline nlohmann::json report_of(const std::string& scene) {
    const tests::Output output = tests::run_program("seaway-inspect", scene + " --format json");
    EXPECT_EQ(output.status, 0) << output.err;
    EXPECT_EQ(output.err, "");
    return nlohmann::json::parse(output.out, nullptr, false);
}

} // namespace seaway::testing
