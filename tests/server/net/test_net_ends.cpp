// SPDX-License-Identifier: Apache-2.0
// How sessions and connections end, what is counted of it, and that nothing goes on for who has gone.
#include "tests/server/net/net_fixture.h"

#include "tests/support/metrics_page.h"

namespace seaway::tests {
namespace {

using wire::Body;
using wire::ErrorCode;

class NetEnds : public NetTest {
  protected:
    /// All connections but the one that asks are gone.
    bool all_gone() {
        return eventually([&] { return metric("seaway_net_connections") == 1; });
    }
};

// One session a way to end, each as often as no other.
TEST_F(NetEnds, each_way_to_end_has_its_own_count_and_its_own_line) {
    options.hello_deadline = options.idle_timeout = std::chrono::minutes(5);
    start();
    for (int i = 0; i < 3; ++i) {
        RawPeer says_so(port());
        says_so.upgrade();
        says_so.frame(protocol::hello("raw", ""));
        says_so.say(closing_frame(1001, "gone home"));
        EXPECT_NE(says_so.rest().find(std::string("\x88\x02\x03\xe9", 4)), std::string::npos)
            << "a closing frame with the same code comes back";
    }
    for (int i = 0; i < 2; ++i) {
        RawPeer breaks(port());
        breaks.upgrade();
        breaks.frame(protocol::hello("raw", ""));
        breaks.reset();
    }
    {
        Client twice(port());
        ASSERT_FALSE(twice.connect());
        ASSERT_TRUE(twice.greet());
        ASSERT_FALSE(twice.send(protocol::hello("again", "")));
        EXPECT_EQ(twice.close_code(), protocol::close_code(ErrorCode::bad_message));
    }
    ASSERT_TRUE(all_gone());
    const MetricsPage page = read_metrics(get("/metrics").body);
    std::map<std::string, double> closed;
    for (const auto& [name, value] : page.values)
        if (name.starts_with("seaway_net_sessions_closed_total") && value > 0)
            closed[name.substr(name.find('{'))] = value;
    EXPECT_EQ(closed, (std::map<std::string, double>{{"{reason=\"bad_message\"}", 1},
                                                     {"{reason=\"closed_by_client\"}", 3},
                                                     {"{reason=\"disconnected\"}", 2}}));
    net->stop();
    EXPECT_EQ(log.lines_with("reason=closed_by_client", "why=\"code 1001 gone home\"").size(), 3u)
        << log.text();
}

// Who goes between two requests, or before the first, has done nothing wrong.
TEST_F(NetEnds, who_goes_without_half_a_request_has_not_failed) {
    options.http_deadline = std::chrono::minutes(5);
    start();
    {
        const RawPeer silent(port());
        RawPeer asks(port());
        asks.say("GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
        EXPECT_TRUE(asks.header().starts_with("HTTP/1.1 200"));
        ASSERT_TRUE(eventually([&] { return metric("seaway_net_connections") == 3; }));
    }
    ASSERT_TRUE(all_gone());
    EXPECT_EQ(metric("seaway_net_handshakes_failed_total"), 0);
    EXPECT_EQ(metric("seaway_net_http_responses_total{status=\"400\"}"), -1) << "nobody was told";
    net->stop();
    EXPECT_TRUE(log.lines_with("event=connection_refused").empty()) << log.text();
}

TEST_F(NetEnds, each_status_has_the_header_that_it_asks_for_and_no_other) {
    options.client_token_file = folder().write("ends_token", "open sesame\n");
    start();
    const std::string fields[] = {"WWW-Authenticate", "Allow", "Upgrade"};
    struct Case {
        const char* target;
        const char* method;
        const char* authorization;
        int status;
        std::array<std::string, 3> values;
    };
    for (const Case& one : {Case{"/v1/state", "GET", "Bearer open sesame", 200, {}},
                            {"/healthz?a=1", "GET", "", 200, {}},
                            {"/v1/state", "GET", "", 401, {"Bearer", "", ""}},
                            {"/none", "GET", "Bearer open sesame", 404, {}},
                            {"/metrics", "POST", "Bearer open sesame", 405, {"", "GET, HEAD", ""}},
                            {"/v1/stream?a=1", "GET", "", 426, {"", "", "websocket"}}}) {
        HttpAnswer answer = ask_http(port(), one.target, one.method, one.authorization);
        EXPECT_EQ(answer.status, one.status) << one.target;
        for (std::size_t i = 0; i < 3; ++i)
            EXPECT_EQ(answer.fields[fields[i]], one.values[i]) << one.target << ' ' << fields[i];
    }
}

// The next of its line shows that the one before has had its turn.
TEST_F(NetEnds, what_who_has_gone_asked_for_is_not_encoded) {
    host.answer_fetches = false;
    start();
    const protocol::TileWish heights{.cascades = 1u, .fields = {sea::Field::height}};
    const sea::TimeUs time_us = 50 * interval_us, later_us = 90 * interval_us;
    {
        const auto goes = greeted();
        ASSERT_FALSE(goes->send(protocol::fetch(1, {&time_us, 1}, heights)));
        ASSERT_TRUE(eventually([&] { return metric("seaway_net_fetches_total") == 1; }));
    }
    ASSERT_TRUE(eventually([&] { return metric("seaway_net_sessions") == 0; }));
    for (const auto& answer : std::exchange(host.unanswered, {}))
        answer();
    host.answer_fetches = true;
    const auto stays = greeted();
    ASSERT_FALSE(stays->send(protocol::fetch(1, {&later_us, 1}, heights)));
    ASSERT_TRUE(stays->receive(Body::FetchDone));
    const auto encoded = [&] { return metric("seaway_net_fields_encoded_total"); };
    ASSERT_TRUE(eventually([&] { return encoded() >= 2; }));
    EXPECT_EQ(encoded(), 2) << "the two keyframes of who stayed";
}

// Two who are granted one cascade each, and one who is granted both.
TEST_F(NetEnds, a_subscriber_gets_the_cascades_that_were_granted_and_no_others) {
    start();
    std::unique_ptr<Client> clients[3];
    const std::uint32_t wishes[] = {1u, 2u, 3u};
    for (std::size_t i = 0; i < 3; ++i) {
        clients[i] = greeted();
        ASSERT_FALSE(clients[i]->send(
            protocol::subscribe(1, {.cascades = wishes[i], .fields = {sea::Field::height}}, 8)));
        ASSERT_TRUE(clients[i]->receive(Body::FetchDone));
    }
    for (const std::int64_t n : {10, 11}) {
        publish(n);
        for (std::size_t i = 0; i < 3; ++i)
            for (int cascade = 0; cascade < 2; ++cascade)
                if ((wishes[i] >> cascade) & 1u) {
                    const wire::Message* message = clients[i]->receive();
                    ASSERT_TRUE(message && message->body_as_Tile());
                    EXPECT_EQ(message->body_as_Tile()->cascade(), cascade) << "client " << i;
                    EXPECT_EQ(message->body_as_Tile()->time_us(), n * interval_us);
                    ASSERT_FALSE(
                        clients[i]->send(protocol::ack(message->body_as_Tile()->keyframe())));
                }
    }
    EXPECT_EQ(metric("seaway_net_keyframes_sent_total"), 8);
}

} // namespace
} // namespace seaway::tests
