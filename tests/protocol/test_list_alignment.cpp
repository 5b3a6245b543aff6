// SPDX-License-Identifier: Apache-2.0
// Lists of 8-byte values that stand where such values may not.
#include <gtest/gtest.h>

#include "protocol/messages.h"
#include "tests/protocol/sample_messages.h"

namespace seaway::protocol {
namespace {

using tests::read;
using tests::some_state;
using tests::with_list_at;

// The verifier looks at the alignment of a list's count alone; found by the fuzzer.
TEST(ListAlignment, lists_that_are_not_aligned_are_not_a_message) {
    const sea::TimeUs times[] = {-5, 1'000'000};
    const sea::QueryPoint points[] = {{1.5, -2.5, 7}, {1e6, 2e6, -9}};
    const std::vector<sea::Answer> answers(3);
    const double depths[] = {-1, -2};
    SeaStateValues glides = some_state();
    glides.glide =
        GlideValues{.end_us = 20'000'000, .leads_to = glides.probes, .k_lo_radpm = {0.005, 0.07}};
    const Bytes asked = query(9, points, false, {}, depths), fetched = fetch(8, times, {}),
                stated = sea_state(glides), answered = query_reply(9, 1, answers);
    for (const std::size_t shift : {0u, 4u}) {
        MessageReader reader(Sender::client);
        const wire::Message* whole = read(reader, asked);
        const auto* body = reinterpret_cast<const flatbuffers::Table*>(whole->body_as_Query());
        const Bytes moved = with_list_at(asked, *body, wire::Query::VT_POINTS, 24, shift);
        MessageReader again(Sender::client);
        EXPECT_EQ(again.read(moved).has_value(), shift == 0) << "points";
        const Bytes sunk = with_list_at(asked, *body, wire::Query::VT_Z_M, 8, shift);
        EXPECT_EQ(again.read(sunk).has_value(), shift == 0) << "depths";
        whole = read(reader, fetched);
        body = reinterpret_cast<const flatbuffers::Table*>(whole->body_as_Fetch());
        const Bytes late = with_list_at(fetched, *body, wire::Fetch::VT_TIMES_US, 8, shift);
        EXPECT_EQ(again.read(late).has_value(), shift == 0) << "times";
        MessageReader client(Sender::server), client_again(Sender::server);
        whole = read(client, stated);
        body = reinterpret_cast<const flatbuffers::Table*>(whole->body_as_SeaState());
        const Bytes other = with_list_at(stated, *body, wire::SeaState::VT_CASCADES,
                                         sizeof(wire::CascadeInfo), shift);
        EXPECT_EQ(client_again.read(other).has_value(), shift == 0) << "cascades";
        const Bytes far =
            with_list_at(stated, *body, wire::SeaState::VT_PROBES, sizeof(wire::Probe), shift);
        EXPECT_EQ(client_again.read(far).has_value(), shift == 0) << "probes";
        const Bytes ahead =
            with_list_at(stated, *body, wire::SeaState::VT_LEADS_TO, sizeof(wire::Probe), shift);
        EXPECT_EQ(client_again.read(ahead).has_value(), shift == 0) << "leads_to";
        const Bytes longest =
            with_list_at(stated, *body, wire::SeaState::VT_GLIDE_K_LO_RADPM, 8, shift);
        EXPECT_EQ(client_again.read(longest).has_value(), shift == 0) << "glide_k_lo_radpm";
        whole = read(client, answered);
        body = reinterpret_cast<const flatbuffers::Table*>(whole->body_as_QueryReply());
        const Bytes reply = with_list_at(answered, *body, wire::QueryReply::VT_ANSWERS,
                                         sizeof(wire::PointAnswer), shift);
        EXPECT_EQ(client_again.read(reply).has_value(), shift == 0) << "answers";
    }
}

} // namespace
} // namespace seaway::protocol
