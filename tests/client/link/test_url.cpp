// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "client/link/failure.h"
#include "client/link/url.h"

namespace seaway::client {
namespace {

Url parsed(const char* text) {
    const Result<Url> url = parse_url(text);
    EXPECT_TRUE(url) << text;
    return url ? *url : Url{};
}

TEST(UrlOf, a_server_has_its_port_and_the_stream_path_by_default) {
    const Url url = parsed("ws://sea.example:9430");
    EXPECT_FALSE(url.tls);
    EXPECT_EQ(url.host, "sea.example");
    EXPECT_EQ(url.port, "9430");
    EXPECT_EQ(url.path, "/v1/stream");
    EXPECT_EQ(url.authority(), "sea.example:9430");
}

TEST(UrlOf, a_scheme_decides_tls_and_the_default_port) {
    EXPECT_EQ(parsed("ws://a").port, "80");
    EXPECT_EQ(parsed("wss://a").port, "443");
    EXPECT_TRUE(parsed("wss://a/").tls);
    EXPECT_EQ(parsed("wss://a/").path, "/v1/stream");
    EXPECT_EQ(parsed("wss://a").authority(), "a");
}

TEST(UrlOf, a_gateway_may_have_another_path_and_a_query) {
    EXPECT_EQ(parsed("ws://a:1/north/v1/stream?x=1").path, "/north/v1/stream?x=1");
    EXPECT_EQ(parsed("ws://a?world=2").path, "/v1/stream?world=2");
}

TEST(UrlOf, an_ipv6_address_stands_in_brackets) {
    const Url url = parsed("ws://[::1]:9430/x");
    EXPECT_EQ(url.host, "::1");
    EXPECT_EQ(url.port, "9430");
    EXPECT_EQ(url.authority(), "[::1]:9430");
    EXPECT_EQ(parsed("wss://[fe80::2]").authority(), "[fe80::2]");
}

struct Wrong {
    const char* text;
    const char* says;
};

class WrongUrls : public ::testing::TestWithParam<Wrong> {};

TEST_P(WrongUrls, say_what_to_write_instead) {
    const Result<Url> url = parse_url(GetParam().text);
    ASSERT_FALSE(url) << GetParam().text;
    EXPECT_NE(url.error().message.find(GetParam().says), std::string::npos) << url.error().message;
    EXPECT_EQ(failure_of(url.error()), Failure::bad_argument);
}

INSTANTIATE_TEST_SUITE_P(
    All, WrongUrls,
    ::testing::Values(Wrong{"localhost:9430", "ws://HOST:PORT"}, Wrong{"", "ws://HOST:PORT"},
                      Wrong{"http://a:1", "'http'"}, Wrong{"ws://", "host is missing"},
                      Wrong{"ws://:80", "host is missing"}, Wrong{"ws://a:0", "'0'"},
                      Wrong{"ws://a:65536", "65535"}, Wrong{"ws://a:", "1 to 65535"},
                      Wrong{"ws://a:80x", "'80x'"}, Wrong{"ws://::1:80", "brackets"},
                      Wrong{"ws://[::1", "']'"}, Wrong{"ws://[::1]80", "after ']'"},
                      Wrong{"ws://[a]:80", "IPv6"}, Wrong{"ws://[[::1]", "once"},
                      Wrong{"ws://a[b]:80", "once"}, Wrong{"ws://me:secret@a", "token"},
                      Wrong{"ws://a b", "blanks"},
                      Wrong{"ws://b\xc3\xbc"
                            "cher.example",
                            "xn--"},
                      Wrong{"ws://a/\r\nX: y", "control"}));

} // namespace
} // namespace seaway::client
