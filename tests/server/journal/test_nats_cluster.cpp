// SPDX-License-Identifier: Apache-2.0
// The journal in a cluster of three nodes, each of which dies once, when the others are well.
#include <array>
#include <barrier>
#include <thread>

#include "tests/server/journal/journals.h"
#include "tests/support/eventually.h"
#include "tests/support/nats_cluster.h"

namespace seaway::server {
namespace {

using namespace tests_of_journals;
using tests::NatsCluster;

JournalPlace place_in(const NatsCluster& cluster) {
    return {.where = cluster.url("three"), .replicas = 3};
}

/// Once there is a cluster to open it in.
std::unique_ptr<Journal> open_in(const NatsCluster& cluster) {
    std::unique_ptr<Journal> journal;
    EXPECT_TRUE(tests::eventually([&] {
        Result<std::unique_ptr<Journal>> made = open_journal(place_in(cluster), beginning);
        if (made)
            journal = *std::move(made);
        return journal != nullptr;
    })) << error_at(place_in(cluster));
    return journal;
}

/// Said again until the cluster has chosen who leads: taken now, or there since an attempt whose answer was lost.
bool taken_in_the_end(Journal& journal, std::uint32_t epoch) {
    return tests::eventually(
        [&] { return journal.append(change(epoch)) || journal.standing().last_epoch >= epoch; });
}

TEST(NatsCluster, of_three_nodes_each_may_die_and_the_log_goes_on_with_all_that_was_acknowledged) {
    NatsCluster cluster;
    const std::unique_ptr<Journal> writes = open_in(cluster), follows = open_in(cluster);
    ASSERT_TRUE(writes && follows);
    std::uint32_t last = 1;
    std::vector<bool> acknowledged;
    std::string why;
    const auto taken = [&] {
        ++last;
        acknowledged.push_back(false);
        return tests::eventually([&] {
            const Result<void> said = writes->append(change(last));
            acknowledged.back() = said.has_value();
            if (!said)
                why = said.error().message;
            return acknowledged.back() || writes->standing().last_epoch >= last;
        });
    };
    for (std::size_t dying = 0; dying < 3; ++dying) {
        ASSERT_TRUE(taken());
        cluster.node(dying).stop(SIGKILL);
        for (int i = 0; i < 5; ++i)
            ASSERT_TRUE(taken()) << "two of three are enough: " << why;
        ASSERT_TRUE(tests::eventually([&] { return follows->standing().last_epoch == last; }));
        EXPECT_TRUE(tests::eventually([&] { return follows->standing().current; }));
        ASSERT_TRUE(cluster.node(dying).start());
        // Of two that have the log to its end one has to be left.
        ASSERT_TRUE(tests::eventually([&] { return cluster.whole("three"); }));
    }
    const std::unique_ptr<Journal> later = open_in(cluster);
    ASSERT_TRUE(later);
    std::vector<SeaChange> log = later->since(1).value();
    EXPECT_EQ(follows->since(1).value(), log);
    ASSERT_EQ(log.size(), last - 1);
    for (std::uint32_t epoch = 2; epoch <= last; ++epoch) {
        SeaChange& one = log[epoch - 2];
        // What waited for a leader came too late for all to know of it, and was told so.
        EXPECT_FALSE(one.lapsed && acknowledged[epoch - 2]) << epoch;
        one.lapsed = false;
        EXPECT_EQ(one, change(epoch));
    }
}

TEST(NatsCluster, with_one_node_of_three_left_nothing_is_acknowledged_and_what_is_held_stays) {
    NatsCluster cluster;
    const std::unique_ptr<Journal> journal = open_in(cluster);
    ASSERT_TRUE(journal);
    ASSERT_TRUE(taken_in_the_end(*journal, 2));
    cluster.node(0).stop(SIGKILL);
    cluster.node(1).stop(SIGKILL);
    const auto refused = journal->append(change(3));
    ASSERT_FALSE(refused);
    EXPECT_EQ(journal->standing().last_epoch, 2u);
    EXPECT_TRUE(tests::eventually([&] { return !journal->standing().current; }));
    ASSERT_TRUE(cluster.node(0).start());
    EXPECT_TRUE(taken_in_the_end(*journal, 3)) << "two are enough again";
}

/// What the cluster says of a write, repeated while it says nothing.
Result<std::uint64_t> said_of(SharedLog& log, const std::string& id, std::uint64_t before) {
    Result<std::uint64_t> number = log.write(id, id, before);
    (void)tests::eventually([&] {
        const bool silent = !number && (number.error().is(LogFailure::unanswered) ||
                                        number.error().is(LogFailure::unreachable));
        if (silent)
            number = log.write(id, id, before);
        return !silent;
    });
    return number;
}

// Who leads has several under way before the others have agreed to the first.
TEST(NatsCluster, of_writes_of_one_number_at_once_one_is_stored_and_its_repeat_is_known) {
    NatsCluster cluster;
    ASSERT_TRUE(open_in(cluster));
    cluster.delay(std::chrono::milliseconds(20));
    constexpr int writers = 4, rounds = 25;
    std::barrier together(writers);
    std::array<std::array<bool, rounds>, writers> taken{};
    std::array<std::string, writers> wrong;
    const auto write = [&](std::size_t who) {
        NatsLog log = log_of(cluster.url("three"));
        for (int round = 0; round < rounds; ++round) {
            const auto before = static_cast<std::uint64_t>(round) + 1;
            const std::string id = fmt::format("{} of {}", round, who);
            (void)log.tail(); // connects
            together.arrive_and_wait();
            const Result<std::uint64_t> number = said_of(log, id, before);
            taken[who][static_cast<std::size_t>(round)] = number.has_value();
            if (!number && !number.error().is(LogFailure::outrun))
                wrong[who] += number.error().message;
            const Result<std::uint64_t> again = number ? said_of(log, id, before) : number;
            if (number && (!again || *again != before + 1))
                wrong[who] += again ? fmt::format("again as {}", *again) : again.error().message;
            together.arrive_and_wait();
        }
    };
    std::vector<std::thread> threads;
    for (std::size_t who = 0; who < writers; ++who)
        threads.emplace_back(write, who);
    for (std::thread& thread : threads)
        thread.join();
    NatsLog log = log_of(cluster.url("three"));
    ASSERT_EQ(log.tail()->last, rounds + 1u) << "one a round";
    const std::vector<SharedLog::Stored> stored = log.read(2, rounds + 1).value();
    for (std::size_t who = 0; who < writers; ++who)
        EXPECT_EQ(wrong[who], "") << who;
    for (std::size_t round = 0; round < rounds; ++round)
        for (std::size_t who = 0; who < writers; ++who)
            EXPECT_EQ(taken[who][round], stored[round].id == fmt::format("{} of {}", round, who));
}

} // namespace
} // namespace seaway::server
