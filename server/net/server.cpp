// SPDX-License-Identifier: Apache-2.0
#include "server/net/server.h"

#include <charconv>
#include <thread>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <fmt/format.h>

#include "protocol/token_file.h"
#include "server/net/connection.h"
#include "server/net/session.h"
#include "sockets/socket.h"

namespace seaway::server {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using sockets::error_code;

/// Kernel memory a slow reader can fill; large enough for a fast one on a long link.
constexpr int send_buffer_bytes = 256 * 1024;
/// Out of file descriptors: wait, do not spin.
constexpr std::chrono::milliseconds accept_pause{100};

Result<tcp::endpoint> parse_endpoint(const std::string& listen) {
    const Error wrong{fmt::format("--listen {}: not understood, expected ADDR:PORT with numbers, "
                                  "such as 127.0.0.1:9430, 0.0.0.0:9430 or [::]:9430",
                                  listen)};
    const std::size_t colon = listen.rfind(':');
    if (colon == std::string::npos)
        return wrong;
    std::string host = listen.substr(0, colon);
    const bool bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
    if (bracketed)
        host = host.substr(1, host.size() - 2);
    else if (host.find(':') != std::string::npos)
        return wrong;
    unsigned port = 0;
    const char* begin = listen.data() + colon + 1;
    const char* end = listen.data() + listen.size();
    const auto parsed = std::from_chars(begin, end, port);
    if (begin == end || parsed.ptr != end || parsed.ec != std::errc() || port > 65535)
        return wrong;
    error_code error;
    const auto address = asio::ip::make_address(host, error);
    if (error)
        return wrong;
    return tcp::endpoint(address, static_cast<unsigned short>(port));
}

std::string text(const tcp::endpoint& endpoint) {
    const std::string address = endpoint.address().to_string();
    return endpoint.address().is_v6() ? fmt::format("[{}]:{}", address, endpoint.port())
                                      : fmt::format("{}:{}", address, endpoint.port());
}

std::string why_not(const tcp::endpoint& endpoint, error_code error) {
    std::string advice = "choose another address with --listen ADDR:PORT";
    if (error == asio::error::address_in_use)
        advice = "another program listens there; stop it or choose another port with --listen, 0 "
                 "takes a free one";
    else if (error == asio::error::access_denied)
        advice = "ports below 1024 need root; choose another with --listen";
    else if (error.value() == EADDRNOTAVAIL)
        advice = "this machine has no such address; 0.0.0.0 listens on all of them";
    return fmt::format("cannot listen on {}: {}: {}", text(endpoint), error.message(), advice);
}

struct Tokens {
    std::string client;
    std::string admin;
};

Result<Tokens> load_tokens(const NetOptions& options) {
    Tokens tokens;
    for (const auto& [file, token] : {std::pair(&options.client_token_file, &tokens.client),
                                      std::pair(&options.admin_token_file, &tokens.admin)})
        if (!file->empty()) {
            SEAWAY_TRY_LET(*token, protocol::read_token_file(*file));
        }
    return tokens;
}

/// Nothing to do without --tls-cert and --tls-key.
Result<void> load_certificate(const NetOptions& options, asio::ssl::context& tls) {
    if (options.tls_cert_file.empty() != options.tls_key_file.empty())
        return Error{"--tls-cert and --tls-key belong together: give both or neither"};
    if (options.tls_cert_file.empty())
        return {};
    error_code error;
    tls.set_options(asio::ssl::context::no_tlsv1 | asio::ssl::context::no_tlsv1_1 |
                        asio::ssl::context::no_sslv2 | asio::ssl::context::no_sslv3,
                    error);
    tls.use_certificate_chain_file(options.tls_cert_file, error);
    if (error)
        return Error{fmt::format("--tls-cert {}: {}; a PEM certificate chain is expected",
                                 options.tls_cert_file, error.message())};
    tls.use_private_key_file(options.tls_key_file, asio::ssl::context::pem, error);
    if (error)
        return Error{fmt::format("--tls-key {}: {}; the PEM key of the certificate is expected",
                                 options.tls_key_file, error.message())};
    return {};
}

} // namespace

class NetServer::Impl {
  public:
    Impl(const NetOptions& options, Host& host)
        : tls_(asio::ssl::context::tls_server),
          core_(std::make_shared<Core>(
              options, host, [this](Core::Work work) { asio::post(io_, std::move(work)); })) {}

    ~Impl() { stop(); }

    Result<void> start() {
        const NetOptions& options = core_->options;
        SEAWAY_TRY_LET(const Tokens tokens, load_tokens(options));
        core_->client_token = tokens.client;
        core_->admin_token = tokens.admin;
        with_tls_ = !options.tls_cert_file.empty();
        SEAWAY_TRY(load_certificate(options, tls_));
        SEAWAY_TRY(listen());
        accept();
        thread_ = std::thread([this] { io_.run(); });
        return {};
    }

    int port() const { return endpoint_.port(); }
    std::string url() const {
        return fmt::format("{}://{}", with_tls_ ? "wss" : "ws", text(endpoint_));
    }

    void publish(KeyframeTiles tiles);
    void announce(protocol::SharedBytes sea_state) {
        core_->post([core = core_.get(), sea_state = std::move(sea_state)] {
            for_each_session(*core, [&](Session& session) { session.announce(sea_state); });
        });
    }
    void stop();

  private:
    Result<void> listen();
    void accept();
    void on_accepted(error_code error, tcp::socket socket);
    void begin_stop();

    /// A session may end, and leave the map, while it is called.
    template <class Call>
    static void for_each_session(Core& core, Call call) {
        for (auto at = core.sessions.begin(); at != core.sessions.end();)
            call(*(at++)->second);
    }

    asio::io_context io_{1};
    asio::ssl::context tls_;
    bool with_tls_ = false;
    tcp::endpoint endpoint_;
    tcp::acceptor acceptor_{io_};
    asio::steady_timer accept_timer_{io_};
    asio::steady_timer stop_timer_{io_};
    std::shared_ptr<Core> core_;
    std::thread thread_;
};

Result<void> NetServer::Impl::listen() {
    const Result<tcp::endpoint> wanted = parse_endpoint(core_->options.listen);
    if (!wanted)
        return wanted.error();
    error_code error;
    acceptor_.open(wanted->protocol(), error);
    if (!error)
        acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error)
        acceptor_.bind(*wanted, error);
    if (!error)
        acceptor_.listen(asio::socket_base::max_listen_connections, error);
    if (!error)
        endpoint_ = acceptor_.local_endpoint(error);
    if (error)
        return Error{why_not(*wanted, error)};
    return {};
}

void NetServer::Impl::accept() {
    acceptor_.async_accept(
        [this](error_code error, tcp::socket socket) { on_accepted(error, std::move(socket)); });
}

void NetServer::Impl::on_accepted(error_code error, tcp::socket socket) {
    if (!acceptor_.is_open() || error == asio::error::operation_aborted)
        return;
    if (error) {
        core_->log(fmt::format("event=accept_failed why=\"{}\"", error.message()));
        accept_timer_.expires_after(accept_pause);
        accept_timer_.async_wait([this](error_code waited) {
            if (!waited)
                accept();
        });
        return;
    }
    if (core_->connections >= core_->options.connections_max) {
        if (core_->awaiting_requests.empty()) {
            ++core_->counters.connections_refused; // closed by its destructor
            return accept();
        }
        ++core_->counters.connections_given_up;
        const auto give_up = core_->awaiting_requests.front();
        give_up();
    }
    ++core_->counters.connections_accepted;
    error_code ignored; // a socket that is gone already will say so when it is read
    socket.set_option(tcp::no_delay(true), ignored);
    socket.set_option(asio::socket_base::send_buffer_size(send_buffer_bytes), ignored);
    const tcp::endpoint peer = socket.remote_endpoint(ignored);
    ConnectionSlot slot(core_);
    serve_http(std::move(slot),
               with_tls_ ? sockets::Socket(std::move(socket), tls_)
                         : sockets::Socket(std::move(socket)),
               text(peer));
    accept();
}

void NetServer::Impl::publish(KeyframeTiles tiles) {
    const sea::FieldSet wanted =
        core_->host.subscriptions().wanted(tiles.keyframe->cascade, tiles.quality);
    if (wanted.empty())
        return;
    const std::weak_ptr<Core> weak = core_;
    const bool taken = core_->encoding.submit_streamed([weak, tiles, wanted](Encoder& encoder) {
        auto encoded = encoder.encode(*tiles.keyframe, tiles.codec_error, tiles.quality, wanted,
                                      tiles.compact_size);
        const std::shared_ptr<Core> core = weak.lock();
        if (core == nullptr)
            return true;
        core->post([weak, encoded = std::move(encoded)] {
            const std::shared_ptr<Core> here = weak.lock();
            if (here == nullptr)
                return;
            if (!encoded) {
                ++here->counters.keyframes_wrong;
                return here->log(
                    fmt::format("event=keyframe_refused why=\"{}\"", encoded.error().message));
            }
            ++here->counters.keyframes_published;
            for_each_session(*here, [&](Session& session) { session.deliver(*encoded); });
        });
        return true;
    });
    if (!taken)
        core_->post([core = core_.get()] { ++core->counters.keyframes_dropped; });
}

void NetServer::Impl::begin_stop() {
    core_->stopping = true;
    error_code ignored;
    acceptor_.close(ignored);
    accept_timer_.cancel();
    for_each_session(*core_, [](Session& session) {
        session.close(wire::ErrorCode::shutting_down, "the server stops");
    });
    // Ends when the last connection has said goodbye, or at the deadline.
    const auto deadline = std::chrono::steady_clock::now() + core_->options.stop_deadline;
    const auto look = [this, deadline](const auto& again) -> void {
        if (core_->connections == 0 || std::chrono::steady_clock::now() >= deadline)
            return io_.stop();
        stop_timer_.expires_after(std::chrono::milliseconds(10));
        stop_timer_.async_wait([again](error_code) { again(again); });
    };
    look(look);
}

void NetServer::Impl::stop() {
    core_->encoding.stop();
    if (thread_.joinable()) {
        asio::post(io_, [this] { begin_stop(); });
        thread_.join();
    }
    core_->detach();
    core_->waiting_for_maps.clear();
    core_->disposal.stop(); // maps hold the core, and its last holder must not be its own thread
}

// ---- NetServer -----------------------------------------------------------------------------

Result<void> NetServer::check(const NetOptions& options) {
    if (const Result<tcp::endpoint> endpoint = parse_endpoint(options.listen); !endpoint)
        return endpoint.error();
    if (const Result<Tokens> tokens = load_tokens(options); !tokens)
        return tokens.error();
    asio::ssl::context tls(asio::ssl::context::tls_server);
    return load_certificate(options, tls);
}

Result<std::unique_ptr<NetServer>> NetServer::start(const NetOptions& options, Host& host) {
    auto impl = std::make_unique<Impl>(options, host);
    SEAWAY_TRY(impl->start());
    return std::unique_ptr<NetServer>(new NetServer(std::move(impl)));
}

NetServer::NetServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
NetServer::~NetServer() = default;
int NetServer::port() const {
    return impl_->port();
}
std::string NetServer::url() const {
    return impl_->url();
}
void NetServer::publish(KeyframeTiles tiles) {
    impl_->publish(std::move(tiles));
}
void NetServer::announce(protocol::SharedBytes sea_state) {
    impl_->announce(std::move(sea_state));
}
void NetServer::stop() {
    impl_->stop();
}

} // namespace seaway::server
