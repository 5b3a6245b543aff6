// SPDX-License-Identifier: Apache-2.0
// A client that samples the sea of now while the wind rises.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "client/client.h"
#include "tests/server/change_bench.h"
#include "tests/server/net/clients.h"
#include "tests/support/metrics_page.h"

namespace seaway::changes {
namespace {

using client::Client;

/// What a client saw at one place, 50 times a second.
struct Watched {
    std::vector<sea::QueryPoint> points;
    std::vector<sea::Answer> sampled;
    int extrapolated = 0;
};

/// Until a sea time. No step is larger than the water's speed makes it, and half a metre a second for its change and the glide.
Watched watched(Client& client, double until_s) {
    Watched seen;
    while (sea::seconds_from_us(client.now_us()) < until_s) {
        const sea::QueryPoint point{3, 4, client.now_us()};
        const auto answer = client.sample({&point, 1});
        if (!answer) {
            ADD_FAILURE() << answer.error().message;
            return seen;
        }
        const sea::Answer& now = answer->front();
        seen.extrapolated += (now.flags & sea::answer_extrapolated) != 0;
        if (!seen.points.empty()) {
            const sea::Answer& last = seen.sampled.back();
            const double dt_s = sea::seconds_from_us(point.time_us - seen.points.back().time_us);
            const double speed_mps =
                std::abs(now.velocity_mps[2]) + std::abs(last.velocity_mps[2]) + 0.5;
            // Without the keyframe that is due, which a busy machine may owe, it says so and may be off.
            if (dt_s < 0.1 && !((now.flags | last.flags) & sea::answer_extrapolated)) {
                EXPECT_LT(std::abs(now.height_m - last.height_m), 0.02 + speed_mps * dt_s)
                    << point.time_us;
            }
        }
        seen.points.push_back(point);
        seen.sampled.push_back(now);
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return seen;
}

/// Keyframes that this machine had no time for.
double left_out(const std::string& url) {
    const std::string page = tests::ask_http(tests::port_of(url), "/metrics", "GET").body;
    return tests::figure_of(page, "seaway_keyframes_skipped_total") +
           tests::figure_of(page, "seaway_net_keyframes_dropped_total");
}

/// The wind rises, and a client watches until two seconds behind the end of that.
struct Storm {
    Watched seen;
    double late_max = 0;
    /// Keyframes of each sea came before they were due: but for a tenth of the time, and half a second for each that was left out.
    bool in_time() const { return seen.extrapolated < late_max; }
};

Storm watched_storm(Client& client, const std::string& url, int wind_mps) {
    const double left_out_before = left_out(url);
    const Said said = ctl(
        url, {"set", fmt::format("systems.0.wind_speed_10m_mps={}", wind_mps), "--over", "10s"});
    EXPECT_EQ(said.code, 0) << said.words;
    const double start_s = number(said.words, "start_s"), end_s = number(said.words, "end_s");
    EXPECT_NEAR(end_s - start_s, 10, 1e-6);
    EXPECT_GT(start_s, sea::seconds_from_us(client.now_us())) << "announced before it begins";
    Storm storm;
    storm.seen = watched(client, end_s + 2);
    storm.late_max = 0.1 * static_cast<double>(storm.seen.points.size()) +
                     25 * (left_out(url) - left_out_before);
    return storm;
}

void expect_exact(Client& client, const Watched& seen) {
    for (std::size_t first = 0; first < seen.points.size(); first += 100) {
        const auto batch =
            std::span(seen.points)
                .subspan(first, std::min<std::size_t>(100, seen.points.size() - first));
        const auto exact = client.ask(batch, {.exact = true, .timeout_s = 60});
        ASSERT_TRUE(exact) << exact.error().message;
        for (std::size_t i = 0; i < batch.size(); ++i) {
            const sea::Answer& one = seen.sampled[first + i];
            if (one.flags & (sea::answer_extrapolated | sea::answer_folded))
                continue;
            EXPECT_LE(std::abs(one.height_m - (*exact)[i].height_m),
                      one.error_m + (*exact)[i].error_m)
                << batch[i].time_us;
        }
    }
}

// What a client samples from its stream is the exact sum of the server's, before, during and after; and no step of it is
// larger than those of the waves.
TEST(Changes, a_client_that_samples_sees_a_storm_come_without_a_jump_and_right_to_its_bounds) {
    tests::ServerProcess server(arguments(tests::folder().file("storm")));
    const std::string url = server.wait_until_ready();
    const auto client = connect(url);
    ASSERT_TRUE(client) << server.log();
    ASSERT_TRUE(client->subscribe({.fields = sea::surface_fields}, 8, 60));
    Storm storm;
    for (const int wind_mps : {17, 20, 23}) {
        storm = watched_storm(*client, url, wind_mps);
        expect_exact(*client, storm.seen);
        if (storm.in_time()) // else this machine may have been late with each, and left none out
            break;
    }
    const auto& [points, sampled, extrapolated] = storm.seen;
    ASSERT_GE(points.size(), 20u) << "50 a second";
    EXPECT_TRUE(storm.in_time()) << extrapolated << " of " << points.size() << ", "
                                 << storm.late_max << " may be late";
    EXPECT_GT(client->sea_state(client->now_us())->realised.hs_m,
              2 * client->sea_state(0)->realised.hs_m);
    // Who comes now sees the same sea, and who asks about the past the one that was.
    const auto late = connect(url);
    ASSERT_TRUE(late);
    EXPECT_EQ(late->sea_state(late->now_us())->realised.hs_m,
              client->sea_state(client->now_us())->realised.hs_m);
    const std::vector<sea::QueryPoint> past(points.begin(), points.begin() + 20);
    const auto fetched = late->fetch_and_sample(past, 20);
    ASSERT_TRUE(fetched) << fetched.error().message;
    for (std::size_t i = 0; i < past.size(); ++i) {
        if (sampled[i].flags & sea::answer_extrapolated)
            continue;
        EXPECT_NEAR((*fetched)[i].height_m, sampled[i].height_m,
                    (*fetched)[i].error_m + sampled[i].error_m);
    }
}

} // namespace
} // namespace seaway::changes
