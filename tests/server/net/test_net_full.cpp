// SPDX-License-Identifier: Apache-2.0
// Crowds that take all connections there are, and who makes room for those that come after.
#include <thread>
#include <utility>

#include "tests/server/net/door_fixture.h"

namespace seaway::tests {
namespace {

class NetFull : public NetDoor {};

// Naive: whoever has waited longest makes room, and that is the neighbour between two requests.
TEST_F(NetFull, a_crowd_of_silent_connections_of_one_address_is_its_own_affair) {
    options.connections_max = 40;
    options.connections_per_address = 10;
    start();
    RawPeer idle(port(), 0, neighbour);
    EXPECT_TRUE(is_served(idle));
    const auto crowd = silent_crowd(100);
    EXPECT_EQ(status("/healthz", "", neighbour), 200);
    EXPECT_EQ(status("/healthz"), 200) << "one more of the same address takes an old one's place";
    EXPECT_EQ(knock("", neighbour), 0u);
    EXPECT_LE(counted("seaway_net_connections"), 13) << "ten, the idle one, those who ask";
    EXPECT_GE(counted("seaway_net_connections_given_up_total"), 90);
    EXPECT_TRUE(is_served(idle)) << "nobody sent it away";
    net->stop();
    EXPECT_EQ(
        log.lines_with("event=connections_crowded", "address=127.0.0.1 reason=address_full").size(),
        1u)
        << log.text();
    EXPECT_TRUE(log.lines_with("event=connections_crowded", "address=127.0.0.2").empty());
}

TEST_F(NetFull, where_the_server_is_full_the_largest_crowd_makes_room) {
    options.connections_max = 10;
    options.connections_per_address = 0; // no limit: as if a proxy were in front
    start();
    RawPeer idle(port(), 0, neighbour);
    EXPECT_TRUE(is_served(idle));
    const auto crowd = silent_crowd(30);
    EXPECT_EQ(status("/healthz", "", "127.0.0.3"), 200);
    EXPECT_TRUE(is_served(idle));
}

// Naive: who has been told that it is over is in no line any more, and keeps its place for as long as one may take to go.
TEST_F(NetFull, a_crowd_that_has_said_goodbye_and_stays_makes_room) {
    options.connections_max = 10;
    options.connections_per_address = 0;
    options.sessions_without_hello_per_address = 0;
    start();
    std::vector<std::unique_ptr<RawPeer>> crowd;
    for (int i = 0; i < 30; ++i) {
        crowd.push_back(std::make_unique<RawPeer>(port()));
        crowd.back()->upgrade();
        crowd.back()->say(closing_frame(1000, ""));
        EXPECT_TRUE(crowd.back()->reads(4)) << "it is answered";
    }
    EXPECT_EQ(status("/healthz", "", "127.0.0.3"), 200);
    EXPECT_EQ(knock("", neighbour), 0u);
    EXPECT_GE(counted("seaway_net_connections_given_up_total"), 20);
}

// Naive: who does not read what it has asked for waits in no line.
TEST_F(NetFull, a_crowd_that_asks_and_does_not_read_makes_room) {
    options.connections_max = 10;
    options.connections_per_address = 0;
    options.request_bytes_per_s_per_address = 1e12;
    options.health_listen = "127.0.0.1:0";
    start();
    std::string requests;
    for (int i = 0; i < 1500; ++i)
        requests += "GET /status.js HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
    std::vector<std::unique_ptr<RawPeer>> crowd;
    for (int i = 0; i < 10; ++i) {
        crowd.push_back(std::make_unique<RawPeer>(port(), 2048));
        crowd.back()->say(requests);
    }
    double served = -1;
    EXPECT_TRUE(eventually([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
        const double before =
            std::exchange(served, counted("seaway_net_http_responses_total{status=\"200\"}"));
        return served == before + 1; // who looks, and nobody else
    }));
    EXPECT_EQ(status("/healthz", "", "127.0.0.3"), 200);
    EXPECT_EQ(knock("", neighbour), 0u);
}

} // namespace
} // namespace seaway::tests
