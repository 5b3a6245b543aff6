// SPDX-License-Identifier: Apache-2.0
#include "server/net/server.h"

#include <array>
#include <atomic>
#include <functional>
#include <new>
#include <optional>
#include <thread>

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/host_name.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <fmt/format.h>

#include "base/messages.h"
#include "base/short_turns.h"
#include "base/thread_name.h"
#include "server/net/connection.h"
#include "server/net/credentials.h"
#include "server/net/endpoint.h"
#include "server/net/publishing.h"
#include "server/net/session.h"
#include "sockets/handler_memory.h"
#include "sockets/socket.h"

namespace seaway::server {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using sockets::error_code;
using Clock = std::chrono::steady_clock;

/// Kernel memory a slow reader can fill; large enough for a fast one on a long link.
constexpr int send_buffer_bytes = 256 * 1024;
/// Out of file descriptors: wait, do not spin.
constexpr std::chrono::milliseconds accept_pause{100};

Endpoint endpoint_of(const tcp::endpoint& endpoint) {
    return {endpoint.address().to_string(), endpoint.port(), endpoint.address().is_v6()};
}

/// Takes connections, one after the other, until it is closed.
class Listener {
  public:
    using Take = std::function<void(tcp::socket, const tcp::endpoint& peer)>;

    Listener(asio::io_context& io, Core& core, Take take)
        : core_(core), acceptor_(io), timer_(io), take_(std::move(take)) {}

    Result<void> listen(const std::string& flag, const std::string& where) {
        SEAWAY_TRY_LET(const Endpoint wanted, read_endpoint(flag, where));
        error_code error;
        const tcp::endpoint at(asio::ip::make_address(wanted.ip, error),
                               static_cast<unsigned short>(wanted.port));
        acceptor_.open(at.protocol(), error);
        if (!error)
            acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
        if (!error)
            acceptor_.bind(at, error);
        if (!error)
            acceptor_.listen(asio::socket_base::max_listen_connections, error);
        if (!error)
            endpoint_ = endpoint_of(acceptor_.local_endpoint(error));
        if (error)
            return cannot_listen(flag, wanted, error.value(), error.message());
        return {};
    }

    /// Once at a time. Does not throw.
    void accept() {
        if (memory_->in_use() || !acceptor_.is_open())
            return;
        acceptor_.async_accept(sockets::with(memory_, [this](error_code error, tcp::socket socket) {
            on_accepted(error, std::move(socket));
        }));
    }

    void close() {
        error_code ignored;
        acceptor_.close(ignored);
        timer_.cancel();
    }

    const Endpoint& endpoint() const { return endpoint_; }

  private:
    void on_accepted(error_code error, tcp::socket socket) {
        if (!acceptor_.is_open() || error == asio::error::operation_aborted)
            return;
        if (error) {
            core_.log(fmt::format("event=accept_failed why={}", in_quotes(error.message())));
            timer_.expires_after(accept_pause);
            timer_.async_wait([this](error_code waited) {
                if (!waited)
                    accept();
            });
            return;
        }
        error_code gone; // a socket that is gone already will say so when it is read
        socket.set_option(tcp::no_delay(true), gone);
        socket.set_option(asio::socket_base::send_buffer_size(send_buffer_bytes), gone);
        const tcp::endpoint peer = socket.remote_endpoint(gone);
        take_(std::move(socket), peer);
        accept();
    }

    Core& core_;
    tcp::acceptor acceptor_;
    asio::steady_timer timer_;
    Take take_;
    Endpoint endpoint_;
    const sockets::HandlerMemoryPtr memory_ = std::make_shared<sockets::HandlerMemory>();
};

} // namespace

class NetServer::Impl {
  public:
    Impl(const NetOptions& options, Host& host)
        : core_(std::make_shared<Core>(
              options, host, [this](Core::Work work) { asio::post(io_, std::move(work)); })) {}

    ~Impl() { stop(); }

    Result<void> start() {
        const NetOptions& options = core_->options;
        CredentialsRead read = read_credentials(options);
        SEAWAY_TRY_LET(const Credentials credentials, std::move(read.all));
        files_ = std::move(read.files);
        SEAWAY_TRY_LET(core_->origins,
                       Origins::read(options.allowed_origins, asio::ip::host_name()));
        take(credentials);
        SEAWAY_TRY(public_.listen("--listen", options.listen));
        public_.accept();
        if (!options.health_listen.empty()) {
            SEAWAY_TRY(health_.listen("--health-listen", options.health_listen));
            health_.accept();
        }
        core_->senders.start(options.io_threads);
        thread_ = std::thread([this] { serve(); });
        return {};
    }

    Reloaded reload() {
        const std::scoped_lock lock(reloading_);
        CredentialsRead read = read_credentials(core_->options);
        Reloaded reloaded{{}, compare(files_, read.files)};
        if (!read.all) {
            reloaded.all = read.all.error();
            return reloaded;
        }
        asio::post(io_, [this, credentials = *read.all] { take(credentials); });
        files_ = std::move(read.files);
        return reloaded;
    }

    int port() const { return public_.endpoint().port; }
    Clock::duration silence() {
        if (asked_ && !answered_)
            return Clock::now() - *asked_;
        asked_.reset();
        answered_ = false;
        asio::post(io_, [this] {
            answered_ = true;
            core_->turns.go_on();
        });
        asked_ = Clock::now(); // not where there was no memory to ask
        return {};
    }
    int health_port() const { return health_.endpoint().port; }
    std::string url() const {
        return fmt::format("{}://{}", with_tls() ? "wss" : "ws", public_.endpoint().text());
    }

    void publish(KeyframeTiles tiles) { publish_keyframe(core_, std::move(tiles)); }
    void announce(protocol::SharedBytes sea_state) {
        core_->post([core = core_.get(), sea_state = std::move(sea_state)] {
            core->deliveries.announce(sea_state);
        });
    }
    void hand_over(const std::string& why, const std::string& in_general);
    void stop();

  private:
    /// The io thread. What there is no memory for is one connection's or one message's, which it ends.
    void serve() {
        const NoBrokenPipes none;
        name_thread("sea-network");
        take_short_turns(); // all clients wait for it
        for (;;) {
            try {
                io_.run();
                return;
            } catch (const std::bad_alloc&) {
                ++core_->counters.out_of_memory;
            }
            public_.accept(); // who came may have taken the handler along
            health_.accept();
        }
    }

    bool with_tls() const { return core_->options.has_tls(); }
    void take(const Credentials& credentials) {
        core_->tokens = credentials.tokens;
        tls_ = credentials.tls;
    }
    bool make_room(Address& address);
    void take_public(tcp::socket socket, const tcp::endpoint& from);
    void take_health(tcp::socket socket, const tcp::endpoint& from);
    void begin_stop();
    void come_to_an_end();

    /// A session may end, and leave the map, while it is called.
    template <class Call>
    static void for_each_session(Core& core, Call call) {
        for (auto at = core.sessions.begin(); at != core.sessions.end();)
            call(*(at++)->second);
    }

    asio::io_context io_{1};
    /// It ends when it is stopped: the last thing that it waited for may have gone with an exception.
    const asio::executor_work_guard<asio::io_context::executor_type> goes_on_{io_.get_executor()};
    asio::steady_timer stop_timer_{io_};
    Clock::time_point drained_; ///< once it stops
    std::shared_ptr<Core> core_;
    std::shared_ptr<asio::ssl::context> tls_; ///< null: plain
    std::mutex reloading_;
    std::vector<CredentialFile> files_; ///< that are in use
    Listener public_{io_, *core_, [this](tcp::socket socket, const tcp::endpoint& from) {
                         take_public(std::move(socket), from);
                     }};
    std::optional<Clock::time_point> asked_; ///< by silence()
    std::atomic<bool> answered_ = false;
    Listener health_{io_, *core_, [this](tcp::socket socket, const tcp::endpoint& from) {
                         take_health(std::move(socket), from);
                     }};
    /// Who asks for health crowds nobody else's address.
    const AddressPtr health_address_ = std::make_shared<Address>("health", core_->options);
    std::thread thread_;
};

/// For one more connection of this address, which is its own affair where it has as many as one
/// address may have, and else that of who has the most. False: there is no room.
bool NetServer::Impl::make_room(Address& address) {
    const NetOptions& options = core_->options;
    Door& door = core_->door;
    const int most = options.connections_per_address;
    const bool address_full = most > 0 && address.connections >= most;
    if (!address_full && door.connections < options.connections_max)
        return true;
    const bool made = address_full
                          ? door.awaiting_requests.give_up_of(address)
                          : door.awaiting_requests.give_up_of_most(&Address::connections, 0);
    const std::string reason = address_full ? "address_full" : "server_full";
    if (made)
        ++core_->counters.connections_given_up;
    else
        ++core_->counters.connections_refused[reason];
    if (const auto count = address.turn_away(Crowding::connections, Bucket::Clock::now()))
        core_->log(fmt::format("event=connections_crowded address={} reason={} connections={} "
                               "of_address={} count={}",
                               address.name, reason, door.connections, address.connections, count));
    return made;
}

/// So that busy does not look like broken. It fits into any send buffer, and who has closed already does
/// not matter; over TLS nothing can be said before a handshake.
void say_busy(tcp::socket& socket, Core& core) {
    constexpr std::string_view page = "HTTP/1.1 503 Service Unavailable\r\n"
                                      "Server: seaway/" SEAWAY_VERSION "\r\n"
                                      "Content-Type: text/plain; charset=utf-8\r\n"
                                      "Cache-Control: no-store\r\n"
                                      "Retry-After: 1\r\n"
                                      "Connection: close\r\n"
                                      "Content-Length: 42\r\n\r\n"
                                      "too many connections, try again in a while";
    ++core.counters.http_responses[503];
    error_code ignored;
    socket.non_blocking(true, ignored);
    socket.write_some(asio::buffer(page.data(), page.size()), ignored);
    socket.shutdown(tcp::socket::shutdown_send, ignored);
    // A request that is there already: unread, it would have the page thrown away.
    std::array<char, 4096> unseen;
    socket.read_some(asio::buffer(unseen), ignored);
}

void NetServer::Impl::take_public(tcp::socket socket, const tcp::endpoint& from) {
    const AddressPtr address =
        core_->addresses.of(from.address().to_string(), Bucket::Clock::now());
    if (!make_room(*address)) {
        if (!tls_)
            say_busy(socket, *core_);
        return; // closed by its destructor
    }
    ++core_->counters.connections_accepted;
    sockets::Socket taken =
        tls_ ? sockets::Socket(std::move(socket), *tls_) : sockets::Socket(std::move(socket));
    Peer peer = peer_of(endpoint_of(from), address, taken.has_tls());
    serve_http(ConnectionSlot(core_, core_->door, address), std::move(taken), std::move(peer));
}

void NetServer::Impl::take_health(tcp::socket socket, const tcp::endpoint& from) {
    Door& door = core_->health_door;
    if (door.connections >= core_->options.health_connections_max &&
        !door.awaiting_requests.give_up_of(*health_address_))
        return;
    serve_http(ConnectionSlot(core_, door, health_address_), sockets::Socket(std::move(socket)),
               peer_of(endpoint_of(from), health_address_, false));
}

void NetServer::Impl::hand_over(const std::string& why, const std::string& in_general) {
    core_->post([core = core_.get(), why, told = "the server hands over: " + in_general] {
        if (core->stopping)
            return;
        core->begin_to_hand_over(why);
        for_each_session(*core, [&told](Session& session) {
            session.close(wire::ErrorCode::shutting_down, told);
        });
    });
}

void NetServer::Impl::begin_stop() {
    core_->begin_to_stop();
    drained_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                  std::chrono::duration<double>(core_->options.drain_s));
    come_to_an_end();
}

/// Sends away whoever has been answered, or after options.drain_s everybody. Ends when the last connection
/// has said goodbye, or at its deadline; until then those who come are told that the server stops.
void NetServer::Impl::come_to_an_end() {
    stop_timer_.expires_after(std::chrono::milliseconds(10));
    stop_timer_.async_wait([this](error_code) { come_to_an_end(); });
    const bool drained = Clock::now() >= drained_;
    for_each_session(*core_, [drained](Session& session) {
        if (drained || !session.is_owed())
            session.close(wire::ErrorCode::shutting_down, "the server stops");
    });
    const Door& door = core_->door;
    const bool served =
        door.connections + door.answered <= static_cast<int>(door.awaiting_requests.size());
    if (served || Clock::now() >= drained_ + core_->options.stop_deadline) {
        public_.close();
        health_.close();
        io_.stop();
    }
}

void NetServer::Impl::stop() {
    if (thread_.joinable()) {
        asio::post(io_, [this] { begin_stop(); });
        thread_.join();
    }
    core_->encoding.stop();
    core_->spectra.stop();
    core_->detach();
    core_->map_places.stop();
    core_->waiting_for_maps.clear();
    core_->turns.clear();
    core_->disposal.stop(); // maps hold the core, and its last holder must not be its own thread
}

// ---- NetServer -----------------------------------------------------------------------------

Result<void> NetServer::check(const NetOptions& options) {
    SEAWAY_TRY_LET(const Endpoint endpoint, read_endpoint("--listen", options.listen));
    if (!options.health_listen.empty()) {
        SEAWAY_TRY_LET(const Endpoint health,
                       read_endpoint("--health-listen", options.health_listen));
        if (meet(endpoint, health))
            return Error{fmt::format("--health-listen {}: --listen {} has that port already; give "
                                     "it one of its own",
                                     options.health_listen, options.listen)};
    }
    if (const Result<Origins> origins = Origins::read(options.allowed_origins); !origins)
        return origins.error();
    const Result<Credentials> credentials = load_credentials(options);
    return credentials ? Result<void>() : credentials.error();
}

Result<void> NetServer::check_addresses(const NetOptions& options) {
    for (const auto& [flag, where] :
         {std::pair{"--listen", &options.listen}, {"--health-listen", &options.health_listen}})
        if (!where->empty()) {
            SEAWAY_TRY_LET(const Endpoint endpoint, read_endpoint(flag, *where));
            SEAWAY_TRY(check_address(flag, endpoint));
        }
    return {};
}

Result<std::unique_ptr<NetServer>> NetServer::start(const NetOptions& options, Host& host) {
    auto impl = std::make_unique<Impl>(options, host);
    SEAWAY_TRY(impl->start());
    return std::unique_ptr<NetServer>(new NetServer(std::move(impl)));
}

NetServer::NetServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
NetServer::~NetServer() = default;
NetServer::Reloaded NetServer::reload() {
    return impl_->reload();
}
int NetServer::port() const {
    return impl_->port();
}
std::chrono::steady_clock::duration NetServer::silence() {
    return impl_->silence();
}
int NetServer::health_port() const {
    return impl_->health_port();
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
void NetServer::hand_over(const std::string& why, const std::string& why_in_general) {
    impl_->hand_over(why, why_in_general);
}
void NetServer::stop() {
    impl_->stop();
}

} // namespace seaway::server
