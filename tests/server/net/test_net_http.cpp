// SPDX-License-Identifier: Apache-2.0
// The HTTP side, start and stop.
#include <chrono>
#include <string>
#include <system_error>
#include <vector>

#include "tests/server/net/net_fixture.h"
#include "tests/server/net/tcp.h"

namespace seaway::tests {
namespace {

class NetHttp : public NetTest {};

TEST_F(NetHttp, pages_are_served_with_their_content_types) {
    start();
    const auto health = get("/healthz");
    EXPECT_EQ(health.status, 200);
    EXPECT_EQ(health.body, "ok\n");
    const auto state = get("/v1/state?pretty=1");
    EXPECT_EQ(state.status, 200);
    EXPECT_EQ(state.fields.at("Content-Type"), "application/json");
    EXPECT_EQ(state.body, "{\"sea\":1}");
    EXPECT_EQ(get("/v1/plan").body, "{\"plan\":1}");
    const auto metrics = get("/metrics");
    EXPECT_NE(metrics.body.find("seaway_simulation_up 1\n"), std::string::npos);
    EXPECT_NE(metrics.body.find("# TYPE seaway_net_sessions gauge\nseaway_net_sessions 0\n"),
              std::string::npos);
    const auto page = get("/");
    EXPECT_EQ(page.fields.at("Content-Type"), "text/html; charset=utf-8");
    EXPECT_NE(page.body.find("Seaway"), std::string::npos);
}

TEST_F(NetHttp, a_failed_simulation_is_not_healthy) {
    start();
    host.well = false;
    EXPECT_EQ(get("/healthz").status, 503);
    EXPECT_EQ(get("/healthz").body, "the simulation has failed\n");
    EXPECT_EQ(get("/readyz").status, 503);
}

TEST_F(NetHttp, it_is_ready_while_a_session_would_be_taken_and_healthy_when_it_is_full) {
    options.sessions_max = 1;
    start();
    EXPECT_EQ(get("/readyz").body, "ready\n");
    Client client(port());
    ASSERT_FALSE(client.connect());
    ASSERT_TRUE(client.greet());
    EXPECT_EQ(get("/readyz").status, 503);
    EXPECT_EQ(get("/readyz").body, "no session is free\n");
    EXPECT_EQ(get("/healthz").status, 200);
}

// Naive: whoever reaches the port reads names of streams, rights and hosts out of what NATS said.
TEST_F(NetHttp, why_it_is_not_ready_is_told_to_strangers_in_general_words) {
    options.client_token_file = folder().write("ready_client", "open sesame\n");
    options.health_listen = "127.0.0.1:0";
    start();
    host.doubts = true;
    EXPECT_EQ(get("/readyz").status, 503);
    EXPECT_EQ(get("/readyz").body, "it is not sure of its sea\n");
    EXPECT_EQ(ask_http(net->health_port(), "/readyz", "GET").body,
              "secret.stream has not been heard of\n");
    const auto client = greeted("open sesame");
    net->hand_over("secret.stream has not been heard of", "it is not sure of its sea");
    const wire::Message* away = client->receive(wire::Body::GoAway);
    ASSERT_TRUE(away);
    EXPECT_EQ(away->body_as_GoAway()->message()->string_view(),
              "the server hands over: it is not sure of its sea");
    EXPECT_EQ(log.lines_with("event=handing_over", "secret.stream").size(), 1u) << log.text();
}

TEST_F(NetHttp, where_no_token_is_asked_for_anybody_reads_why_it_is_not_ready) {
    start();
    host.doubts = true;
    EXPECT_EQ(get("/readyz").body, "secret.stream has not been heard of\n");
}

TEST_F(NetHttp, what_is_not_there_or_not_allowed_is_said_clearly) {
    start();
    const auto missing = get("/v2/state");
    EXPECT_EQ(missing.status, 404);
    EXPECT_NE(missing.body.find("/v1/state"), std::string::npos);
    const auto posted = get("/v1/state", "POST");
    EXPECT_EQ(posted.status, 405);
    EXPECT_EQ(posted.fields.at("Allow"), "GET, HEAD");
    EXPECT_EQ(get("/v1/stream").status, 426);
}

TEST_F(NetHttp, every_answer_says_which_program_it_is_and_is_not_to_be_kept) {
    start();
    for (const char* target : {"/healthz", "/none", "/v1/stream"}) {
        const HttpAnswer answer = get(target);
        EXPECT_EQ(answer.fields.at("Server"), "seaway/" SEAWAY_VERSION) << target;
        EXPECT_EQ(answer.fields.at("Cache-Control"), "no-store") << target;
        EXPECT_EQ(answer.fields.at("X-Content-Type-Options"), "nosniff") << target;
    }
    RawPeer peer(port());
    peer.say("GET /v1/stream HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: "
             "Upgrade\r\n"
             "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
             "Sec-WebSocket-Protocol: seaway.v1\r\n\r\n");
    const std::string upgraded = peer.header();
    EXPECT_NE(upgraded.find("Server: seaway/" SEAWAY_VERSION "\r\n"), std::string::npos)
        << upgraded;
    EXPECT_NE(upgraded.find("Sec-WebSocket-Protocol: seaway.v1\r\n"), std::string::npos)
        << upgraded;
}

// RFC 6455, 11.3.4: the field may stand several times.
TEST_F(NetHttp, subprotocols_may_be_offered_on_several_lines) {
    start();
    for (const bool offered : {true, false}) {
        RawPeer peer(port());
        peer.say("GET /v1/stream HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: "
                 "Upgrade\r\n"
                 "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                 "Sec-WebSocket-Protocol: other\r\nSec-WebSocket-Protocol: " +
                 std::string(offered ? "more, seaway.v1" : "more") + "\r\n\r\n");
        EXPECT_NE(peer.header().find(offered ? "101 Switching" : "400 Bad"), std::string::npos);
    }
}

// What it shows its script asks for (tests/browser): this is the same whatever sea there is, and may load nothing of others.
TEST_F(NetHttp, the_page_for_people_is_a_shell_that_loads_its_own_script_and_nothing_else) {
    options.sessions_max = 17;
    start();
    const HttpAnswer page = get("/");
    for (const char* part : {"/status.js", "/status.css"})
        EXPECT_NE(page.body.find(fmt::format("\"{}\"", part)), std::string::npos) << part;
    EXPECT_EQ(page.body.find("<script>"), std::string::npos) << "none stands in the page";
    EXPECT_EQ(page.fields.at("Content-Security-Policy").find("default-src 'none'; "), 0u);
    EXPECT_EQ(page.fields.at("Content-Security-Policy").find("unsafe"), std::string::npos);
    EXPECT_NE(page.fields.at("Content-Security-Policy").find("; frame-ancestors 'none'"),
              std::string::npos)
        << "nor does it stand in a frame";
    EXPECT_EQ(get("/status.js").fields.at("Content-Type"), "text/javascript; charset=utf-8");
    EXPECT_EQ(get("/status.css").fields.at("Content-Type"), "text/css; charset=utf-8");
    EXPECT_EQ(host.maps_asked, 0) << "a page costs nothing of the sea";
    EXPECT_EQ(metric("seaway_net_sessions_max"), 17);
}

// Naive: closed with the body unread, where the system has the peer throw away why.
TEST_F(NetHttp, who_sends_a_body_that_is_too_large_hears_so_before_the_end) {
    start();
    Tcp peer;
    ASSERT_EQ(peer.connect(port()), std::error_code{});
    // More than is read for a request.
    const std::string body(60'000, 'x');
    const auto bytes = [](const std::string& text) {
        return std::vector<std::uint8_t>(text.begin(), text.end());
    };
    ASSERT_EQ(peer.write(bytes("POST /v1/state HTTP/1.1\r\nHost: 127.0.0.1\r\n"
                               "Content-Length: 1000000\r\n\r\n" +
                               body),
                         std::chrono::minutes(1)),
              std::error_code{});
    const auto end = Tcp::Clock::now() + std::chrono::minutes(1);
    std::string answer;
    std::error_code ended;
    while (!(ended = peer.read(answer, end)))
        continue;
    EXPECT_EQ(answer.substr(0, 12), "HTTP/1.1 413");
    EXPECT_EQ(ended, std::errc::no_message_available);
    EXPECT_EQ(peer.write(bytes(body), std::chrono::minutes(1)), std::error_code{})
        << "FIN, but no RST";
}

TEST_F(NetHttp, requests_that_are_too_large_or_not_for_reading_have_each_a_status) {
    start();
    const auto status = [&](const std::string& request) {
        RawPeer peer(port());
        peer.say(request);
        return peer.rest().substr(0, 12);
    };
    const std::string head = " HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n";
    EXPECT_EQ(status("GET /healthz" + head + "X: " + std::string(9000, 'x') + "\r\n\r\n"),
              "HTTP/1.1 431");
    EXPECT_EQ(status("GET /healthz" + head + "Content-Length: 1025\r\n\r\n"), "HTTP/1.1 413");
    for (const char* target : {"/", "/healthz", "/metrics", "/v1/state", "/v1/plan", "/v1/map"})
        EXPECT_EQ(status(std::string("POST ") + target + head + "Content-Length: 0\r\n\r\n"),
                  "HTTP/1.1 405")
            << target;
    EXPECT_EQ(host.maps_asked, 0);
    EXPECT_EQ(status("POST /none" + head + "Content-Length: 0\r\n\r\n"), "HTTP/1.1 404");
}

// Naive: it waits for a body of which it was told that it waits for a word (RFC 9110, 10.1.1).
TEST_F(NetHttp, who_waits_to_be_told_to_send_a_body_hears_that_none_is_wanted) {
    start();
    RawPeer peer(port());
    peer.say("POST /v1/state HTTP/1.1\r\nHost: 127.0.0.1\r\nExpect: 100-continue\r\n"
             "Content-Length: 5\r\n\r\n");
    EXPECT_EQ(peer.rest().substr(0, 12), "HTTP/1.1 417");
}

TEST_F(NetHttp, head_has_the_length_and_no_body) {
    start();
    const auto head = get("/healthz", "HEAD");
    EXPECT_EQ(head.status, 200);
    EXPECT_EQ(head.fields.at("Content-Length"), "3");
    EXPECT_TRUE(head.body.empty());
}

// Naive: as many half requests as there may be connections shut everybody out.
TEST_F(NetHttp, connections_without_a_whole_request_make_room_for_newcomers) {
    options.connections_max = 8;
    start();
    std::vector<std::unique_ptr<RawPeer>> peers;
    for (int i = 0; i < 12; ++i) {
        peers.push_back(std::make_unique<RawPeer>(port()));
        peers.back()->say("GET /healthz HT");
    }
    EXPECT_EQ(get("/healthz").status, 200);
    EXPECT_GE(metric("seaway_net_connections_given_up_total"), 5);
    EXPECT_TRUE(peers.front()->closed_by_server()) << "who has waited longest goes first";
    // Sessions stay whatever comes.
    Client client(port());
    ASSERT_FALSE(client.connect());
    EXPECT_TRUE(client.greet());
    for (int i = 0; i < 12; ++i)
        peers.push_back(std::make_unique<RawPeer>(port()));
    EXPECT_EQ(get("/healthz").status, 200);
    ASSERT_FALSE(client.send(protocol::ping(1, 1)));
    EXPECT_TRUE(client.receive(wire::Body::Pong));
}

TEST_F(NetHttp, with_a_client_token_pages_and_maps_ask_for_it) {
    const std::string file = ::testing::TempDir() + "map_token";
    std::ofstream(file) << " open sesame \n";
    options.client_token_file = file;
    options.admin_token_file = folder().write("map_admin_token", "master\n");
    start();
    const auto status = [&](const std::string& target, const std::string& authorization) {
        return ask_http(port(), target, "GET", authorization).status;
    };
    for (const char* target : {"/v1/state", "/v1/plan", "/metrics", "/v1/map?columns=2", "/none"}) {
        EXPECT_EQ(status(target, ""), 401) << target;
        EXPECT_EQ(status(target, "Bearer sesame"), 401) << target;
        EXPECT_EQ(status(target, "Basic open sesame"), 401) << target;
    }
    EXPECT_EQ(host.maps_asked, 0);
    EXPECT_EQ(status("/metrics", "Bearer master"), 200)
        << "an administrator may see what others may";
    const HttpAnswer refused = ask_http(port(), "/v1/state", "GET");
    EXPECT_EQ(refused.fields.at("WWW-Authenticate"), "Bearer");
    EXPECT_NE(refused.body.find("Authorization"), std::string::npos);
    EXPECT_EQ(status("/v1/state", "Bearer open sesame"), 200);
    EXPECT_EQ(status("/metrics", "bearer open sesame"), 200) << "schemes have no case";
    for (const char* target : {"/healthz", "/", "/status.js", "/status.css"})
        EXPECT_EQ(status(target, ""), 200) << target << " says nothing of the sea";
    EXPECT_EQ(status("/v1/stream", ""), 426) << "its Hello brings the token";
}

TEST_F(NetHttp, a_stream_without_the_subprotocol_is_refused) {
    start();
    Client client(port());
    EXPECT_TRUE(client.connect("other.v1"));
    EXPECT_EQ(client.status(), 400);
}

TEST_F(NetHttp, sessions_above_the_limit_are_told_503_and_the_others_go_on) {
    options.sessions_max = 2;
    start();
    Client first(port());
    Client second(port());
    Client third(port());
    ASSERT_FALSE(first.connect());
    ASSERT_FALSE(second.connect());
    ASSERT_TRUE(first.greet());
    EXPECT_TRUE(third.connect());
    EXPECT_EQ(third.status(), 503);
    EXPECT_TRUE(second.greet());
}

TEST_F(NetHttp, an_address_that_cannot_be_had_is_one_helpful_line) {
    start();
    for (const auto& [listen, words] : std::map<std::string, std::string>{
             {fmt::format("127.0.0.1:{}", port()), "choose another port with --listen"},
             {"203.0.113.7:9430", "no such address"},
             {"[2001:db8::7]:9430", "cannot listen on [2001:db8::7]:9430: "},
             {"localhost:9430", "expected ADDR:PORT"},
             {"127.0.0.1", "expected ADDR:PORT"},
             {"127.0.0.1:", "expected ADDR:PORT"},
             {"127.0.0.1:65536", "expected ADDR:PORT"},
             {"::1:80", "expected ADDR:PORT"},
             {"", "expected ADDR:PORT"}}) {
        server::NetOptions other = options;
        other.listen = listen;
        const auto started = server::NetServer::start(other, host);
        ASSERT_FALSE(started.has_value()) << listen;
        EXPECT_NE(started.error().message.find(words), std::string::npos)
            << started.error().message;
        EXPECT_EQ(started.error().message.find('\n'), std::string::npos);
    }
}

// Looked at before anything is listened to: a port that nobody may have is as good as any other.
TEST(NetOptions, an_address_is_two_parts_each_in_its_range) {
    const auto understood = [](const std::string& listen) {
        server::NetOptions options;
        options.listen = listen;
        return server::NetServer::check(options).has_value();
    };
    for (const char* listen :
         {"127.0.0.1:0", "0.0.0.0:1", "10.1.2.3:65535", "[::]:9430", "[::1]:0", "[fe80::2]:65535"})
        EXPECT_TRUE(understood(listen)) << listen;
    for (const char* listen : {"127.0.0.1:65536", "127.0.0.1:-1", "127.0.0.1:+1", "127.0.0.1: 1",
                               "127.0.0.1:1x", ":9430", "9430", "::1:9430", "[::1]", "[]:9430",
                               "[::1:9430", "256.0.0.1:9430", "[127.0.0.1:1"})
        EXPECT_FALSE(understood(listen)) << listen;
}

TEST_F(NetHttp, files_that_cannot_be_read_are_one_helpful_line) {
    const auto message = [&](const server::NetOptions& other) {
        const auto started = server::NetServer::start(other, host);
        EXPECT_FALSE(started.has_value());
        return started ? std::string() : started.error().message;
    };
    server::NetOptions other = options;
    other.client_token_file = "/nonexistent/token";
    EXPECT_NE(message(other).find("/nonexistent/token"), std::string::npos);
    other = options;
    other.tls_cert_file = "/nonexistent/cert.pem";
    EXPECT_NE(message(other).find("--tls-key"), std::string::npos);
    other.tls_key_file = "/nonexistent/key.pem";
    EXPECT_NE(message(other).find("--tls-cert /nonexistent/cert.pem"), std::string::npos);
}

TEST_F(NetHttp, the_url_names_the_port_that_was_taken) {
    start();
    EXPECT_EQ(net->url(), fmt::format("ws://127.0.0.1:{}", port()));
    EXPECT_GT(port(), 0);
}

TEST_F(NetHttp, stop_says_goaway_to_all_and_is_idempotent) {
    start();
    Client greeted(port());
    ASSERT_FALSE(greeted.connect());
    ASSERT_TRUE(greeted.greet());
    Client silent(port());
    ASSERT_FALSE(silent.connect());
    std::thread stopper([&] { net->stop(); });
    const wire::Message* message = greeted.receive();
    ASSERT_TRUE(message && message->body_as_GoAway());
    EXPECT_EQ(message->body_as_GoAway()->code(), wire::ErrorCode::shutting_down);
    EXPECT_EQ(greeted.close_code(), protocol::close_code(wire::ErrorCode::shutting_down));
    stopper.join();
    net->stop();
    net->publish(host.keyframe(0, 1, {sea::Field::height}));
    net->announce(SmallSea::state_message(1));
}

} // namespace
} // namespace seaway::tests
