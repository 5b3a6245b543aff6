// SPDX-License-Identifier: Apache-2.0
#include "sockets/socket.h"

#include <algorithm>
#include <array>
#include <deque>
#include <new>
#include <optional>
#include <utility>

#include <boost/asio/post.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/ssl.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <boost/beast/websocket/teardown.hpp>
#include <sys/sendfile.h>

#include "base/check.h"
#include "sockets/connecting.h"
#include "sockets/ready_set.h"

namespace seaway::sockets {

namespace asio = boost::asio;
namespace beast = boost::beast;

/// One of both. What is under way refers to it, also when the Socket has gone: TLS's operations keep references to the
/// stream, and those of sequences of buffers do of either. So every handler holds it (kept_until), and a Socket that goes
/// closes it, by which they all end.
struct Socket::Streams : std::enable_shared_from_this<Streams> {
    std::optional<beast::tcp_stream> plain;
    std::optional<beast::ssl_stream<beast::tcp_stream>> tls;

    beast::tcp_stream& tcp() { return tls ? tls->next_layer() : *plain; }

    template <class Handler>
    auto kept_until(Handler done) {
        return [self = shared_from_this(), done = std::move(done)](auto... values) mutable {
            done(values...);
        };
    }

    struct Write {
        std::vector<asio::const_buffer> buffers;
        Bytes done;
    };
    /// Held by the write that is under way alone, so that what waits ends with it.
    using Writes = std::deque<Write>;

    void write(Write write) {
        if (const std::shared_ptr<Writes> waiting = writes.lock())
            return waiting->push_back(std::move(write));
        const auto waiting = std::make_shared<Writes>();
        writes = waiting;
        begin(waiting, std::move(write));
    }
    void begin(const std::shared_ptr<Writes>& all, Write write) {
        const std::vector<asio::const_buffer> buffers = std::move(write.buffers);
        auto on_written = [self = shared_from_this(), waiting = std::shared_ptr<Writes>(all),
                           done = std::move(write.done)](error_code error,
                                                         std::size_t bytes) mutable {
            if (!self->tcp().socket().is_open()) {
                done(error, bytes);
                return end(*waiting);
            }
            if (!waiting->empty())
                self->begin(waiting, take_first(*waiting));
            waiting.reset();
            done(error, bytes);
        };
        if (tls)
            asio::async_write(*tls, buffers, std::move(on_written));
        else
            asio::async_write(*plain, buffers, std::move(on_written));
    }
    static Write take_first(Writes& waiting) {
        Write first = std::move(waiting.front());
        waiting.pop_front();
        return first;
    }
    /// Of a closed socket: none of them is begun any more.
    static void end(Writes& waiting) {
        while (!waiting.empty())
            take_first(waiting).done(asio::error::operation_aborted, 0);
    }

    void receive(Received done);
    void stop_receiving();
    void leave_ready_set();
    void say_later(Received done, error_code error);
    ~Streams() { stop_receiving(); }

    std::optional<Connecting::Clock::time_point> expiry; ///< as tcp() has it
    std::weak_ptr<Connecting> connecting;
    bool whole = false;
    std::weak_ptr<Writes> writes;
    ReadySet* ready = nullptr; ///< of a plain one that receives
    ReadySet::Id member = 0;
    std::vector<std::uint8_t> received; ///< of TLS
};

/// Of what a peer of TLS sends the layer below holds a record already.
constexpr std::size_t tls_received_bytes = 4 * 1024;

void Socket::Streams::receive(Received done) {
    if (tls) {
        received.resize(tls_received_bytes);
        tls->async_read_some(asio::buffer(received),
                             [self = shared_from_this(),
                              done = std::move(done)](error_code error, std::size_t bytes) {
                                 done(error, {self->received.data(), error ? 0 : bytes});
                             });
        return;
    }
    if (!plain->socket().is_open())
        return say_later(std::move(done), asio::error::operation_aborted);
    if (ready == nullptr) {
        auto& set = asio::use_service<ReadySet>(
            asio::query(plain->get_executor(), asio::execution::context));
        member = set.add(plain->socket().native_handle());
        ready = &set;
    }
    if (const error_code error = ready->receive(member, done))
        say_later(std::move(done), error);
}

void Socket::Streams::stop_receiving() {
    if (tls) {
        error_code ignored; // of one that is closed
        tcp().socket().cancel(ignored);
        return;
    }
    leave_ready_set();
}

void Socket::Streams::leave_ready_set() {
    if (ReadySet* set = std::exchange(ready, nullptr))
        set->remove(member);
}

void Socket::Streams::say_later(Received done, error_code error) {
    asio::post(plain->get_executor(), [done = std::move(done), error] { done(error, {}); });
}

Socket::Socket(asio::ip::tcp::socket socket) : streams_(std::make_shared<Streams>()) {
    streams_->plain.emplace(std::move(socket));
}

Socket::Socket(asio::ip::tcp::socket socket, asio::ssl::context& tls)
    : streams_(std::make_shared<Streams>()) {
    // Where OpenSSL has no memory for one more, Asio goes on with none, or throws what is no bad_alloc. One that is asked for
    // before shows that there is some; another thread may still take it.
    SSL* const one = SSL_new(tls.native_handle());
    if (one == nullptr)
        throw std::bad_alloc();
    SSL_free(one);
    try {
        streams_->tls.emplace(beast::tcp_stream(std::move(socket)), tls);
    } catch (const boost::system::system_error&) {
        throw std::bad_alloc();
    }
}

Socket::~Socket() {
    close();
}
Socket::Socket(Socket&&) noexcept = default;

Socket::executor_type Socket::get_executor() {
    return streams_->tcp().get_executor();
}

bool Socket::has_tls() const {
    return streams_->tls.has_value();
}

void Socket::connect(const Endpoints& endpoints, Done done) {
    const auto connecting = std::make_shared<Connecting>(
        get_executor(), endpoints,
        [streams = streams_,
         done = std::move(done)](error_code error, std::optional<asio::ip::tcp::socket> connected) {
            if (connected)
                streams->tcp().socket() = *std::move(connected);
            done(error);
        });
    streams_->connecting = connecting;
    connecting->begin(streams_->expiry);
}

void Socket::accept_tls(Done done) {
    streams_->tls->async_handshake(asio::ssl::stream_base::server,
                                   streams_->kept_until(std::move(done)));
}

void Socket::connect_tls(const std::string& host, Done done) {
    auto& tls = *streams_->tls;
    // What the macro SSL_set_tlsext_host_name does, without its old-style cast. Addresses are no
    // names (RFC 6066).
    error_code no_address;
    asio::ip::make_address(host, no_address);
    std::string name = host;
    if (no_address && name.ends_with('.')) // of the root, which stands in no certificate
        name.pop_back();
    if (no_address && !SSL_ctrl(tls.native_handle(), SSL_CTRL_SET_TLSEXT_HOSTNAME,
                                TLSEXT_NAMETYPE_host_name, name.data()))
        return asio::post(get_executor(), [done = std::move(done)] {
            done(make_error_code(boost::system::errc::invalid_argument));
        });
    tls.set_verify_mode(asio::ssl::verify_peer);
    tls.set_verify_callback(asio::ssl::host_name_verification(name));
    tls.async_handshake(asio::ssl::stream_base::client, streams_->kept_until(std::move(done)));
}

std::string Socket::words_of(const error_code& failed) const {
    const long found =
        streams_->tls ? SSL_get_verify_result(streams_->tls->native_handle()) : X509_V_OK;
    if (found == X509_V_OK)
        return failed.message();
    // All is well with it by itself.
    if (found == X509_V_ERR_UNSPECIFIED || found == X509_V_ERR_APPLICATION_VERIFICATION)
        return failed.message() + ": the certificate is of another name";
    return failed.message() + ": " + X509_verify_cert_error_string(found);
}

void Socket::expires_after(std::chrono::milliseconds patience) {
    streams_->expiry = Connecting::Clock::now() + patience;
    streams_->tcp().expires_after(patience);
}

void Socket::expires_never() {
    streams_->expiry.reset();
    streams_->tcp().expires_never();
}

void Socket::set_no_delay() {
    error_code ignored; // a socket that is gone already will say so when it is read
    streams_->tcp().socket().set_option(asio::ip::tcp::no_delay(true), ignored);
}

bool Socket::has_unread() const {
    error_code gone;
    return streams_->tcp().socket().available(gone) > 0;
}

void Socket::shutdown_send() {
    error_code ignored;
    streams_->tcp().socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
}

int Socket::descriptor() const {
    auto& socket = streams_->tcp().socket();
    return socket.is_open() ? socket.native_handle() : -1;
}

void Socket::close() {
    if (streams_ == nullptr)
        return; // given away
    streams_->stop_receiving();
    if (const auto connecting = streams_->connecting.lock())
        connecting->give_up();
    streams_->tcp().close();
}

void Socket::receive(Received done) {
    SEAWAY_CHECK(streams_->whole, "a layer above may have read ahead");
    streams_->receive(std::move(done));
}

void Socket::stop_receiving() {
    streams_->stop_receiving();
}

void Socket::read_some(FewBuffers<asio::mutable_buffer> buffers, Bytes done) {
    if (streams_->tls)
        streams_->tls->async_read_some(buffers, streams_->kept_until(std::move(done)));
    else
        streams_->plain->async_read_some(buffers, streams_->kept_until(std::move(done)));
}

void Socket::write_whole() {
    streams_->whole = true;
    error_code ignored;                                   // of a socket that is gone
    streams_->tcp().socket().non_blocking(true, ignored); // for write_now()
}

void Socket::write_all(std::vector<asio::const_buffer> buffers, Bytes done) {
    SEAWAY_CHECK(streams_->whole, "writes in pieces would come between");
    streams_->write({std::move(buffers), std::move(done)});
}

bool Socket::takes_writes_now() const {
    SEAWAY_CHECK(streams_->whole, "writes in pieces would come between");
    return !streams_->tls && streams_->writes.expired();
}

std::size_t Socket::send_now(const FileRange& range) {
    if (!takes_writes_now())
        return 0;
    auto at = static_cast<off_t>(range.begin);
    const ssize_t sent =
        ::sendfile(streams_->plain->socket().native_handle(), range.handle, &at, range.bytes);
    return sent < 0 ? 0 : static_cast<std::size_t>(sent);
}

std::size_t Socket::write_now(const std::vector<asio::const_buffer>& buffers) {
    if (!takes_writes_now())
        return 0;
    error_code later; // a system that takes nothing now, or a connection that is gone
    return streams_->plain->socket().write_some(buffers, later);
}

void Socket::write_some(FewBuffers<asio::const_buffer> buffers, Bytes done) {
    if (streams_->tls)
        streams_->tls->async_write_some(buffers, streams_->kept_until(std::move(done)));
    else
        streams_->plain->async_write_some(buffers, streams_->kept_until(std::move(done)));
}

// ---- the end -------------------------------------------------------------------------------

struct Socket::Parting : std::enable_shared_from_this<Parting> {
    Parting(std::shared_ptr<Streams> of, std::function<void()> done)
        : streams(std::move(of)), gone(std::move(done)) {}

    void take_the_rest() {
        streams->tcp().async_read_some(
            asio::buffer(unseen), [self = shared_from_this()](error_code error, std::size_t bytes) {
                self->left -= std::min(self->left, bytes);
                if (!error && self->left > 0)
                    return self->take_the_rest();
                self->streams->tcp().close();
                self->gone();
            });
    }

    const std::shared_ptr<Streams> streams;
    const std::function<void()> gone;
    std::size_t left = parted_bytes_max;
    std::array<char, 4096> unseen{};
};

void Socket::part(std::chrono::milliseconds patience, std::function<void()> gone) {
    streams_->leave_ready_set();
    expires_after(patience);
    const auto parting = std::make_shared<Parting>(streams_, std::move(gone));
    const auto after_tls = [parting](error_code) {
        error_code ignored; // of a peer that has gone already
        parting->streams->tcp().socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
        parting->take_the_rest();
    };
    if (streams_->tls) // which fails where the peer goes on
        streams_->tls->async_shutdown(after_tls);
    else
        after_tls({});
}

void Socket::tear_down(beast::role_type role, Completion<error_code> done) {
    using beast::websocket::async_teardown;
    if (streams_->tls)
        async_teardown(role, *streams_->tls, streams_->kept_until(std::move(done)));
    else
        async_teardown(role, *streams_->plain, streams_->kept_until(std::move(done)));
}

} // namespace seaway::sockets
