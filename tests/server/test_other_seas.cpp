// SPDX-License-Identifier: Apache-2.0
// What seaway-query says of times at which another sea runs than now.
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/child_process.h"
#include "tests/server/change_bench.h"

namespace seaway::changes {
namespace {

// Naive: a program that has connected a moment ago takes the sea of now for that of any time, and its waves have their bound there.
TEST(Changes, who_asks_from_waves_for_the_time_of_another_sea_is_answered_from_that_one) {
    tests::ServerProcess server(arguments(tests::folder().file("another")));
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    const Said said = ctl(url, {"set", "sea.seed=3", "--at", "1000", "--over", "10s"});
    ASSERT_EQ(said.code, 0) << said.words;
    const auto asked = [&](const std::string& how) {
        std::FILE* pipe = popen(
            (SEAWAY_BIN_DIR "/seaway-query " + url + " --at 3,4 --time 1100 --format json " + how)
                .c_str(),
            "r");
        std::array<char, 4096> text{};
        const std::size_t got = std::fread(text.data(), 1, text.size(), pipe);
        EXPECT_EQ(pclose(pipe), 0) << how;
        return nlohmann::json::parse(std::string(text.data(), got), nullptr, false).at(0);
    };
    const double exact_m = asked("--exact").at("height_m");
    for (const char* how : {"--local", "--local --from spectrum", "--local --from scene"}) {
        const nlohmann::json answer = asked(how);
        EXPECT_LE(std::abs(answer.at("height_m").get<double>() - exact_m),
                  answer.at("error_m").get<double>())
            << how;
        EXPECT_EQ(answer.at("flags"), 0) << how;
    }
}

} // namespace
} // namespace seaway::changes
