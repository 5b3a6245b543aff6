// SPDX-License-Identifier: Apache-2.0
// What a connection acknowledges, and when: by one Ack for several keyframes where server and credit have room for it.
#include "tests/client/link/connection_fixture.h"

namespace seaway::client {
namespace {

using Numbers = std::vector<std::uint64_t>;
using Sizes = std::vector<std::size_t>;
const sea::FieldSet height{sea::Field::height};

class Acknowledging : public ConnectionTest {
  protected:
    void grant(int credit) {
        server.send(protocol::subscribed(1, {.cascades = 1, .fields = height}, credit));
    }
    void complete(const Numbers& keyframes) {
        for (const std::uint64_t number : keyframes)
            server.send(tile(number, sea::Field::height));
    }
};

/// The Welcome of a server from before an Ack could name several keyframes.
protocol::Bytes welcome_of_old() {
    flatbuffers::FlatBufferBuilder built;
    const auto name = built.CreateString("old");
    const auto body =
        wire::CreateWelcome(built, protocol::version, 1, name, 5'000'000, 4096, 256, 8, 1 << 17);
    built.Finish(wire::CreateMessage(built, wire::Body::Welcome, body.Union()),
                 wire::MessageIdentifier());
    return {built.GetBufferPointer(), built.GetBufferPointer() + built.GetSize()};
}

TEST_F(Acknowledging, every_second_keyframe_is_for_two_where_four_may_be_under_way) {
    const auto connection = open();
    ASSERT_TRUE(connection);
    grant(4);
    complete({7});
    EXPECT_TRUE(server.acks.empty()) << "three more may come meanwhile";
    complete({9, 8, 12});
    EXPECT_EQ(server.acknowledged, (Numbers{7, 9, 8, 12}));
    EXPECT_EQ(server.acks, (Sizes{2, 2}));
}

TEST_F(Acknowledging, a_server_from_before_that_is_told_of_each_keyframe_by_itself) {
    server.on_message = [this](const wire::Message& message) {
        if (!message.body_as_Hello())
            return;
        server.send(welcome_of_old());
        protocol::SeaStateValues state;
        state.epoch = 1;
        state.cascades.push_back({.length_m = 10, .size = 16, .interval_us = 100'000});
        server.send(protocol::sea_state(state));
    };
    const auto connection = open();
    ASSERT_TRUE(connection);
    grant(8);
    complete({7, 8, 9});
    EXPECT_EQ(server.acknowledged, (Numbers{7, 8, 9}));
    EXPECT_EQ(server.acks, (Sizes{1, 1, 1}));
}

// A change of the sea brings the grant again, and so does another subscription; its window still has what was before.
TEST_F(Acknowledging, what_was_held_back_is_said_when_a_grant_comes_be_it_of_less) {
    const auto connection = open();
    ASSERT_TRUE(connection);
    grant(8);
    complete({1, 2, 3});
    EXPECT_TRUE(server.acks.empty());
    grant(8);
    EXPECT_EQ(server.acknowledged, (Numbers{1, 2, 3}));
    complete({4});
    (*connection)->unsubscribe();
    grant(1);
    EXPECT_EQ(server.acknowledged, (Numbers{1, 2, 3, 4}));
    complete({5});
    EXPECT_EQ(server.acknowledged, (Numbers{1, 2, 3, 4, 5})) << "at once, as one is the credit";
}

TEST_F(Acknowledging, keyframes_that_were_fetched_are_named_like_those_of_the_stream) {
    const auto connection = open();
    ASSERT_TRUE(connection);
    grant(4);
    const sea::TimeUs time_us = 0;
    (*connection)->fetch({&time_us, 1}, {.fields = height}, 1, [](const Result<Reply>&) {});
    complete({20, 21});
    EXPECT_EQ(server.acks, (Sizes{2}));
    EXPECT_EQ(server.acknowledged, (Numbers{20, 21}));
}

TEST_F(Acknowledging, one_that_a_grant_brings_and_that_cannot_be_sent_ends_the_connection) {
    const auto connection = open();
    ASSERT_TRUE(connection);
    grant(4);
    complete({7});
    server.takes = false;
    grant(4);
    EXPECT_FALSE((*connection)->is_open());
    EXPECT_NE(lost.find("takes nothing"), std::string::npos) << lost;
}

} // namespace
} // namespace seaway::client
