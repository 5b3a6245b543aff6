// SPDX-License-Identifier: Apache-2.0
// Servers at the nodes of a cluster of NATS, as real programs on loopback, while who leads the log is cut off from the two others.
#include <array>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/server/fleet_bench.h"
#include "tests/support/eventually.h"
#include "tests/support/nats_cluster.h"
#include "tests/support/times_in.h"

namespace seaway::changes {
namespace {

using tests::NatsCluster;
using tests::ServerProcess;

/// One that knows of one node alone.
std::unique_ptr<ServerProcess> server_at(const std::string& world_url) {
    std::vector<std::string> words = arguments_of(world_url);
    words.insert(words.end(), {"--journal-replicas", "3"});
    return std::make_unique<ServerProcess>(words);
}

int times_handed_over(const ServerProcess& server) {
    return tests::times_in(server.log(), "event=handing_over");
}

TEST(FleetParted, the_server_at_a_leader_that_is_cut_off_is_not_ready_changes_nothing_and_follows) {
    NatsCluster cluster;
    std::array<std::unique_ptr<ServerProcess>, NatsCluster::size> servers;
    std::array<std::string, NatsCluster::size> at;
    // A cluster that has not found together yet keeps no log: who starts then ends with exit code 5, and is started again.
    for (std::size_t i = 0; i < servers.size(); ++i)
        ASSERT_TRUE(tests::eventually([&] {
            servers[i] = server_at(cluster.node(i).url("parted"));
            at[i] = servers[i]->wait_until_ready();
            return !at[i].empty();
        })) << servers[i]->log();
    const auto ready = [&](std::size_t i) { return get(at[i], "/readyz").status == 200; };
    std::size_t leader = NatsCluster::size;
    ASSERT_TRUE(tests::eventually([&] {
        leader = cluster.leader("parted", 0);
        return leader < NatsCluster::size && cluster.whole("parted");
    }));
    ASSERT_TRUE(tests::eventually([&] { return ready(0) && ready(1) && ready(2); }));
    const std::size_t other = (leader + 1) % NatsCluster::size;

    // A busy machine may have had it do so for a moment before.
    const int before = times_handed_over(*servers[leader]);
    cluster.part(leader);
    ASSERT_TRUE(tests::eventually([&] { return !ready(leader); }));
    EXPECT_NE(get(at[leader], "/readyz").body.find("the journal has not been heard of for"),
              std::string::npos)
        << get(at[leader], "/readyz").body;
    EXPECT_EQ(get(at[leader], "/healthz").status, 200) << "it serves on";
    // Who comes after that is not sent away again.
    ASSERT_TRUE(tests::eventually([&] { return times_handed_over(*servers[leader]) > before; }));
    const std::vector<std::string> breeze{"set", "systems.0.wind_speed_10m_mps=15", "--over",
                                          "10s"};
    const Said refused = ctl(at[leader], breeze);
    EXPECT_EQ(refused.code, 6) << refused.words;
    EXPECT_NE(refused.words.find("the sea cannot be changed now"), std::string::npos)
        << refused.words;
    // The two others choose one who leads, and go on.
    ASSERT_TRUE(tests::eventually([&] { return ready(other); })) << get(at[other], "/readyz").body;
    Said made{};
    ASSERT_TRUE(tests::eventually([&] {
        made = ctl(at[other], breeze);
        return made.code == 0;
    })) << made.words;
    const int last = static_cast<int>(number(made.words, "change"));
    EXPECT_GE(last, 2);
    EXPECT_FALSE(ready(leader));
    EXPECT_EQ(journal_of(at[leader])["played"], 1);

    cluster.join(leader);
    for (std::size_t i = 0; i < at.size(); ++i) {
        EXPECT_TRUE(tests::eventually([&] {
            return ready(i) && journal_of(at[i])["played"] == last;
        })) << i
            << get(at[i], "/readyz").body;
        EXPECT_EQ(journal_of(at[i])["changes"], last) << "and no other change is in the log";
    }
    EXPECT_EQ(ctl(at[leader], {"diff", at[other], "--points", "200"}).code, 0);
}

} // namespace
} // namespace seaway::changes
