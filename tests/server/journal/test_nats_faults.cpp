// SPDX-License-Identifier: Apache-2.0
// The journal in NATS where the log is not as it should be: foreign, damaged, late, lost, or in a stream that forgets.
#include <array>
#include <filesystem>
#include <memory>
#include <thread>

#include <gtest/gtest.h>

#include "server/journal/change_text.h"
#include "server/journal/sea_clock.h"
#include "tests/server/journal/journals.h"
#include "tests/support/eventually.h"
#include "tests/support/fault_proxy.h"
#include "tests/support/listener.h"

namespace seaway::server {
namespace {

using namespace tests_of_journals;
using tests::NatsServer;

TEST(NatsJournal, names_what_is_no_change_and_takes_nothing_behind_it) {
    struct Case {
        const char* what;
        std::string message;
        const char* says;
    };
    LoggedChange second{.change = change(2), .by_utc_us = SeaClock::utc_now_us() + 60'000'000};
    second.sum = sum_of(sum_of(first_sum(beginning.epoch_utc_us), {1, 0, 0, beginning.scene}),
                        second.change);
    const std::string whole = message_of(second);
    std::string later = whole, torn = whole, damaged = whole;
    later.replace(later.find(" 1\n"), 3, " 2\n");
    torn.resize(torn.find("sum") + 8);
    damaged.back() ^= 1;
    LoggedChange gap = second;
    gap.change.epoch = 3;
    const Case cases[] = {{"foreign", "a text of others", "is no change of a sea"},
                          {"empty", "", "is no change of a sea"},
                          {"later", later, "by another version of Seaway (its layout is 2"},
                          {"torn", torn, "is damaged"},
                          {"damaged", damaged, "is damaged, of another sea's log"},
                          {"a gap", message_of(gap), "is out of turn"}};
    for (const Case& c : cases) {
        const std::string url = nats().url(fresh_world());
        const auto journal = open_at(url);
        ASSERT_TRUE(journal);
        NatsLog log = log_of(url);
        ASSERT_TRUE(log.write(c.message, "a", 1)) << c.what;
        ASSERT_TRUE(log.write(message_of({.change = change(3), .sum = 1}), "b", 2));
        // Who follows names it, and holds what was before; who starts does not start.
        EXPECT_TRUE(tests::eventually([&] { return !journal->standing().trouble.empty(); }))
            << c.what;
        const auto says = [&](const std::string& text) {
            return text.find("message 2 ") != std::string::npos &&
                   text.find(c.says) != std::string::npos &&
                   text.find("left as it is") != std::string::npos;
        };
        EXPECT_TRUE(says(journal->standing().trouble)) << journal->standing().trouble;
        EXPECT_EQ(journal->standing().last_epoch, 1u);
        const auto refused = journal->append(change(2));
        ASSERT_FALSE(refused) << c.what;
        EXPECT_TRUE(says(refused.error().message)) << refused.error().message;
        EXPECT_TRUE(says(error_at({.where = url}))) << error_at({.where = url});
        EXPECT_EQ(log.tail()->last, 3u) << "nothing was overwritten";
        EXPECT_EQ(log.read(2, 2)->at(0).message, c.message);
    }
}

TEST(NatsJournal, whole_it_is_read_where_the_message_of_the_test_before_is_not_damaged) {
    LoggedChange second{.change = change(2), .by_utc_us = SeaClock::utc_now_us() + 60'000'000};
    second.sum = sum_of(sum_of(first_sum(beginning.epoch_utc_us), {1, 0, 0, beginning.scene}),
                        second.change);
    const std::string url = nats().url(fresh_world());
    const auto journal = open_at(url);
    ASSERT_TRUE(log_of(url).write(message_of(second), "a", 1));
    EXPECT_TRUE(tests::eventually([&] { return journal->standing().last_epoch == 2; }));
    EXPECT_EQ(journal->since(1).value(), std::vector<SeaChange>{change(2)});
}

// Naive: what waited in a cut line for a minute is a change from a minute ago, and the sea of every server jumps.
TEST(NatsJournal, a_change_that_comes_to_the_log_too_late_changes_nothing_and_keeps_its_number) {
    const std::string url = nats().url(fresh_world());
    const auto journal = open_at(url);
    LoggedChange second{.change = change(2), .by_utc_us = SeaClock::utc_now_us() - 1};
    second.sum = sum_of(sum_of(first_sum(beginning.epoch_utc_us), {1, 0, 0, beginning.scene}),
                        second.change);
    ASSERT_TRUE(log_of(url).write(message_of(second), "a", 1));
    ASSERT_TRUE(tests::eventually([&] { return journal->standing().last_epoch == 2; }));
    EXPECT_TRUE(journal->since(1)->front().lapsed);
    EXPECT_TRUE(journal->append(change(3)));
    const auto again = open_at(url);
    EXPECT_TRUE(again->since(1).value()[0].lapsed) << "for whoever comes later, too";
    EXPECT_FALSE(again->since(1).value()[1].lapsed);
}

// Its store is removed, or damaged on the disk, while NATS is down.
TEST(NatsJournal, a_log_that_has_lost_its_end_is_named_and_not_written_to) {
    namespace fs = std::filesystem;
    NatsServer server;
    const auto journal = open_at(server.url("lost"));
    ASSERT_TRUE(journal);
    for (std::uint32_t epoch = 2; epoch <= 4; ++epoch)
        ASSERT_TRUE(journal->append(change(epoch)));
    server.stop();
    fs::remove_all(server.store());
    ASSERT_TRUE(server.start());
    ASSERT_TRUE(tests::eventually([&] {
        return journal->standing().trouble.find("not there any more") != std::string::npos;
    })) << journal->standing().trouble;
    // Another server begins the world anew: that is another sea's log.
    const auto other = open_at(server.url("lost"));
    ASSERT_TRUE(other);
    ASSERT_TRUE(tests::eventually([&] {
        return journal->standing().trouble.find("made anew") != std::string::npos;
    })) << journal->standing().trouble;
    for (std::uint32_t epoch = 2; epoch <= 4; ++epoch)
        ASSERT_TRUE(other->append(change(epoch)));
    const auto refused = journal->append(change(5));
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("made anew"), std::string::npos);
    EXPECT_EQ(journal->standing().last_epoch, 4u);
    EXPECT_EQ(other->since(0)->size(), 4u);
}

std::string create_stream(const std::string& name, const std::string& settings) {
    return nats().ask("$JS.API.STREAM.CREATE." + name,
                      fmt::format("{{\"name\":\"{}\",{}}}", name, settings));
}

TEST(NatsJournal, names_a_stream_that_forgets_and_leaves_it_as_it_is) {
    struct Case {
        const char* settings;
        const char* says;
    };
    const Case cases[] = {
        {R"("subjects":["seaway.W.log"],"storage":"memory")", "is kept in memory"},
        {R"("subjects":["seaway.W.log"],"storage":"file","max_age":3600000000000)", "forgets"},
        {R"("subjects":["seaway.W.log"],"storage":"file","max_msgs":5)", "forgets"},
        {R"("subjects":["seaway.W.log"],"storage":"file","max_bytes":5000)", "forgets"},
        {R"("subjects":["seaway.W.log"],"storage":"file","retention":"workqueue")", "forgets"},
        {R"("subjects":["seaway.W.log"],"storage":"file")", "allow_direct"},
        {R"("subjects":["seaway.W.log","other.W"],"storage":"file")", "takes other subjects"},
        {R"("subjects":["other.W"],"storage":"file")", "takes other subjects"}};
    for (const Case& c : cases) {
        const std::string world = fresh_world();
        std::string settings = c.settings;
        for (std::size_t at; (at = settings.find(".W")) != std::string::npos;)
            settings.replace(at, 2, "." + world);
        const std::string made = create_stream("SEAWAY_" + world, settings);
        ASSERT_NE(made.find("\"created\""), std::string::npos) << made;
        const std::string error = error_at({.where = nats().url(world)});
        EXPECT_NE(error.find(c.says), std::string::npos) << error;
        EXPECT_NE(error.find("SEAWAY_" + world), std::string::npos) << error;
        EXPECT_NE(error.find("left as it is"), std::string::npos) << error;
    }
    // One that an operator has made, as for copies in a cluster, is taken.
    const std::string world = fresh_world();
    create_stream(
        "SEAWAY_" + world,
        fmt::format(R"("subjects":["seaway.{}.log"],"storage":"file","allow_direct":true)", world));
    EXPECT_EQ(error_at({.where = nats().url(world)}), "it was opened");
}

// Where the operator's stream lets messages be deleted. Naive: they are asked for until the start is given up, each time anew.
TEST(NatsJournal, names_a_stream_out_of_which_a_message_was_deleted) {
    const std::string world = fresh_world();
    create_stream(
        "SEAWAY_" + world,
        fmt::format(R"("subjects":["seaway.{}.log"],"storage":"file","allow_direct":true)", world));
    const auto journal = open_at(nats().url(world));
    ASSERT_TRUE(journal);
    for (std::uint32_t epoch = 2; epoch <= 4; ++epoch)
        ASSERT_TRUE(journal->append(change(epoch)));
    const std::string deleted =
        nats().ask("$JS.API.STREAM.MSG.DELETE.SEAWAY_" + world, "{\"seq\":2}");
    ASSERT_NE(deleted.find("\"success\""), std::string::npos) << deleted;
    const std::string error = error_at({.where = nats().url(world)});
    EXPECT_NE(error.find("holds 3 of 4 messages"), std::string::npos) << error;
}

/// Takes whoever connects, and says nothing.
class SilentHost {
  public:
    ~SilentHost() {
        for (const int one : come_)
            close(one);
    }
    int port() const { return listener_.port(); }
    /// Connections until now.
    std::size_t come() {
        for (int one; (one = listener_.accept(std::chrono::milliseconds(0))) >= 0;)
            come_.push_back(one);
        return come_.size();
    }

  private:
    tests::Listener listener_;
    std::vector<int> come_;
};

class SilentHosts : public testing::Test {
  protected:
    SilentHosts() {
        for (std::unique_ptr<SilentHost>& host : hosts) {
            host = std::make_unique<SilentHost>();
            place.servers.push_back(fmt::format("nats://127.0.0.1:{}", host->port()));
        }
        place.world = "silent";
    }
    std::size_t come() {
        std::size_t all = 0;
        for (const std::unique_ptr<SilentHost>& host : hosts)
            all += host->come();
        return all;
    }

    std::array<std::unique_ptr<SilentHost>, nats_servers_max> hosts;
    NatsPlace place;
};

// Each is waited for for a second.
TEST_F(SilentHosts, who_connects_no_more_is_through_with_the_one_that_it_waits_for) {
    NatsConnection connection = NatsConnection::make(place).value();
    std::thread asks([&] {
        const Result<natsConnection*> made = connection.get();
        ASSERT_FALSE(made);
        EXPECT_TRUE(made.error().is(LogFailure::unreachable)) << made.error().message;
    });
    EXPECT_TRUE(tests::eventually([&] { return come() > 0; }));
    connection.connect_no_more();
    asks.join();
    const std::size_t tried = come();
    EXPECT_LT(tried, hosts.size());
    const Result<natsConnection*> later = connection.get();
    ASSERT_FALSE(later);
    EXPECT_NE(later.error().message.find("this server stops"), std::string::npos);
    EXPECT_EQ(come(), tried) << "nobody is asked any more";
}

TEST_F(SilentHosts,
       one_that_is_there_is_found_among_those_that_hang_and_is_asked_first_from_then_on) {
    place.servers.resize(3);
    place.servers[1] = fmt::format("nats://127.0.0.1:{}", nats().port());
    NatsConnection connection = NatsConnection::make(place).value();
    ASSERT_TRUE(connection.get());
    const std::size_t tried = come();
    for (int again = 0; again < 3; ++again) {
        connection.drop();
        EXPECT_TRUE(connection.get());
    }
    EXPECT_EQ(come(), tried);
}

TEST_F(SilentHosts, a_journal_whose_hosts_all_hang_ends_without_trying_each) {
    // A line for each host, which leads to NATS, and then to who says nothing.
    std::array<std::unique_ptr<tests::FaultProxy>, nats_servers_max> lines;
    std::string url;
    for (std::unique_ptr<tests::FaultProxy>& line : lines) {
        line = std::make_unique<tests::FaultProxy>(nats().port());
        url += fmt::format("{}127.0.0.1:{}", url.empty() ? "nats://" : ",", line->port());
    }
    std::unique_ptr<Journal> journal = open_at(url + "/" + fresh_world());
    ASSERT_TRUE(journal);
    journal->compare_clocks([] { return local_now_us(); });
    for (std::size_t i = 0; i < lines.size(); ++i) {
        lines[i]->lead_to(hosts[i]->port());
        lines[i]->cut();
    }
    ASSERT_TRUE(tests::eventually([&] { return come() > 0; }));
    std::thread asks([&] { EXPECT_FALSE(journal->append(change(2))); });
    journal->connect_no_more();
    asks.join();
    journal->compare_clocks({});
    journal.reset();
    EXPECT_LT(come(), hosts.size());
}

} // namespace
} // namespace seaway::server
