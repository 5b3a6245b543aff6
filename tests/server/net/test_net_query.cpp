// SPDX-License-Identifier: Apache-2.0
// What the answer to a query says beside the answers.
#include "tests/server/net/net_fixture.h"

#include <optional>

namespace seaway::tests {
namespace {

using wire::Body;

class NetQuery : public NetTest {};

// By which a client knows that its choice was understood; who chooses nothing is sent what it was always sent.
TEST_F(NetQuery, the_answer_to_a_query_of_some_waves_says_which_of_them_counted) {
    start();
    const auto client = greeted();
    const sea::QueryPoint point{1, 2, 3};
    const auto counted = [&](const sea::Looking& looking) -> std::optional<std::uint32_t> {
        EXPECT_FALSE(client->send(protocol::query(5, {&point, 1}, false, looking)));
        const wire::Message* message = client->receive(Body::QueryReply);
        EXPECT_TRUE(message);
        const auto cascades = message->body_as_QueryReply()->cascades();
        return cascades ? std::optional(*cascades) : std::nullopt;
    };
    EXPECT_EQ(counted({}), std::nullopt);
    EXPECT_EQ(counted({.cascades = 2u}), 2u);
    EXPECT_EQ(counted({.min_wavelength_m = 0.5}), 3u);
    EXPECT_EQ(counted({.cascades = 0u}), 0u) << "none is an answer, too";
}

} // namespace
} // namespace seaway::tests
