// SPDX-License-Identifier: Apache-2.0
// What a connection makes of a server that is silent, wrong or going away: over a stream without
// sockets, whose other end is the test.
#include <deque>
#include <limits>
#include <mutex>
#include <thread>

#include <gtest/gtest.h>

#include "client/link/failure.h"
#include "protocol/limits.h"
#include "tests/client/link/connection_fixture.h"

namespace seaway::client {
namespace {

TEST_F(ConnectionTest, a_server_that_says_nothing_is_named_after_the_deadline) {
    server.on_message = nullptr;
    const auto connection = open();
    ASSERT_FALSE(connection);
    EXPECT_EQ(failure_of(connection.error()), Failure::cannot_connect);
    EXPECT_NE(connection.error().message.find("no welcome"), std::string::npos);
}

TEST_F(ConnectionTest, a_server_without_a_sea_is_no_server) {
    server.on_message = [this](const wire::Message&) {
        server.send(protocol::welcome(1, "fake", 0));
    };
    const auto connection = open();
    ASSERT_FALSE(connection);
    EXPECT_NE(connection.error().message.find("no sea state"), std::string::npos);
}

// Naive: what follows a sea is made of it, and its time is unknown.
TEST_F(ConnectionTest, whoever_says_anything_before_the_welcome_is_no_server) {
    for (const protocol::Bytes& early :
         {protocol::sea_state({.epoch = 1}), protocol::pong(1, 0, 0),
          protocol::fetch_done(1, 0, {}), tile(1, sea::Field::height)}) {
        server.open = true;
        server.closed_because.clear();
        server.on_message = [&](const wire::Message&) { server.send(early); };
        const auto connection = open();
        ASSERT_FALSE(connection);
        EXPECT_NE(connection.error().message.find("before the welcome"), std::string::npos)
            << connection.error().message;
        EXPECT_EQ(failure_of(connection.error()), Failure::cannot_connect);
    }
}

TEST_F(ConnectionTest, a_server_that_turns_us_away_says_why) {
    server.on_message = [this](const wire::Message&) {
        server.send(protocol::go_away(wire::ErrorCode::unauthorised, "token missing or wrong"));
        server.end("closed");
    };
    const auto connection = open();
    ASSERT_FALSE(connection);
    EXPECT_NE(connection.error().message.find("token missing"), std::string::npos);
}

TEST_F(ConnectionTest, h6_bytes_that_are_no_message_end_it_and_fail_what_is_open) {
    const auto connection = open();
    ASSERT_TRUE(connection);
    std::string outcome;
    const sea::QueryPoint point{};
    (*connection)->query({&point, 1}, false, 1, [&](const Result<Reply>& reply) {
        outcome = reply ? "answered" : reply.error().message;
    });
    server.send(protocol::Bytes(100, 0xff));
    EXPECT_NE(server.closed_because.find("cannot read"), std::string::npos);
    EXPECT_EQ(outcome, server.closed_because);
    EXPECT_EQ(lost, server.closed_because);
    EXPECT_FALSE((*connection)->is_open());
}

TEST_F(ConnectionTest, h6_values_out_of_range_and_unasked_answers_end_it) {
    constexpr auto ever = std::numeric_limits<std::int64_t>::max();
    for (const protocol::Bytes& wrong :
         {protocol::query_reply(77, 1, {}), protocol::fetch_done(77, 0, {}),
          tile(1, sea::Field::height, 9), protocol::welcome(2, "again", 0), protocol::pong(1, 0, 7),
          protocol::pong(1, -ever, 7), protocol::pong(1, ever, 7),
          protocol::tile({.keyframe = 1, .size = 16, .x0 = 8, .width = 16, .height = 16}, {})}) {
        server.open = true;
        server.closed_because.clear();
        const auto connection = open();
        ASSERT_TRUE(connection);
        server.send(wrong);
        EXPECT_NE(server.closed_because.find("cannot read"), std::string::npos);
    }
}

// Naive: each text is copied, and may be the same 300 KB of the message ten thousand times.
TEST_F(ConnectionTest, h6_more_warnings_than_a_sea_may_have_end_it) {
    protocol::SeaStateValues state;
    state.epoch = 1;
    state.cascades.push_back({.length_m = 10, .size = 16, .interval_us = 100'000});
    for (const bool many : {true, false}) {
        flatbuffers::FlatBufferBuilder built;
        const auto text = built.CreateString(std::string(many ? 10 : 300'000, 'x'));
        const std::vector<flatbuffers::Offset<flatbuffers::String>> texts(many ? 10'000 : 10, text);
        const auto warnings = built.CreateVector(texts);
        wire::SeaStateBuilder sea(built);
        sea.add_epoch(1);
        sea.add_warnings(warnings);
        const auto body = sea.Finish();
        built.Finish(wire::CreateMessage(built, wire::Body::SeaState, body.Union()),
                     wire::MessageIdentifier());
        server.open = true;
        server.closed_because.clear();
        const auto connection = open();
        ASSERT_TRUE(connection);
        server.send({built.GetBufferPointer(), built.GetBufferPointer() + built.GetSize()});
        EXPECT_NE(server.closed_because.find("warnings"), std::string::npos)
            << server.closed_because;
    }
    state.warnings.assign(1000, std::string(10'000, 'x'));
    server.open = true;
    const auto connection = open();
    ASSERT_TRUE(connection);
    server.send(protocol::sea_state(state));
    EXPECT_TRUE((*connection)->is_open()) << server.closed_because;
}

// Naive: what was never asked for is held: a few hundred of the largest seas that there may be.
TEST_F(ConnectionTest, waves_that_nobody_asked_for_are_passed_over) {
    int spectra = 0;
    ConnectionEvents events;
    events.on_spectrum = [&](const auto&, const auto&) { ++spectra; };
    const auto connection = open(0.05, std::move(events));
    ASSERT_TRUE(connection);
    const protocol::Bytes empty = protocol::spectrum({.epoch = 1,
                                                      .chunks = 0,
                                                      .steps = {0.0000625, 2.5},
                                                      .dispersion = {9.75, 0.0000625, 95.5}});
    server.send(empty);
    EXPECT_TRUE((*connection)->is_open());
    EXPECT_EQ(spectra, 0);
    (*connection)->subscribe_spectrum({}, 10, [](const auto&) {});
    server.send(empty);
    EXPECT_EQ(spectra, 1);
    (*connection)->unsubscribe_spectrum();
    server.send(empty);
    EXPECT_EQ(spectra, 1) << "it was under way";
}

// Naive: a keyframe has the size that its first tile says. Beside one of another size it is sampled
// beyond its end.
TEST_F(ConnectionTest, h6_tiles_of_another_size_than_their_sea_announced_end_it) {
    for (const int size : {14, 32}) { // 8 could be a compact map (docs/protocol.md), 14 could not
        server.open = true;
        server.closed_because.clear();
        const auto connection = open();
        ASSERT_TRUE(connection);
        server.send(tile(1, sea::Field::height, 1, size));
        EXPECT_NE(server.closed_because.find("size"), std::string::npos) << server.closed_because;
        EXPECT_TRUE(keyframes.empty());
    }
}

TEST_F(ConnectionTest, h6_a_sea_state_that_changes_the_maps_of_its_epoch_ends_it) {
    protocol::SeaStateValues state;
    state.epoch = 1;
    state.cascades.push_back({.length_m = 10, .size = 16, .interval_us = 100'000});
    protocol::SeaStateValues larger = state;
    larger.cascades[0].size = 32;
    protocol::SeaStateValues longer = state;
    longer.cascades[0].length_m = 11;
    protocol::SeaStateValues more = state;
    more.cascades.push_back(more.cascades[0]);
    for (const protocol::SeaStateValues& wrong : {larger, longer, more}) {
        server.open = true;
        server.closed_because.clear();
        const auto connection = open();
        ASSERT_TRUE(connection);
        server.send(protocol::sea_state(state));
        EXPECT_TRUE((*connection)->is_open()) << "said again, it is the same sea";
        server.send(protocol::sea_state(wrong));
        EXPECT_NE(server.closed_because.find("epoch 1"), std::string::npos);
    }
}

TEST_F(ConnectionTest, a_subscription_gets_and_acknowledges_whole_keyframes) {
    const auto connection = open();
    ASSERT_TRUE(connection);
    const sea::FieldSet fields{sea::Field::height, sea::Field::height_rate};
    std::uint32_t request_id = 0;
    server.on_message = [&](const wire::Message& message) {
        if (const auto* subscribe = message.body_as_Subscribe()) {
            request_id = subscribe->request_id();
            server.send(protocol::subscribed(
                request_id, {.cascades = 1, .fields = fields, .error_m = 0.02f}, 2));
        }
    };
    Reply got;
    bool granted = false;
    (*connection)
        ->subscribe({.fields = sea::surface_fields}, 2, 1, [&](const Result<Reply>& reply) {
            granted = reply.has_value();
            got = *reply;
        });
    EXPECT_FALSE(granted) << "the keyframes around now come first";
    server.send(tile(8, sea::Field::height));
    server.send(tile(8, sea::Field::height_rate));
    server.send(protocol::fetch_done(request_id, 5, fields));
    ASSERT_TRUE(granted);
    EXPECT_EQ(got.keyframes, 5u) << "as the server counts them";
    EXPECT_EQ(got.fields, fields);
    EXPECT_EQ(got.grant.fields, fields);
    EXPECT_FLOAT_EQ(got.grant.error_m, 0.02f);
    ASSERT_EQ(keyframes.size(), 1u);
    EXPECT_EQ((*connection)->keyframes_dropped(), 0u);

    server.send(tile(9, sea::Field::height));
    EXPECT_EQ(server.acknowledged, std::vector<std::uint64_t>{8});
    server.send(tile(9, sea::Field::height_rate));
    EXPECT_EQ(server.acknowledged, (std::vector<std::uint64_t>{8, 9}));
    EXPECT_EQ(keyframes.size(), 2u);

    // Of keyframes that stay halves no more than that are kept; no ack says that they came.
    for (std::uint64_t number = 20; number < 20 + TileAssembly::keyframes_max + 3; ++number)
        server.send(tile(number, sea::Field::height));
    EXPECT_EQ((*connection)->keyframes_dropped(), 3u);
    EXPECT_EQ(server.acknowledged.size(), 2u);
}

// Naive: the count is looked at with the next tile, which may never come.
TEST_F(ConnectionTest, keyframes_that_make_room_are_counted_when_it_happens) {
    const auto connection = open();
    ASSERT_TRUE(connection);
    std::uint32_t request_id = 0;
    server.on_message = [&](const wire::Message& message) {
        if (const auto* fetch = message.body_as_Fetch())
            request_id = fetch->request_id();
    };
    const sea::TimeUs time_us = 0;
    const sea::FieldSet pair{sea::Field::height, sea::Field::height_rate};
    (*connection)->fetch({&time_us, 1}, {.fields = pair}, 1, [](const Result<Reply>&) {});
    // At the end of a fetch as many halves are kept as can be under way in a stream.
    constexpr std::uint64_t kept = protocol::limits::credit_max;
    for (std::uint64_t number = 1; number <= kept + 3; ++number)
        server.send(tile(number, sea::Field::height));
    EXPECT_EQ((*connection)->keyframes_dropped(), 0u);
    server.send(protocol::fetch_done(request_id, 0, pair));
    EXPECT_EQ((*connection)->keyframes_dropped(), 3u);

    // A tile that is wrong has made room all the same.
    const std::uint64_t more = TileAssembly::keyframes_max - kept;
    for (std::uint64_t number = 20; number < 20 + more; ++number)
        server.send(tile(number, sea::Field::height));
    EXPECT_EQ((*connection)->keyframes_dropped(), 3u);
    server.send(protocol::tile(
        {.keyframe = 999, .epoch = 1, .size = 16, .width = 16, .height = 16, .error = 0.01f},
        protocol::Bytes(20, 7)));
    EXPECT_FALSE((*connection)->is_open());
    EXPECT_EQ((*connection)->keyframes_dropped(), 4u);
}

// What is on its way, what waits for a place, and what is asked by who is being told of the end.
TEST_F(ConnectionTest, whoever_waits_is_told_once_that_the_connection_was_given_up) {
    std::vector<std::string> outcomes;
    {
        auto connection = open();
        ASSERT_TRUE(connection);
        Connection* const link = connection->get();
        const sea::TimeUs time_us = 0;
        const sea::QueryPoint point{};
        const protocol::TileWish wish{.fields = {sea::Field::height}};
        const auto note = [&](const Result<Reply>& reply) {
            outcomes.push_back(reply ? "answered" : reply.error().message);
        };
        for (int i = 0; i < Requests::queries_in_flight_max + 2; ++i)
            link->query({&point, 1}, false, 1, note);
        link->subscribe(wish, 2, 1, note);
        link->fetch({&time_us, 1}, wish, 1, [&, link](const Result<Reply>& reply) {
            note(reply);
            link->query({&point, 1}, true, 1, note);
        });
        EXPECT_TRUE(outcomes.empty());
    }
    EXPECT_EQ(outcomes.size(), static_cast<std::size_t>(Requests::queries_in_flight_max) + 5);
    for (const std::string& outcome : outcomes)
        EXPECT_EQ(outcome, "destroyed");
    EXPECT_EQ(lost, "destroyed");
}

TEST_F(ConnectionTest, what_is_too_much_for_the_server_is_said_without_asking_it) {
    const auto connection = open();
    ASSERT_TRUE(connection);
    // As much as the server said is asked for, one more is not: plain points, exact ones, times.
    int asked = 0;
    server.on_message = [&](const wire::Message& message) {
        if (const auto* query = message.body_as_Query()) {
            ++asked;
            const std::vector<sea::Answer> answers(query->points()->size());
            server.send(protocol::query_reply(query->request_id(), 1, answers));
        } else if (const auto* fetch = message.body_as_Fetch()) {
            ++asked;
            server.send(protocol::fetch_done(fetch->request_id(), 0, {}));
        }
    };
    const Welcome& welcome = (*connection)->welcome();
    ASSERT_NE(welcome.points_per_query_max, welcome.exact_points_per_query_max);
    const auto query = [&](std::size_t count, bool exact) {
        const std::vector<sea::QueryPoint> points(count);
        Failure failure = Failure::none;
        (*connection)->query(points, exact, 1, [&](const Result<Reply>& reply) {
            failure = reply ? Failure::none : failure_of(reply.error());
        });
        return failure;
    };
    const auto fetch = [&](std::size_t count) {
        const std::vector<sea::TimeUs> times_us(count);
        Failure failure = Failure::none;
        (*connection)->fetch(times_us, {}, 1, [&](const Result<Reply>& reply) {
            failure = reply ? Failure::none : failure_of(reply.error());
        });
        return failure;
    };
    for (const bool exact : {false, true}) {
        const std::size_t most =
            exact ? welcome.exact_points_per_query_max : welcome.points_per_query_max;
        EXPECT_EQ(query(most, exact), Failure::none) << exact;
        EXPECT_EQ(query(most + 1, exact), Failure::bad_argument) << exact;
    }
    EXPECT_EQ(fetch(1), Failure::none);
    EXPECT_EQ(fetch(welcome.times_per_fetch_max), Failure::none);
    EXPECT_EQ(asked, 4) << "what is too much never left";
    EXPECT_EQ(fetch(0), Failure::bad_argument);
    EXPECT_EQ(fetch(welcome.times_per_fetch_max + 1), Failure::bad_argument);
    EXPECT_EQ(asked, 4);
}

// A burst for the clock, ten a second while it settles, then two: never earlier, and at the first look when one
// is due. The pings say themselves when they were sent.
TEST_F(ConnectionTest, pings_come_in_a_burst_of_nine_then_ten_and_after_four_seconds_two_a_second) {
    const auto connection = open();
    ASSERT_TRUE(connection);
    std::vector<std::int64_t> sent_us;
    std::vector<std::uint32_t> nonces;
    server.on_message = [&](const wire::Message& message) {
        if (const auto* ping = message.body_as_Ping()) {
            sent_us.push_back(ping->client_time_us());
            nonces.push_back(ping->request_id());
        }
    };
    const auto next = [&](std::int64_t after_us) {
        const std::size_t before = sent_us.size();
        while (sent_us.size() == before && local_now_us() < sent_us.back() + after_us) {
            server.events.on_tick(); // too early: it would say so itself
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
        if (sent_us.size() == before)
            server.events.on_tick();
        ASSERT_EQ(sent_us.size(), before + 1);
        EXPECT_GE(sent_us.back() - sent_us[before - 1], after_us);
    };
    server.events.on_tick();
    ASSERT_EQ(sent_us.size(), 1u) << "the first at once";
    for (int i = 0; i < 8; ++i)
        next(50'000);
    for (int i = 0; i < 40; ++i)
        next(100'000);
    for (int i = 0; i < 2; ++i)
        next(500'000);
    for (std::size_t i = 0; i < nonces.size(); ++i)
        EXPECT_EQ(nonces[i], i + 1);
}

// Tiles of the sea before may still be on their way, and the one that runs is told of once: the sea that was not used for the
// longest time is forgotten.
TEST_F(ConnectionTest, tiles_of_the_seas_used_last_are_taken_and_of_no_earlier_one) {
    const auto connection = open();
    ASSERT_TRUE(connection);
    constexpr auto held = static_cast<std::uint32_t>(protocol::limits::sea_states_held);
    const auto tell = [&](std::uint32_t epoch) {
        protocol::SeaStateValues state;
        state.epoch = epoch;
        state.cascades.push_back({.length_m = 10, .size = 16, .interval_us = 100'000});
        server.send(protocol::sea_state(state));
    };
    for (std::uint32_t epoch = 2; epoch <= held; ++epoch) {
        tell(epoch);
        server.send(tile(epoch, sea::Field::height, 1));
        ASSERT_TRUE((*connection)->is_open()) << epoch << ": the first one runs";
    }
    server.send(tile(1000, sea::Field::height, 2));
    tell(held + 1);
    for (const std::uint32_t epoch : {1u, 2u, held + 1})
        server.send(tile(1000 + epoch, sea::Field::height, epoch));
    EXPECT_TRUE((*connection)->is_open()) << server.closed_because;
    server.send(tile(2000, sea::Field::height, 3));
    EXPECT_NE(server.closed_because.find("epoch 3"), std::string::npos) << server.closed_because;
}

TEST_F(ConnectionTest, an_answer_of_the_wrong_length_fails_its_query_alone) {
    const auto connection = open();
    ASSERT_TRUE(connection);
    server.on_message = [&](const wire::Message& message) {
        if (const auto* query = message.body_as_Query())
            server.send(protocol::query_reply(query->request_id(), 1, {}));
    };
    const sea::QueryPoint point{};
    std::string outcome;
    (*connection)->query({&point, 1}, false, 1, [&](const Result<Reply>& reply) {
        outcome = reply ? "answered" : reply.error().message;
    });
    EXPECT_NE(outcome.find("0 answered"), std::string::npos) << outcome;
    EXPECT_TRUE((*connection)->is_open());
}

} // namespace
} // namespace seaway::client
