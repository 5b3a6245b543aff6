// SPDX-License-Identifier: Apache-2.0
// What a client is subscribed to once its connection has come back: tiles and waves each for itself, with threads and without.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/client.h"
#include "client/link/failure.h"
#include "server/host/refusal.h"
#include "tests/client/wave_server.h"
#include "tests/support/fault_proxy.h"

namespace seaway::client {
namespace {

using testing::HasSubstr;
using tests::eventually;
using tests::FaultProxy;

/// Grants what the test lets it, and counts what it has been asked for.
class PickySea : public tests::WaveSea {
  public:
    using WaveSea::WaveSea;

    std::atomic<bool> refuses_tiles = false, refuses_waves = false;
    std::atomic<bool> holds_waves_back = false; ///< as one that does not know the question
    mutable std::atomic<int> tiles_asked = 0;
    std::atomic<int> waves_asked = 0;

    server::Demand grant(const server::Demand& wish,
                         std::optional<server::SessionId> session) const override {
        const bool refused = session && refuses_tiles;
        tiles_asked += session ? 1 : 0; // else a grant is renewed
        server::Demand none;
        none.why = "no tiles are left";
        return refused ? none : WaveSea::grant(wish, session);
    }
    Result<server::GrantedSpectrum> spectrum(const server::SpectrumRequest& request) override {
        const bool refused = refuses_waves;
        ++waves_asked;
        while (holds_waves_back)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        if (refused)
            return Error{server::Refusal::not_offered, "no waves are left"};
        return WaveSea::spectrum(request);
    }
};

/// Of other cascades, so that nobody takes it for that of before.
sea::RealizationPtr waves_of_another_sea() {
    return tests::known_waves({200.0, 36.0}, 25.0, {{0, 2, 1, 0.8, 0.3}, {1, 2, 3, 0.04, 1.0}});
}

/// A client of tiles, and of waves where that is said, on a line that can be cut.
struct OnTheWayBack {
    PickySea sea;
    std::unique_ptr<server::NetServer> net = tests::serve(sea);
    FaultProxy line{net->port()};
    std::atomic<double> longest_wait_s = 0; ///< for an attempt
    std::unique_ptr<Client> client;

    explicit OnTheWayBack(bool threadless, bool waves = true) {
        auto connected = Client::connect({.url = "ws://127.0.0.1:" + std::to_string(line.port()),
                                          .timeout_s = 60,
                                          .threadless = threadless},
                                         {.on_status = [this](const ClientStatus& status) {
                                             longest_wait_s = std::max(longest_wait_s.load(),
                                                                       status.next_attempt_s);
                                         }});
        EXPECT_TRUE(connected) << connected.error().message;
        client = std::move(*connected);
        EXPECT_TRUE(client->subscribe({.fields = sea::surface_fields, .error_m = 0.25f}, 2, 30));
        EXPECT_TRUE(!waves || client->subscribe_spectrum({}, 30));
    }
    ~OnTheWayBack() { sea.holds_waves_back = false; }

    template <class Condition>
    bool until(const Condition& condition) {
        return eventually([&] {
            if (client->threadless())
                client->work_until(std::chrono::steady_clock::now(), [] { return true; });
            return condition();
        });
    }
    bool is_back(int connections = 2) {
        return until([&] {
            const ClientStatus status = client->status();
            return status.connections == connections && status.state == LinkState::connected;
        });
    }
    /// Cuts the line, and no tiles are granted behind it. Has the client heard of that?
    bool comes_back_to_no_tiles() {
        sea.refuses_tiles = true;
        line.cut();
        return until(
            [&] { return client->status().reason.find("no tiles are left") != std::string::npos; });
    }
};

// Naive: what was subscribed to is noted when the line is back, and asked for whatever comes between.
TEST(OnTheWayBack, what_is_unsubscribed_from_is_not_asked_for_again) {
    for (const bool threadless : {false, true}) {
        OnTheWayBack way(threadless, false);
        ASSERT_TRUE(way.comes_back_to_no_tiles()) << way.client->status().reason;
        const int fetches = way.sea.fetches;
        way.client->unsubscribe();
        way.sea.refuses_tiles = false;
        ASSERT_TRUE(way.is_back()) << way.client->status().reason;
        const sea::QueryPoint point{0, 0, 0};
        ASSERT_TRUE(way.client->ask({&point, 1}, {})) << "what was sent before has come";
        EXPECT_EQ(way.sea.fetches, fetches) << "a subscription begins with one";
        EXPECT_FALSE(way.client->grant());
    }
}

TEST(OnTheWayBack, what_was_subscribed_to_last_is_what_comes) {
    for (const bool threadless : {false, true}) {
        OnTheWayBack way(threadless, false);
        ASSERT_TRUE(way.comes_back_to_no_tiles()) << way.client->status().reason;
        way.sea.refuses_tiles = false;
        EXPECT_TRUE(way.client->subscribe({.fields = sea::surface_fields, .error_m = 0.5f}, 2, 30));
        ASSERT_TRUE(way.is_back()) << way.client->status().reason;
        EXPECT_EQ(way.sea.wished_error_m, 0.5f);
    }
}

// Naive: waves come first, and where they are not to be had nobody asks for tiles: nothing is held of a sea that offers some.
TEST(OnTheWayBack, tiles_come_where_the_waves_of_another_sea_are_not_to_be_had) {
    for (const bool threadless : {false, true})
        for (const bool refused : {true, false}) {
            OnTheWayBack way(threadless);
            PickySea other(waves_of_another_sea());
            other.refuses_waves = refused;
            other.spectrum_change = [](sea::WaveBlock& block) {
                for (std::size_t i = 1; i < block.codes.size(); i += 2)
                    block.codes[i] = -block.codes[i]; // which the probes know
            };
            const auto another = tests::serve(other);
            ASSERT_TRUE(another);
            way.line.lead_to(another->port());
            way.line.cut();
            ASSERT_TRUE(way.is_back()) << way.client->status().reason;
            const ClientStatus status = way.client->status();
            EXPECT_EQ(status.seas, 2);
            EXPECT_TRUE(status.holds_tiles);
            EXPECT_THAT(status.reason, HasSubstr(refused ? "no waves are left" : "probes differ"));
            const sea::QueryPoint now{1, 2, way.client->now_us()};
            EXPECT_TRUE(way.client->sample({&now, 1}));
        }
}

TEST(OnTheWayBack, tiles_come_where_nobody_answers_who_asks_for_waves) {
    for (const bool threadless : {false, true}) {
        OnTheWayBack way(threadless, false);
        way.sea.holds_waves_back = true;
        const auto waves = way.client->subscribe_spectrum({}, 0.3);
        ASSERT_FALSE(waves);
        EXPECT_EQ(failure_of(waves.error()), Failure::deadline) << "so it may begin yet";
        const int fetches = way.sea.fetches;
        way.line.cut();
        ASSERT_TRUE(way.is_back()) << way.client->status().reason;
        EXPECT_GT(way.sea.fetches, fetches);
        EXPECT_THAT(way.client->status().reason, HasSubstr("in time"));
    }
}

// Naive: all is asked for again for as long as something is missed, 57 KB of waves each time.
TEST(OnTheWayBack, what_is_granted_is_not_fetched_anew_while_the_other_is_refused) {
    for (const bool threadless : {false, true})
        for (const bool no_tiles : {true, false}) {
            OnTheWayBack way(threadless);
            std::atomic<bool>& refuses = no_tiles ? way.sea.refuses_tiles : way.sea.refuses_waves;
            const auto& missed = no_tiles ? way.sea.tiles_asked : way.sea.waves_asked;
            const auto& granted = no_tiles ? way.sea.waves_asked : way.sea.tiles_asked;
            const int missed_before = missed, granted_before = granted;
            refuses = true;
            way.line.cut();
            ASSERT_TRUE(way.until([&] { return missed >= missed_before + 2; }));
            ASSERT_TRUE(way.is_back()) << way.client->status().reason;
            EXPECT_EQ(granted, granted_before + 1);
            EXPECT_THAT(way.client->status().reason,
                        HasSubstr(no_tiles ? "no tiles are left" : "no waves are left"));
            refuses = false;
            const int refused = missed;
            ASSERT_TRUE(way.until([&] { return missed > refused; })) << "it is asked for again";
            EXPECT_EQ(granted, granted_before + 1);
        }
}

// Naive: by the answer that came last, which may be of what has been granted since.
TEST(OnTheWayBack, the_reason_is_of_what_is_missed_now) {
    for (const bool threadless : {false, true}) {
        OnTheWayBack way(threadless);
        way.sea.refuses_tiles = true;
        way.sea.refuses_waves = true;
        way.line.cut();
        ASSERT_TRUE(way.until(
            [&] { return way.client->status().reason.find("no tiles") != std::string::npos; }));
        way.sea.refuses_tiles = false;
        ASSERT_TRUE(way.is_back()) << way.client->status().reason;
        EXPECT_TRUE(way.until([&] {
            return way.client->status().reason.find("no waves") != std::string::npos;
        })) << way.client->status().reason;
    }
}

// Naive: it is asked for once more when its turn comes, the stream stops and begins anew.
TEST(OnTheWayBack, what_the_program_was_granted_meanwhile_is_not_asked_for_again) {
    for (const bool threadless : {false, true}) {
        OnTheWayBack way(threadless);
        way.sea.refuses_waves = true;
        ASSERT_TRUE(way.comes_back_to_no_tiles()) << way.client->status().reason;
        way.sea.refuses_tiles = false;
        EXPECT_TRUE(way.client->subscribe({.fields = sea::surface_fields, .error_m = 0.5f}, 2, 30));
        const int tiles = way.sea.tiles_asked, waves = way.sea.waves_asked;
        ASSERT_TRUE(way.is_back()) << way.client->status().reason;
        ASSERT_TRUE(way.until([&] { return way.sea.waves_asked >= waves + 2; }))
            << "its turn has come, too";
        EXPECT_EQ(way.sea.tiles_asked, tiles);
    }
}

TEST(OnTheWayBack, who_is_granted_nothing_is_connecting_until_something_is) {
    for (const bool threadless : {false, true}) {
        OnTheWayBack way(threadless);
        const int tiles = way.sea.tiles_asked, waves = way.sea.waves_asked;
        way.sea.refuses_tiles = true;
        way.sea.refuses_waves = true;
        way.line.cut();
        ASSERT_TRUE(way.until(
            [&] { return way.sea.tiles_asked >= tiles + 2 && way.sea.waves_asked >= waves + 2; }));
        EXPECT_EQ(way.client->status().state, LinkState::connecting);
        way.sea.refuses_waves = false;
        EXPECT_TRUE(way.is_back()) << way.client->status().reason;
    }
}

// Naive: who is refused something for ever comes back late for ever, after the next cut too.
TEST(OnTheWayBack, waits_begin_anew_once_something_is_granted) {
    for (const bool threadless : {false, true}) {
        OnTheWayBack way(threadless);
        const int waves = way.sea.waves_asked;
        way.sea.refuses_waves = true;
        way.line.cut();
        ASSERT_TRUE(way.is_back()) << way.client->status().reason;
        ASSERT_TRUE(way.until([&] { return way.sea.waves_asked >= waves + 2; }));
        way.longest_wait_s = 0;
        way.line.cut();
        ASSERT_TRUE(way.is_back(3)) << way.client->status().reason;
        EXPECT_GT(way.longest_wait_s, 0);
        EXPECT_LE(way.longest_wait_s, 0.75) << "the first wait and half of it again";
    }
}

} // namespace
} // namespace seaway::client
