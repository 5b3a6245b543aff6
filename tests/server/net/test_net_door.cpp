// SPDX-License-Identifier: Apache-2.0
// Who comes in, and what one address may take: over sockets that come from several loopback addresses.
#include "protocol/limits.h"
#include "server/net/pages.h"
#include "server/net/session.h"
#include "tests/server/net/door_fixture.h"

namespace seaway::tests {
namespace {

using wire::Body;
using wire::ErrorCode;

TEST_F(NetDoor, sessions_without_hello_are_few_for_one_address_and_give_way_to_others) {
    options.sessions_max = 4;
    options.sessions_without_hello_per_address = 3;
    start();
    std::vector<std::unique_ptr<RawPeer>> silent;
    for (int i = 0; i < 3; ++i) {
        silent.push_back(std::make_unique<RawPeer>(port()));
        silent.back()->upgrade();
    }
    Client fourth(port());
    EXPECT_TRUE(fourth.connect());
    EXPECT_EQ(fourth.status(), 429);
    EXPECT_EQ(fourth.field("Retry-After"), "1");
    Client first(port(), neighbour);
    ASSERT_FALSE(first.connect());
    ASSERT_TRUE(first.greet()) << "the last place";
    EXPECT_EQ(status("/readyz", "", neighbour), 200) << "a silent crowd takes no server out of use";
    Client second(port(), neighbour);
    ASSERT_FALSE(second.connect()) << "one of three silent ones gives way";
    ASSERT_TRUE(second.greet());
    Client third(port(), neighbour);
    ASSERT_FALSE(third.connect());
    ASSERT_TRUE(third.greet());
    Client one_more(port(), neighbour);
    EXPECT_TRUE(one_more.connect()) << "one silent session is no crowd";
    EXPECT_EQ(one_more.status(), 503);
    EXPECT_EQ(one_more.field("Retry-After"), "1");
    EXPECT_EQ(counted("seaway_net_sessions"), 4);
    EXPECT_EQ(counted("seaway_net_sessions_refused_total{reason=\"address_full\"}"), 1);
    EXPECT_EQ(counted("seaway_net_sessions_refused_total{reason=\"server_full\"}"), 1);
    EXPECT_EQ(counted("seaway_net_sessions_closed_total{reason=\"server_full\"}"), -1)
        << "what was never opened is not closed";
    EXPECT_EQ(counted("seaway_net_sessions_closed_total{reason=\"hello_expected\"}"), 2);
    EXPECT_EQ(counted("seaway_net_sessions_opened_total"), 6);
    for (Client* client : {&first, &second, &third}) {
        ASSERT_FALSE(client->send(protocol::ping(1, 1)));
        EXPECT_TRUE(client->receive(Body::Pong));
    }
}

TEST_F(NetDoor, a_token_at_the_upgrade_takes_the_place_of_those_without_and_is_the_hellos_own) {
    ask_for_tokens();
    options.sessions_max = 2;
    options.sessions_without_hello_per_address = 2;
    start();
    RawPeer silent[2] = {RawPeer(port()), RawPeer(port())};
    for (RawPeer& peer : silent)
        peer.upgrade();
    EXPECT_EQ(knock(""), 429u);
    Client client(port());
    ASSERT_FALSE(client.connect("seaway.v1", bearer("open sesame")));
    EXPECT_TRUE(client.greet("")) << "Hello needs no token then";
    Client admin(port());
    ASSERT_FALSE(admin.connect("seaway.v1", bearer("master")));
    EXPECT_TRUE(admin.greet(""));
    EXPECT_EQ(knock("", "", bearer("open sesame")), 503u) << "those who greeted stay";
    net->stop();
    EXPECT_EQ(log.lines_with("event=session_open", "administrator=true").size(), 1u);
    EXPECT_EQ(log.lines_with("event=session_open", "administrator=false").size(), 1u);
}

TEST_F(NetDoor, each_of_both_tokens_that_a_client_brings_has_to_be_right) {
    ask_for_tokens();
    start();
    const unsigned unauthorised = protocol::close_code(ErrorCode::unauthorised);
    EXPECT_EQ(knock("open sesame", "", bearer("wrong")), 401u) << "at the upgrade";
    EXPECT_EQ(knock("wrong", "", bearer("open sesame")), unauthorised) << "in Hello";
    EXPECT_EQ(knock("", "", "Authorization: Basic b3Blbg==\r\n"), unauthorised) << "none of ours";
    EXPECT_EQ(knock("master", "", bearer("open sesame")), 0u);
    EXPECT_EQ(counted("seaway_net_sessions_refused_total{reason=\"unauthorised\"}", "open sesame"),
              1);
}

// ---- guessing --------------------------------------------------------------------------------

TEST_F(NetDoor,
       wrong_tokens_are_counted_together_for_pages_and_streams_and_then_none_is_looked_at) {
    ask_for_tokens();
    options.wrong_tokens_per_address = 4;
    options.wrong_tokens_refill = std::chrono::hours(1);
    start();
    Client before(port());
    ASSERT_FALSE(before.connect());
    ASSERT_TRUE(before.greet("open sesame"));
    const unsigned unauthorised = protocol::close_code(ErrorCode::unauthorised);
    for (int i = 0; i < 20; ++i) { // who brings none has not guessed
        EXPECT_EQ(status("/v1/state"), 401);
        EXPECT_EQ(knock(""), unauthorised);
    }
    EXPECT_EQ(status("/v1/state", "guess1"), 401);
    EXPECT_EQ(knock("guess2"), unauthorised);
    EXPECT_EQ(knock("", "", bearer("guess3")), 401u);
    EXPECT_EQ(status("/metrics", "guess4"), 401);
    const HttpAnswer locked = ask_http(port(), "/v1/state", "GET", "Bearer open sesame");
    EXPECT_EQ(locked.status, 429) << "else guessing would go on";
    const auto expect_a_quarter_of_the_hour = [guessed =
                                                   std::chrono::steady_clock::now()](double s) {
        const std::chrono::duration<double> since = std::chrono::steady_clock::now() - guessed;
        EXPECT_LE(s, 900);
        EXPECT_GE(s, 900 - 60 - since.count()) << "since the first guess, on a busy machine";
    };
    const std::string& after = locked.fields.at("Retry-After");
    expect_a_quarter_of_the_hour(std::stod(after));
    EXPECT_NE(locked.body.find(after + " s"), std::string::npos) << locked.body;
    EXPECT_EQ(knock("open sesame"), protocol::close_code(ErrorCode::too_many_requests));
    Client barred(port());
    ASSERT_FALSE(barred.connect());
    ASSERT_FALSE(barred.send(protocol::hello("c", "open sesame")));
    const wire::Message* const away = barred.receive(Body::GoAway);
    ASSERT_TRUE(away);
    expect_a_quarter_of_the_hour(0.001 * away->body_as_GoAway()->retry_after_ms());
    EXPECT_EQ(knock("", "", bearer("master")), 429u);
    EXPECT_EQ(status("/healthz"), 200);
    for (const char* path :
         {"/healthz", "/readyz"}) // Naive: a prober with an old token locks its address out.
        for (const char* token : {"guess5", "open sesame"})
            EXPECT_EQ(status(path, token), 200) << "no token is looked at";
    EXPECT_EQ(status("/v1/state", "open sesame", neighbour), 200) << "of another address";
    ASSERT_FALSE(before.send(protocol::ping(1, 1)));
    EXPECT_TRUE(before.receive(Body::Pong)) << "who is in stays in";
    EXPECT_EQ(counted("seaway_net_tokens_refused_total{reason=\"wrong\"}", "open sesame"), 4);
    EXPECT_EQ(counted("seaway_net_tokens_refused_total{reason=\"too_many_wrong\"}", "open sesame"),
              4);
    net->stop();
    EXPECT_EQ(log.lines_with("event=token_refused", "reason=wrong").size(), 1u) << log.text();
    EXPECT_EQ(log.lines_with("event=token_refused", "reason=too_many_wrong").size(), 1u);
    for (const char* secret : {"guess", "sesame", "master"})
        EXPECT_EQ(log.text().find(secret), std::string::npos) << "no secrets in the log";
}

TEST_F(NetDoor, a_guess_at_the_administrators_token_counts_where_everybody_may_come_in) {
    options.admin_token_file = folder().write("door_only_admin", "master\n");
    options.wrong_tokens_per_address = 2;
    options.wrong_tokens_refill = std::chrono::hours(1);
    start();
    EXPECT_EQ(knock("guess1"), 0u) << "a stranger, as all are";
    EXPECT_EQ(knock("guess2"), 0u);
    EXPECT_EQ(knock("master"), protocol::close_code(ErrorCode::too_many_requests));
    EXPECT_EQ(knock(""), 0u);
    EXPECT_EQ(knock("master", neighbour), 0u);
}

// URLs end up in logs, histories and the Referer of the next page: a token there is no token.
TEST_F(NetDoor, tokens_in_urls_open_nothing_and_reach_no_log) {
    ask_for_tokens();
    start();
    for (const char* target :
         {"/v1/state?token=open%20sesame", "/v1/state?access_token=open+sesame",
          "/v1/state?authorization=Bearer%20open%20sesame"})
        EXPECT_EQ(status(target), 401) << target;
    EXPECT_EQ(status("http://open:sesame@127.0.0.1/v1/state"), 400);
    net->stop();
    EXPECT_EQ(log.text().find("sesame"), std::string::npos) << log.text();
}

/// A session without a connection.
class NoLink : public server::Link {
  public:
    void drop() noexcept override {}
    void send_more() override {}
    void close(protocol::SharedBytes, ErrorCode closed_with,
               const std::string& closed_why) override {
        code = closed_with;
        why = closed_why;
    }
    ErrorCode code = ErrorCode::none;
    std::string why;
};

TEST_F(NetDoor, the_administrators_token_is_not_taken_where_others_could_have_read_it) {
    const auto core = std::make_shared<server::Core>(options, host, nullptr);
    core->tokens = {.client = "open sesame", .admin = "master"};
    const auto knocks = [&](const char* token, bool loopback, bool tls,
                            std::string* why = nullptr) {
        NoLink link;
        server::Session session(*core, link,
                                {.name = "198.51.100.7:4711",
                                 .address = core->addresses.of("198.51.100.7", {}),
                                 .loopback = loopback,
                                 .tls = tls},
                                server::Standing::stranger);
        session.receive(protocol::hello("door", token));
        if (why)
            *why = link.why;
        return link.code;
    };
    std::string why;
    EXPECT_EQ(knocks("master", false, false, &why), ErrorCode::unauthorised);
    EXPECT_NE(why.find("TLS only, or on this machine itself at ws://127.0.0.1"), std::string::npos)
        << why;
    EXPECT_EQ(knocks("master", true, false), ErrorCode::none);
    EXPECT_EQ(knocks("master", false, true), ErrorCode::none);
    EXPECT_EQ(knocks("open sesame", false, false), ErrorCode::none);
    EXPECT_EQ(core->counters.tokens_refused["in_the_clear"], 1u);
    EXPECT_EQ(log.lines_with("event=session_open", "administrator=true").size(), 2u);
}

// Naive: taken, and both passed over.
TEST_F(NetDoor, a_pace_that_is_to_begin_later_or_by_and_by_is_refused) {
    options.admin_token_file = folder().write("door_pace", "master\n");
    start();
    Client admin(port());
    ASSERT_FALSE(admin.connect());
    ASSERT_TRUE(admin.greet("master"));
    ASSERT_FALSE(admin.send(protocol::change(7, {.at_us = 9, .pace_permille = 500})));
    expect_refused(admin, 7, ErrorCode::bad_value, "at_us 9");
    ASSERT_FALSE(admin.send(protocol::change(8, {.over_us = 20'000'000, .pace_permille = 500})));
    expect_refused(admin, 8, ErrorCode::bad_value, "over_us is 20000000");
}

// Naive: its line is one of the 200 of that second, which anybody can use up.
TEST_F(NetDoor, what_an_administrator_does_is_in_the_log_whatever_others_do) {
    const auto core = std::make_shared<server::Core>(
        options, host, [](const server::Core::Work& work) { work(); });
    core->tokens.admin = "master";
    NoLink link;
    server::Session session(*core, link,
                            {.name = "127.0.0.1:4711",
                             .address = core->addresses.of("127.0.0.1", {}),
                             .loopback = true},
                            server::Standing::stranger);
    session.receive(protocol::hello("door", "master"));
    for (int i = 0; i < 1000; ++i)
        core->log("event=connection_refused");
    session.receive(protocol::change(7, {.set = {"a=1"}, .over_us = 20'000'000}));
    EXPECT_LT(log.lines_with("event=connection_refused").size(), 1000u);
    EXPECT_EQ(log.lines_with("event=change_asked", "peer=127.0.0.1:4711").size(), 1u);
    EXPECT_EQ(log.lines_with("event=change_refused").size(), 1u);
}

// The same for pages, from a function: no test comes from another machine.
TEST_F(NetDoor, what_a_token_was_worth_decides_which_status_a_page_has) {
    const auto core = std::make_shared<server::Core>(options, host, nullptr);
    core->tokens = {.client = "open sesame", .admin = "master"};
    const auto page = [&](const char* path, const server::Judgement& judged) {
        const std::optional<server::Page> kept_out = server::keep_out(*core, path, judged);
        return kept_out ? kept_out->status : 0;
    };
    using server::Barred;
    using server::Standing;
    EXPECT_EQ(page("/healthz", {}), 0u) << "for which none is judged";
    for (const char* path : {"/v1/state", "/v1/stream"}) {
        const bool open = std::string_view(path) != "/v1/state";
        EXPECT_EQ(page(path, {.standing = Standing::administrator}), 0u);
        EXPECT_EQ(page(path, {.standing = Standing::client}), 0u);
        EXPECT_EQ(page(path, {.standing = Standing::stranger}), open ? 0u : 401u) << path;
        EXPECT_EQ(page(path, {.barred = Barred::wrong}), 401u);
        EXPECT_EQ(page(path, {.barred = Barred::in_the_clear}), 403u);
        EXPECT_EQ(page(path, {.barred = Barred::too_many_wrong}), 429u);
    }
}

// ---- what is asked for -----------------------------------------------------------------------

TEST_F(NetDoor, an_upgrade_of_a_foreign_page_or_another_case_is_no_session) {
    options.allowed_origins = {"https://sea.example.org"};
    start();
    EXPECT_EQ(knock("", "", "Origin: https://evil.example\r\n"), 403u);
    EXPECT_EQ(knock("", "", "Origin: null\r\n"), 403u);
    EXPECT_EQ(knock("", "", "Origin: https://sea.example.org\r\n"), 0u);
    EXPECT_EQ(knock(""), 0u);
    Client shouts(port());
    EXPECT_TRUE(shouts.connect("SEAWAY.V1"));
    EXPECT_EQ(shouts.status(), 400);
    EXPECT_EQ(counted("seaway_net_sessions_refused_total{reason=\"origin\"}"), 2);
    EXPECT_EQ(counted("seaway_net_sessions_refused_total{reason=\"subprotocol\"}"), 1);
    EXPECT_EQ(counted("seaway_net_sessions_opened_total"), 2);
}

TEST_F(NetDoor, a_body_in_an_unknown_coding_hides_no_second_request) {
    start();
    RawPeer peer(port());
    peer.say("GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\nTransfer-Encoding: identity\r\n\r\n"
             "GET /v1/plan HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
    const std::string all = peer.rest();
    EXPECT_TRUE(all.starts_with("HTTP/1.1 501")) << all;
    EXPECT_EQ(all.find("HTTP/1.1", 1), std::string::npos) << "one answer, and the end";
    EXPECT_EQ(status("http://127.0.0.1/v1/%73tate?x=%31"), 200);
    EXPECT_EQ(status("http://evil.example/v1/state"), 421);
}

// Naive: 60 bytes that have half a millisecond of the network's thread spent on them are counted as 60 bytes.
TEST_F(NetDoor, pages_that_are_made_are_of_the_share_of_who_asks_and_not_for_who_watches) {
    options.health_listen = "127.0.0.1:0";
    options.request_bytes_per_s_per_address = 256 * 1024; // twice that at once: four pages
    start();
    for (int i = 0; i < 20; ++i)
        EXPECT_EQ(ask_http(net->health_port(), "/metrics", "GET").status, 200);
    EXPECT_EQ(counted("seaway_net_reads_delayed_total"), 0);
    // Seven, and as many as their share comes again for while a busy machine asks: two a second.
    const auto begun = std::chrono::steady_clock::now();
    const auto seconds = [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    };
    const auto delayed = [&] { return counted("seaway_net_reads_delayed_total"); };
    for (int i = 0; i < 7 || (i < 7 + 2 * seconds() && delayed() == 0); ++i)
        EXPECT_EQ(get("/v1/state").status, 200);
    EXPECT_GE(delayed(), 1);
}

// Naive: a page that nobody has to make is as cheap as the 60 bytes that ask for it, whatever it says.
TEST_F(NetDoor, every_answer_is_of_the_share_of_who_asks) {
    options.client_token_file = folder().write("answers_client", "open sesame\n");
    options.health_listen = "127.0.0.1:0";
    options.request_bytes_per_s_per_address = 16 * 1024; // four answers at once, and two a second
    start();
    double delayed = 0;
    int last = 1;
    for (const auto& [request, status] : {std::pair("GET /", "200"),
                                          {"GET /status.js", "200"},
                                          {"GET /healthz", "200"},
                                          {"GET /readyz", "200"},
                                          {"GET /none", "401"},
                                          {"POST /healthz", "405"},
                                          {"HEAD /healthz", "200"}}) {
        const std::string from =
            "127.0.0." + std::to_string(++last); // each with a share of its own
        // It ends at the first that is read later, the fifth but on a very busy machine.
        for (int i = 0; i < 128 && counted("seaway_net_reads_delayed_total") == delayed; ++i) {
            RawPeer peer(port(), 0, from);
            peer.say(fmt::format("{} HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 0\r\n\r\n",
                                 request));
            EXPECT_TRUE(peer.header().starts_with(fmt::format("HTTP/1.1 {}", status))) << request;
        }
        EXPECT_GT(counted("seaway_net_reads_delayed_total"), delayed) << request;
        delayed = counted("seaway_net_reads_delayed_total");
    }
    for (int i = 0; i < 100; ++i)
        EXPECT_EQ(ask_http(net->health_port(), "/healthz", "GET").status, 200);
    EXPECT_EQ(counted("seaway_net_reads_delayed_total"), delayed) << "who watches is not to wait";
}

// Naive: what answers a map charges for nothing but maps.
TEST_F(NetDoor, maps_that_are_refused_are_of_the_share_of_who_asks_too) {
    host.is_busy = true;
    options.health_listen = "127.0.0.1:0";
    options.request_bytes_per_s_per_address = 16 * 1024; // four answers at once, and two a second
    start();
    const auto delayed = [&] { return counted("seaway_net_reads_delayed_total"); };
    for (int i = 0; i < 128 && delayed() == 0; ++i)
        EXPECT_EQ(get("/v1/map").status, 503);
    EXPECT_GE(delayed(), 1);
}

TEST_F(NetDoor, an_address_that_sends_too_much_is_read_later_and_answered_all_the_same) {
    options.health_listen = "127.0.0.1:0";
    options.request_bytes_per_s_per_address = 64 * 1024; // twice that at once
    start();
    const auto client = greeted();
    const std::vector<sea::QueryPoint> points(4000); // 96 KB
    for (std::uint32_t id = 1; id <= 3; ++id)
        ASSERT_FALSE(client->send(protocol::query(id, points, false)));
    for (std::uint32_t id = 1; id <= 3; ++id) {
        const wire::Message* reply = client->receive(Body::QueryReply);
        ASSERT_TRUE(reply);
        EXPECT_EQ(reply->body_as_QueryReply()->request_id(), id);
    }
    EXPECT_GE(counted("seaway_net_reads_delayed_total"), 1);
}

// Frames of no message, and parts of one that never ends: what they hold is next to nothing, and each has to be looked at.
TEST_F(NetDoor, an_address_that_sends_many_empty_frames_is_read_later_too) {
    options.health_listen = "127.0.0.1:0";
    options.request_bytes_per_s_per_address = 256 * 1024; // twice that at once
    start();
    double delayed = 0;
    for (const auto& [begin, again] :
         {std::pair<std::uint8_t, std::uint8_t>{0x89, 0x89}, {0x8a, 0x8a}, {0x02, 0x00}}) {
        RawPeer peer(port());
        peer.upgrade();
        peer.frame(protocol::hello("raw", ""));
        std::string frames;
        for (int i = 0; i < 750; ++i) // 4.5 KB on the line
            frames += std::string{static_cast<char>(i == 0 ? begin : again), '\x80', 0, 0, 0, 0};
        peer.say(frames);
        EXPECT_TRUE(eventually([&] { return counted("seaway_net_reads_delayed_total") > delayed; }))
            << int{begin};
        delayed = counted("seaway_net_reads_delayed_total");
    }
}

TEST_F(NetDoor, health_is_told_at_its_own_address_however_full_the_other_is) {
    ask_for_tokens();
    options.health_listen = "127.0.0.1:0";
    options.connections_max = 2;
    options.health_connections_max = 3;
    start();
    ASSERT_GT(net->health_port(), 0);
    ASSERT_NE(net->health_port(), port());
    RawPeer sessions[2] = {RawPeer(port()), RawPeer(port())};
    for (RawPeer& peer : sessions)
        peer.upgrade();
    RawPeer refused(port());
    EXPECT_TRUE(refused.closed_by_server());
    std::vector<std::unique_ptr<RawPeer>> silent;
    for (int i = 0; i < 10; ++i)
        silent.push_back(std::make_unique<RawPeer>(net->health_port()));
    EXPECT_EQ(ask_http(net->health_port(), "/healthz", "GET").body, "ok\n");
    EXPECT_EQ(ask_http(net->health_port(), "/readyz", "GET").body, "ready\n")
        << "of 1024 sessions two are taken";
    const HttpAnswer metrics = ask_http(net->health_port(), "/metrics", "GET");
    EXPECT_EQ(metrics.status, 200) << "without a token";
    EXPECT_NE(metrics.body.find("\nseaway_net_connections 2\n"), std::string::npos) << metrics.body;
    for (const char* target : {"/", "/v1/state", "/v1/plan", "/v1/map", "/v1/stream"})
        EXPECT_EQ(ask_http(net->health_port(), target, "GET", "Bearer master").status, 404)
            << target;
    EXPECT_EQ(ask_http(net->health_port(), "/healthz", "POST").status, 405);
}

TEST_F(NetDoor, tokens_are_read_again_when_asked_to_and_a_broken_file_changes_nothing) {
    ask_for_tokens();
    start();
    const auto inside = greeted("open sesame");
    folder().write("door_client", "new sesame\n");
    EXPECT_EQ(status("/v1/state", "open sesame"), 200) << "nobody has asked to";
    ASSERT_TRUE(net->reload().all);
    const auto outcome = [](const server::NetServer::Reloaded& read) {
        return read.files.front().outcome; // of the clients' token
    };
    EXPECT_EQ(outcome(net->reload()), server::ReadAgain::unchanged) << "since it was read again";
    EXPECT_EQ(status("/v1/state", "open sesame"), 401);
    EXPECT_EQ(status("/v1/state", "new sesame"), 200);
    folder().write("door_client", "third\n");
    folder().write("door_admin", "\n");
    const Result<void> broken = net->reload().all;
    ASSERT_FALSE(broken);
    EXPECT_NE(broken.error().message.find("door_admin"), std::string::npos);
    EXPECT_EQ(status("/v1/state", "new sesame"), 200) << "both or none";
    EXPECT_EQ(status("/v1/state", "master"), 200);
    ASSERT_FALSE(inside->send(protocol::ping(1, 1)));
    EXPECT_TRUE(inside->receive(Body::Pong)) << "who is in stays in";
}

} // namespace
} // namespace seaway::tests
