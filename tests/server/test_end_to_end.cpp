// SPDX-License-Identifier: Apache-2.0
// The whole way of the data with real programs, sockets and device: scene to answer.
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "client/client.h"
#include "tests/support/server_process.h"

namespace seaway {
namespace {

using client::Client;
using sea::Answer;
using sea::QueryPoint;

Result<std::unique_ptr<Client>> connect(const std::string& url) {
    client::ConnectOptions options;
    options.url = url;
    return Client::connect(options);
}

/// Ten points at each of a hundred times, all random: |x| up to 1e6 m, from a year before the
/// sea's epoch to thirty years after it.
std::vector<QueryPoint> random_points() {
    std::mt19937_64 random(20261121);
    std::uniform_real_distribution<double> place(-1e6, 1e6);
    std::uniform_int_distribution<sea::TimeUs> time(-31'557'600'000'000, 946'728'000'000'000);
    std::vector<QueryPoint> points;
    for (int t = 0; t < 100; ++t) {
        const sea::TimeUs time_us = time(random);
        for (int i = 0; i < 10; ++i)
            points.push_back({place(random), place(random), time_us});
    }
    return points;
}

class EndToEnd : public ::testing::TestWithParam<const char*> {};

TEST_P(EndToEnd, server_local_and_exact_answers_agree_within_the_stated_bound) {
    tests::ServerProcess server({"scenes/north_sea_gale.toml", "--listen", "127.0.0.1:0",
                                 "--device", GetParam(), "--validation"});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    Result<std::unique_ptr<Client>> client = connect(url);
    ASSERT_TRUE(client) << client.error().message;

    const std::vector<QueryPoint> points = random_points();
    const Result<std::vector<Answer>> served = (*client)->ask(points, {.timeout_s = 120});
    ASSERT_TRUE(served) << served.error().message;
    const Result<std::vector<Answer>> exact =
        (*client)->ask(points, {.exact = true, .timeout_s = 120});
    ASSERT_TRUE(exact) << exact.error().message;
    const Result<std::vector<Answer>> local = (*client)->fetch_and_sample(points, 120);
    ASSERT_TRUE(local) << local.error().message;

    double height_max = 0;
    double worst_bound_m = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double truth = (*exact)[i].height_m;
        height_max = std::max(height_max, std::abs(truth));
        for (const Answer* answer : {&(*served)[i], &(*local)[i]}) {
            EXPECT_LE(std::abs(answer->height_m - truth), answer->error_m + (*exact)[i].error_m)
                << "point " << i;
            EXPECT_EQ(answer->flags & (sea::answer_extrapolated | sea::answer_invalid), 0u);
            if (!(answer->flags & (sea::answer_folded | sea::answer_not_converged)))
                worst_bound_m = std::max(worst_bound_m, answer->error_m);
            EXPECT_NEAR(std::hypot(answer->normal[0], answer->normal[1], answer->normal[2]), 1.0,
                        1e-6);
        }
        EXPECT_TRUE((*exact)[i].flags & sea::answer_exact);
    }
    // Promise for height_error_m = 0.01; a gale's slopes stay below 1.
    EXPECT_LE(worst_bound_m, 0.02);
    EXPECT_GT(height_max, 3.0) << "an Hs of 6.6 m must show in 1000 points";
    client->reset();
    server.send(SIGTERM);
    EXPECT_EQ(server.wait_for_exit(std::chrono::seconds(2)), 0);
    EXPECT_EQ(server.log().find("VUID"), std::string::npos) << server.log();
}

INSTANTIATE_TEST_SUITE_P(Devices, EndToEnd, ::testing::Values("auto", "native"),
                         [](const auto& device) { return std::string(device.param); });

struct BadStart {
    const char* what;
    std::vector<std::string> arguments;
    int exit_code;
    const char* says;
};

class BadStarts : public ::testing::TestWithParam<BadStart> {};

TEST_P(BadStarts, one_helpful_line_and_the_documented_exit_code) {
    tests::ServerProcess server(GetParam().arguments);
    EXPECT_EQ(server.wait_until_ready(), "");
    EXPECT_EQ(server.wait_for_exit(std::chrono::seconds(60)), GetParam().exit_code);
    const std::string log = server.log();
    EXPECT_NE(log.find(GetParam().says), std::string::npos) << log;
    EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 1) << log;
}

INSTANTIATE_TEST_SUITE_P(
    All, BadStarts,
    ::testing::Values(
        BadStart{"missing_file", {"no/such/scene.toml"}, 2, "no/such/scene.toml"},
        BadStart{"broken_toml", {"tests/data/scenes/broken.toml"}, 2, "broken.toml:"},
        BadStart{"unknown_key", {"tests/data/scenes/unknown_key.toml"}, 2, "colour"},
        BadStart{"value_out_of_range", {"tests/data/scenes/out_of_range.toml"}, 2, "gamma"},
        BadStart{
            "unknown_device", {"scenes/north_sea_gale.toml", "--device", "abacus"}, 3, "abacus"},
        BadStart{"bad_address",
                 {"scenes/north_sea_gale.toml", "--device", "native", "--listen", "here:there"},
                 4,
                 "here:there"}),
    [](const auto& start) { return std::string(start.param.what); });

TEST(Start, port_in_use_is_exit_code_4) {
    const std::vector<std::string> arguments{"scenes/north_sea_gale.toml", "--device", "native",
                                             "--listen"};
    std::vector<std::string> first_arguments = arguments;
    first_arguments.push_back("127.0.0.1:0");
    tests::ServerProcess first(first_arguments);
    const std::string url = first.wait_until_ready();
    ASSERT_FALSE(url.empty()) << first.log();
    std::vector<std::string> second_arguments = arguments;
    second_arguments.push_back(url.substr(std::string("ws://").size()));
    tests::ServerProcess second(second_arguments);
    EXPECT_EQ(second.wait_for_exit(std::chrono::seconds(60)), 4);
    EXPECT_NE(second.log().find("in use"), std::string::npos) << second.log();
}

TEST(Stop, both_signals_end_it_within_two_seconds_with_clients_connected) {
    for (const int signal : {SIGTERM, SIGINT}) {
        tests::ServerProcess server(
            {"scenes/north_sea_gale.toml", "--device", "native", "--listen", "127.0.0.1:0"});
        const std::string url = server.wait_until_ready();
        ASSERT_FALSE(url.empty()) << server.log();
        Result<std::unique_ptr<Client>> client = connect(url);
        ASSERT_TRUE(client) << client.error().message;
        ASSERT_TRUE((*client)->subscribe({.fields = sea::surface_fields}, 2, 10));
        server.send(signal);
        EXPECT_EQ(server.wait_for_exit(std::chrono::seconds(2)), 0) << server.log();
    }
}

} // namespace
} // namespace seaway
