// SPDX-License-Identifier: Apache-2.0
// A client that has asked about a sea before everybody is told of it.
#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "client/client.h"
#include "tests/server/change_bench.h"
#include "tests/support/eventually.h"

namespace seaway::changes {
namespace {

using client::Client;

/// Shallower from then on, so that displacements follow from heights no more: what a stream holds is other than before.
std::string shallow_from(double at_s) {
    return fmt::format(R"(
[sea]
seed = 7
depth_m = 60
choppiness = 0.8
[[sea.system]]
type = "wind"
spectrum = "jonswap"
wind_speed_10m_mps = 10
from_deg = 200
fetch_m = 100e3
[[cascade]]
length_m = 500
size = 64
[[cascade]]
length_m = 83
size = 64
[accuracy]
height_error_m = 0.03
[[weather]]
at_s = {}
over_s = 10
set = {{ sea.depth_m = 20 }}
)",
                       at_s);
}

/// Of keyframes or waves that came, now; on a busy machine some come late.
void expect_now(Client& client, const char* whose) {
    std::vector<sea::QueryPoint> points;
    Result<std::vector<sea::Answer>> own = Error{"nothing has come"};
    ASSERT_TRUE(tests::eventually([&] {
        points.clear();
        for (int place = 0; place < 20; ++place)
            points.push_back({31.0 * place, -17.0 * place, client.now_us() - 100'000});
        own = client.sample(points);
        return own && std::ranges::none_of(*own, [](const sea::Answer& answer) {
                   return (answer.flags & sea::answer_extrapolated) != 0;
               });
    })) << whose;
    const auto exact = client.ask(points, {.exact = true, .timeout_s = 60});
    ASSERT_TRUE(exact) << whose << ": " << exact.error().message;
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_LE(std::abs((*own)[i].height_m - (*exact)[i].height_m),
                  (*own)[i].error_m + (*exact)[i].error_m)
            << whose;
    }
}

// Naive: who has been sent the state of a sea, for a question about it, is not told of it when it comes: neither does what was
// granted follow it, so that keyframes are sent which lack half of it, nor do its waves come.
TEST(Changes, who_looked_ahead_at_a_sea_is_served_it_like_others) {
    double at_s = 30;
    std::unique_ptr<tests::ServerProcess> server;
    std::unique_ptr<Client> tiles, waves;
    const auto look_ahead = [&] {
        tiles = nullptr;
        waves = nullptr;
        server = std::make_unique<tests::ServerProcess>(natively("soon.toml", shallow_from(at_s)));
        const std::string url = server->wait_until_ready();
        tiles = connect(url);
        waves = connect(url);
        ASSERT_TRUE(tiles && waves) << server->log();
        ASSERT_TRUE(tiles->subscribe({.fields = sea::surface_fields}, 2, 60));
        ASSERT_TRUE(waves->subscribe_spectrum({}, 60));
        const sea::TimeUs ahead_us = sea::us_from_seconds(at_s + 5);
        for (const auto& client : {tiles.get(), waves.get()}) {
            ASSERT_TRUE(client->hold({&ahead_us, 1}, 60));
            EXPECT_TRUE(client->sea_state(ahead_us)->glide) << "it was told of that sea";
        }
    };
    look_ahead();
    // Else all have been told: a slow machine has more time once more.
    while (!HasFatalFailure() && sea::seconds_from_us(tiles->now_us()) >= at_s - 10) {
        at_s *= 2;
        ASSERT_LT(at_s, 300);
        look_ahead();
    }
    ASSERT_FALSE(HasFatalFailure());
    const sea::TimeUs ahead_us = sea::us_from_seconds(at_s + 5);
    // All are told ten seconds before it begins, and its waves come behind that.
    const auto has_waves = [&] {
        return waves->source(ahead_us).source == client::AnswersFrom::spectrum;
    };
    while (!has_waves() && sea::seconds_from_us(waves->now_us()) < at_s - 0.5)
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    EXPECT_TRUE(has_waves()) << "before it begins";
    for (const double then_s : {at_s + 3, at_s + 8, at_s + 13}) {
        wait_until(*tiles, then_s);
        expect_now(*tiles, "tiles");
        expect_now(*waves, "waves");
    }
}

} // namespace
} // namespace seaway::changes
