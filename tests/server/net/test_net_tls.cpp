// SPDX-License-Identifier: Apache-2.0
// The same port with TLS: a client that is bare OpenSSL over a socket.
#include <array>
#include <csignal>
#include <filesystem>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>

#include "tests/server/net/net_fixture.h"
#include "tests/support/certificate.h"
#include "tests/support/read_file.h"

namespace seaway::tests {
namespace {

template <auto Free>
struct Freed {
    template <class T>
    void operator()(T* thing) const {
        Free(thing);
    }
};
using X509Ptr = std::unique_ptr<X509, Freed<X509_free>>;
using Context = std::unique_ptr<SSL_CTX, Freed<SSL_CTX_free>>;
using Ssl = std::unique_ptr<SSL, Freed<SSL_free>>;

class TlsPeer {
  public:
    /// `receive_buffer_bytes` above 0: the system holds no more of what it has not read.
    explicit TlsPeer(int port, int receive_buffer_bytes = 0)
        : context_(SSL_CTX_new(TLS_client_method())) {
        socket_ = ::socket(AF_INET, SOCK_STREAM, 0);
        if (receive_buffer_bytes > 0)
            ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receive_buffer_bytes,
                         sizeof receive_buffer_bytes);
        const timeval a_minute{60, 0};
        ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &a_minute, sizeof a_minute);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(static_cast<std::uint16_t>(port));
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        EXPECT_EQ(::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    }
    ~TlsPeer() { ::close(socket_); }
    TlsPeer(const TlsPeer&) = delete;
    TlsPeer& operator=(const TlsPeer&) = delete;

    /// `suites`: of TLS 1.2, in OpenSSL's words; empty: all.
    bool handshake(int version_max = TLS1_3_VERSION, const char* suites = "ALL") {
        SSL_CTX_set_security_level(context_.get(), 0); // offers old versions too
        EXPECT_EQ(SSL_CTX_set_cipher_list(context_.get(), suites), 1) << suites;
        SSL_CTX_set_min_proto_version(context_.get(), TLS1_VERSION);
        SSL_CTX_set_max_proto_version(context_.get(), version_max);
        ssl_.reset(SSL_new(context_.get()));
        SSL_set_fd(ssl_.get(), socket_);
        return SSL_connect(ssl_.get()) == 1;
    }
    /// SHA-256 of the server's certificate.
    std::string fingerprint() const {
        const X509Ptr certificate(SSL_get1_peer_certificate(ssl_.get()));
        std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
        unsigned size = 0;
        X509_digest(certificate.get(), EVP_sha256(), digest.data(), &size);
        return {digest.begin(), digest.begin() + size};
    }
    /// True: the session of another connection is taken up again.
    bool takes_up(const TlsPeer& other, int version_max) {
        ssl_.reset(SSL_new(context_.get()));
        SSL_set_max_proto_version(ssl_.get(), version_max);
        SSL_set_session(ssl_.get(), SSL_get0_session(other.ssl_.get()));
        SSL_set_fd(ssl_.get(), socket_);
        EXPECT_EQ(SSL_connect(ssl_.get()), 1);
        return SSL_session_reused(ssl_.get()) == 1;
    }
    bool renegotiates() {
        return SSL_renegotiate(ssl_.get()) == 1 && SSL_do_handshake(ssl_.get()) == 1;
    }
    /// False: nobody takes it any more.
    bool takes_new_keys() {
        return SSL_key_update(ssl_.get(), SSL_KEY_UPDATE_NOT_REQUESTED) == 1 &&
               SSL_do_handshake(ssl_.get()) == 1;
    }
    bool tries_to_say(std::string_view text) {
        return SSL_write(ssl_.get(), text.data(), static_cast<int>(text.size())) ==
               static_cast<int>(text.size());
    }
    void say(std::string_view text) { EXPECT_TRUE(tries_to_say(text)); }
    /// Reads until `word` has been seen, or the end.
    std::string hear(std::string_view word) {
        std::string heard;
        std::array<char, 4096> some{};
        while (heard.find(word) == std::string::npos) {
            const int count = SSL_read(ssl_.get(), some.data(), some.size());
            if (count <= 0)
                break;
            heard.append(some.data(), static_cast<std::size_t>(count));
        }
        return heard;
    }

  private:
    Context context_;
    Ssl ssl_;
    int socket_;
};

class NetTls : public ::testing::Test {
  protected:
    NetTls() {
        options.listen = "127.0.0.1:0";
        options.http_deadline = std::chrono::minutes(5);
        options.tls_cert_file = folder().file("cert.pem");
        options.tls_key_file = folder().file("key.pem");
        make_certificate(options.tls_cert_file, options.tls_key_file);
        auto started = server::NetServer::start(options, host);
        EXPECT_TRUE(started.has_value()) << (started ? "" : started.error().message);
        net = std::move(*started);
    }
    /// Asked for over a connection of its own; -1 if it is not there.
    double metric(const std::string& name) {
        TlsPeer peer(net->port());
        EXPECT_TRUE(peer.handshake());
        peer.say("GET /metrics HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n");
        return figure_of(peer.hear("the end"), name);
    }

    SmallSea host;
    server::NetOptions options;
    std::unique_ptr<server::NetServer> net;
};

/// One binary message in a frame whose mask changes nothing.
void say_message(TlsPeer& peer, const protocol::Bytes& message) {
    ASSERT_LT(message.size(), 126u);
    std::string frame{
        static_cast<char>(0x82), static_cast<char>(0x80 | message.size()), 0, 0, 0, 0};
    frame.append(message.begin(), message.end());
    peer.say(frame);
}

/// A connection becomes a stream, and its client says who it is.
void begin_stream(TlsPeer& peer) {
    peer.say("GET /v1/stream HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: Upgrade\r\nUpgrade: "
             "websocket\r\n"
             "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
             "Sec-WebSocket-Protocol: seaway.v1\r\n\r\n");
    EXPECT_NE(peer.hear("\r\n\r\n").find("101 Switching"), std::string::npos);
    say_message(peer, protocol::hello("tls", ""));
}

TEST_F(NetTls, pages_and_streams_are_served) {
    EXPECT_EQ(net->url().substr(0, 6), "wss://");
    TlsPeer peer(net->port());
    ASSERT_TRUE(peer.handshake());
    peer.say("GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
    EXPECT_NE(peer.hear("ok\n").find("200 OK"), std::string::npos);
    begin_stream(peer); // the same connection, kept alive
    EXPECT_NE(peer.hear("seaway " SEAWAY_VERSION).find("SEAW"), std::string::npos) << "Welcome";
}

// A client that has lost its line: keyframes are stuck in a write, the ping that falls due waits behind it, and the write
// that is overdue ends the session. Naive: the ping is begun on what was closed, and ends in memory that was given back
// (CMakeLists.txt has that written over).
TEST_F(NetTls, who_goes_silent_while_he_is_sent_keyframes_is_let_go_and_the_server_lives_on) {
    LogCapture log;
    options.idle_timeout = std::chrono::seconds(6); // a ping after half of it
    options.write_timeout = std::chrono::milliseconds(2500);
    net = *server::NetServer::start(options, host);
    host.size = 256;
    host.error = {1e-5f}; // a megabyte a keyframe
    std::vector<std::unique_ptr<TlsPeer>> silent;
    for (int i = 0; i < 4; ++i) {
        TlsPeer& peer = *silent.emplace_back(std::make_unique<TlsPeer>(net->port(), 2048));
        ASSERT_TRUE(peer.handshake());
        begin_stream(peer);
        EXPECT_NE(peer.hear("seaway " SEAWAY_VERSION).find("SEAW"), std::string::npos);
        say_message(peer, protocol::subscribe(1, {.cascades = 3u, .fields = host.offered}, 8));
    }
    EXPECT_TRUE(eventually([&] { return metric("seaway_net_fetches_total") == 4; }));
    for (std::int64_t n = 1; n <= 8; ++n) {
        host.newest = n;
        for (int cascade = 0; cascade < 2; ++cascade)
            net->publish(host.keyframe(cascade, n, host.offered));
    }
    EXPECT_TRUE(eventually([&] { return metric("seaway_net_sessions") == 0; }));
    net = nullptr;
    EXPECT_EQ(log.lines_with("session_closed", "reason=too_slow").size(), 4u) << log.text();
}

// Naive: over TLS nothing goes out at once, and what a newcomer is told of a timetable that runs fast counts as what he is too
// slow for: nobody comes in.
TEST_F(NetTls, a_newcomer_is_told_of_as_many_seas_as_there_are) {
    host.states.clear();
    for (std::size_t i = 0; i < protocol::limits::sea_states_told; ++i)
        host.states.push_back(SmallSea::state_message(static_cast<std::uint32_t>(i), 100 + i));
    TlsPeer peer(net->port());
    ASSERT_TRUE(peer.handshake());
    begin_stream(peer);
    const std::string last(99 + protocol::limits::sea_states_told, 's');
    EXPECT_NE(peer.hear(last).find(last), std::string::npos);
}

// They are TLS's own: no limit of bytes above it sees them, and each costs the thread of the network microseconds.
TEST_F(NetTls, who_takes_new_keys_without_end_is_let_go_and_who_does_so_now_and_then_is_not) {
    ::signal(SIGPIPE, SIG_IGN);
    TlsPeer now_and_then(net->port()), without_end(net->port());
    ASSERT_TRUE(now_and_then.handshake() && without_end.handshake());
    for (int i = 0; i < 20; ++i)
        ASSERT_TRUE(now_and_then.takes_new_keys());
    const std::string_view question = "GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
    // Each is answered before the next is sent: else what the system holds for the server counts, too.
    int taken = 0;
    while (taken < 1000 && without_end.takes_new_keys() && without_end.tries_to_say(question) &&
           without_end.hear("ok\n").find("200 OK") != std::string::npos)
        ++taken;
    // A hundred messages in a life, of which the handshake has taken a few.
    EXPECT_GE(taken, 90);
    EXPECT_LE(taken, 100);
    now_and_then.say(question);
    EXPECT_NE(now_and_then.hear("ok\n").find("200 OK"), std::string::npos);
}

// What is kept to take a session up again, here or at the client, opens what was overheard of it.
TEST_F(NetTls, no_session_is_taken_up_again) {
    for (const int version : {TLS1_2_VERSION, TLS1_3_VERSION}) {
        TlsPeer first(net->port()), second(net->port());
        ASSERT_TRUE(first.handshake(version));
        first.say("GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
        EXPECT_NE(first.hear("ok\n").find("200 OK"), std::string::npos); // tickets come before it
        EXPECT_FALSE(second.takes_up(first, version)) << std::hex << version;
    }
}

// Naive: a handshake that takes all of the time is followed by a request that has as long again.
TEST_F(NetTls, handshake_and_first_request_have_one_deadline) {
    ::signal(SIGPIPE, SIG_IGN);
    options.http_deadline = std::chrono::milliseconds(1500);
    net = *server::NetServer::start(options, host);
    const std::string question = "GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
    TlsPeer slow(net->port());
    std::this_thread::sleep_for(std::chrono::milliseconds(1000));
    if (slow.handshake()) { // which this machine may have been too slow for
        std::this_thread::sleep_for(std::chrono::milliseconds(1000));
        static_cast<void>(slow.tries_to_say(question));
        EXPECT_EQ(slow.hear("ok\n"), "");
    }
}

TEST_F(NetTls, versions_before_1_2_are_refused) {
    TlsPeer old(net->port());
    EXPECT_FALSE(old.handshake(TLS1_1_VERSION));
    TlsPeer good(net->port());
    EXPECT_TRUE(good.handshake(TLS1_2_VERSION));
}

// RFC 9325, section 4.2: forward secrecy and authenticated encryption.
TEST_F(NetTls, of_the_suites_of_1_2_only_those_with_forward_secrecy_and_without_cbc_are_spoken) {
    for (const char* weak : {"ECDHE-ECDSA-AES128-SHA", "ECDHE-ECDSA-AES256-SHA384",
                             "ECDHE-ECDSA-AES128-SHA256", "ECDHE-ECDSA-AES128-CCM"}) {
        TlsPeer peer(net->port());
        EXPECT_FALSE(peer.handshake(TLS1_2_VERSION, weak)) << weak;
    }
    for (const char* strong : {"ECDHE-ECDSA-AES128-GCM-SHA256", "ECDHE-ECDSA-AES256-GCM-SHA384",
                               "ECDHE-ECDSA-CHACHA20-POLY1305"}) {
        TlsPeer peer(net->port());
        EXPECT_TRUE(peer.handshake(TLS1_2_VERSION, strong)) << strong;
    }
    TlsPeer again(net->port());
    ASSERT_TRUE(again.handshake(TLS1_2_VERSION));
    EXPECT_FALSE(again.renegotiates()) << "a handshake costs the server more than the client";
}

TEST_F(NetTls, a_new_certificate_is_for_new_connections_and_a_broken_one_for_none) {
    const std::string request = "GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
    const auto shown = [&] {
        TlsPeer peer(net->port());
        EXPECT_TRUE(peer.handshake());
        return peer.fingerprint();
    };
    TlsPeer old(net->port());
    ASSERT_TRUE(old.handshake());
    const std::string first = old.fingerprint();
    make_certificate(folder().file("cert.pem"), folder().file("key.pem"));
    EXPECT_EQ(shown(), first) << "nobody has asked to read it";
    using server::ReadAgain;
    const auto outcomes = [](const server::NetServer::Reloaded& read) {
        std::vector<std::pair<std::string, ReadAgain>> all;
        for (const server::FileReadAgain& file : read.files)
            all.emplace_back(file.option, file.outcome);
        return all;
    };
    const server::NetServer::Reloaded fine = net->reload();
    ASSERT_TRUE(fine.all);
    EXPECT_EQ(outcomes(fine),
              (std::vector<std::pair<std::string, ReadAgain>>{
                  {"--tls-cert", ReadAgain::read_again}, {"--tls-key", ReadAgain::read_again}}));
    const std::string second = shown();
    EXPECT_NE(second, first);
    old.say(request);
    EXPECT_NE(old.hear("ok\n").find("200 OK"), std::string::npos) << "what is open stays open";
    make_certificate(folder().file("cert.pem"), folder().file("other_key.pem"));
    const server::NetServer::Reloaded read = net->reload();
    const Result<void>& broken = read.all;
    ASSERT_FALSE(broken) << "the key is not this certificate's";
    EXPECT_EQ(outcomes(read),
              (std::vector<std::pair<std::string, ReadAgain>>{{"--tls-cert", ReadAgain::kept},
                                                              {"--tls-key", ReadAgain::failed}}));
    EXPECT_NE(broken.error().message.find("--tls-key"), std::string::npos);
    EXPECT_EQ(shown(), second);
}

// Naive: OpenSSL asks whoever started the server for a pass phrase, and waits for a pipe; nothing else is read or ended meanwhile.
TEST_F(NetTls, a_key_that_needs_a_pass_phrase_or_is_a_pipe_is_refused_at_once) {
    const std::string key = folder().file("key.pem"), before = read_file(key);
    const auto why = [&] {
        const server::NetServer::Reloaded read = net->reload();
        return read.all ? std::string("taken") : read.all.error().message;
    };
    for (const char* encrypted :
         {"-----BEGIN ENCRYPTED PRIVATE KEY-----\nMIIB\n-----END ENCRYPTED PRIVATE KEY-----\n",
          "-----BEGIN RSA PRIVATE KEY-----\nProc-Type: 4,ENCRYPTED\n"
          "DEK-Info: AES-128-CBC,00112233445566778899AABBCCDDEEFF\n\nMIIB\n"
          "-----END RSA PRIVATE KEY-----\n"}) {
        folder().write("key.pem", encrypted);
        EXPECT_EQ(why(),
                  "--tls-key " + key +
                      ": is encrypted; a key without a pass phrase is needed; the PEM key of "
                      "the certificate is expected");
    }
    for (const char* name : {"key.pem", "cert.pem"}) {
        folder().write("key.pem", before);
        const std::string path = folder().file(name), was = read_file(path);
        std::filesystem::remove(path);
        ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
        EXPECT_NE(why().find("is a pipe, a device or a socket"), std::string::npos) << why();
        std::filesystem::remove(path);
        folder().write(name, was);
    }
    EXPECT_EQ(why(), "taken");
}

TEST_F(NetTls, a_key_of_another_certificate_is_one_helpful_line) {
    server::NetOptions options;
    options.listen = "127.0.0.1:0";
    options.tls_cert_file = folder().file("cert_a.pem");
    options.tls_key_file = folder().file("key_b.pem");
    make_certificate(options.tls_cert_file, folder().file("key_a.pem"));
    make_certificate(folder().file("cert_b.pem"), options.tls_key_file);
    const auto started = server::NetServer::start(options, host);
    ASSERT_FALSE(started.has_value());
    EXPECT_NE(started.error().message.find("--tls-key"), std::string::npos);
}

// Naive: OpenSSL takes both, each in a place of its own, and no handshake ever succeeds.
TEST_F(NetTls, a_key_of_another_type_than_the_certificates_is_refused_at_the_start_and_later) {
    const std::string rsa_cert = folder().file("rsa_cert.pem"),
                      rsa_key = folder().file("rsa_key.pem"), ec_key = folder().file("ec_key.pem");
    make_certificate(rsa_cert, rsa_key, "IP:127.0.0.1", "rsa:2048");
    make_certificate(folder().file("ec_cert.pem"), ec_key);
    server::NetOptions options;
    options.listen = "127.0.0.1:0";
    options.tls_cert_file = rsa_cert;
    options.tls_key_file = ec_key;
    const Result<void> checked = server::NetServer::check(options);
    ASSERT_FALSE(checked);
    EXPECT_EQ(checked.error().message,
              "--tls-key " + ec_key + ": not the key of the certificate in " + rsa_cert);
    EXPECT_FALSE(server::NetServer::start(options, host).has_value());
    options.tls_key_file = rsa_key;
    EXPECT_TRUE(server::NetServer::check(options));
    // The running one, of which a new certificate came without its key.
    make_certificate(folder().file("cert.pem"), rsa_key, "IP:127.0.0.1", "rsa:2048");
    const server::NetServer::Reloaded read = net->reload();
    ASSERT_FALSE(read.all);
    EXPECT_NE(read.all.error().message.find("not the key of the certificate"), std::string::npos);
    TlsPeer peer(net->port());
    EXPECT_TRUE(peer.handshake()) << "with what it had";
}

} // namespace
} // namespace seaway::tests
