// SPDX-License-Identifier: Apache-2.0
// The journal in NATS, with real servers on loopback: several who follow one log, and lines that fail.
#include <atomic>
#include <chrono>
#include <thread>

#include <gtest/gtest.h>

#include "server/journal/sea_clock.h"
#include "server/journal/shared_journal.h"
#include "tests/server/journal/journals.h"
#include "tests/support/certificate.h"
#include "tests/support/eventually.h"
#include "tests/support/fault_proxy.h"

namespace seaway::server {
namespace {

using namespace tests_of_journals;
using tests::FaultProxy;
using tests::NatsServer;

TEST(NatsJournal, a_change_that_one_server_makes_reaches_all_others_in_order) {
    const std::string url = nats().url(fresh_world());
    const auto a = open_at(url), b = open_at(url, {5, "a later start"}), c = open_at(url);
    ASSERT_TRUE(a && b && c);
    EXPECT_EQ(b->epoch_utc_us(), beginning.epoch_utc_us) << "of the first";
    std::atomic<int> calls = 0;
    b->call_on_change([&] { ++calls; });
    for (std::uint32_t epoch = 2; epoch <= 20; ++epoch)
        ASSERT_TRUE(a->append(change(epoch)));
    for (Journal* follower : {b.get(), c.get()}) {
        EXPECT_TRUE(tests::eventually([&] { return follower->standing().last_epoch == 20; }));
        EXPECT_EQ(follower->since(0).value(), a->since(0).value());
    }
    EXPECT_GT(calls, 0);
    b->call_on_change({});
    ASSERT_TRUE(b->append(change(21)));
    EXPECT_TRUE(tests::eventually([&] { return a->standing().last_epoch == 21; }));
}

TEST(NatsJournal, of_servers_that_begin_one_log_at_once_all_have_the_sea_of_one) {
    const std::string url = nats().url(fresh_world());
    std::vector<std::unique_ptr<Journal>> journals(8);
    std::vector<std::thread> servers;
    for (int i = 0; i < 8; ++i)
        servers.emplace_back([&, i] {
            journals[static_cast<std::size_t>(i)] =
                open_at(url, {1000 + i, fmt::format("sea {}", i)});
        });
    for (std::thread& server : servers)
        server.join();
    for (const auto& journal : journals) {
        ASSERT_TRUE(journal);
        EXPECT_EQ(journal->epoch_utc_us(), journals[0]->epoch_utc_us());
        EXPECT_EQ(journal->since(0).value(), journals[0]->since(0).value());
        EXPECT_EQ(journal->since(0)->size(), 1u);
    }
}

// Four administrators at four servers append as fast as they can: each number has one winner, and the log is what they were told.
TEST(NatsJournal, of_administrators_at_once_one_wins_and_the_others_are_told) {
    const std::string url = nats().url(fresh_world());
    std::atomic<int> outrun = 0;
    std::vector<std::vector<SeaChange>> won(4);
    std::vector<std::thread> administrators;
    for (std::size_t who = 0; who < 4; ++who)
        administrators.emplace_back([&, who] {
            const auto journal = open_at(url);
            for (int i = 0; i < 25;) {
                SeaChange mine = change(journal->standing().last_epoch + 1);
                mine.scene = fmt::format("sea {} of {}", i, who);
                const auto taken = journal->append(mine);
                if (taken) {
                    won[who].push_back(mine);
                    ++i;
                    continue;
                }
                ASSERT_TRUE(taken.error().is(JournalError::outrun)) << taken.error().message;
                ASSERT_NE(taken.error().message.find("another change"), std::string::npos);
                ++outrun;
            }
        });
    for (std::thread& administrator : administrators)
        administrator.join();
    const std::vector<SeaChange> log = open_at(url)->since(0).value();
    ASSERT_EQ(log.size(), 101u);
    std::size_t found = 0;
    for (const std::vector<SeaChange>& mine : won)
        for (const SeaChange& one : mine)
            found += log.at(one.epoch - 1) == one;
    EXPECT_EQ(found, 100u);
    EXPECT_GT(outrun, 0);
}

// The line is cut after so many bytes of the answer, or of the question: what was acknowledged is there once, what was not is there
// once or not at all, and the same is said of it as is so.
TEST(NatsJournal, a_change_is_there_once_wherever_the_line_is_cut) {
    const std::string world = fresh_world();
    FaultProxy line(nats().port());
    const auto direct = open_at(nats().url(world));
    const auto journal = open_at(NatsServer::url(line.port(), world));
    ASSERT_TRUE(direct && journal);
    std::uint32_t last = 1;
    int acknowledged = 0;
    for (int cut = 0; cut < 40; ++cut) {
        const auto way = cut % 2 ? FaultProxy::Way::to_server : FaultProxy::Way::to_client;
        line.cut_next_after(way, static_cast<std::uint64_t>(cut) * 97);
        line.cut(); // so that the next connection is the one
        // The library takes a moment to see it; until then what is asked ends with the old connection.
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        const auto taken = journal->append(change(last + 1));
        const auto there = [&] {
            return direct->append(change(last + 1)).error().is(JournalError::outrun) ||
                   direct->standing().last_epoch > last;
        };
        if (taken) {
            EXPECT_TRUE(there()) << cut;
            ++acknowledged;
        } else {
            ASSERT_FALSE(taken.error().kind == ErrorKind{}) << taken.error().message;
            if (taken.error().is(JournalError::unreachable))
                EXPECT_TRUE(direct->append(change(last + 1))) << "nobody has it";
            else
                (void)direct->append(change(last + 1));
        }
        ++last;
        ASSERT_TRUE(tests::eventually([&] { return direct->standing().last_epoch == last; }));
        ASSERT_TRUE(tests::eventually([&] { return journal->standing().last_epoch == last; }));
    }
    EXPECT_GT(acknowledged, 0);
    EXPECT_LT(acknowledged, 40) << "no cut was felt";
    const std::vector<SeaChange> log = open_at(nats().url(world))->since(0).value();
    ASSERT_EQ(log.size(), last);
    for (std::uint32_t epoch = 2; epoch <= last; ++epoch)
        EXPECT_EQ(log[epoch - 1], change(epoch));
}

TEST(NatsJournal, what_was_acknowledged_outlives_a_kill_of_nats) {
    NatsServer server;
    const auto journal = open_at(server.url("killed"));
    ASSERT_TRUE(journal);
    std::uint32_t last = 1;
    for (int round = 0; round < 5; ++round) {
        for (int i = 0; i < 10; ++i)
            ASSERT_TRUE(journal->append(change(++last)));
        server.stop(SIGKILL);
        const auto refused = journal->append(change(last + 1));
        ASSERT_FALSE(refused);
        EXPECT_TRUE(refused.error().is(JournalError::unreachable)) << refused.error().message;
        EXPECT_NE(refused.error().message.find("NATS "), std::string::npos)
            << refused.error().message;
        EXPECT_EQ(journal->since(0)->size(), last) << "it holds what it held";
        ASSERT_TRUE(server.start());
        const std::int64_t back_us = local_now_us();
        ASSERT_TRUE(tests::eventually([&] {
            const std::int64_t now_us = local_now_us();
            const JournalStanding standing = journal->standing();
            return now_us - standing.unheard_us > back_us && standing.trouble.empty();
        })) << "it was asked since then, and has answered";
    }
    EXPECT_EQ(open_at(server.url("killed"))->since(0).value(), journal->since(0).value());
    EXPECT_EQ(journal->since(0)->size(), 51u);
}

// Nothing comes through, and nobody is told: as a network that is cut.
TEST(NatsJournal, behind_a_cut_network_it_holds_what_it_held_says_so_and_follows_on_when_it_heals) {
    const std::string world = fresh_world();
    FaultProxy line(nats().port());
    const auto cut_off = open_at(NatsServer::url(line.port(), world));
    const auto other = open_at(nats().url(world));
    ASSERT_TRUE(cut_off && other);
    ASSERT_TRUE(cut_off->append(change(2)));
    EXPECT_TRUE(cut_off->standing().current);
    line.stall(true);
    ASSERT_TRUE(other->append(change(3)) || other->append(change(3)));
    ASSERT_TRUE(tests::eventually([&] { return !cut_off->standing().current; }));
    EXPECT_GT(cut_off->standing().unheard_us, SharedJournal::current_us);
    EXPECT_NE(cut_off->standing().trouble, "");
    EXPECT_EQ(cut_off->standing().last_epoch, 2u);
    const auto refused = cut_off->append(change(3));
    ASSERT_FALSE(refused);
    EXPECT_TRUE(refused.error().is(JournalError::unreachable)) << refused.error().message;
    line.stall(false);
    line.cut();
    EXPECT_TRUE(tests::eventually([&] { return cut_off->standing().current; }));
    EXPECT_EQ(cut_off->since(2).value(), std::vector<SeaChange>{change(3)});
    EXPECT_EQ(cut_off->standing().trouble, "");
    EXPECT_TRUE(cut_off->append(change(4)));
}

// An hour is what a wrong time zone makes; the write itself takes milliseconds.
TEST(NatsJournal, a_change_of_a_server_whose_clock_is_behind_is_refused_with_that_reason) {
    const std::string url = nats().url(fresh_world());
    const auto journal = SharedJournal::open(
        std::make_unique<NatsLog>(log_of(url)), beginning,
        {url, "behind", local_now_us, [] { return SeaClock::utc_now_us() - 3'600'000'000; }});
    ASSERT_TRUE(journal);
    const auto refused = (*journal)->append(change(2));
    ASSERT_FALSE(refused);
    EXPECT_TRUE(refused.error().is(JournalError::clock_behind)) << refused.error().message;
    EXPECT_NE(refused.error().message.find("clock is behind that of NATS"), std::string::npos)
        << refused.error().message;
    EXPECT_TRUE((*journal)->since(1)->front().lapsed);
}

TEST(NatsJournal, a_change_longer_than_nats_takes_is_refused_by_name) {
    const auto journal = open_at(nats().url(fresh_world()));
    ASSERT_TRUE(journal);
    SeaChange long_one = change(2);
    long_one.scene.assign(1'048'577, 'x'); // NATS's own default is 1 MiB
    const auto refused = journal->append(long_one);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("max_payload"), std::string::npos)
        << refused.error().message;
    EXPECT_TRUE(refused.error().kind == ErrorKind{});
    EXPECT_TRUE(journal->append(change(2)));
}

// As of one that has just started: it passes, and the start of a server may be tried again.
TEST(NatsJournal, without_jetstream_it_says_so) {
    NatsServer plain("", false);
    const auto journal = open_journal({.where = plain.url("w")}, beginning);
    ASSERT_FALSE(journal);
    EXPECT_NE(journal.error().message.find("NATS runs without JetStream"), std::string::npos)
        << journal.error().message;
    EXPECT_TRUE(journal.error().is(JournalError::unknown)) << journal.error().message;
}

TEST(NatsJournal, is_let_in_by_what_a_file_says_and_tells_nobody) {
    NatsServer server("authorization { user: sea, password: \"s3cret:x\" }");
    const auto file = [](const std::string& text) {
        return tests::folder().write(fmt::format("credentials-{}", next_number()), text);
    };
    const std::string url = server.url("guarded");
    EXPECT_EQ(error_at({.where = url, .credentials_file = file("sea:s3cret:x\n")}),
              "it was opened");
    const std::string wrong = error_at({.where = url, .credentials_file = file("sea:hunter2\n")});
    EXPECT_NE(wrong.find("with these credentials"), std::string::npos) << wrong;
    EXPECT_EQ(wrong.find("hunter2"), std::string::npos) << wrong;
    const auto checked = [&](const std::string& where, const std::string& credentials) {
        const Result<void> fine =
            check_journal_place({.where = where, .credentials_file = credentials});
        return fine ? "fine" : fine.error().message;
    };
    EXPECT_NE(checked(url, "/not/there").find("--journal-credentials /not/there"),
              std::string::npos);
    EXPECT_NE(checked(url, file("")).find("neither NATS credentials nor one line"),
              std::string::npos);
    EXPECT_NE(checked(url, file("a:b\nc:d\n")).find("neither NATS credentials"), std::string::npos);
    const std::string half = file("-----BEGIN NATS USER JWT-----\neyJ0\n");
    EXPECT_NE(
        checked(url, half).find("--journal-credentials " + half + ": NATS credentials without"),
        std::string::npos)
        << checked(url, half);
    EXPECT_NE(error_at({.where = url}).find("lets nobody in without credentials"),
              std::string::npos)
        << error_at({.where = url});
    EXPECT_NE(checked("folder", file("a:b")).find("goes with --journal nats://"),
              std::string::npos);
    const std::string in_url = checked("nats://sea:hunter2@127.0.0.1:4222/w", "");
    EXPECT_NE(in_url.find("--journal-credentials"), std::string::npos) << in_url;
    EXPECT_EQ(in_url.find("hunter2"), std::string::npos) << in_url;
}

// NATS tells who lacks a right only aside, and does not answer: naive, that is a network that is cut.
TEST(NatsJournal, a_user_who_lacks_a_right_is_told_which_are_needed) {
    const auto with = [](const std::string& publish, const std::string& subscribe) {
        NatsServer server(fmt::format("authorization {{ users: [ {{ user: sea, password: \"p\", "
                                      "permissions: {{ publish: [{}], subscribe: [{}] }} }} ] }}",
                                      publish, subscribe));
        return error_at({.where = server.url("w"),
                         .credentials_file = tests::folder().write("rights", "sea:p\n")});
    };
    const std::string info = "\"$JS.API.STREAM.INFO.SEAWAY_w\"",
                      create = "\"$JS.API.STREAM.CREATE.SEAWAY_w\"",
                      get = "\"$JS.API.DIRECT.GET.SEAWAY_w\"", log = "\"seaway.w.>\"",
                      inbox = "\"_INBOX.>\"";
    EXPECT_EQ(with(info + "," + create + "," + get + "," + log, inbox), "it was opened");
    for (const auto& [publish, lacks] : {std::pair(log, "STREAM.INFO.SEAWAY_w\""),
                                         {info + "," + log, "STREAM.CREATE.SEAWAY_w\""},
                                         {info + "," + create + "," + log, "DIRECT.GET.SEAWAY_w\""},
                                         {info + "," + create + "," + get, "seaway.w.log\""}}) {
        const std::string why = with(publish, inbox);
        EXPECT_NE(why.find("NATS does not let this user do what the log needs"), std::string::npos)
            << why;
        EXPECT_NE(why.find(lacks), std::string::npos) << why;
        EXPECT_NE(why.find("subscribe _INBOX.>, seaway.w.clock"), std::string::npos) << why;
    }
}

// A password is changed while servers run: NATS first, then the file; nobody restarts them.
TEST(NatsJournal, a_connection_that_is_made_anew_reads_its_files_again) {
    const std::string file = tests::folder().write("rotated", "sea:old\n");
    NatsServer server("authorization { user: sea, password: \"old\" }");
    const auto journal =
        open_journal({.where = server.url("rotated"), .credentials_file = file}, beginning);
    ASSERT_TRUE(journal);
    server.stop();
    ASSERT_TRUE(server.start("authorization { user: sea, password: \"new\" }"));
    ASSERT_TRUE(tests::eventually([&] {
        return (*journal)->standing().trouble.find("with these credentials") != std::string::npos;
    })) << (*journal)->standing().trouble;
    tests::folder().write("rotated", "sea:new\nand more\n");
    ASSERT_TRUE(tests::eventually([&] {
        return (*journal)->standing().trouble.find("a file that lets this server in is broken") !=
               std::string::npos;
    })) << (*journal)->standing().trouble;
    tests::folder().write("rotated", "sea:new\n");
    EXPECT_TRUE(tests::eventually([&] { return (*journal)->standing().trouble.empty(); }))
        << (*journal)->standing().trouble;
    EXPECT_TRUE((*journal)->append(change(2)));
}

TEST(NatsJournal, speaks_tls_with_who_is_trusted_and_shows_its_own_certificate) {
    const tests::Certificate of_server, own;
    NatsServer server(fmt::format("tls {{ cert_file: \"{}\", key_file: \"{}\", ca_file: \"{}\", "
                                  "verify: true }}",
                                  of_server.cert_file, of_server.key_file, own.cert_file));
    const JournalPlace place{.where = server.url("tls"),
                             .tls_ca_file = of_server.cert_file,
                             .tls_cert_file = own.cert_file,
                             .tls_key_file = own.key_file};
    EXPECT_EQ(error_at(place), "it was opened");
    JournalPlace other = place;
    other.tls_ca_file = own.cert_file; // signs another
    EXPECT_NE(error_at(other).find("SSL"), std::string::npos) << error_at(other);
    JournalPlace in_the_clear{.where = place.where};
    EXPECT_NE(error_at(in_the_clear).find("NATS"), std::string::npos);
    other.tls_ca_file = "/not/there.pem";
    const Result<void> checked = check_journal_place(other);
    ASSERT_FALSE(checked);
    EXPECT_NE(checked.error().message.find("--journal-tls-ca /not/there.pem"), std::string::npos);
}

TEST(NatsUrl, is_hosts_with_ports_and_a_world) {
    const auto read = [](const std::string& url) {
        const Result<NatsPlace> place = read_nats_url(url);
        return place ? place->name() : place.error().message;
    };
    EXPECT_EQ(read("nats://a/w"), "nats://a:4222/w");
    EXPECT_EQ(read("nats://a.b:1,c:65535/North-Sea_1"), "nats://a.b:1,c:65535/North-Sea_1");
    EXPECT_EQ(read("nats://[::1]/w"), "nats://[::1]:4222/w");
    EXPECT_EQ(read("nats://[::1]:7/w"), "nats://[::1]:7/w");
    EXPECT_EQ(read("nats://a/" + std::string(64, 'w')), "nats://a:4222/" + std::string(64, 'w'));
    for (const std::string& wrong :
         {std::string("nats://"), std::string("nats:///w"), std::string("nats://a"),
          std::string("nats://a/"), std::string("nats://a/b.c"), std::string("nats://a/b/c"),
          std::string("nats://a/b*"), std::string("nats://a:0/w"), std::string("nats://a:65536/w"),
          std::string("nats://a:x/w"), std::string("nats://a b/w"), std::string("http://a/w"),
          "nats://a/" + std::string(65, 'w')})
        EXPECT_NE(read(wrong).find("it is a folder, or nats://HOST:PORT/WORLD"), std::string::npos)
            << read(wrong);
    EXPECT_FALSE(is_nats_url("a/folder"));
    EXPECT_TRUE(is_nats_url("nats://a/w"));
}

} // namespace
} // namespace seaway::server
