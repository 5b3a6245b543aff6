// SPDX-License-Identifier: Apache-2.0
// "Every function may be called from any thread at any time, also several at once for one client" (seaway.h), over a line that
// breaks meanwhile. A race shows under the thread sanitizer.
#include <atomic>
#include <cmath>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/client/engine.h"
#include "tests/support/eventually.h"
#include "tests/support/fault_proxy.h"

namespace seaway {
namespace {

class AnyThread : public tests::WaveServer {
  protected:
    std::unique_ptr<tests::FaultProxy> line;
    seaway_client* client = nullptr;
    std::vector<seaway_point> points;

    void SetUp() override {
        WaveServer::SetUp();
        line = std::make_unique<tests::FaultProxy>(net->port());
        const std::string url = "ws://127.0.0.1:" + std::to_string(line->port());
        ASSERT_EQ(seaway_connect(url.c_str(), nullptr, &client), SEAWAY_OK) << seaway_last_error();
        ASSERT_EQ(seaway_subscribe(client, nullptr), SEAWAY_OK) << seaway_last_error();
        for (int i = 0; i < 16; ++i)
            points.push_back({31.0 * i, -17.0 * i, seaway_now_us(client)});
    }
    void TearDown() override { seaway_disconnect(client); }

    seaway_status status() const {
        seaway_status now{};
        now.size = sizeof(now);
        EXPECT_EQ(seaway_get_status(client, &now), SEAWAY_OK);
        return now;
    }

    using Call = std::function<seaway_code()>;

    Call sampling() {
        return [this] {
            std::vector<seaway_answer> answers(points.size());
            const seaway_code code =
                seaway_sample(client, points.data(), points.size(), answers.data());
            for (const seaway_answer& answer : answers)
                EXPECT_TRUE(std::isfinite(answer.height_m));
            return code;
        };
    }

    Call looking() {
        return [this] {
            std::vector<seaway_water> water(points.size());
            return seaway_sample_water(client, nullptr, points.data(), points.size(), water.data(),
                                       sizeof(seaway_water));
        };
    }

    Call diving() {
        return [this] {
            std::vector<seaway_below> below(points.size());
            const std::vector<double> z_m(points.size(), -1);
            const seaway_code asked =
                seaway_query_below(client, nullptr, points.data(), z_m.data(), points.size(), 5,
                                   below.data(), sizeof(seaway_below));
            const seaway_code sampled =
                seaway_sample_below(client, nullptr, points.data(), z_m.data(), points.size(),
                                    below.data(), sizeof(seaway_below));
            return sampled == SEAWAY_NOT_HELD ? asked : sampled;
        };
    }

    Call asking() {
        return [this] {
            std::vector<seaway_answer> answers(points.size());
            std::uint64_t question = 0;
            const seaway_code code =
                seaway_ask(client, points.data(), points.size(), 0, 5, &question);
            if (code != SEAWAY_OK)
                return code;
            seaway_event event = SEAWAY_SIZED(seaway_event);
            (void)seaway_poll(client, 0.01, &event);
            const seaway_code taken =
                seaway_take_answers(client, question, answers.data(), answers.size());
            return taken == SEAWAY_PENDING ? seaway_cancel(client, question) : taken;
        };
    }

    Call subscribing() {
        return [this, turn = 0]() mutable {
            seaway_wish wish = SEAWAY_SIZED(seaway_wish);
            wish.timeout_s = 5;
            wish.cascades = ++turn % 2 == 0 ? 1 : 0;
            if (turn % 3 == 0)
                (void)seaway_unsubscribe(client);
            seaway_subscription waves{};
            waves.rung = SEAWAY_SPECTRUM;
            waves.timeout_s = 5;
            (void)seaway_subscribe(client, &waves);
            return seaway_subscribe_to(client, &wish, nullptr);
        };
    }

    Call drawing() {
        return [this, texels = std::vector<float>(512 * 512)]() mutable {
            seaway_map_wish wish = SEAWAY_SIZED(seaway_map_wish);
            seaway_map map = SEAWAY_SIZED(seaway_map);
            wish.time_us = points[0].time_us;
            wish.channels = 1;
            return seaway_get_map(client, &wish, texels.data(), texels.size() * sizeof(float),
                                  &map);
        };
    }

    Call watching() {
        return [this] {
            const auto told = [](void* user, const seaway_status* status) {
                static_cast<std::atomic<std::uint32_t>*>(user)->store(status->connections);
            };
            std::atomic<std::uint32_t> connections = 0;
            seaway_state state = SEAWAY_SIZED(seaway_state);
            seaway_source source = SEAWAY_SIZED(seaway_source);
            seaway_sea bulk{};
            (void)seaway_get_state(client, &state);
            (void)seaway_get_source(client, points[0].time_us, &source);
            (void)seaway_sea_at(client, points[0].time_us, &bulk);
            (void)seaway_watch_status(client, told, &connections);
            return seaway_watch_status(client, nullptr, nullptr);
        };
    }
};

TEST_F(AnyThread, may_call_every_function_while_others_do_and_the_line_breaks) {
    std::vector<Call> calls = {sampling(),    looking(), asking(),  diving(),
                               subscribing(), drawing(), watching()};
    constexpr std::size_t rounds_least = 5;
    std::atomic<bool> over = false;
    std::vector<std::size_t> rounds(calls.size());
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < calls.size(); ++t)
        threads.emplace_back([&, t] {
            std::int64_t before_us = 0;
            for (; rounds[t] < rounds_least || !over; ++rounds[t]) {
                const seaway_code code = calls[t]();
                EXPECT_NE(code, SEAWAY_INTERNAL) << t << ": " << seaway_last_error();
                EXPECT_NE(code, SEAWAY_BAD_ARGUMENT) << t << ": " << seaway_last_error();
                const std::int64_t now_us = seaway_now_us(client);
                EXPECT_GE(now_us, before_us) << "time ran back";
                before_us = now_us;
            }
        });
    // Waits grow for as long as a line is cut before it is subscribed to again.
    for (std::uint32_t connections = 1; connections < 6; ++connections) {
        line->cut();
        EXPECT_TRUE(tests::eventually([&] {
            const seaway_status now = status();
            return now.connections > connections && now.state == SEAWAY_CONNECTED;
        })) << status().reason;
    }
    over = true;
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_EQ(status().seas, 1u) << "it is the same sea all the time";
    std::vector<seaway_answer> answers(points.size());
    EXPECT_EQ(seaway_query(client, points.data(), points.size(), 0, 30, answers.data()), SEAWAY_OK)
        << seaway_last_error();
}

} // namespace
} // namespace seaway
