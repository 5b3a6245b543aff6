// SPDX-License-Identifier: Apache-2.0
// What a connection makes of a server that goes, and of one that takes nothing.
#include "client/link/failure.h"
#include "protocol/limits.h"
#include "tests/client/link/connection_fixture.h"

namespace seaway::client {
namespace {

using GoingAway = ConnectionTest;

TEST_F(GoingAway, a_server_that_stops_says_for_how_long_nobody_should_come) {
    const auto connection = open();
    ASSERT_TRUE(connection);
    std::uint32_t asked_ms = 0;
    const sea::QueryPoint point{0, 0, 0};
    (*connection)->query({&point, 1}, false, 100, [&](const Result<Reply>& reply) {
        asked_ms = reply ? 0 : reply.error().retry_after_ms;
    });
    server.send(protocol::go_away(wire::ErrorCode::shutting_down, "the server stops", 7500));
    server.end("closed");
    EXPECT_EQ(stay_away_ms, 7500u);
    EXPECT_EQ(asked_ms, 7500u) << "who waits for an answer hears it, too";
    EXPECT_NE(lost.find("shutting_down"), std::string::npos) << lost;
}

// Naive: that to come again makes no sense, which is the client's own affair, and a program is told of a bug.
TEST_F(GoingAway, who_waits_for_an_answer_of_a_server_that_drops_him_has_lost_it) {
    const auto connection = open();
    ASSERT_TRUE(connection);
    Failure told = Failure::none;
    const sea::QueryPoint point{0, 0, 0};
    (*connection)->query({&point, 1}, false, 100, [&](const Result<Reply>& reply) {
        told = reply ? Failure::none : failure_of(reply.error());
    });
    server.send(protocol::go_away(wire::ErrorCode::dropped, "by an administrator", 0));
    server.end("closed");
    EXPECT_EQ(told, Failure::lost);
}

TEST_F(GoingAway, a_server_that_stops_turns_newcomers_away_with_the_same_word) {
    server.on_message = [this](const wire::Message&) {
        server.send(protocol::go_away(wire::ErrorCode::shutting_down, "the server stops", 2500));
        server.end("closed");
    };
    const auto connection = open();
    ASSERT_FALSE(connection);
    EXPECT_EQ(connection.error().retry_after_ms, 2500u);
}

// A day is no wait that a client could keep: such a server is broken.
TEST_F(GoingAway, a_wait_of_more_than_an_hour_is_not_taken) {
    const auto connection = open();
    ASSERT_TRUE(connection);
    server.send(protocol::go_away(wire::ErrorCode::shutting_down, "stops", 86'400'000));
    EXPECT_FALSE((*connection)->is_open());
    EXPECT_EQ(stay_away_ms, 0u);
    EXPECT_NE(lost.find("retry_after_ms"), std::string::npos) << lost;
}

// It would hold its keyframe's place in the window for ever, and the stream would stand.
TEST_F(GoingAway, an_acknowledgement_that_cannot_be_sent_ends_the_connection) {
    const auto connection = open();
    ASSERT_TRUE(connection);
    server.send(protocol::subscribed(1, {.cascades = 1, .fields = {sea::Field::height}}, 2));
    server.takes = false;
    server.send(tile(9, sea::Field::height));
    EXPECT_FALSE((*connection)->is_open());
    EXPECT_NE(lost.find("takes nothing"), std::string::npos) << lost;
}

} // namespace
} // namespace seaway::client
