// SPDX-License-Identifier: Apache-2.0
// How the head of a request is read, which pages may use the server, and what one address may take: as
// functions, without sockets and with a clock that is handed in.
#include <deque>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "server/net/addresses.h"
#include "server/net/http_head.h"
#include "server/net/map_places.h"
#include "server/net/waiting_line.h"

namespace seaway::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

Origins origins_of(const std::vector<std::string>& allowed) {
    Result<Origins> origins = Origins::read(allowed);
    EXPECT_TRUE(origins) << (origins ? "" : origins.error().message);
    return origins ? *origins : Origins();
}

HttpHead head_for(std::string_view target, std::string_view host = "127.0.0.1:9430") {
    return {.method = "GET", .target = target, .hosts = {host}};
}

/// 0: taken.
unsigned status_of(const HttpHead& head, const Origins& origins = {}, bool loopback = true,
                   bool tls = false) {
    const auto read = read_head(head, origins, loopback, tls);
    const auto* refused = std::get_if<Refused>(&read);
    if (refused != nullptr) {
        EXPECT_TRUE(refused->page.body.ends_with('\n'));
    }
    return refused ? refused->page.status : 0;
}

Asked asked_by(const HttpHead& head) {
    auto read = read_head(head, {}, true, false);
    EXPECT_TRUE(std::holds_alternative<Asked>(read)) << head.target;
    return std::holds_alternative<Asked>(read) ? std::get<Asked>(read) : Asked{};
}

// RFC 9112, section 3.2: without Host, with two and with one that is none a request is 400.
TEST(HttpHead, a_request_names_one_host) {
    HttpHead head = head_for("/");
    EXPECT_EQ(status_of(head), 0u);
    head.hosts = {};
    EXPECT_EQ(status_of(head), 400u);
    head.version = 10; // where it was not asked for yet
    EXPECT_EQ(status_of(head), 0u);
    head.hosts = {"127.0.0.1", "127.0.0.1"};
    EXPECT_EQ(status_of(head), 400u) << "twice the same is twice";
    for (const std::string_view host : {"", "a b", "[::1", "[x]", "h:0", "h:65536", "h:1x", "h:1:2",
                                        "user@h", "h/x", "[::1]9430", "["})
        EXPECT_EQ(status_of(head_for("/", host), {}, false), 400u) << host;
}

// RFC 9112, section 3.2.2: a server takes the absolute form, and what it names counts, not Host.
TEST(HttpHead, an_absolute_target_is_a_path_and_a_host) {
    EXPECT_EQ(asked_by(head_for("http://127.0.0.1:9430/v1/state?x=1")).path, "/v1/state");
    EXPECT_EQ(asked_by(head_for("HTTPS://localhost/")).path, "/");
    EXPECT_EQ(status_of(head_for("http://evil.example/v1/state")), 421u);
    for (const std::string_view target : {"http://127.0.0.1", "http:///x", "http://127.0.0.1?x",
                                          "ftp://127.0.0.1/", "127.0.0.1:80", "v1/state", "/a#b"})
        EXPECT_EQ(status_of(head_for(target)), 400u) << target;
}

TEST(HttpHead, percent_signs_stand_for_bytes_in_path_and_parameters) {
    const Asked asked = asked_by(head_for("/v1/%6dap?wi%64th_m=1%30&kind=hei%67ht&x=%2B5&y=+5"));
    EXPECT_EQ(asked.path, "/v1/map");
    EXPECT_EQ(asked.parameters,
              (std::map<std::string, std::string>{
                  {"width_m", "10"}, {"kind", "height"}, {"x", "+5"}, {"y", "+5"}}));
    EXPECT_EQ(asked_by(head_for("/a%2Fb%00")).path, std::string("/a/b\0", 5));
    EXPECT_EQ(asked_by(head_for("/a?b%26c=d%3D")).parameters.at("b&c"), "d=") << "split first";
    for (const std::string_view target : {"/%", "/%4", "/%zz", "/%4g", "/a?%=1", "/a?b=%f"})
        EXPECT_EQ(status_of(head_for(target)), 400u) << target;
}

// What a program on the way could frame otherwise carries a second request (RFC 9112, section 6.1).
TEST(HttpHead, of_transfer_encodings_only_one_chunked_is_taken) {
    const auto status = [](std::vector<std::string_view> codings, unsigned version = 11) {
        HttpHead head = head_for("/");
        head.transfer_encodings = std::move(codings);
        head.version = version;
        return status_of(head);
    };
    EXPECT_EQ(status({"Chunked"}), 0u);
    for (const std::string_view coding :
         {"gzip", "identity", "chunked, gzip", "gzip, chunked", "chunked, chunked", "", "xchunked"})
        EXPECT_EQ(status({coding}), 501u) << coding;
    EXPECT_EQ(status({"chunked", "chunked"}), 501u);
    EXPECT_EQ(status({"chunked"}, 10), 400u);
}

TEST(HttpHead, subprotocols_are_names_in_their_case) {
    EXPECT_TRUE(offers("seaway.v1", "seaway.v1"));
    EXPECT_TRUE(offers("a, seaway.v1 ,b", "seaway.v1"));
    for (const std::string_view list :
         {"SEAWAY.V1", "Seaway.v1", "seaway.v10", "seaway", "", "a,b"})
        EXPECT_FALSE(offers(list, "seaway.v1")) << list;
}

TEST(HttpHead, one_bearer_is_a_token_and_two_are_a_mistake) {
    const auto token = [](std::string_view value) {
        HttpHead head = head_for("/");
        head.authorizations = {value};
        return asked_by(head).token;
    };
    EXPECT_EQ(token("Bearer open sesame"), "open sesame");
    EXPECT_EQ(token("bEARER  x "), "x");
    for (const std::string_view other : {"Basic x", "Bearer", "Bearer ", "Bearerx", ""})
        EXPECT_EQ(token(other), "") << other;
    HttpHead two = head_for("/");
    two.authorizations = {"Bearer a", "Bearer a"};
    EXPECT_EQ(status_of(two), 400u);
}

// ---- pages of others ---------------------------------------------------------------------------

TEST(OriginRules, a_page_is_the_servers_own_an_allowed_one_or_refused) {
    const Origins origins = origins_of({"https://Sea.Example.org", "http://b.example:8080"});
    const auto status = [&](std::string_view origin, std::string_view host, bool tls = false) {
        HttpHead head = head_for("/v1/stream", host);
        head.origins = {origin};
        return status_of(head, origins, false, tls);
    };
    EXPECT_EQ(status("http://127.0.0.1:9430", "127.0.0.1:9430"), 0u) << "its own";
    EXPECT_EQ(status("HTTP://LOCALHOST:9430", "localhost:9430"), 0u) << "hosts have no case";
    EXPECT_EQ(status("http://[::1]", "[::1]:80"), 0u) << "80 is what http means";
    EXPECT_EQ(status("https://10.0.0.1", "10.0.0.1", true), 0u);
    EXPECT_EQ(status("https://sea.example.org:443", "x:1"), 0u) << "allowed, whatever Host says";
    EXPECT_EQ(status("http://b.example:8080", "x:1"), 0u);
    EXPECT_EQ(status("http://127.0.0.1:9431", "127.0.0.1:9430"), 403u) << "another port";
    EXPECT_EQ(status("https://127.0.0.1:9430", "127.0.0.1:9430"), 403u) << "another scheme";
    EXPECT_EQ(status("http://sea.example.org", "x:1"), 403u) << "allowed is the one by https";
    EXPECT_EQ(status("http://b.example", "x:1"), 403u);
    for (const std::string_view origin :
         {"null", "", "https://evil.example", "https://sea.example.org.evil.example", "file://",
          "https://sea.example.org/", "://sea.example.org", "sea.example.org"})
        EXPECT_EQ(status(origin, "127.0.0.1:9430"), 403u) << origin;
    HttpHead two = head_for("/");
    two.origins = {"http://127.0.0.1:9430", "http://127.0.0.1:9430"};
    EXPECT_EQ(status_of(two), 400u);
    EXPECT_EQ(status_of(head_for("/")), 0u) << "no browser, no Origin";
}

// A name of a stranger that is made to point here is of the server's own origin for the browser.
TEST(OriginRules, a_name_that_anybody_can_point_here_is_not_the_servers_own) {
    const Origins origins = origins_of({"https://sea.example.org"});
    HttpHead rebound = head_for("/v1/stream", "evil.example:9430");
    rebound.origins = {"http://evil.example:9430"};
    EXPECT_EQ(status_of(rebound, origins, false), 403u) << "from elsewhere: by its Origin";
    EXPECT_EQ(status_of(rebound, origins, true), 421u);
    rebound.origins = {}; // a page's own GET brings no Origin
    EXPECT_EQ(status_of(rebound, origins, true), 421u) << "on this machine: by its Host";
    for (const std::string_view host : {"127.attacker.example", "127.0.0.1.evil.example",
                                        "localhost.evil.example", "x", "0x7f.1"})
        EXPECT_EQ(status_of(head_for("/", host), origins), 421u) << host;
    for (const std::string_view host :
         {"127.0.0.1", "127.9.9.9:1", "[::1]:9430", "203.0.113.5", "localhost", "LocalHost.:9430",
          "a.localhost", "SEA.example.org", "sea.example.org:9430"})
        EXPECT_EQ(status_of(head_for("/", host), origins), 0u) << host;
    const Result<Origins> named = Origins::read({}, "MyMachine");
    ASSERT_TRUE(named);
    EXPECT_EQ(status_of(head_for("/", "mymachine:9430"), *named), 0u) << "what it calls itself";
    EXPECT_TRUE(named->allows("http://mymachine:9430", {"mymachine", 9430, false}, false));
    EXPECT_FALSE(named->allows("http://mymachine:80", {"mymachine", 9430, false}, false));
    EXPECT_EQ(status_of(head_for("/", "any.example"), origins, false), 0u)
        << "from elsewhere names cannot be known";
}

TEST(OriginRules, pages_of_other_sites_load_nothing_unseen) {
    HttpHead head = head_for("/v1/map");
    head.fetch_site = "cross-site";
    head.fetch_mode = "no-cors"; // <img src=...>
    EXPECT_EQ(status_of(head), 403u);
    head.fetch_mode = "navigate"; // a link that somebody follows
    EXPECT_EQ(status_of(head), 0u);
    head.fetch_dest = "document";
    EXPECT_EQ(status_of(head), 0u);
    for (const std::string_view frame : {"iframe", "frame", "object", "embed"}) {
        head.fetch_dest = frame;
        EXPECT_EQ(status_of(head), 403u) << frame;
    }
    head.fetch_dest = {};
    for (const std::string_view site : {"same-origin", "same-site", "none", ""}) {
        head.fetch_site = site;
        head.fetch_mode = "no-cors";
        EXPECT_EQ(status_of(head), 0u) << site;
    }
}

TEST(OriginRules, what_cannot_be_allowed_is_said_at_the_start) {
    for (const std::string wrong : {"null", "*", "sea.example.org", "https://", "https://a/b", "",
                                    "https://*.example.org", "https://a b"}) {
        const Result<Origins> read = Origins::read({"https://ok.example", wrong});
        ASSERT_FALSE(read) << wrong;
        EXPECT_TRUE(read.error().message.starts_with("--allow-origin " + wrong + ":"))
            << read.error().message;
    }
    EXPECT_TRUE(Origins::read({"https://a.example:8443", "chrome-extension://abcdef"}));
}

// ---- addresses ---------------------------------------------------------------------------------

TEST(Addresses, an_ipv6_network_and_a_mapped_ipv4_are_one_address) {
    EXPECT_EQ(address_name("203.0.113.7"), "203.0.113.7");
    EXPECT_EQ(address_name("::ffff:203.0.113.7"), "203.0.113.7");
    EXPECT_EQ(address_name("2001:db8:1:2:3:4:5:6"), "2001:db8:1:2::/64");
    EXPECT_EQ(address_name("2001:db8:1:2::"), "2001:db8:1:2::/64");
    EXPECT_EQ(address_name("2001:db8:1:3::"), "2001:db8:1:3::/64");
    const NetOptions options;
    Addresses addresses(options);
    const AddressPtr one = addresses.of("2001:db8::1", {});
    EXPECT_EQ(addresses.of("2001:db8::2", {}), one);
    EXPECT_NE(addresses.of("2001:db8:0:1::1", {}), one);
}

// What tokens and names of hosts are held against: a listener of both kinds of addresses says "::ffff:" of IPv4.
TEST(Addresses, who_comes_from_elsewhere_in_the_clear_may_have_been_overheard) {
    const auto comes_from = [](const std::string& ip, bool is_v6, bool tls) {
        return peer_of({ip, 4711, is_v6}, nullptr, tls);
    };
    for (const bool tls : {false, true}) {
        for (const char* here : {"127.0.0.1", "127.8.9.10"})
            EXPECT_TRUE(comes_from(here, false, tls).loopback) << here;
        for (const char* here : {"::1", "::ffff:127.0.0.1"})
            EXPECT_TRUE(comes_from(here, true, tls).loopback) << here;
        for (const char* elsewhere : {"203.0.113.5", "10.0.0.1", "192.168.0.1", "0.0.0.0"}) {
            EXPECT_FALSE(comes_from(elsewhere, false, tls).loopback) << elsewhere;
            EXPECT_EQ(comes_from(elsewhere, false, tls).unseen(), tls) << elsewhere;
        }
        for (const char* elsewhere : {"::ffff:203.0.113.5", "2001:db8::1", "fe80::1%1", "::2"}) {
            EXPECT_FALSE(comes_from(elsewhere, true, tls).loopback) << elsewhere;
            EXPECT_EQ(comes_from(elsewhere, true, tls).unseen(), tls) << elsewhere;
        }
        EXPECT_TRUE(comes_from("127.0.0.1", false, tls).unseen());
        EXPECT_TRUE(comes_from("::1", true, tls).unseen());
        EXPECT_TRUE(comes_from("::ffff:127.0.0.1", true, tls).unseen());
    }
    const NetOptions options;
    const auto address = std::make_shared<Address>("203.0.113.5", options);
    const Peer named = peer_of({"203.0.113.5", 4711, false}, address, true);
    EXPECT_EQ(named.name, "203.0.113.5:4711");
    EXPECT_EQ(named.address, address);
    EXPECT_TRUE(named.tls);
}

TEST(Addresses, what_is_used_up_comes_back_evenly_and_no_further_than_its_burst) {
    Bucket bucket(10, seconds(60));
    Bucket::Clock::time_point now{seconds(1000)};
    for (int i = 0; i < 10; ++i) {
        EXPECT_EQ(bucket.wait_for(1, now).count(), 0) << i;
        bucket.take(1, now);
    }
    EXPECT_EQ(bucket.wait_for(1, now), seconds(6)) << "one of ten in sixty seconds";
    now += milliseconds(5999);
    EXPECT_EQ(bucket.wait_for(1, now), milliseconds(1));
    now += milliseconds(1);
    EXPECT_EQ(bucket.wait_for(1, now).count(), 0);
    now += std::chrono::hours(24);
    EXPECT_TRUE(bucket.is_full(now));
    bucket.take(25, now); // a debt
    EXPECT_EQ(bucket.wait_for(0, now), seconds(90));
    Bucket none(0, seconds(60));
    none.take(1e9, now);
    EXPECT_EQ(none.wait_for(1, now).count(), 0) << "0 is no limit";
}

TEST(Addresses, kinds_of_coarser_maps_are_counted_by_who_has_them) {
    CoarserMaps maps;
    EXPECT_EQ(maps.kinds_but({}), 0u);
    maps.change({}, Quality{20});
    maps.change({}, Quality{20});
    maps.change({}, Quality{30});
    EXPECT_EQ(maps.kinds_but({}), 2u);
    EXPECT_EQ(maps.kinds_but(Quality{20}), 2u) << "another has it, too";
    EXPECT_EQ(maps.kinds_but(Quality{30}), 1u);
    maps.change(Quality{20}, Quality{30});
    maps.change(Quality{30}, Quality{30});
    EXPECT_EQ(maps.kinds_but(Quality{20}), 1u);
    EXPECT_EQ(maps.kinds_but(Quality{30}), 2u);
    maps.change(Quality{20}, {});
    EXPECT_EQ(maps.kinds_but({}), 1u) << "nobody has it any more";
}

TEST(Addresses, are_forgotten_when_nothing_is_to_be_remembered_of_them) {
    const NetOptions options;
    Addresses addresses(options);
    Bucket::Clock::time_point now{seconds(1000)};
    const AddressPtr held = addresses.of("192.0.2.1", now);
    addresses.of("192.0.2.2", now)->wrong_tokens.take(10, now);
    const auto flood = [&](int count) {
        for (int i = 0; i < count; ++i)
            addresses.of("10." + std::to_string(i >> 16) + "." + std::to_string(i >> 8 & 255) +
                             "." + std::to_string(i & 255),
                         now);
    };
    flood(3000);
    EXPECT_LT(addresses.size(), 3000u);
    EXPECT_GT(addresses.of("192.0.2.2", now)->wrong_tokens.wait_for(1, now).count(), 0)
        << "guessed, and not forgotten";
    now += seconds(60);
    flood(3000);
    EXPECT_EQ(addresses.of("192.0.2.2", now)->wrong_tokens.wait_for(1, now).count(), 0);
    EXPECT_EQ(addresses.of("192.0.2.1", now), held) << "who is here is known";
    // However many guess: memory is bounded.
    for (std::size_t i = 0; i < 2 * Addresses::remembered_max; ++i)
        addresses
            .of("11." + std::to_string(i >> 16) + "." + std::to_string(i >> 8 & 255) + "." +
                    std::to_string(i & 255),
                now)
            ->wrong_tokens.take(1, now);
    EXPECT_LE(addresses.size(), Addresses::remembered_max + 1);
    EXPECT_EQ(addresses.of("192.0.2.1", now), held);
}

TEST(Addresses, a_flood_of_one_address_is_a_line_now_and_then_with_its_count) {
    const NetOptions options;
    Address address("192.0.2.1", options);
    Bucket::Clock::time_point now{seconds(1000)};
    EXPECT_EQ(address.turn_away(Crowding::connections, now), 1u);
    for (int i = 0; i < 500; ++i)
        EXPECT_EQ(address.turn_away(Crowding::connections, now), 0u);
    EXPECT_EQ(address.turn_away(Crowding::wrong_tokens, now), 1u) << "each reason for itself";
    now += Address::log_pause;
    EXPECT_EQ(address.turn_away(Crowding::connections, now), 501u);
}

TEST(WaitingLine, the_longest_waiting_of_the_most_crowded_address_makes_room) {
    const NetOptions options;
    const auto crowd = std::make_shared<Address>("192.0.2.1", options);
    const auto few = std::make_shared<Address>("192.0.2.2", options);
    crowd->connections = 3;
    few->connections = 1;
    WaitingLine line;
    std::string given_up;
    std::array<WaitingLine::Place, 4> places;
    const auto wait = [&](std::size_t i, const AddressPtr& of) {
        places[i].take(line, of, [&, i] {
            given_up += std::to_string(i);
            places[i].leave();
        });
    };
    wait(0, few); // has waited longest of all
    wait(1, crowd);
    wait(2, crowd);
    wait(3, crowd);
    EXPECT_TRUE(line.give_up_of_most(&Address::connections, 0));
    EXPECT_FALSE(line.give_up_of_most(&Address::connections, 3)) << "none has more than three";
    wait(2, crowd); // again, at the end
    EXPECT_TRUE(line.give_up_of(*crowd));
    EXPECT_TRUE(line.give_up_of(*few));
    EXPECT_FALSE(line.give_up_of(*few));
    EXPECT_TRUE(line.give_up_of_most(&Address::connections, 0));
    EXPECT_FALSE(line.give_up_of_most(&Address::connections, 0));
    EXPECT_EQ(given_up, "1302");
}

TEST(HttpHead, a_key_of_a_websocket_is_sixteen_bytes_in_base64) {
    EXPECT_TRUE(server::is_websocket_key("dGhlIHNhbXBsZSBub25jZQ=="));
    for (const char* wrong :
         {"", "dGhlIHNhbXBsZQ==", "dGhlIHNhbXBsZSBub25jZQ", "dGhlIHNhbXBsZSBub25jZSEh",
          "dGhlIHNhbXBsZSBub25jZQ== ", "dGhlIHNhbXBs_SBub25jZQ==", "dGhlIHNhbXBsZSBub25jZQAA=="})
        EXPECT_FALSE(server::is_websocket_key(wrong)) << wrong;
}

} // namespace
} // namespace seaway::server
