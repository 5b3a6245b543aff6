// SPDX-License-Identifier: Apache-2.0
// wss://: a server is trusted by its certificate and name, or not at all.
#include <sys/socket.h>

#include <algorithm>
#include <memory>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

#include "client/client.h"
#include "client/link/failure.h"
#include "server/net/server.h"
#include "tests/client/wave_sea.h"
#include "tests/support/certificate.h"
#include "tests/support/listener.h"

namespace seaway::client {
namespace {

using tests::Certificate;

std::unique_ptr<server::NetServer> serve(tests::WaveSea& sea, const Certificate& certificate) {
    server::NetOptions options;
    options.listen = "127.0.0.1:0";
    options.tls_cert_file = certificate.cert_file;
    options.tls_key_file = certificate.key_file;
    auto started = server::NetServer::start(options, sea);
    EXPECT_TRUE(started) << started.error().message;
    return started ? std::move(*started) : nullptr;
}

TEST(Tls, a_server_with_a_trusted_certificate_answers) {
    tests::WaveSea sea;
    const Certificate certificate;
    const auto net = serve(sea, certificate);
    ASSERT_TRUE(net);
    ASSERT_TRUE(net->url().starts_with("wss://"));
    for (const bool threadless : {false, true}) {
        const auto client = Client::connect(
            {.url = net->url(), .ca_file = certificate.cert_file, .threadless = threadless});
        ASSERT_TRUE(client) << client.error().message;
        const sea::QueryPoint point{1, 2, 3'000'000};
        const auto local = (*client)->fetch_and_sample({&point, 1}, 10);
        ASSERT_TRUE(local) << local.error().message;
        EXPECT_NEAR((*local)[0].height_m, sea.truth(point).height_m, (*local)[0].error_m);
    }
}

TEST(Tls, a_server_that_nobody_vouches_for_is_refused) {
    tests::WaveSea sea;
    const Certificate certificate;
    const Certificate another;
    const auto net = serve(sea, certificate);
    ASSERT_TRUE(net);
    for (const std::string& trusted : {std::string(), another.cert_file})
        for (const bool threadless : {false, true}) {
            const auto client =
                Client::connect({.url = net->url(), .ca_file = trusted, .threadless = threadless});
            ASSERT_FALSE(client);
            EXPECT_EQ(failure_of(client.error()), Failure::cannot_connect);
            EXPECT_NE(client.error().message.find("certificate verify failed"), std::string::npos)
                << client.error().message;
        }
}

TEST(Tls, a_certificate_for_another_name_is_refused) {
    tests::WaveSea sea;
    const Certificate certificate("DNS:elsewhere.example");
    const auto net = serve(sea, certificate);
    ASSERT_TRUE(net);
    const auto client = Client::connect({.url = net->url(), .ca_file = certificate.cert_file});
    ASSERT_FALSE(client);
    EXPECT_EQ(failure_of(client.error()), Failure::cannot_connect);
    EXPECT_NE(client.error().message.find("of another name"), std::string::npos)
        << client.error().message;
}

TEST(Tls, ws_to_a_tls_port_and_wss_to_a_plain_one_cannot_connect) {
    tests::WaveSea sea;
    const Certificate certificate;
    const auto net = serve(sea, certificate);
    ASSERT_TRUE(net);
    const auto plain = Client::connect({.url = "ws" + net->url().substr(3)});
    ASSERT_FALSE(plain);
    EXPECT_EQ(failure_of(plain.error()), Failure::cannot_connect);

    server::NetOptions options;
    options.listen = "127.0.0.1:0";
    const auto plain_net = server::NetServer::start(options, sea);
    ASSERT_TRUE(plain_net);
    const auto secure = Client::connect({.url = "wss" + (*plain_net)->url().substr(2)});
    ASSERT_FALSE(secure);
    EXPECT_EQ(failure_of(secure.error()), Failure::cannot_connect);
}

TEST(Tls, a_certificate_file_that_cannot_be_read_is_named) {
    const auto client = Client::connect({.url = "wss://127.0.0.1:1", .ca_file = "/no/such.pem"});
    ASSERT_FALSE(client);
    EXPECT_EQ(failure_of(client.error()), Failure::bad_argument);
    EXPECT_NE(client.error().message.find("/no/such.pem"), std::string::npos);
}

/// What a client says first to a server under this name, which then closes.
std::string first_words(const std::string& host) {
    const tests::Listener listener;
    const std::string url = "wss://" + host + ":" + std::to_string(listener.port());
    std::thread connects([&] { EXPECT_FALSE(Client::connect({.url = url, .timeout_s = 60})); });
    const int peer = listener.accept();
    std::string words(4096, '\0');
    const ssize_t read = ::recv(peer, words.data(), words.size(), 0);
    ::close(peer);
    connects.join();
    words.resize(static_cast<std::size_t>(std::max<ssize_t>(read, 0)));
    return words;
}

// RFC 6066, 3: names are told to the server in the clear, addresses are not allowed there. "127.1" is a name
// that every resolver takes for the loopback address; a machine need not know "localhost".
TEST(Tls, the_server_is_told_the_name_that_it_is_asked_by_but_no_address) {
    EXPECT_NE(first_words("127.1").find("127.1"), std::string::npos);
    const std::string by_address = first_words("127.0.0.1");
    EXPECT_GT(by_address.size(), 100u) << "a ClientHello";
    EXPECT_EQ(by_address.find("127.0.0.1"), std::string::npos);
}

} // namespace
} // namespace seaway::client
