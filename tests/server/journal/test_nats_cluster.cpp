// SPDX-License-Identifier: Apache-2.0
// The journal in a cluster of three nodes, each of which dies once.
#include <array>

#include "tests/server/journal/journals.h"

namespace seaway::server {
namespace {

using namespace tests_of_journals;
using tests::NatsServer;

/// Three nodes that know of one another.
class Cluster {
  public:
    Cluster() {
        for (int& port : routes_)
            port = tests::free_port();
        for (std::size_t i = 0; i < nodes_.size(); ++i)
            nodes_[i] = std::make_unique<NatsServer>(
                fmt::format("server_name: node{}\n"
                            "cluster {{ name: sea, listen: \"127.0.0.1:{}\", routes: [\"nats://"
                            "127.0.0.1:{}\", \"nats://127.0.0.1:{}\"] }}",
                            i, routes_[i], routes_[(i + 1) % 3], routes_[(i + 2) % 3]));
    }
    NatsServer& node(std::size_t i) { return *nodes_[i]; }
    JournalPlace place() const {
        return {.where = fmt::format("nats://127.0.0.1:{},127.0.0.1:{},127.0.0.1:{}/three",
                                     nodes_[0]->port(), nodes_[1]->port(), nodes_[2]->port()),
                .replicas = 3};
    }

  private:
    std::array<int, 3> routes_{};
    std::array<std::unique_ptr<NatsServer>, 3> nodes_;
};

/// Said again until the cluster has chosen who leads: taken now, or there since an attempt whose answer was lost.
bool taken_in_the_end(Journal& journal, std::uint32_t epoch) {
    return comes_true(
        [&] { return journal.append(change(epoch)) || journal.standing().last_epoch >= epoch; });
}

TEST(NatsCluster, of_three_nodes_each_may_die_and_the_log_goes_on_with_all_that_was_acknowledged) {
    Cluster cluster;
    std::unique_ptr<Journal> writes, follows;
    const auto opened = [&](std::unique_ptr<Journal>& journal) {
        Result<std::unique_ptr<Journal>> made = open_journal(cluster.place(), beginning);
        if (made)
            journal = *std::move(made);
        return journal != nullptr;
    };
    ASSERT_TRUE(comes_true([&] { return opened(writes); })) << error_at(cluster.place());
    ASSERT_TRUE(comes_true([&] { return opened(follows); }));
    std::uint32_t last = 1;
    for (std::size_t dying = 0; dying < 3; ++dying) {
        ASSERT_TRUE(taken_in_the_end(*writes, ++last));
        cluster.node(dying).stop(SIGKILL);
        for (int i = 0; i < 5; ++i)
            ASSERT_TRUE(taken_in_the_end(*writes, ++last)) << "two of three are enough";
        ASSERT_TRUE(comes_true([&] { return follows->standing().last_epoch == last; }));
        EXPECT_TRUE(comes_true([&] { return follows->standing().current; }));
        ASSERT_TRUE(cluster.node(dying).start());
    }
    std::unique_ptr<Journal> later;
    ASSERT_TRUE(comes_true([&] { return opened(later); }));
    const std::vector<SeaChange> log = later->since(1).value();
    ASSERT_EQ(log.size(), last - 1);
    for (std::uint32_t epoch = 2; epoch <= last; ++epoch)
        EXPECT_EQ(log[epoch - 2], change(epoch));
    EXPECT_EQ(follows->since(1).value(), log);
}

TEST(NatsCluster, with_one_node_of_three_left_nothing_is_acknowledged_and_what_is_held_stays) {
    Cluster cluster;
    std::unique_ptr<Journal> journal;
    ASSERT_TRUE(comes_true([&] {
        Result<std::unique_ptr<Journal>> made = open_journal(cluster.place(), beginning);
        if (made)
            journal = *std::move(made);
        return journal != nullptr;
    }));
    ASSERT_TRUE(taken_in_the_end(*journal, 2));
    cluster.node(0).stop(SIGKILL);
    cluster.node(1).stop(SIGKILL);
    const auto refused = journal->append(change(3));
    ASSERT_FALSE(refused);
    EXPECT_EQ(journal->standing().last_epoch, 2u);
    EXPECT_TRUE(comes_true([&] { return !journal->standing().current; }));
    ASSERT_TRUE(cluster.node(0).start());
    EXPECT_TRUE(taken_in_the_end(*journal, 3)) << "two are enough again";
}

} // namespace
} // namespace seaway::server
