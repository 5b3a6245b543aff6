// SPDX-License-Identifier: Apache-2.0
// The journal in a cluster of three nodes whose leader is cut off from the two others, and not from those who use it.
#include <array>
#include <chrono>
#include <optional>
#include <thread>

#include "server/journal/sea_clock.h"
#include "server/journal/shared_journal.h"
#include "tests/server/journal/journals.h"
#include "tests/support/eventually.h"
#include "tests/support/nats_cluster.h"

namespace seaway::server {
namespace {

using namespace tests_of_journals;
using tests::NatsCluster;

/// A journal at each node, which knows of that node alone.
class Parted : public testing::Test {
  protected:
    void SetUp() override {
        for (std::size_t i = 0; i < NatsCluster::size; ++i) {
            const JournalPlace place{.where = cluster.node(i).url(world), .replicas = 3};
            ASSERT_TRUE(tests::eventually([&] {
                Result<std::unique_ptr<Journal>> made = open_journal(place, beginning);
                if (made)
                    journals[i] = *std::move(made);
                return journals[i] != nullptr;
            })) << error_at(place);
        }
        ASSERT_TRUE(taken_in_the_end(0, change(2)));
        ASSERT_TRUE(whole());
    }

    /// All have found together, and one leads.
    bool whole() {
        return tests::eventually([&] {
            leader = cluster.leader(world, 0);
            return leader < NatsCluster::size && all_hold(2);
        });
    }

    bool taken_in_the_end(std::size_t at, const SeaChange& change) {
        return tests::eventually([&] {
            const Result<void> taken = journals[at]->append(change);
            if (!taken)
                why = taken.error().message;
            return taken || journals[at]->standing().last_epoch >= change.epoch;
        });
    }
    /// What the log holds behind the first. One that waited for a leader may have lapsed, and was not acknowledged then.
    static std::vector<SeaChange> behind_the_first(const Journal& journal) {
        std::vector<SeaChange> changes = journal.since(1).value();
        for (SeaChange& one : changes)
            one.lapsed = false;
        return changes;
    }
    bool all_hold(std::uint32_t last) const {
        for (const std::unique_ptr<Journal>& journal : journals)
            if (journal->standing().last_epoch != last || !journal->standing().current)
                return false;
        return true;
    }
    /// By the steady clock: since then nothing has passed between the leader and the others. Long enough to tell, for nodes say
    /// something each second.
    std::int64_t cut_off_since_us() {
        constexpr std::int64_t silence_us = 1'500'000;
        cluster.part(leader);
        std::int64_t since_us = local_now_us();
        for (std::uint64_t bytes = cluster.bytes_between(leader);
             local_now_us() - since_us < silence_us;
             std::this_thread::sleep_for(std::chrono::milliseconds(10)))
            if (const std::uint64_t now = cluster.bytes_between(leader); now != bytes) {
                bytes = now;
                since_us = local_now_us();
            }
        return since_us;
    }

    /// What the machine itself may stand still: a node reads what the line has brought when it has a core.
    static constexpr std::int64_t read_late_us_max = 1'000'000;
    /// Cuts the one so far behind the leader off, which is `leader` from then on: its journal is sure no longer than stated. Where the
    /// machine stands still, something may be on its way for longer than nodes are silent, and pass once all seems cut off: once in
    /// three times it is so.
    bool is_stale_in_time(std::size_t behind) {
        for (int time = 0; time < 3; ++time) {
            if (time > 0) {
                cluster.join(leader);
                if (!whole())
                    return false;
            }
            leader = (leader + behind) % NatsCluster::size;
            if (is_cut_off_in_time())
                return true;
        }
        return false;
    }
    bool is_cut_off_in_time() {
        const std::int64_t since_us = cut_off_since_us();
        const std::uint64_t passed = cluster.bytes_between(leader);
        bool in_time = true;
        int looks = 0;
        for (std::int64_t now_us = 0; now_us < since_us + 2 * SharedJournal::current_us; ++looks) {
            now_us = local_now_us(); // before it is asked
            const bool sure = journals[leader]->standing().current;
            in_time = in_time && (!sure || now_us <= since_us + SharedJournal::current_us);
            EXPECT_TRUE(!sure ||
                        now_us <= since_us + SharedJournal::current_us + read_late_us_max ||
                        cluster.bytes_between(leader) != passed)
                << now_us - since_us;
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
        EXPECT_GT(looks, 0);
        return in_time;
    }

    const std::string world = "parted";
    NatsCluster cluster;
    std::array<std::unique_ptr<Journal>, NatsCluster::size> journals;
    std::size_t leader = NatsCluster::size;
    std::string why; ///< a change was not taken
};

TEST_F(Parted,
       who_follows_a_leader_that_is_cut_off_is_stale_refuses_changes_and_follows_when_healed) {
    // The leader answers on, for it does not know of another yet: what it says is no longer sure after the stated time.
    ASSERT_TRUE(is_stale_in_time(0));
    Journal& cut_off = *journals[leader];
    const std::size_t other = (leader + 1) % NatsCluster::size;
    SeaChange invented = change(3);
    invented.scene = "asked of who is cut off";
    for (int i = 0; i < 3; ++i) {
        const Result<void> taken = cut_off.append(invented);
        ASSERT_FALSE(taken);
        EXPECT_TRUE(taken.error().is(JournalError::unreachable)) << taken.error().message;
    }
    ASSERT_TRUE(tests::eventually([&] { return journals[other]->standing().current; }))
        << "the two others choose one who leads";
    ASSERT_TRUE(taken_in_the_end(other, change(3))) << why;
    EXPECT_FALSE(cut_off.standing().current);
    EXPECT_EQ(cut_off.standing().last_epoch, 2u);
    // Its copy of the log has its share of what they read, and does not answer.
    ASSERT_TRUE(tests::eventually([&] { return journals[other]->standing().last_epoch == 3; }));
    NatsLog log = log_of(cluster.node(other).url(world));
    for (int i = 0; i < 30; ++i) {
        const Result<std::vector<SharedLog::Stored>> messages = log.read(1, 3);
        ASSERT_TRUE(messages) << i << ' ' << messages.error().message;
        EXPECT_NE(messages->at(0).message.find(beginning.scene), std::string::npos);
        EXPECT_NE(messages->at(2).message.find(change(3).scene), std::string::npos);
    }
    cluster.join(leader);
    ASSERT_TRUE(tests::eventually([&] { return all_hold(3); }));
    for (const std::unique_ptr<Journal>& journal : journals)
        EXPECT_EQ(behind_the_first(*journal), (std::vector<SeaChange>{change(2), change(3)}));
}

TEST_F(Parted, who_follows_a_follower_that_is_cut_off_is_stale_and_the_others_go_on) {
    ASSERT_TRUE(is_stale_in_time(1));
    Journal& cut_off = *journals[leader];
    const std::size_t other = (leader + 1) % NatsCluster::size;
    EXPECT_FALSE(cut_off.standing().current);
    const Result<void> taken = cut_off.append(change(3));
    ASSERT_FALSE(taken);
    EXPECT_TRUE(taken.error().is(JournalError::unreachable)) << taken.error().message;
    ASSERT_TRUE(taken_in_the_end(other, change(3)));
    EXPECT_EQ(cut_off.standing().last_epoch, 2u);
    cluster.join(leader);
    ASSERT_TRUE(tests::eventually([&] { return all_hold(3); }));
    EXPECT_EQ(behind_the_first(cut_off), (std::vector<SeaChange>{change(2), change(3)}));
}

} // namespace
} // namespace seaway::server
