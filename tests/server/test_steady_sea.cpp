// SPDX-License-Identifier: Apache-2.0
// What a session in which nothing happens takes of a line.
#include <chrono>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "client/link/clock.h"
#include "protocol/messages.h"
#include "tests/server/net/clients.h"
#include "tests/support/metrics_page.h"
#include "tests/support/server_process.h"

namespace seaway {
namespace {

// Bytes of messages, and of each two that frame it: answers to the pings by which a client keeps its clock, as often as ours sends
// them once it has done so for a while. Not a time: a busy machine sends no more of them.
TEST(SteadySea, who_has_the_waves_is_sent_100_bytes_a_second) {
    tests::ServerProcess server(
        {"scenes/north_sea_gale.toml", "--listen", "127.0.0.1:0", "--device", "native"});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    const int port = tests::port_of(url);
    const auto metric = [&](const std::string& name) {
        return tests::figure_of(tests::ask_http(port, "/metrics", "GET").body,
                                "seaway_net_" + name);
    };
    tests::Client client(port);
    ASSERT_FALSE(client.connect());
    ASSERT_TRUE(client.greet());
    ASSERT_FALSE(client.send(protocol::subscribe_spectrum(1, {})));
    const wire::Message* waves = client.receive(wire::Body::Spectrum);
    ASSERT_TRUE(waves);
    for (std::uint32_t left = waves->body_as_Spectrum()->chunks(); left > 0; --left)
        ASSERT_TRUE(client.receive(wire::Body::SpectrumChunk));
    const double bytes = metric("sent_bytes_total"), messages = metric("messages_sent_total");
    constexpr std::uint32_t pings_of_a_while = 1000, seconds = 5;
    const std::chrono::microseconds pause(client::pause_after_ping_us(pings_of_a_while));
    const auto pings = static_cast<std::uint32_t>(std::chrono::seconds(seconds) / pause);
    for (std::uint32_t ping = 0; ping < pings; ++ping) {
        ASSERT_FALSE(client.send(protocol::ping(ping, ping)));
        std::this_thread::sleep_for(pause);
        ASSERT_TRUE(client.receive(wire::Body::Pong));
    }
    const double told = metric("messages_sent_total") - messages;
    EXPECT_GE(told, pings);
    EXPECT_LE(metric("sent_bytes_total") - bytes + 2 * told, 100.0 * seconds);
}

} // namespace
} // namespace seaway
