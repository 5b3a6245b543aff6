// SPDX-License-Identifier: Apache-2.0
// The client library whose server is killed, stops, moves, or becomes another one: real servers, and a program that samples
// sixty times a second through all of it.
#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <limits>
#include <mutex>
#include <thread>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/client.h"
#include "client/link/failure.h"
#include "tests/support/eventually.h"
#include "tests/support/fault_proxy.h"
#include "tests/support/folder.h"
#include "tests/support/server_process.h"

namespace seaway {
namespace {

using client::Client;
using client::Failure;
using client::LinkState;
using std::chrono::milliseconds;

constexpr double x_m = 31, y_m = -7;

/// What a program sees that asks for the height of now, again and again.
class Sampler {
  public:
    struct Look {
        std::int64_t before_us = 0, after_us = 0; ///< of the local clock
        int seas = 0;
        sea::QueryPoint point{};
        std::optional<sea::Answer> answer; ///< none: why
        Failure why = Failure::none;
    };

    explicit Sampler(Client& client) : client_(client), thread_([this] { run(); }) {}
    ~Sampler() { stop(); }

    std::vector<Look> stop() {
        stopped_ = true;
        if (thread_.joinable())
            thread_.join();
        return looks_;
    }

  private:
    void run() {
        while (!stopped_) {
            Look look;
            look.seas = client_.status().seas;
            look.before_us = client::local_now_us();
            look.point = {x_m, y_m, client_.now_us()};
            look.after_us = client::local_now_us();
            const auto sampled = client_.sample({&look.point, 1});
            if (sampled)
                look.answer = sampled->front();
            else
                look.why = client::failure_of(sampled.error());
            if (look.seas == client_.status().seas) // else it is of two
                looks_.push_back(look);
            std::this_thread::sleep_for(std::chrono::microseconds(16'667));
        }
    }

    Client& client_;
    std::atomic<bool> stopped_ = false;
    std::vector<Look> looks_;
    std::thread thread_;
};

/// Time goes on, and never faster than twice the clock on the wall (link/clock.h), which is what catches up.
void expect_no_jump_in_time(const std::vector<Sampler::Look>& looks) {
    for (std::size_t i = 1; i < looks.size(); ++i) {
        if (looks[i].seas != looks[i - 1].seas)
            continue;
        const auto passed_us = looks[i].after_us - looks[i - 1].before_us;
        EXPECT_GE(looks[i].point.time_us, looks[i - 1].point.time_us) << i;
        EXPECT_LE(looks[i].point.time_us - looks[i - 1].point.time_us, 2 * passed_us + 1) << i;
    }
}

/// Every height that was given within what is held is that of the sea, which has no jumps, within its error. How many of
/// them are flagged stale.
int expect_the_sea(Client& client, const std::vector<Sampler::Look>& looks) {
    std::vector<sea::QueryPoint> points;
    std::vector<sea::Answer> answers;
    for (const Sampler::Look& look : looks)
        if (look.answer && look.seas == client.status().seas &&
            (look.answer->flags & sea::answer_extrapolated) == 0) {
            points.push_back(look.point);
            answers.push_back(*look.answer);
        }
    const auto truth = client.ask(points, {.exact = true, .timeout_s = 100});
    EXPECT_TRUE(truth) << (truth ? "" : truth.error().message);
    int stale = 0;
    for (std::size_t i = 0; truth && i < points.size(); ++i) {
        EXPECT_NEAR(answers[i].height_m, (*truth)[i].height_m, answers[i].error_m)
            << "at " << points[i].time_us << " us";
        stale += (answers[i].flags & sea::answer_stale) != 0;
    }
    return stale;
}

/// A program is answered all the time. Where nothing is held the sea comes to stand, no higher than waves are, and once all
/// of it stands what it states to miss does not shrink; it is told so. A cascade whose last keyframe is still to come is best known there.
void expect_a_standing_sea(const std::vector<Sampler::Look>& looks, const client::SeaState& state) {
    constexpr double higher_than_waves_m = 1; // of 0.12 m
    const auto longest =
        std::ranges::max_element(state.cascades, {}, &protocol::CascadeInfo::interval_us);
    sea::TimeUs first_us = std::numeric_limits<sea::TimeUs>::max();
    double standing_s = 0;
    int followed = 0; // by another frame, as soon as frames are
    const sea::Answer* before = nullptr;
    sea::TimeUs before_us = 0;
    for (const Sampler::Look& look : looks) {
        ASSERT_TRUE(look.answer) << static_cast<int>(look.why);
        const sea::Answer& answer = *look.answer;
        EXPECT_LT(std::abs(answer.height_m), higher_than_waves_m);
        const bool stands = (answer.flags & sea::answer_extrapolated) != 0 &&
                            (answer.flags & sea::answer_stale) != 0;
        if (stands)
            first_us = std::min(first_us, look.point.time_us);
        if (stands && before != nullptr) {
            if (look.point.time_us > first_us + longest->interval_us) {
                EXPECT_GE(answer.error_m, before->error_m * (1 - 1e-3));
            }
            const double passed_s = sea::seconds_from_us(look.point.time_us - before_us);
            if (passed_s < 0.1) {
                EXPECT_NEAR(answer.height_m, before->height_m, 0.05)
                    << "from one frame to the next";
                ++followed;
            }
            standing_s += passed_s;
        }
        before = stands ? &answer : nullptr;
        before_us = look.point.time_us;
    }
    EXPECT_GT(standing_s, 1) << "of three";
    EXPECT_GT(followed, 0);
}

std::vector<std::string> arguments(int port, const std::string& data_dir,
                                   const std::string& scene = "scenes/calm.toml") {
    std::vector<std::string> words{scene, "--listen", fmt::format("127.0.0.1:{}", port), "--device",
                                   "native"};
    if (!data_dir.empty())
        words.insert(words.end(), {"--data-dir", data_dir});
    return words;
}

/// A server behind one name, which is a proxy's, and a client that has subscribed there.
class GoesOn : public ::testing::Test {
  protected:
    std::unique_ptr<tests::ServerProcess> server;
    std::unique_ptr<tests::FaultProxy> line;
    std::unique_ptr<Client> client;
    std::mutex mutex;
    std::vector<client::ClientStatus> told;

    /// At whatever port.
    void serve(std::vector<std::string> words) {
        server = std::make_unique<tests::ServerProcess>(std::move(words));
        const std::string url = server->wait_until_ready();
        ASSERT_FALSE(url.empty()) << server->log();
        if (line)
            line->lead_to(tests::port_of(url));
        else
            line = std::make_unique<tests::FaultProxy>(tests::port_of(url));
    }
    void connect(bool tiles, bool waves, bool stays_lost = false) {
        auto made = Client::connect({.url = fmt::format("ws://127.0.0.1:{}", line->port()),
                                     .timeout_s = 60,
                                     .stays_lost = stays_lost},
                                    {.on_status = [this](const client::ClientStatus& status) {
                                        const std::scoped_lock lock(mutex);
                                        told.push_back(status);
                                    }});
        ASSERT_TRUE(made) << made.error().message;
        client = std::move(*made);
        EXPECT_TRUE(!tiles || client->subscribe({.fields = sea::surface_fields}, 2, 30));
        EXPECT_TRUE(!waves || client->subscribe_spectrum({}, 30));
    }
    void TearDown() override {
        client.reset(); // before what its events write to
    }
    void kill_server() {
        server->send(SIGKILL);
        ASSERT_TRUE(server->wait_for_exit(std::chrono::seconds(10)));
        line->lead_to(1); // where nobody listens: its port may be somebody else's by now
        line->cut();
    }
    bool is_in(LinkState state) {
        return tests::eventually([&] { return client->status().state == state; });
    }
    bool samples_now() {
        return tests::eventually([&] {
            const sea::QueryPoint point{x_m, y_m, client->now_us()};
            const auto answer = client->sample({&point, 1});
            return answer && answer->front().flags == 0;
        });
    }
};

TEST_F(GoesOn, after_a_server_was_killed_and_came_again_at_another_port) {
    const std::string folder = tests::folder().file("killed");
    serve(arguments(0, folder));
    connect(true, false);
    ASSERT_TRUE(samples_now());
    Sampler sampler(*client);
    std::this_thread::sleep_for(milliseconds(500));
    const sea::TimeUs held_until_us = client->status().held_until_us;
    kill_server();
    EXPECT_TRUE(is_in(LinkState::waiting));
    const client::ClientStatus lost = client->status();
    EXPECT_NE(lost.reason, "");
    EXPECT_GT(lost.stale_s, 0);
    EXPECT_TRUE(lost.holds_tiles || client->now_us() > held_until_us + 500'000)
        << "unless this thread stood still";
    // Beyond the last keyframe the sea stands, and that is said.
    std::this_thread::sleep_for(std::chrono::seconds(3));
    serve(arguments(0, folder));
    EXPECT_TRUE(samples_now());
    std::this_thread::sleep_for(milliseconds(500));
    const std::vector<Sampler::Look> looks = sampler.stop();
    expect_no_jump_in_time(looks);
    EXPECT_GT(expect_the_sea(*client, looks), 0) << "what was held was flagged";
    expect_a_standing_sea(looks, *client->sea_state(looks.back().point.time_us));
    EXPECT_TRUE(tests::eventually([&] { return client->status().stale_s == 0; }));
    const client::ClientStatus status = client->status();
    EXPECT_EQ(status.state, LinkState::connected);
    EXPECT_EQ(status.connections, 2);
    EXPECT_EQ(status.seas, 1);
    const std::scoped_lock lock(mutex);
    const auto other = std::ranges::find_if(told, [](const client::ClientStatus& said) {
        return said.state != LinkState::connected; // before it was told what is held
    });
    ASSERT_NE(other, told.end());
    EXPECT_EQ(other->state, LinkState::waiting);
    EXPECT_EQ(told.back().state, LinkState::connected);
}

TEST_F(GoesOn, through_ten_seconds_without_a_server_where_it_has_the_waves) {
    const std::string folder = tests::folder().file("gone");
    serve(arguments(0, folder));
    connect(false, true);
    ASSERT_TRUE(samples_now());
    Sampler sampler(*client);
    kill_server();
    std::this_thread::sleep_for(std::chrono::seconds(10));
    EXPECT_TRUE(client->status().holds_waves);
    EXPECT_GT(client->clock().error_us, 13'000) << "1.5 ms a second";
    const sea::QueryPoint stale_point{x_m, y_m, client->now_us()};
    const auto stale = client->look({&stale_point, 1}, {});
    ASSERT_TRUE(stale) << stale.error().message;
    EXPECT_TRUE(stale->front().answer.flags & sea::answer_stale);
    const double reach_m = client->sea_state(0)->displacement_reach_m;
    EXPECT_GT(stale->front().displacement_error_m, 0.5 * reach_m)
        << "of a change of 10 s that began when it could, most is over";
    const std::int64_t back_us = client::local_now_us();
    serve(arguments(0, folder));
    EXPECT_TRUE(samples_now());
    std::this_thread::sleep_for(milliseconds(500));
    const std::vector<Sampler::Look> looks = sampler.stop();
    expect_no_jump_in_time(looks);
    EXPECT_GT(expect_the_sea(*client, looks), 0);
    double last_m = 0, most_m = 0;
    for (const Sampler::Look& look : looks) {
        ASSERT_TRUE(look.answer) << "waves have no end";
        if (!(look.answer->flags & sea::answer_stale))
            continue;
        most_m = std::max(most_m, look.answer->error_m);
        // The sum of waves has a bound of its own at every point; what staleness adds to it only grows, until a server has been
        // heard again.
        if (look.after_us < back_us) {
            EXPECT_GT(look.answer->error_m, 0.5 * last_m);
        }
        last_m = look.answer->error_m;
    }
    EXPECT_GT(most_m, client->sea_state(0)->realised.hs_m / 4)
        << "of a change of 10 s that began when it could, most is over";
    EXPECT_EQ(client->status().seas, 1);
}

TEST_F(GoesOn, stays_away_for_as_long_as_a_server_that_stops_says_and_comes_back) {
    const std::string folder = tests::folder().file("stops");
    std::vector<std::string> words = arguments(0, folder);
    words.insert(words.end(), {"--retry-after", "3"});
    serve(words);
    connect(true, false);
    ASSERT_TRUE(samples_now());
    Sampler sampler(*client);
    const std::int64_t lost_us = client::local_now_us();
    server->send(SIGTERM);
    ASSERT_TRUE(is_in(LinkState::waiting));
    EXPECT_THAT(client->status().reason, testing::HasSubstr("shutting_down"));
    EXPECT_EQ(client->end()->retry_after_ms, 3000u);
    ASSERT_TRUE(server->wait_for_exit(std::chrono::seconds(30)));
    serve(words);
    EXPECT_TRUE(samples_now());
    EXPECT_GE(client::local_now_us() - lost_us, 2'900'000) << "looked at every few milliseconds";
    const std::vector<Sampler::Look> looks = sampler.stop();
    expect_no_jump_in_time(looks);
    expect_the_sea(*client, looks);
    EXPECT_EQ(client->status().seas, 1);
}

// It writes before it has read, to a peer that has gone, and is answered with a reset. Without threads a program is held up for sure.
TEST_F(GoesOn, who_was_held_up_while_a_server_stopped_hears_its_last_word) {
    std::vector<std::string> words = arguments(0, "");
    words.insert(words.end(), {"--retry-after", "30"});
    for (int round = 0; round < 3; ++round) {
        tests::ServerProcess stops(words);
        const std::string url = stops.wait_until_ready();
        ASSERT_FALSE(url.empty()) << stops.log();
        auto made = Client::connect({.url = url, .timeout_s = 60, .threadless = true}, {});
        ASSERT_TRUE(made) << made.error().message;
        client = std::move(*made);
        ASSERT_TRUE(client->subscribe({.fields = sea::surface_fields}, 8, 30));
        std::this_thread::sleep_for(milliseconds(1200)); // until it owes pings and acknowledgements
        stops.send(SIGTERM);
        ASSERT_TRUE(stops.wait_for_exit(std::chrono::seconds(30)));
        const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
        while (client->status().state == LinkState::connected &&
               std::chrono::steady_clock::now() < until)
            client->work_until(std::chrono::steady_clock::now(), [] { return false; });
        const client::ClientStatus status = client->status();
        EXPECT_THAT(status.reason, testing::HasSubstr("shutting_down"));
        EXPECT_GT(status.next_attempt_s, 25);
        client.reset();
    }
}

// Without a journal the same scene begins anew, at time 0: it is not the sea of before.
TEST_F(GoesOn, never_mixes_two_seas_behind_one_name) {
    for (const char* next : {"scenes/shallow_lagoon.toml", "scenes/calm.toml"}) {
        serve(arguments(0, ""));
        connect(true, true);
        ASSERT_TRUE(samples_now());
        std::this_thread::sleep_for(milliseconds(1500));
        Sampler sampler(*client);
        kill_server();
        serve(arguments(0, "", next));
        EXPECT_TRUE(tests::eventually([&] { return client->status().seas == 2; }));
        EXPECT_TRUE(samples_now());
        std::this_thread::sleep_for(milliseconds(500));
        const std::vector<Sampler::Look> looks = sampler.stop();
        EXPECT_THAT(client->status().reason, testing::HasSubstr("another sea")) << next;
        expect_no_jump_in_time(looks);
        expect_the_sea(*client, looks);
        client.reset();
        line.reset();
    }
}

TEST_F(GoesOn, stops_where_it_is_turned_away_for_good) {
    const std::string folder = tests::folder().file("turned");
    const std::string token = tests::folder().file("token");
    std::ofstream(token) << "a-token-that-nobody-knows-0123456789\n";
    std::filesystem::permissions(token, std::filesystem::perms::owner_read);
    serve(arguments(0, folder));
    connect(false, true);
    kill_server();
    std::vector<std::string> words = arguments(0, folder);
    words.insert(words.end(), {"--client-token-file", token});
    serve(words);
    ASSERT_TRUE(is_in(LinkState::stopped));
    EXPECT_THAT(client->status().reason, testing::HasSubstr("token"));
    const sea::QueryPoint point{x_m, y_m, client->now_us()};
    EXPECT_TRUE(client->sample({&point, 1})) << "what is held can still be sampled";
}

TEST_F(GoesOn, not_where_it_was_told_not_to) {
    serve(arguments(0, ""));
    connect(false, true, true);
    kill_server();
    ASSERT_TRUE(is_in(LinkState::stopped));
    EXPECT_FALSE(client->is_open());
    EXPECT_NE(client->closed_reason(), "");
    const std::scoped_lock lock(mutex);
    EXPECT_LE(std::ranges::count_if(told,
                                    [](const client::ClientStatus& said) {
                                        return said.state != LinkState::connected;
                                    }),
              1);
}

} // namespace
} // namespace seaway
