// SPDX-License-Identifier: Apache-2.0
// Token files of the command line, with the real server.
#include <string>
#include <utility>

#include <csignal>

#include <gtest/gtest.h>

#include "client/client.h"
#include "tests/server/change_bench.h"
#include "tests/support/certificate.h"
#include "tests/support/folder.h"
#include "tests/support/server_process.h"
#include "tests/support/times_in.h"

namespace seaway {
namespace {

// Each word of the command line reaches the server that listens.
TEST(Start, tokens_on_the_command_line_open_the_door_they_are_for) {
    const tests::Folder& folder = tests::folder();
    tests::ServerProcess server({changes::small_sea, "--device", "native", "--listen",
                                 "127.0.0.1:0", "--client-token-file",
                                 folder.write("client.token", "open sesame\n"),
                                 "--admin-token-file", folder.write("admin.token", "master\n")});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    for (const auto& [token, in] :
         {std::pair("", false), {"open", false}, {"open sesame", true}, {"master", true}}) {
        const auto connected = client::Client::connect(
            {.url = url, .name = "knocks", .token = token, .timeout_s = 60});
        EXPECT_EQ(connected.has_value(), in) << token;
    }
    server.send(SIGTERM);
    EXPECT_EQ(server.wait_for_exit(std::chrono::seconds(20)), 0);
    const std::string log = server.log();
    EXPECT_EQ(tests::times_in(log, "client=\"knocks\" administrator=false"), 1) << log;
    EXPECT_EQ(tests::times_in(log, "client=\"knocks\" administrator=true"), 1) << log;
}

// What comes back from a port that speaks TLS is an end without a word.
TEST(Start, who_asks_a_server_with_tls_without_it_is_told_of_wss) {
    const tests::Certificate own;
    tests::ServerProcess server({changes::small_sea, "--device", "native", "--listen",
                                 "127.0.0.1:0", "--tls-cert", own.cert_file, "--tls-key",
                                 own.key_file});
    const std::string url = server.wait_until_ready();
    ASSERT_EQ(url.substr(0, 6), "wss://") << server.log();
    const changes::Said said = changes::ctl("ws://" + url.substr(6), {"state"}, "");
    EXPECT_EQ(said.code, 5);
    EXPECT_NE(said.words.find("if it speaks TLS it is " + url), std::string::npos) << said.words;
}

} // namespace
} // namespace seaway
