// SPDX-License-Identifier: Apache-2.0
// Acknowledgements of one keyframe and of several.
#include <gtest/gtest.h>

#include "tests/protocol/sample_messages.h"

namespace seaway::protocol {
namespace {

using tests::read;
using tests::sample;
using wire::Body;

TEST(Acks, of_several_keyframes_name_each_and_welcome_says_how_many_a_server_takes) {
    MessageReader of_client(Sender::client), of_server(Sender::server);
    const wire::Ack* several = read(of_client, sample(Body::Ack))->body_as_Ack();
    ASSERT_TRUE(several && several->also());
    EXPECT_EQ(several->keyframe(), 1ull << 40);
    EXPECT_TRUE(std::ranges::equal(*several->also(), tests::some_others));
    EXPECT_EQ(read(of_server, sample(Body::Welcome))->body_as_Welcome()->keyframes_per_ack_max(),
              9u);
}

// An Ack as it was before there could be more of them: an older server reads it as it always did.
TEST(Acks, of_one_keyframe_are_the_bytes_that_they_always_were) {
    const std::uint8_t of_old[] = {
        0x10, 0x00, 0x00, 0x00, 0x53, 0x45, 0x41, 0x57, 0x08, 0x00, 0x0e, 0x00, 0x07,
        0x00, 0x08, 0x00, 0x08, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x04, 0x0c, 0x00,
        0x00, 0x00, 0x00, 0x00, 0x06, 0x00, 0x0c, 0x00, 0x04, 0x00, 0x06, 0x00, 0x00,
        0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00}; // tests/golden/wire_v1/Ack.txt
    EXPECT_EQ(ack(1ull << 40), Bytes(std::begin(of_old), std::end(of_old)));
}

// The verifier looks at the alignment of a list's count alone.
TEST(Acks, whose_numbers_are_not_aligned_are_not_a_message) {
    MessageReader reader(Sender::client);
    const Bytes bytes = sample(Body::Ack);
    const auto* body =
        reinterpret_cast<const flatbuffers::Table*>(read(reader, bytes)->body_as_Ack());
    for (const std::size_t shift : {0u, 4u}) {
        MessageReader again(Sender::client);
        EXPECT_EQ(
            again.read(tests::with_list_at(bytes, *body, wire::Ack::VT_ALSO, 8, shift)).has_value(),
            shift == 0);
    }
}

} // namespace
} // namespace seaway::protocol
