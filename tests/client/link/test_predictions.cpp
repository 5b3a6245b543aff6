// SPDX-License-Identifier: Apache-2.0
// A connection and keyframes that are differences to others: it takes them, and asks for whole ones where it cannot.
#include <optional>

#include "server/publish/encoder.h"
#include "tests/client/link/connection_fixture.h"
#include "tests/server/publish/predicted_sea.h"

namespace seaway::client {
namespace {

using sea::Field;
using sea::FieldSet;

constexpr FieldSet both{Field::height, Field::height_rate};

class PredictionsTest : public ConnectionTest {
  protected:
    /// Welcomes, with a sea of the law that its keyframes run by, and keeps what is said.
    void SetUp() override {
        server.on_message = [this](const wire::Message& message) {
            if (message.body_as_Hello() != nullptr) {
                server.send(protocol::welcome(1, "fake", 5'000'000));
                protocol::SeaStateValues state;
                state.epoch = 1;
                state.cascades.push_back({.length_m = server::predicted_length_m,
                                          .size = 32,
                                          .interval_us = server::predicted_interval_us});
                state.wave_law = server::predicted_law;
                server.send(protocol::sea_state(state));
            }
            if (const wire::Subscribe* wish = message.body_as_Subscribe()) {
                subscribed.push_back(wish->predicted());
                fields_wished.push_back(FieldSet::from_bits(wish->fields()));
                if (refuses)
                    return server.send(protocol::refused(
                        wish->request_id(), wire::ErrorCode::too_many_requests, "busy", 0));
                server.send(protocol::subscribed(
                    wish->request_id(), {.cascades = 1, .fields = both, .error_m = 0.01f}, 2, {}));
                server.send(protocol::fetch_done(wish->request_id(), 0, both));
            }
        };
    }

    void send(int n, bool differs, std::optional<int> without = {}) {
        send_of(encoder, n, differs, without);
    }
    void send_of(server::Encoder& made_by, int n, bool differs, std::optional<int> without = {}) {
        const float bounds[] = {1e-3f, 4e-3f};
        const auto made = made_by.encode(server::running_keyframe(n), bounds, 10, both,
                                         {.law = server::predicted_law});
        ASSERT_TRUE(made);
        int map_number = 0;
        for (const server::EncodedField& map : (*made)->maps)
            if (map_number++ != without)
                for (const auto& part : differs ? map.differences : map.parts)
                    server.send(*part);
    }

    server::Encoder encoder;
    std::vector<bool> subscribed; ///< each wish: predicted?
    std::vector<FieldSet> fields_wished;
    bool refuses = false;
};

TEST_F(PredictionsTest, differences_are_asked_for_and_taken) {
    const auto connection = open();
    ASSERT_TRUE(connection);
    (*connection)->subscribe({.fields = both}, 2, 1, [](const auto&) {});
    ASSERT_EQ(subscribed, std::vector<bool>{true});
    for (int n = 0; n < 8; ++n)
        send(n, n > 0);
    EXPECT_EQ(keyframes.size(), 8u);
    EXPECT_EQ(server.acknowledged.size(), 8u);
    EXPECT_EQ((*connection)->keyframes_unpredicted(), 0u);
    EXPECT_EQ(subscribed.size(), 1u);
}

// It came to a map that others follow from, and the map got lost on the way, or never came: the place in the window is given
// back, and what comes next is whole.
TEST_F(PredictionsTest, what_follows_from_nothing_that_is_here_makes_it_ask_for_whole_ones) {
    const auto connection = open();
    ASSERT_TRUE(connection);
    (*connection)->subscribe({.fields = both}, 2, 1, [](const auto&) {});
    send(0, false);
    send(1, true, 1); // its rates are lost
    refuses = true;
    send(2, true);
    EXPECT_GE((*connection)->keyframes_unpredicted(), 1u);
    ASSERT_EQ(subscribed, (std::vector<bool>{true, false})) << "refused";
    EXPECT_EQ(server.acknowledged.back(), 3u);
    refuses = false;
    send(3, true);
    ASSERT_EQ(subscribed.size(), 3u) << "with the next keyframe";
    send(4, true);
    EXPECT_EQ(subscribed.size(), 3u) << "what was on its way does not ask again";
    EXPECT_EQ(keyframes.size(), 1u);
    send(5, false);
    EXPECT_EQ(keyframes.size(), 2u);
    EXPECT_TRUE(server.open) << server.closed_because;
    (*connection)->subscribe({.fields = both}, 2, 1, [](const auto&) {});
    EXPECT_FALSE(subscribed.back()) << "it has seen that it cannot";
}

TEST_F(PredictionsTest, another_base_than_was_said_is_not_taken_for_it) {
    const auto connection = open();
    ASSERT_TRUE(connection);
    (*connection)->subscribe({.fields = both}, 2, 1, [](const auto&) {});
    server::Encoder other; // whose keyframes have the same numbers and are others
    send_of(other, 100, false);
    send(0, false);
    send(1, true);
    EXPECT_EQ(keyframes.size(), 2u);
    EXPECT_EQ((*connection)->keyframes_unpredicted(), 1u) << "of two maps";
    EXPECT_TRUE(server.open);
}

// The server's first stream goes on where the second is refused, so that is what is asked for without predictions.
TEST_F(PredictionsTest, what_was_refused_is_not_what_it_asks_for_again) {
    const auto connection = open();
    ASSERT_TRUE(connection);
    (*connection)->subscribe({.fields = both}, 2, 1, [](const auto&) {});
    refuses = true;
    (*connection)->subscribe({.fields = FieldSet{Field::foam}}, 5, 1, [](const auto&) {});
    refuses = false;
    send(0, false);
    send(1, true, 1); // its rates are lost
    send(2, true);
    ASSERT_EQ(subscribed, (std::vector<bool>{true, true, false}));
    EXPECT_EQ(fields_wished.back(), both);
    (*connection)->unsubscribe();
    EXPECT_EQ((*connection)->keyframes_unpredicted(), 1u);
}

TEST_F(PredictionsTest, a_difference_where_nothing_is_predicted_is_a_broken_server) {
    const auto connection = open();
    ASSERT_TRUE(connection);
    send(0, false);
    const float bounds[] = {1e-3f, 4e-3f};
    const auto made = encoder.encode(server::running_keyframe(1), bounds, 10, both,
                                     {.law = server::predicted_law});
    protocol::MessageReader reader(protocol::Sender::server);
    const wire::Tile& tile = *(*reader.read(*(*made)->maps[0].differences[0]))->body_as_Tile();
    protocol::TileHeader header = protocol::header(tile);
    header.field = Field::slope_x;
    server.send(protocol::tile(header, {tile.payload()->data(), tile.payload()->size()}));
    EXPECT_FALSE(server.open);
}

} // namespace
} // namespace seaway::client
