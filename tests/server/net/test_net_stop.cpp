// SPDX-License-Identifier: Apache-2.0
// How a server takes leave: what is under way is finished, nobody new is taken, and who goes hears when to come back.
#include "tests/server/net/net_fixture.h"

namespace seaway::tests {
namespace {

using wire::Body;
using wire::ErrorCode;

class NetStop : public NetTest {
  protected:
    NetStop() { host.answer_queries = host.answer_fetches = false; }
    ~NetStop() override {
        if (stopper.joinable())
            stopper.join();
    }
    /// From here on it stops; until then /readyz was fine.
    void begin_to_stop() {
        EXPECT_EQ(get("/readyz").status, 200);
        stopper = std::thread([this] { net->stop(); });
        ASSERT_TRUE(eventually([this] { return get("/readyz").status == 503; }));
    }
    void ask(Client& client, std::uint32_t request_id) {
        const sea::QueryPoint point{1, 2, 3};
        ASSERT_FALSE(client.send(protocol::query(request_id, {&point, 1}, false)));
    }
    /// What waited is answered, from the thread of somebody else.
    void answer() {
        for (const auto& one : std::exchange(host.unanswered, {}))
            one();
    }

    static constexpr const char* received = "seaway_net_messages_received_total";
    std::thread stopper;
};

TEST_F(NetStop, what_was_asked_for_is_answered_before_who_asked_is_sent_away) {
    options.drain_s = 60;
    start();
    const auto queries = greeted(), fetches = greeted(), idle = greeted();
    ask(*queries, 7);
    const sea::TimeUs time_us = 50 * interval_us;
    ASSERT_FALSE(fetches->send(protocol::fetch(8, {&time_us, 1}, heights)));
    ASSERT_TRUE(eventually([this] { return metric(received) == 5; }));
    begin_to_stop();
    const wire::Message* gone = idle->receive();
    ASSERT_TRUE(gone && gone->body_as_GoAway()) << "it is owed nothing and goes at once";
    answer();
    const wire::Message* reply = queries->receive();
    ASSERT_TRUE(reply && reply->body_as_QueryReply());
    EXPECT_EQ(reply->body_as_QueryReply()->request_id(), 7u);
    ASSERT_TRUE(fetches->receive(Body::FetchDone));
    for (Client* client : {queries.get(), fetches.get()}) {
        gone = client->receive();
        ASSERT_TRUE(gone && gone->body_as_GoAway());
        EXPECT_EQ(gone->body_as_GoAway()->code(), ErrorCode::shutting_down);
        EXPECT_EQ(client->close_code(), protocol::close_code(ErrorCode::shutting_down));
    }
}

TEST_F(NetStop, whoever_comes_meanwhile_is_refused_by_name_with_a_time_and_health_goes_on) {
    options.drain_s = 60;
    options.retry_after_s = 12.5;
    options.health_listen = "127.0.0.1:0";
    start();
    const auto waits = greeted();
    ask(*waits, 1);
    ASSERT_TRUE(eventually([this] { return metric(received) == 2; }));
    begin_to_stop();
    const HttpAnswer ready = get("/readyz");
    EXPECT_EQ(ready.body, "the server stops\n");
    EXPECT_EQ(ready.fields.at("Retry-After"), "13") << "whole seconds, never too few";
    EXPECT_EQ(get("/healthz").body, "ok\n") << "it is alive: nobody has to kill it";
    EXPECT_EQ(ask_http(net->health_port(), "/readyz", "GET").status, 503);
    const HttpAnswer map = get("/v1/map?t_s=0&size=16&length_m=100");
    EXPECT_EQ(map.status, 503);
    EXPECT_EQ(map.body, "the server stops\n");
    Client late(port());
    EXPECT_TRUE(late.connect());
    EXPECT_EQ(late.status(), 503);
    EXPECT_EQ(late.field("Retry-After"), "13");
    EXPECT_EQ(metric("seaway_net_sessions_refused_total{reason=\"shutting_down\"}"), 1);
    // More of one who is owed something is not taken: it would have no end.
    ask(*waits, 2);
    ask(*waits, 3);
    EXPECT_EQ(metric("seaway_net_sessions"), 1);
    EXPECT_EQ(metric(received), 2);
    answer();
    const wire::Message* reply = waits->receive();
    ASSERT_TRUE(reply && reply->body_as_QueryReply());
    const wire::Message* gone = waits->receive();
    ASSERT_TRUE(gone && gone->body_as_GoAway());
    EXPECT_EQ(gone->body_as_GoAway()->retry_after_ms(), 12'500u);
}

// Its Hello was long ago, and like any client it goes on talking meanwhile: what holds its connection is what is read from it.
TEST_F(NetStop, who_is_owed_an_answer_gets_it_whatever_it_says_meanwhile) {
    options.hello_deadline = std::chrono::seconds(3); // in which a busy machine has said its hello
    options.drain_s = 60;
    start();
    const auto waits = greeted();
    std::this_thread::sleep_for(options.hello_deadline + std::chrono::milliseconds(100));
    ask(*waits, 1);
    ASSERT_TRUE(eventually([this] { return metric(received) == 2; }));
    begin_to_stop();
    for (std::uint32_t i = 2; i < 10; ++i) {
        ask(*waits, i);
        std::this_thread::sleep_for(std::chrono::milliseconds(10)); // each read by itself
    }
    EXPECT_EQ(metric("seaway_net_sessions"), 1);
    answer();
    const wire::Message* reply = waits->receive();
    ASSERT_TRUE(reply && reply->body_as_QueryReply());
    const wire::Message* gone = waits->receive();
    ASSERT_TRUE(gone && gone->body_as_GoAway());
}

TEST_F(NetStop, who_is_not_answered_in_time_goes_all_the_same) {
    options.drain_s = 0.05;
    start();
    const auto waits = greeted();
    ask(*waits, 1);
    ASSERT_TRUE(eventually([this] { return metric(received) == 2; }));
    net->stop();
    const wire::Message* gone = waits->receive();
    ASSERT_TRUE(gone && gone->body_as_GoAway());
    EXPECT_EQ(gone->body_as_GoAway()->code(), ErrorCode::shutting_down);
    answer(); // nobody is there to hear it
}

// 200 of them a second, over a window as long as the time they are told.
TEST_F(NetStop, the_more_they_are_the_longer_they_stay_away) {
    options.connections_per_address = options.sessions_without_hello_per_address = 0;
    options.idle_timeout = std::chrono::minutes(5);
    start();
    const auto told_ms = [this](std::size_t count) {
        std::vector<std::unique_ptr<Client>> all;
        for (std::size_t i = 0; i < count; ++i)
            all.push_back(greeted());
        net->stop();
        std::set<std::uint32_t> waits_ms;
        for (const auto& client : all) {
            const wire::Message* gone = client->receive(Body::GoAway);
            EXPECT_TRUE(gone);
            waits_ms.insert(gone ? gone->body_as_GoAway()->retry_after_ms() : 0);
        }
        EXPECT_EQ(waits_ms.size(), 1u);
        return *waits_ms.begin();
    };
    EXPECT_EQ(told_ms(1), 2000u);
    start();
    EXPECT_EQ(told_ms(500), 2500u);
}

// Who is sent away for his own sake is told nothing of coming back.
TEST_F(NetStop, other_ends_of_a_session_say_no_time) {
    start();
    const auto twice = greeted();
    ASSERT_FALSE(twice->send(protocol::hello("again", "")));
    const wire::Message* gone = twice->receive(Body::GoAway);
    ASSERT_TRUE(gone);
    EXPECT_EQ(gone->body_as_GoAway()->retry_after_ms(), 0u);
}

// A browser keeps its connection open for the next page: nobody waits for it.
TEST_F(NetStop, a_connection_between_two_requests_holds_nobody_up) {
    options.stop_deadline = options.http_deadline = std::chrono::minutes(10);
    start();
    RawPeer browser(port());
    browser.say("GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
    EXPECT_TRUE(browser.header().starts_with("HTTP/1.1 200"));
    RawPeer silent(port());
    ASSERT_TRUE(eventually([this] { return metric("seaway_net_connections") == 3; }));
    net.reset();
    EXPECT_TRUE(browser.closed_by_server());
}

} // namespace
} // namespace seaway::tests
