// SPDX-License-Identifier: Apache-2.0
#include <new>
#include <optional>
#include <span>
#include <vector>

#include <boost/asio/steady_timer.hpp>
#include <fmt/format.h>

#include "protocol/limits.h"
#include "server/net/connection.h"
#include "server/net/http_response.h"
#include "server/net/session.h"
#include "sockets/served_web_socket.h"
#include "sockets/upgrade.h"

namespace seaway::server {
namespace {

namespace asio = boost::asio;
using protocol::SharedBytes;
using sockets::error_code;
using sockets::WebSocketEnd;

/// A read buffer above this is given back after each message: a thousand idle sessions that once
/// sent a large query hold nothing.
constexpr std::size_t idle_buffer_bytes = 16 * 1024;
/// Messages go out together until they have so many bytes: what is begun cannot be replaced by what is newer, and
/// this much lies in the system's buffer of a slow reader anyway.
constexpr std::size_t gathered_bytes = 256 * 1024;
/// What one call to the system takes is 64 buffers, two a message.
constexpr std::size_t gathered_messages_max = 32;
/// For GoAway and the peer's answer to it. Who has answered may take http_deadline to go (ServedWebSocket::leave).
constexpr std::chrono::milliseconds close_deadline{1000};
/// Between two looks at what comes by and by.
constexpr std::chrono::milliseconds waves_pause{1000};

sockets::WebSocketOptions web_socket_options(const std::shared_ptr<Core>& core,
                                             const AddressPtr& address) {
    const NetOptions& options = core->options;
    const auto later = [weak = std::weak_ptr(core)](std::function<void()> work) {
        if (const std::shared_ptr<Core> alive = weak.lock())
            alive->turns.later(std::move(work));
    };
    const auto charge = [weak = std::weak_ptr(core), address](std::size_t bytes) {
        const auto now = Bucket::Clock::now();
        address->request_bytes.take(static_cast<double>(bytes), now);
        const std::chrono::milliseconds wait = address->request_bytes.wait_for(0, now);
        if (const std::shared_ptr<Core> alive = weak.lock(); alive && wait.count() > 0)
            ++alive->counters.reads_delayed;
        return wait;
    };
    return {.subprotocol = std::string(protocol::websocket_subprotocol),
            .program = "seaway/" SEAWAY_VERSION,
            .handshake_patience = options.http_deadline,
            .idle_patience = options.idle_timeout,
            .message_bytes_max = protocol::limits::client_message_bytes_max,
            .kept_buffer_bytes = idle_buffer_bytes,
            .charge = charge,
            .later = later};
}

class StreamConnection final : public Link,
                               public Sending,
                               public std::enable_shared_from_this<StreamConnection> {
  public:
    StreamConnection(ConnectionSlot slot, sockets::Socket socket, Peer peer, Standing standing)
        : slot_(std::move(slot)), upgrade_(slot_.core()), without_hello_(peer.address),
          ws_(std::move(socket), web_socket_options(slot_.core(), peer.address)),
          peer_(std::move(peer)), standing_(standing), hello_timer_(ws_.socket().get_executor()),
          write_timer_(ws_.socket().get_executor()), close_timer_(ws_.socket().get_executor()),
          waves_timer_(ws_.socket().get_executor()) {}

    void run(const sockets::Upgrade& upgrade) {
        if (standing_ == Standing::stranger)
            awaits_hello_.take(core().awaiting_hello, peer_.address, [weak = weak_from_this()] {
                if (const auto self = weak.lock())
                    self->make_room();
            });
        ws_.accept(upgrade,
                   [self = shared_from_this()](Result<void> done) { self->on_accepted(done); });
    }

    // ---- Link ------------------------------------------------------------------------------

    /// What the system takes at once costs no handler, no timer and no turn of the loop.
    void send_more() override {
        if (holds_back_ || sends() || sends_later_)
            return;
        sends_later_ = core().senders.later(shared_from_this());
        if (sends_later_ || !take_up())
            return;
        write();
        go_on_or_finish();
    }

    void send_held_back() override {
        if (std::exchange(holds_back_, false))
            send_more();
    }

    // ---- Sending ---------------------------------------------------------------------------

    bool take() noexcept override {
        sends_later_ = false;
        bool there = false;
        or_just_drop([&] { there = !sends() && take_up(); });
        return there;
    }
    void write() noexcept override {
        try {
            wrote_ = ws_.begin(spans_, same_) ? Wrote::all : Wrote::part;
        } catch (const std::bad_alloc&) {
            wrote_ = Wrote::nothing;
        }
    }
    void written() noexcept override {
        or_just_drop([&] { go_on_or_finish(); });
    }

    /// Closes the socket; whatever is under way ends with an error, and the last handler that goes
    /// takes this object with it.
    void drop() noexcept override {
        nothing_more();
        ws_.socket().close();
    }

    void close(SharedBytes go_away, wire::ErrorCode code, const std::string& why) override {
        closing_ = true;
        go_away_ = std::move(go_away);
        close_reason_ = {protocol::close_code(code), why};
        close_timer_.expires_after(close_deadline);
        close_timer_.async_wait([self = shared_from_this()](error_code error) {
            if (!error)
                self->drop();
        });
        send_more();
    }

  private:
    Core& core() { return *slot_.core(); }

    /// What goes out in one write: the last word, or what the session has to send. False: there is more.
    bool gather() {
        if (go_away_ != nullptr) {
            session_->count_sent(*go_away_);
            writing_.push_back(std::exchange(go_away_, nullptr));
            return true;
        }
        std::size_t bytes = 0;
        while (bytes < gathered_bytes && writing_.size() < gathered_messages_max) {
            SharedBytes message = session_->next_message();
            if (message == nullptr)
                return true;
            bytes += message->size();
            writing_.push_back(std::move(message));
        }
        return false;
    }
    /// What is to be sent, for write(). False: there is nothing.
    bool take_up() {
        took_all_ = gather();
        if (writing_.empty()) {
            go_on_or_close();
            return false;
        }
        spans_.clear();
        for (const SharedBytes& message : writing_)
            spans_.emplace_back(*message);
        const Outbox::Run& run = session_->outbox().run();
        same_ = run.of == nullptr || writing_.size() != session_->outbox().handed_out()
                    ? sockets::FileRange{}
                    : sockets::FileRange{run.of->file->handle(), run.begin, run.end - run.begin};
        return true;
    }
    void go_on_or_finish() {
        if (wrote_ == Wrote::nothing) // there is no memory for its headers
            return drop();
        if (wrote_ == Wrote::part)
            return finish();
        writing_.clear();
        session_->sent();
        go_on_or_close();
    }
    /// Something is being sent, or nothing will be any more.
    bool sends() const { return !writing_.empty() || goes_on_ || lost_; }
    void go_on_or_close() {
        if (!took_all_)
            go_on();
        else if (closing_)
            shake_hands();
        else
            await_waves();
    }
    /// What comes by and by comes to who says nothing, too.
    void await_waves() {
        if (awaits_waves_ || lost_ || !session_->awaits_waves())
            return;
        awaits_waves_ = true;
        waves_timer_.expires_after(waves_pause);
        waves_timer_.async_wait([weak = weak_from_this()](error_code error) {
            const std::shared_ptr<StreamConnection> self = weak.lock();
            if (self == nullptr || error)
                return;
            self->awaits_waves_ = false;
            self->or_drop([&] {
                if (self->lost_ || self->closing_)
                    return;
                self->session_->make_owed_spectra();
                self->send_more();
            });
        });
    }
    /// The reader is slower than we are: the rest as it takes it, write_timeout for each piece.
    void finish() {
        write_timer_.expires_after(core().options.write_timeout);
        write_timer_.async_wait([self = shared_from_this()](error_code error) {
            if (!error)
                self->or_drop([&] { self->write_overdue(); });
        });
        ws_.finish([self = shared_from_this()](const Result<bool>& all) {
            self->or_drop([&] { self->on_written(all); });
        });
    }
    /// With what else waits, after others have had their turn.
    void go_on() {
        goes_on_ = true;
        core().turns.later([self = shared_from_this()] {
            self->goes_on_ = false;
            self->or_drop([&] { self->on_sent(); });
        });
    }
    void on_sent() {
        if (lost_)
            return;
        read(); // may have been held back by replies that waited
        send_more();
    }
    void on_accepted(const Result<void>& accepted) {
        upgrade_.reset();
        if (lost_) // it has made room meanwhile
            return;
        if (!accepted) {
            ++core().counters.sessions_refused["bad_upgrade"];
            note_bad_peer(core(), peer_, "upgrade", accepted.error().message);
            return drop();
        }
        session_.emplace(core(), *this, peer_, standing_);
        if (core().stopping)
            return session_->close(wire::ErrorCode::shutting_down, "the server stops");
        hello_timer_.expires_after(core().options.hello_deadline);
        hello_timer_.async_wait([self = shared_from_this()](error_code waited) {
            if (!waited)
                self->session_->hello_overdue();
        });
        read();
    }

    /// For a newcomer, before its Hello.
    void make_room() {
        says_hello_no_more();
        if (session_)
            return or_drop([&] {
                session_->close(wire::ErrorCode::hello_expected,
                                "no Hello yet, and others want the place");
            });
        upgrade_.reset();
        ++core().counters.sessions_refused["gave_way"];
        drop();
    }

    void says_hello_no_more() {
        awaits_hello_.leave();
        without_hello_.reset();
    }

    void read() {
        if (reading_ || lost_ || (closing_ ? !shaking_ : !session_->wants_requests()))
            return;
        reading_ = true;
        ws_.read(
            [self = shared_from_this()](const Result<sockets::ServedWebSocket::Message>& message) {
                self->or_drop([&] { self->on_read(message); });
            });
    }

    template <class Work>
    void or_just_drop(Work work) noexcept {
        try {
            work();
        } catch (const std::bad_alloc&) {
            drop();
        }
    }
    /// A connection whose next step there is no memory for is over.
    template <class Work>
    void or_drop(Work work) {
        try {
            work();
        } catch (const std::bad_alloc&) {
            drop();
            throw;
        }
    }

    void on_read(const Result<sockets::ServedWebSocket::Message>& message) {
        reading_ = false;
        if (!message) {
            send_held_back();
            return on_lost(message.error());
        }
        holds_back_ = holds_back_ || message->more;
        const bool held_back = holds_back_;
        if (message->binary)
            session_->receive(message->bytes);
        else
            session_->close(wire::ErrorCode::bad_message, "a text message; only binary is spoken");
        if (session_->greeted() || session_->ended())
            says_hello_no_more();
        read();
        if (!held_back || (reading_ && message->more))
            return;
        send_held_back();
        read(); // no answer that has gone is in its way any more
    }

    void on_written(const Result<bool>& all) {
        if (all && !*all && !lost_)
            return finish();
        writing_.clear();
        session_->sent();
        write_timer_.cancel();
        if (!all)
            return on_lost(all.error());
        on_sent();
    }

    void write_overdue() {
        // Behind a stop of the whole process the handler waits already when the socket takes more, and can no longer be called off.
        const bool of_another = write_timer_.expiry() > std::chrono::steady_clock::now();
        if (writing_.empty() || lost_ || of_another)
            return;
        std::size_t bytes = 0;
        for (const SharedBytes& message : writing_)
            bytes += message->size();
        session_->end(protocol::name(wire::ErrorCode::too_slow),
                      fmt::format("{} bytes could not be sent within {} ms", bytes,
                                  core().options.write_timeout.count()));
        drop();
    }

    /// Read or write has failed: the connection is over. Says why, unless that is known already.
    void on_lost(const Error& error) {
        if (lost_)
            return;
        if (error.is(WebSocketEnd::closed)) {
            const auto [code, reason] = ws_.peer_close();
            session_->end(closed_by_client, fmt::format("code {} {}", code, reason));
        } else if (error.is(WebSocketEnd::silent)) {
            const bool stuck = !writing_.empty();
            session_->end(
                protocol::name(stuck ? wire::ErrorCode::too_slow : wire::ErrorCode::idle),
                fmt::format("nothing received for {} ms", core().options.idle_timeout.count()));
        } else if (error.is(WebSocketEnd::unread)) {
            session_->end(protocol::name(wire::ErrorCode::too_slow), error.message);
        } else if (error.is(WebSocketEnd::not_understood)) {
            session_->end(protocol::name(wire::ErrorCode::bad_message), error.message);
        } else {
            session_->end(disconnected, error.message);
        }
        if (error.is(WebSocketEnd::closed) || error.is(WebSocketEnd::not_understood))
            leave();
        else
            drop();
    }

    /// Nothing is read or sent any more but the last word. Who stays behind it makes room for a newcomer.
    void leave() {
        nothing_more();
        leaves_.emplace(slot_.door());
        awaits_end_.take(slot_.door().awaiting_requests, peer_.address, [weak = weak_from_this()] {
            if (const auto self = weak.lock()) {
                self->awaits_end_.leave();
                self->drop();
            }
        });
        ws_.leave([self = shared_from_this()] { self->drop(); });
    }
    void nothing_more() noexcept {
        lost_ = true;
        says_hello_no_more();
        hello_timer_.cancel();
        write_timer_.cancel();
        close_timer_.cancel();
        waves_timer_.cancel();
    }

    void shake_hands() {
        if (std::exchange(shaking_, true))
            return;
        ws_.close(close_reason_);
        read();
    }

    ConnectionSlot slot_;
    std::optional<UpgradeSlot> upgrade_; ///< until there is a session
    std::optional<Counted<&Address::without_hello>> without_hello_;
    sockets::ServedWebSocket ws_;
    Peer peer_;
    const Standing standing_;
    WaitingLine::Place awaits_hello_; ///< strangers only
    WaitingLine::Place awaits_end_;   ///< of the peer, which has been told
    std::optional<AnsweredSlot> leaves_;
    asio::steady_timer hello_timer_;
    asio::steady_timer write_timer_;
    asio::steady_timer close_timer_;
    asio::steady_timer waves_timer_;
    bool awaits_waves_ = false;
    std::optional<Session> session_;
    std::vector<SharedBytes> writing_;
    std::vector<std::span<const std::uint8_t>> spans_; ///< of those
    sockets::FileRange same_;                          ///< as those
    enum class Wrote { nothing, part, all };
    Wrote wrote_ = Wrote::nothing;
    bool took_all_ = true; ///< that there was
    SharedBytes go_away_;
    sockets::CloseReason close_reason_;
    bool goes_on_ = false;     ///< with sending, in a while
    bool sends_later_ = false; ///< with others
    bool reading_ = false;
    bool holds_back_ =
        false; ///< answers, for those of the next message, which comes within this handler
    bool closing_ = false;
    bool shaking_ = false;
    bool lost_ = false;
};

} // namespace

void serve_stream(ConnectionSlot slot, sockets::Socket socket, const sockets::Upgrade& upgrade,
                  Peer peer, Standing standing) {
    std::make_shared<StreamConnection>(std::move(slot), std::move(socket), std::move(peer),
                                       standing)
        ->run(upgrade);
}

} // namespace seaway::server
