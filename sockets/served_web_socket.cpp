// SPDX-License-Identifier: Apache-2.0
#include "sockets/served_web_socket.h"

#include <algorithm>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include <boost/asio/error.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/websocket.hpp>
#include <fmt/format.h>

#include "base/undo.h"
#include "sockets/frame_header.h"
#include "sockets/upgrade.h"

namespace seaway::sockets {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;

/// A slow reader is looked at each time that it has taken so much.
constexpr std::size_t piece_bytes = 64 * 1024;

struct ServedWebSocket::Impl : std::enable_shared_from_this<Impl> {
    using Clock = std::chrono::steady_clock;

    Impl(Socket of, const WebSocketOptions& its_options)
        : options(its_options), socket(std::move(of)), timer(socket.get_executor()),
          pause(socket.get_executor()),
          frames(options.message_bytes_max, options.kept_buffer_bytes) {}

    void watch_silence();
    void on_quiet();
    void receive(Read done);
    void receive_now(Read done);
    void on_received(error_code error, std::span<const std::uint8_t> bytes, Read done);
    void read_frames(std::span<const std::uint8_t> bytes, Read done);
    void keep(std::span<const std::uint8_t> bytes) { left.assign(bytes.begin(), bytes.end()); }
    void read_left_later(Read done);
    void read_left(Read done);
    void on_close(std::span<const std::uint8_t> payload, const Read& done);
    void not_understood(const Error& why, const Read& done);
    void send(std::vector<std::uint8_t> frame, std::function<void()> sent = nullptr);
    void send_pong(std::span<const std::uint8_t> payload);
    void give_up(WebSocketEnd why);
    Error broken(error_code error) const;

    const WebSocketOptions options;
    Socket socket;
    asio::steady_timer timer; ///< of silence, and of the end
    asio::steady_timer pause; ///< of a peer that has said too much
    std::size_t unpaid = 0;   ///< bytes received since it was charged
    std::uint64_t frames_paid = 0;
    FrameReader frames;
    Read wanted;                    ///< by a read() within the callback of another
    bool calling = false;           ///< such a callback
    std::vector<std::uint8_t> left; ///< received, and not looked at yet
    Clock::time_point heard = Clock::now();
    bool pinged = false; ///< since then
    bool receiving = false;
    std::optional<WebSocketEnd> given_up;
    bool closing = false; ///< a closing frame has been sent
    bool leaving = false;
    CloseReason peer_close;
    CloseReason last_word;                              ///< ours, of leave()
    std::optional<std::vector<std::uint8_t>> next_pong; ///< behind the one that is under way
    std::weak_ptr<Read>
        behind_pong; ///< of the pong that is under way; waits where there is a next one
    std::size_t frames_under_way = 0;     ///< of our own: pings, pongs and the last word
    Clock::time_point taken = {};         ///< one of them, or when the first one was begun
    std::vector<FrameHeader> headers;     ///< of what is being written
    std::vector<asio::const_buffer> rest; ///< of what was begun
};

// ---- the handshake -------------------------------------------------------------------------

void ServedWebSocket::accept(const Upgrade& upgrade, Done done) {
    // On the socket that stays: Beast's stream is gone when the answer is.
    auto stream = std::make_shared<websocket::stream<Socket&>>(impl_->socket);
    stream->set_option(websocket::stream_base::timeout{impl_->options.handshake_patience,
                                                       websocket::stream_base::none(), false});
    stream->set_option(
        websocket::stream_base::decorator([impl = impl_](websocket::response_type& response) {
            response.set(http::field::server, impl->options.program);
            response.set(http::field::sec_websocket_protocol, impl->options.subprotocol);
        }));
    auto* const beast_stream = stream.get();
    beast_stream->async_accept(upgrade.request, [impl = impl_, stream = std::move(stream),
                                                 done = std::move(done)](error_code error) {
        if (error)
            return done(Error{WebSocketEnd::broken, error.message()});
        impl->socket.expires_never();
        impl->socket.write_whole();
        impl->watch_silence();
        done({});
    });
}

// ---- silence -------------------------------------------------------------------------------

/// One timer that looks when silence could have lasted too long, not one that each message puts off.
void ServedWebSocket::Impl::watch_silence() {
    timer.expires_at(heard + (pinged ? options.idle_patience : options.idle_patience / 2));
    timer.async_wait([weak = weak_from_this()](error_code error) {
        if (const std::shared_ptr<Impl> self = weak.lock(); self != nullptr && !error)
            self->on_quiet();
    });
}

void ServedWebSocket::Impl::on_quiet() {
    if (leaving)
        return; // the timer is leave()'s, and this call of it was on its way before
    if (!receiving)
        heard = Clock::now(); // nobody listens
    // Nor did a process that stood still, or its machine, who knows since when: the peer is asked anew.
    if (Clock::now() - timer.expiry() > options.idle_patience / 4) {
        heard = std::max(heard, Clock::now() - options.idle_patience / 2);
        taken = std::max(taken, Clock::now() - options.idle_patience / 2);
        pinged = false;
    }
    if (frames_under_way > 0 && Clock::now() - taken >= options.idle_patience)
        return give_up(WebSocketEnd::unread);
    const auto quiet = Clock::now() - heard;
    if (quiet >= options.idle_patience)
        return give_up(WebSocketEnd::silent);
    const bool ask = quiet >= options.idle_patience / 2 && !std::exchange(pinged, true);
    watch_silence(); // first: for a ping there may be no memory
    if (ask)
        send(control_frame(FrameReader::Kind::ping, {}));
}

/// Whoever reads is told; where nobody does, messages are stuck as well, of which their sender keeps the time.
void ServedWebSocket::Impl::give_up(WebSocketEnd why) {
    given_up = why;
    if (receiving)
        return socket.stop_receiving();
    watch_silence();
    const std::shared_ptr<Read> waits = behind_pong.lock();
    if (waits == nullptr || !*waits)
        return;
    const Read done = std::exchange(*waits, nullptr);
    done(broken({}));
}

// ---- reading -------------------------------------------------------------------------------

void ServedWebSocket::read(Read done) {
    Impl& impl = *impl_;
    if (impl.calling) {
        impl.wanted = std::move(done); // of whoever called, who goes on
        return;
    }
    if (impl.left.empty())
        return impl.receive(std::move(done));
    impl.read_left_later(std::move(done));
}

void ServedWebSocket::Impl::read_left_later(Read done) {
    try {
        auto work = [self = shared_from_this(), done = std::move(done)]() mutable {
            self->read_left(std::move(done));
        };
        if (options.later)
            options.later(std::move(work));
        else
            asio::post(socket.get_executor(), std::move(work));
    } catch (const std::bad_alloc&) {
        socket.close(); // nothing would read on
        throw;
    }
}

void ServedWebSocket::Impl::read_left(Read done) {
    if (socket.descriptor() < 0) // closed while it waited
        return done(broken(asio::error::operation_aborted));
    const std::vector<std::uint8_t> bytes = std::exchange(left, {});
    read_frames(bytes, std::move(done));
}

/// From who leaves our answers lying nothing more is received: of pings, answers are all that he is sent.
void ServedWebSocket::Impl::receive(Read done) {
    if (const std::shared_ptr<Read> waits = behind_pong.lock(); waits != nullptr && next_pong) {
        *waits = std::move(done);
        return;
    }
    const std::uint64_t begun = frames.frames_begun();
    unpaid += received_frame_bytes * (begun - std::exchange(frames_paid, begun));
    const auto wait =
        options.charge ? options.charge(std::exchange(unpaid, 0)) : std::chrono::milliseconds{};
    if (wait.count() == 0)
        return receive_now(std::move(done));
    pause.expires_after(wait);
    pause.async_wait([self = shared_from_this(), done = std::move(done)](error_code) mutable {
        self->receive_now(std::move(done)); // one that was closed meanwhile says so
    });
}

void ServedWebSocket::Impl::receive_now(Read done) {
    receiving = true;
    socket.receive([self = shared_from_this(), done = std::move(done)](
                       error_code error, std::span<std::uint8_t> bytes) mutable {
        self->on_received(error, bytes, std::move(done));
    });
}

void ServedWebSocket::Impl::on_received(error_code error, std::span<const std::uint8_t> bytes,
                                        Read done) {
    receiving = false;
    if (error)
        return done(broken(error));
    heard = Clock::now();
    pinged = false;
    unpaid += bytes.size();
    read_frames(bytes, std::move(done));
}

Error ServedWebSocket::Impl::broken(error_code error) const {
    if (given_up == WebSocketEnd::silent)
        return {*given_up, "nothing was heard"};
    if (given_up)
        return {*given_up, fmt::format("pings and pongs could not be sent within {} ms",
                                       options.idle_patience.count())};
    return {WebSocketEnd::broken, error.message()};
}

/// One message a read(); what is left when nobody reads waits for the next, and what is left of many for its turn.
void ServedWebSocket::Impl::read_frames(std::span<const std::uint8_t> bytes, Read done) {
    for (int given = 0; done;) {
        if (given == messages_a_turn && !bytes.empty()) {
            keep(bytes);
            return read_left_later(std::move(done));
        }
        const Result<std::optional<FrameReader::Frame>> next = frames.next(bytes);
        if (!next)
            return not_understood(next.error(), done);
        if (!*next)
            return receive(std::move(done));
        const FrameReader::Frame& frame = **next;
        switch (frame.kind) {
        case FrameReader::Kind::close:
            return on_close(frame.bytes, done);
        case FrameReader::Kind::ping:
            send_pong(frame.bytes);
            break;
        case FrameReader::Kind::pong:
            break;
        case FrameReader::Kind::message: {
            struct Calling {
                bool& is;
                ~Calling() { is = false; }
            } const calls{calling = true};
            // What reads on may own this socket, and would be held by it for ever.
            Undo asked([&] { (void)std::exchange(wanted, nullptr); });
            const bool more = ++given < messages_a_turn && FrameReader::gives_message(bytes);
            std::exchange(done, nullptr)(Message{frame.bytes, frame.binary, more});
            asked.keep();
        }
            done = std::exchange(wanted, nullptr);
            break;
        }
    }
    keep(bytes);
}

void ServedWebSocket::Impl::not_understood(const Error& why, const Read& done) {
    last_word = {why.is(BadFrame::too_large) ? 1009u : 1002u, ""};
    done(Error{WebSocketEnd::not_understood, why.message});
}

void ServedWebSocket::Impl::on_close(std::span<const std::uint8_t> payload, const Read& done) {
    const Result<CloseReason> said = read_close(payload);
    if (!said)
        return not_understood(said.error(), done);
    peer_close = *said;
    last_word = {said->code, ""};
    done(Error{WebSocketEnd::closed, "closed by the peer"});
}

void ServedWebSocket::leave(std::function<void()> done) {
    Impl& impl = *impl_;
    impl.leaving = true;
    impl.timer.expires_after(impl.options.handshake_patience);
    impl.timer.async_wait([weak = impl.weak_from_this()](error_code error) {
        if (const std::shared_ptr<Impl> self = weak.lock(); self != nullptr && !error)
            self->socket.close();
    });
    const auto part = [self = impl_, done = std::move(done)] {
        self->socket.part(self->options.handshake_patience, [self, done] {
            self->timer.cancel();
            done();
        });
    };
    if (std::exchange(impl.closing, true))
        return part();
    impl.send(close_frame(impl.last_word), part);
}

// ---- writing -------------------------------------------------------------------------------

/// Behind what is being written, whole.
void ServedWebSocket::Impl::send(std::vector<std::uint8_t> frame, std::function<void()> sent) {
    const auto held = std::make_shared<const std::vector<std::uint8_t>>(std::move(frame));
    socket.write_all({asio::buffer(*held)},
                     Socket::Bytes([weak = weak_from_this(), held,
                                    sent = std::move(sent)](error_code, std::size_t) mutable {
                         if (const std::shared_ptr<Impl> self = weak.lock()) {
                             --self->frames_under_way;
                             self->taken = Clock::now();
                         }
                         if (sent)
                             sent();
                     }));
    if (frames_under_way++ == 0)
        taken = Clock::now();
}

/// One at a time; of pings that come meanwhile the last one is answered (RFC 6455, 5.5.3).
void ServedWebSocket::Impl::send_pong(std::span<const std::uint8_t> payload) {
    std::vector<std::uint8_t> frame = control_frame(FrameReader::Kind::pong, payload);
    if (closing)
        return;
    if (!behind_pong.expired()) {
        next_pong = std::move(frame);
        return;
    }
    auto waits = std::make_shared<Read>();
    behind_pong = waits;
    send(std::move(frame), [weak = weak_from_this(), waits = std::move(waits)]() mutable {
        const Read reads = std::exchange(*waits, nullptr);
        waits.reset();
        const std::shared_ptr<Impl> self = weak.lock();
        if (self == nullptr)
            return;
        if (const auto next = std::exchange(self->next_pong, {}))
            self->send_pong(std::span(*next).subspan(2));
        if (reads)
            self->receive(reads);
    });
}

bool ServedWebSocket::begin(std::span<const std::span<const std::uint8_t>> messages,
                            const FileRange& same) {
    std::vector<FrameHeader>& headers = impl_->headers;
    headers.clear();
    headers.reserve(messages.size()); // which stay where they are
    std::vector<asio::const_buffer>& rest = impl_->rest;
    rest.clear();
    for (const std::span<const std::uint8_t> message : messages) {
        const FrameHeader& header = headers.emplace_back(message.size());
        rest.emplace_back(header.bytes.data(), header.size);
        rest.emplace_back(message.data(), message.size());
    }
    Socket& socket = impl_->socket;
    std::size_t taken = same.bytes > 0 ? socket.send_now(same) : socket.write_now(rest);
    auto first = rest.begin();
    for (; first != rest.end() && first->size() <= taken; ++first)
        taken -= first->size();
    rest.erase(rest.begin(), first);
    if (!rest.empty())
        rest.front() += taken;
    return rest.empty();
}

void ServedWebSocket::finish(Finished done) {
    std::vector<asio::const_buffer>& rest = impl_->rest;
    std::size_t bytes = 0, count = 0;
    // A header and its message are two buffers, so that an odd number is left where one has begun.
    while (count < rest.size() && (bytes < piece_bytes || (rest.size() - count) % 2 != 0))
        bytes += rest[count++].size();
    std::vector<asio::const_buffer> piece(rest.begin(), rest.begin() + static_cast<long>(count));
    rest.erase(rest.begin(), rest.begin() + static_cast<long>(count));
    impl_->socket.write_all(
        std::move(piece),
        Socket::Bytes([done = std::move(done), all = rest.empty()](error_code error, std::size_t) {
            done(error ? Result<bool>(Error{WebSocketEnd::broken, error.message()})
                       : Result<bool>(all));
        }));
}

void ServedWebSocket::close(const CloseReason& why) {
    if (!std::exchange(impl_->closing, true))
        impl_->send(close_frame(why));
}

// ---- ServedWebSocket -----------------------------------------------------------------------

ServedWebSocket::ServedWebSocket(Socket socket, const WebSocketOptions& options)
    : impl_(std::make_shared<Impl>(std::move(socket), options)) {}
ServedWebSocket::~ServedWebSocket() {
    if (impl_ == nullptr)
        return;
    impl_->timer.cancel();
    impl_->socket.close(); // what is under way holds the rest
}
ServedWebSocket::ServedWebSocket(ServedWebSocket&&) noexcept = default;

const CloseReason& ServedWebSocket::peer_close() const {
    return impl_->peer_close;
}
Socket& ServedWebSocket::socket() {
    return impl_->socket;
}

} // namespace seaway::sockets
