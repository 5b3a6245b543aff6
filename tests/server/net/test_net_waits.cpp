// SPDX-License-Identifier: Apache-2.0
// The network's thread waits for nothing: neither for a disk nor for a sea that has to be made.
#include "tests/server/net/net_fixture.h"

namespace seaway::tests {
namespace {

using wire::Body;
using NetWaits = NetTest;

// Naive: which sea its keyframes are of is looked up when they go out. One that nobody has kept is made anew for that, for a
// quarter of a second in which no session hears anything.
TEST_F(NetWaits, seas_of_fetched_and_streamed_keyframes_are_looked_up_behind_the_network) {
    start();
    const auto client = greeted();
    const sea::TimeUs time_us = 40 * interval_us;
    ASSERT_FALSE(client->send(protocol::fetch(8, {&time_us, 1}, heights)));
    ASSERT_TRUE(client->receive(Body::FetchDone));
    const int fetched = host.looked_up;
    EXPECT_GT(fetched, 0);
    ASSERT_FALSE(client->send(protocol::subscribe(9, heights, 8)));
    ASSERT_TRUE(client->receive(Body::FetchDone));
    publish(50);
    ASSERT_TRUE(client->receive(Body::Tile));
    EXPECT_GT(host.looked_up, fetched);
    EXPECT_EQ(host.looked_up_by_network, 0);
}

// Naive: who asks for the history waits for a disk, and with him everybody.
TEST_F(NetWaits, a_journal_whose_disk_hangs_keeps_nobody_else_waiting) {
    options.admin_token_file = folder().write("journal_admin", "master\n");
    start();
    const auto admin = greeted("master"), other = greeted();
    host.disk_hangs = true;
    for (std::uint32_t id = 1; id <= 5; ++id)
        ASSERT_FALSE(admin->send(protocol::administer(id, wire::Act::history, 1)));
    expect_refused(*admin, 5, wire::ErrorCode::too_many_requests, "4 readings of the journal");
    ASSERT_FALSE(other->send(protocol::ping(6, 0)));
    EXPECT_TRUE(other->receive(Body::Pong));
    host.disk_hangs = false;
    for (std::uint32_t id = 1; id <= 4; ++id) {
        const wire::Message* told = admin->receive(Body::Administered);
        ASSERT_TRUE(told);
        EXPECT_EQ(told->body_as_Administered()->request_id(), id);
    }
}

} // namespace
} // namespace seaway::tests
