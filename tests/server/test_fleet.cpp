// SPDX-License-Identifier: Apache-2.0
// Several servers that follow one log in NATS, as real programs on loopback.
#include <chrono>
#include <cmath>
#include <ctime>
#include <iomanip>
#include <random>
#include <sstream>
#include <thread>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/child_process.h"
#include "client/client.h"
#include "server/journal/nats_peers.h"
#include "server/journal/peer_clocks.h"
#include "server/journal/sea_clock.h"
#include "tests/server/fleet_bench.h"
#include "tests/support/eventually.h"
#include "tests/support/fault_proxy.h"
#include "tests/support/lines_of.h"
#include "tests/support/nats_server.h"
#include "tests/support/times_in.h"

namespace seaway::changes {
namespace {

using client::Client;
using tests::FaultProxy;
using tests::NatsServer;
using tests::ServerProcess;

std::vector<sea::QueryPoint> points_around(sea::TimeUs from_us, sea::TimeUs until_us) {
    std::mt19937_64 random(77);
    std::uniform_real_distribution<double> place(-3000, 3000);
    std::uniform_int_distribution<sea::TimeUs> time(from_us, until_us);
    std::vector<sea::QueryPoint> points;
    for (int i = 0; i < 200; ++i)
        points.push_back({place(random), place(random), time(random)});
    return points;
}

/// The exact sums of both are the same bits.
void expect_one_sea(const std::string& a, const std::string& b, sea::TimeUs from_us,
                    sea::TimeUs until_us) {
    const auto first = connect(a), second = connect(b);
    ASSERT_TRUE(first && second);
    const std::vector<sea::QueryPoint> points = points_around(from_us, until_us);
    const auto one = first->ask(points, {.exact = true, .timeout_s = 60});
    const auto other = second->ask(points, {.exact = true, .timeout_s = 60});
    ASSERT_TRUE(one && other);
    for (std::size_t i = 0; i < points.size(); ++i)
        EXPECT_EQ((*one)[i].height_m, (*other)[i].height_m) << points[i].time_us;
}

TEST(Fleet, a_change_at_one_server_is_the_sea_of_all_and_of_who_comes_later) {
    NatsServer nats;
    const std::string world = nats.url("north-sea");
    ServerProcess a(arguments_of(world)), b(arguments_of(world));
    const std::string at_a = a.wait_until_ready(), at_b = b.wait_until_ready();
    ASSERT_FALSE(at_a.empty() || at_b.empty()) << a.log() << b.log();
    EXPECT_TRUE(tests::eventually([&] { return get(at_a, "/readyz").status == 200; }));
    const auto watcher = connect(at_b);
    ASSERT_TRUE(watcher);
    ASSERT_TRUE(watcher->subscribe({.fields = sea::surface_fields}, 8, 60));
    const Said said =
        ctl_once_sure(at_a, {"set", "systems.0.wind_speed_10m_mps=15", "--over", "10s"});
    ASSERT_EQ(said.code, 0) << said.words;
    const double start_s = number(said.words, "start_s"), end_s = number(said.words, "end_s");
    EXPECT_TRUE(tests::eventually([&] { return journal_of(at_b)["played"] == 2; })) << b.log();
    EXPECT_GT(start_s, sea::seconds_from_us(watcher->now_us())) << "known before it begins";
    ASSERT_EQ(ctl_once_sure(at_b, {"rate", "0.5"}).code, 0);
    EXPECT_TRUE(tests::eventually([&] { return journal_of(at_a)["played"] == 3; })) << a.log();
    ServerProcess later(arguments_of(world));
    const std::string at_later = later.wait_until_ready();
    ASSERT_FALSE(at_later.empty()) << later.log();
    const auto from_us = sea::us_from_seconds(start_s - 5),
               until_us = sea::us_from_seconds(end_s + 5);
    expect_one_sea(at_a, at_b, from_us, until_us);
    expect_one_sea(at_a, at_later, from_us, until_us);
    EXPECT_NE(a.log().find("event=sea_pace"), std::string::npos) << a.log();
    EXPECT_TRUE(tests::eventually([&] { return journal_of(at_a)["stale"] == false; }));
    EXPECT_TRUE(tests::eventually([&] {
        return get(at_a, "/metrics").body.find("seaway_sea_stale 0") != std::string::npos;
    }));
}

/// Foam of all cascades around a time, as a client of this server is sent it, and by how much each value may be rounded.
struct FoamSent {
    std::vector<float> ratios;
    double rounding = 0;
};

FoamSent foam_of(const std::string& url, sea::TimeUs time_us) {
    const auto client = connect(url);
    if (!client || !client->hold({&time_us, 1}, 60, {sea::Field::foam}))
        return {};
    const auto state = client->sea_state(time_us);
    FoamSent sent;
    for (std::size_t c = 0; state && c < state->cascades.size(); ++c) {
        const auto pair =
            client->ring().around(static_cast<int>(c), state->epoch, time_us,
                                  state->cascades[c].interval_us, sea::FieldSet{sea::Field::foam});
        if (!pair)
            return {};
        const std::span<const float> map = pair->before->keyframe().plane(sea::Field::foam);
        sent.ratios.insert(sent.ratios.end(), map.begin(), map.end());
        sent.rounding = std::max(sent.rounding, double{pair->before->error(sea::Field::foam)});
    }
    return sent;
}

// One has walked the foam for a reader since before the wind rose, the other is started when it has risen. They differ by
// what a history keeps of how it began, exp(-10) of some tens (1e-3; docs/foam.md), and by how both round.
TEST(Fleet, foam_is_the_same_of_who_was_there_when_the_wind_rose_and_of_who_came_after) {
    NatsServer nats;
    std::vector<std::string> words = arguments_of(nats.url("white"));
    words[0] = "scenes/north_sea_gale.toml";
    ServerProcess old(words);
    const std::string at_old = old.wait_until_ready();
    ASSERT_FALSE(at_old.empty()) << old.log();
    const auto reader = connect(at_old);
    ASSERT_TRUE(reader);
    ASSERT_TRUE(reader->subscribe({.fields = sea::surface_fields | sea::FieldSet{sea::Field::foam}},
                                  8, 30));
    const Said said =
        ctl_once_sure(at_old, {"set", "systems.0.wind_speed_10m_mps=23", "--over", "10s"});
    ASSERT_EQ(said.code, 0) << said.words;
    const sea::TimeUs time_us = sea::us_from_seconds(number(said.words, "end_s") + 3);
    ASSERT_TRUE(tests::eventually([&] { return reader->now_us() > time_us; }));
    ServerProcess fresh(words);
    const std::string at_fresh = fresh.wait_until_ready();
    ASSERT_FALSE(at_fresh.empty()) << fresh.log();
    const FoamSent one = foam_of(at_old, time_us), other = foam_of(at_fresh, time_us);
    ASSERT_EQ(one.ratios.size(), 3u * 256 * 256);
    ASSERT_EQ(one.ratios.size(), other.ratios.size());
    double apart = 0, most = 0;
    for (std::size_t i = 0; i < one.ratios.size(); ++i) {
        apart = std::max(apart, std::abs(double{one.ratios[i]} - double{other.ratios[i]}));
        most = std::max(most, double{one.ratios[i]});
    }
    EXPECT_GT(most, 5) << "there are whitecaps to compare";
    EXPECT_LE(apart, 1e-3 + one.rounding + other.rounding);
}

/// Is what its server answers about now flagged or not, asked and sampled alike, with an error that grows with what may have
/// changed where it is? Between two pings one may be so and the other not yet.
bool all_stale(Client& client, bool wanted) {
    const sea::TimeUs now_us = client.now_us(), later_us = now_us + 20'000'000;
    const std::vector<sea::QueryPoint> points{{1, 2, now_us}, {1, 2, later_us}};
    const auto asked = client.ask(points, {.exact = true, .timeout_s = 60});
    const auto sampled = client.fetch_and_sample(points, 60);
    if (!asked || !sampled)
        return false;
    const auto stale = [](const sea::Answer& answer) {
        return (answer.flags & sea::answer_stale) != 0;
    };
    const bool grows = (*asked)[1].error_m > 0.01 + (*asked)[0].error_m;
    return stale((*asked)[0]) == wanted && stale((*sampled)[0]) == wanted && grows == wanted;
}

std::vector<std::string> a_lighter_wind() {
    return {"set", "systems.0.wind_speed_10m_mps=9", "--over", "10s"};
}

TEST(Fleet,
     a_server_behind_a_cut_network_serves_on_says_that_it_is_stale_and_follows_when_it_heals) {
    NatsServer nats;
    FaultProxy line(nats.port());
    ServerProcess a(arguments_of(nats.url("cut"))),
        b(arguments_of(NatsServer::url(line.port(), "cut")));
    const std::string at_a = a.wait_until_ready(), at_b = b.wait_until_ready();
    ASSERT_FALSE(at_a.empty() || at_b.empty()) << a.log() << b.log();
    ASSERT_TRUE(tests::eventually([&] { return get(at_b, "/readyz").status == 200; }));
    line.stall(true);
    const Said said =
        ctl_once_sure(at_a, {"set", "systems.0.wind_speed_10m_mps=15", "--over", "10s"});
    ASSERT_EQ(said.code, 0) << said.words;
    EXPECT_TRUE(tests::eventually([&] { return get(at_b, "/readyz").status != 200; }));
    EXPECT_NE(get(at_b, "/readyz").body.find("the journal has not been heard of for"),
              std::string::npos);
    EXPECT_EQ(get(at_b, "/healthz").status, 200) << "it is alive, and not to be restarted";
    EXPECT_EQ(journal_of(at_b)["stale"], true);
    EXPECT_EQ(journal_of(at_b)["played"], 1);
    EXPECT_EQ(ctl(at_a, {"status", at_b}).code, 7) << "stale is not well";
    const auto client = connect(at_b);
    ASSERT_TRUE(client) << "it serves on";
    EXPECT_TRUE(tests::eventually([&] { return all_stale(*client, true); }))
        << "and says that it is unsure";
    EXPECT_GT(client->status().stale_s, 0);
    const auto of_a = connect(at_a);
    ASSERT_TRUE(of_a);
    EXPECT_TRUE(tests::eventually([&] { return all_stale(*of_a, false); }));
    const Said refused = ctl(at_b, a_lighter_wind());
    EXPECT_EQ(refused.code, 6) << refused.words;
    EXPECT_NE(refused.words.find("the sea cannot be changed now"), std::string::npos)
        << refused.words;
    EXPECT_TRUE(tests::eventually([&] { return get(at_a, "/readyz").status == 200; }))
        << get(at_a, "/readyz").body;
    line.stall(false);
    line.cut();
    EXPECT_TRUE(tests::eventually([&] { return get(at_b, "/readyz").status == 200; })) << b.log();
    EXPECT_TRUE(tests::eventually([&] { return journal_of(at_b)["played"] == 2; }));
    const auto later = connect(at_b);
    ASSERT_TRUE(later);
    EXPECT_TRUE(tests::eventually([&] { return all_stale(*later, false); })) << "it knows again";
    // It looks for what to say of itself a few times a second; an answer says at once how it stands.
    EXPECT_TRUE(tests::eventually(
        [&] { return tests::times_in(b.log(), "event=sea_current change=") > 0; }));
    EXPECT_GE(
        tests::times_in(b.log(), "event=sea_stale why=\"the journal has not been heard of for"), 1);
    // Once each time: where the machine stands still for two seconds they are stale once more, and rightly.
    for (const std::string& log : {a.log(), b.log()}) // and no machine stands still so often
        EXPECT_LE(tests::times_in(log, "event=sea_stale"),
                  std::min(6, 1 + tests::times_in(log, "event=sea_current")));
    EXPECT_EQ(tests::times_in(b.log(), "event=change_refused"), 1) << b.log();
    // They were started at once: either may be the first.
    const std::string both = a.log() + b.log();
    EXPECT_EQ(tests::times_in(both, "event=sea_begins journal=\"nats://"), 1) << both;
    EXPECT_EQ(tests::times_in(both, "event=sea_goes_on journal=\"nats://"), 1) << both;
    const double start_s = number(said.words, "start_s");
    expect_one_sea(at_a, at_b, sea::us_from_seconds(start_s - 5),
                   sea::us_from_seconds(start_s + 15));
    EXPECT_EQ(ctl_once_sure(at_b, a_lighter_wind()).code, 0);
}

/// Said by a server that is none: its clock is ahead by so much.
class LyingPeer {
  public:
    LyingPeer(int port, const std::string& world, const std::string& name, double ahead_s,
              std::int64_t epoch_utc_us)
        : clocks_(name), line_(server::NatsConnection::make(
                                   server::read_nats_url(NatsServer::url(port, world)).value())
                                   .value()) {
        const auto sea_us = [=] {
            return server::SeaClock::utc_now_us() - epoch_utc_us + std::llround(1e6 * ahead_s);
        };
        line_.begin(
            [=, this] {
                const std::int64_t local_us = local_now_us();
                return clocks_.word(local_us, sea_us());
            },
            [=, this](const std::string& word) {
                const std::int64_t here_us = sea_us();
                clocks_.hear(word, local_now_us(), here_us);
            });
    }

  private:
    server::PeerClocks clocks_;
    server::NatsPeers line_; // ends before what it calls
};

std::int64_t epoch_utc_us(const std::string& url) {
    std::istringstream text(
        nlohmann::json::parse(get(url, "/v1/state").body)["epoch_utc"].get<std::string>());
    std::tm day{};
    double rest = 0;
    text >> std::get_time(&day, "%Y-%m-%dT%H:%M:%S") >> rest;
    return 1'000'000 * timegm(&day) + std::llround(1e6 * rest);
}

// Two others agree that this one's clock is half a second behind: in the calm sea 5 standard deviations of its vertical
// velocity times that are far beyond its budget of heights.
TEST(
    Fleet,
    a_server_whose_clock_is_off_from_those_of_two_others_is_not_ready_and_hands_its_sessions_over) {
    NatsServer nats;
    ServerProcess server(arguments_of(nats.url("clocks")));
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    const auto client = connect(url);
    ASSERT_TRUE(client);
    const std::int64_t epoch_us = epoch_utc_us(url);
    {
        const LyingPeer right(nats.port(), "clocks", "right1", 0, epoch_us);
        const LyingPeer also(nats.port(), "clocks", "right2", 0, epoch_us);
        ASSERT_TRUE(tests::eventually([&] { return journal_of(url)["peers"] == 2; }));
        EXPECT_TRUE(tests::eventually([&] { return journal_of(url)["clock_error_ms"] < 50; }));
        const auto journal = journal_of(url);
        EXPECT_NEAR(journal["clock_ahead_ms"].get<double>(), 0,
                    journal["clock_error_ms"].get<double>() + 1);
        EXPECT_TRUE(tests::eventually([&] { return get(url, "/readyz").status == 200; }))
            << get(url, "/readyz").body;
    }
    const LyingPeer a(nats.port(), "clocks", "ahead1", 0.5, epoch_us);
    const LyingPeer b(nats.port(), "clocks", "ahead2", 0.5, epoch_us);
    EXPECT_TRUE(tests::eventually([&] {
        const std::string body = get(url, "/readyz").body;
        return body.find("ms behind those of 2 others: heights would be") != std::string::npos;
    })) << get(url, "/readyz").body;
    EXPECT_TRUE(tests::eventually([&] {
        return server.log().find("event=handing_over sessions=1") != std::string::npos;
    })) << server.log();
    EXPECT_TRUE(tests::eventually([&] {
        return client->status().reason.find("the server hands over: ") != std::string::npos;
    })) << "and its session has ended: "
        << client->status().reason;
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"set", "systems.0.wind_speed_10m_mps=15", "--over", "10s"},
          {"pause"}}) {
        const Said refused = ctl(url, words);
        EXPECT_EQ(refused.code, 6) << "it would be a change of another time: " << refused.words;
        EXPECT_NE(refused.words.find("ms behind those of 2 others"), std::string::npos)
            << refused.words;
        EXPECT_EQ(refused.words.find("ask again in"), std::string::npos)
            << "a clock is not right in a second: " << refused.words;
    }
    EXPECT_EQ(journal_of(url)["changes"], 1) << "nothing of them is in the log";
    EXPECT_EQ(get(url, "/healthz").status, 200);
}

/// How its sea is, its changes, and how many it is behind, of a server's row of `status`.
std::string standing_in(const std::string& row) {
    std::istringstream words(row);
    std::string url, name, version, sea, changes, behind;
    words >> url >> name >> version >> sea >> changes >> behind;
    return sea + " " + changes + " " + behind;
}

TEST(Fleet, an_administrator_sees_the_servers_their_history_and_differences_and_rewinds) {
    NatsServer nats;
    ServerProcess a(arguments_of(nats.url("admin"))), b(arguments_of(nats.url("admin")));
    std::vector<std::string> another = arguments(tests::folder().file("stranger"));
    another[0] = "scenes/trade_wind_swell.toml";
    ServerProcess stranger(another);
    const std::string at_a = a.wait_until_ready(), at_b = b.wait_until_ready(),
                      elsewhere = stranger.wait_until_ready();
    ASSERT_FALSE(at_a.empty() || at_b.empty() || elsewhere.empty()) << a.log() << b.log();
    const Said set =
        ctl_once_sure(at_a, {"set", "systems.0.wind_speed_10m_mps=11.5", "--over", "10s"});
    ASSERT_EQ(set.code, 0) << set.words;
    EXPECT_EQ(number(set.words, "change"), 2) << set.words;
    ASSERT_TRUE(tests::eventually([&] { return journal_of(at_b)["played"] == 2; }));
    Said status{};
    std::vector<std::string> rows;
    // Either may be stale for a moment.
    EXPECT_TRUE(tests::eventually([&] {
        status = ctl(at_a, {"status", at_b, "ws://127.0.0.1:1"});
        rows = tests::lines_of(status.words);
        return rows.size() == 4 && standing_in(rows[1]) == "ready 2 0" &&
               standing_in(rows[2]) == "ready 2 0";
    })) << status.words;
    EXPECT_EQ(status.code, 7) << "one does not answer: " << status.words;
    EXPECT_TRUE(tests::eventually([&] { return ctl(at_a, {"status", at_b}).code == 0; }));
    EXPECT_EQ(ctl("ws://127.0.0.1:1", {"status"}).code, 5) << "nobody answers";
    const Said nobody = ctl("ws://127.0.0.1:1", {"status", "ws://127.0.0.1:2"});
    EXPECT_EQ(nobody.code, 5) << "nor does anybody here: " << nobody.words;
    EXPECT_NE(nobody.words.find("\nws://127.0.0.1:2 "), std::string::npos) << "a row for each";
    ASSERT_EQ(rows.size(), 4u) << status.words;
    EXPECT_NE(rows[0].find("ahead_ms"), std::string::npos);
    for (std::size_t row : {1u, 2u})
        EXPECT_EQ(rows[row].find(row == 1 ? at_a : at_b), 0u) << rows[row];
    EXPECT_EQ(rows[3].find("ws://127.0.0.1:1"), 0u) << rows[3];
    const auto history = nlohmann::json::parse(ctl(at_b, {"history"}).words)["changes"];
    ASSERT_EQ(history.size(), 2u);
    EXPECT_EQ(history[1]["change"], 2);
    EXPECT_NE(history[1]["differs"].dump().find("11.5"), std::string::npos) << history.dump();
    EXPECT_EQ(nlohmann::json::parse(ctl(at_b, {"history", "--from", "2"}).words)["changes"].size(),
              1u);
    const Said same = ctl(at_a, {"diff", at_b, "--points", "500"});
    EXPECT_EQ(same.code, 0) << same.words;
    EXPECT_EQ(number(same.words, "beyond_bounds"), 0);
    EXPECT_GT(number(same.words, "points"), 400);
    const Said other = ctl(at_a, {"diff", elsewhere, "--points", "500"});
    EXPECT_EQ(other.code, 6) << other.words;
    EXPECT_NE(other.words.find("different seas"), std::string::npos) << other.words;
    // Back to the beginning, asked of the other server: its scene is that of change 1 to the letter.
    const Said back = ctl_once_sure(at_b, {"rewind", "1", "--over", "10s"});
    ASSERT_EQ(back.code, 0) << back.words;
    EXPECT_EQ(number(back.words, "change"), 3) << back.words;
    ASSERT_TRUE(tests::eventually([&] { return journal_of(at_a)["played"] == 3; }));
    const auto again =
        nlohmann::json::parse(ctl(at_a, {"history", "--from", "3"}).words)["changes"];
    ASSERT_EQ(again.size(), 1u);
    EXPECT_EQ(again[0]["differs"].dump().find("11.5"), std::string::npos) << again.dump();
    const Said none = ctl_once_sure(at_a, {"rewind", "99"});
    EXPECT_EQ(none.code, 6);
    EXPECT_NE(none.words.find("change is 99; there is none"), std::string::npos) << none.words;
}

} // namespace
} // namespace seaway::changes
