// SPDX-License-Identifier: Apache-2.0
// MessageStream over a WebSocket: one io thread a connection, or who calls work(); callbacks on it, no locks.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <deque>
#include <exception>
#include <future>
#include <optional>
#include <thread>
#include <utility>

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <fmt/format.h>

#include "base/quiet_thread.h"
#include "base/thread_name.h"
#include "base/undo.h"
#include "client/link/failure.h"
#include "client/link/message_stream.h"
#include "client/link/tls_context.h"
#include "protocol/limits.h"
#include "sockets/name_lookup.h"
#include "sockets/web_socket.h"

namespace seaway::client {
namespace {

namespace asio = boost::asio;
using sockets::error_code;
using sockets::WebSocketEnd;
using std::chrono::milliseconds;

constexpr milliseconds tick_interval{50};
constexpr milliseconds close_patience{1000};
constexpr milliseconds work_at_once_max{10}; ///< of a call that does not wait
constexpr milliseconds reads_first_max{200}, reads_first_looks{5};
constexpr std::chrono::seconds idle_timeout{30};
constexpr unsigned normal_closure = 1000; // RFC 6455, 7.4.1

milliseconds to_milliseconds(double seconds) {
    return milliseconds(static_cast<std::int64_t>(seconds * 1e3));
}

sockets::WebSocketOptions web_socket_options(const WebSocketOptions& options) {
    return {.subprotocol = std::string(protocol::websocket_subprotocol),
            .program = options.user_agent,
            .handshake_patience = to_milliseconds(options.connect_timeout_s),
            .idle_patience = idle_timeout,
            .message_bytes_max = protocol::limits::server_message_bytes_max};
}

/// Runs on its own thread, or in work(), until closed. Every member but the atomics and io_ belongs to that.
class SocketStream final : public MessageStream {
  public:
    /// TLS if there is a context for it.
    SocketStream(const Url& url, const WebSocketOptions& options,
                 std::shared_ptr<asio::ssl::context> tls_context)
        : url_(url), options_(options), tls_context_(std::move(tls_context)),
          ws_(make_socket(), web_socket_options(options)), ticker_(io_), reads_first_timer_(io_) {}

    ~SocketStream() override { SocketStream::end(); }

    void end() override {
        close("closed by this client");
        if (options_.threadless) {
            const auto patience = std::chrono::steady_clock::now() + close_patience;
            while (!finished_ && std::chrono::steady_clock::now() < patience)
                work(patience);
        }
        if (thread_.joinable()) {
            if (over_.wait_for(close_patience) == std::future_status::timeout)
                io_.stop();
            thread_.join();
        }
    }

    Result<void> connect() {
        std::future<Result<void>> result = opened_.get_future();
        asio::post(io_, [this] { resolve(); });
        begin_thread();
        // Steps have their own time limits, but for the name, which the system takes as long for as it likes.
        const auto deadline = std::chrono::steady_clock::now() +
                              to_milliseconds(options_.connect_timeout_s) + close_patience;
        while (result.wait_for(tick_interval) == std::future_status::timeout) {
            const bool stopped = options_.stop.stop_requested();
            if (!stopped && std::chrono::steady_clock::now() < deadline)
                continue;
            io_.stop();
            return cannot_connect(
                stopped ? "given up by this client"
                        : fmt::format("{} in {} s", named_ ? "no answer" : "the name was not found",
                                      options_.connect_timeout_s));
        }
        return result.get();
    }

    void begin_thread() {
        const QuietThreads quiet;
        thread_ = std::thread([this] { run(); });
    }

    /// Of a stream without a thread, instead of connect().
    void begin() {
        asio::post(io_, [this] { resolve(); });
    }

    void work(std::chrono::steady_clock::time_point until) override {
        if (finished_)
            return;
        try {
            if (work_on_what_is_ready(until) == 0 && io_.run_one_until(until) > 0)
                work_on_what_is_ready(until);
        } catch (const std::exception& problem) {
            fail(problem);
        }
    }

    int descriptor() override { return open_ && !finished_ ? ws_.socket().descriptor() : -1; }

    void start(MessageStreamEvents events) override {
        if (options_.threadless) { // what follows is that it opens
            events_ = std::move(events);
            return;
        }
        asio::post(io_, [this, events = std::move(events)]() mutable {
            events_ = std::move(events);
            reading_ = true;
            read();
            tick();
        });
    }

    bool send(protocol::Bytes message) override {
        if (closing_)
            return true;
        const std::size_t bytes = message.size();
        Undo waits([&] { waiting_bytes_ -= bytes; });
        if (waiting_bytes_.fetch_add(bytes) + bytes > waiting_bytes_max)
            return false;
        asio::post(io_, [this, message = std::move(message)]() mutable {
            outbox_.push_back(std::move(message));
            if (!writing_ && open_)
                write();
        });
        waits.keep();
        return true;
    }

    void close(std::string reason) override {
        if (closing_.exchange(true))
            return;
        asio::post(io_, [this, why = std::move(reason)] { say_goodbye(why); });
    }

    void drop() override {
        closing_ = true;
        asio::post(io_, [this] { finish("dropped by this client"); });
    }

  private:
    sockets::Socket make_socket() {
        asio::ip::tcp::socket socket(io_);
        return tls_context_ ? sockets::Socket(std::move(socket), *tls_context_)
                            : sockets::Socket(std::move(socket));
    }

    Error cannot_connect(std::string_view why) const {
        return failed(Failure::cannot_connect,
                      fmt::format("cannot connect to {}://{}: {}", url_.tls ? "wss" : "ws",
                                  url_.authority(), why));
    }

    void run() {
        name_thread("sea-link");
        try {
            io_.run();
        } catch (const std::exception& problem) {
            fail(problem);
        }
        over_promise_.set_value();
    }

    void fail(const std::exception& problem) {
        if (!answered_)
            opened(cannot_connect(problem.what()));
        finish(fmt::format("the network's work failed: {}", problem.what()));
    }

    // ---- resolve, connect, TLS, WebSocket: each step begins the next ----

    void opened(Result<void> result) {
        answered_ = true;
        open_ = result.has_value();
        if (!options_.threadless)
            return opened_.set_value(std::move(result));
        if (!open_)
            finish({});
        if (events_.on_opened)
            events_.on_opened(result);
        if (!open_)
            return;
        reading_ = true;
        read();
        tick();
    }

    void resolve() {
        const auto resolved = [this](const Result<sockets::Socket::Endpoints>& endpoints) {
            if (!endpoints)
                return opened(cannot_connect(
                    fmt::format("the name does not resolve ({})", endpoints.error().message)));
            connect_to(*endpoints);
        };
        if (options_.threadless)
            return resolved(sockets::NameLookup::now(url_.host, url_.port));
        lookup_.begin(url_.host, url_.port, resolved);
    }

    void connect_to(const sockets::Socket::Endpoints& endpoints) {
        named_ = true;
        ws_.socket().expires_after(to_milliseconds(options_.connect_timeout_s));
        ws_.socket().connect(endpoints, [this](error_code problem) {
            if (problem)
                return opened(cannot_connect(problem.message()));
            ws_.socket().set_no_delay();
            if (!url_.tls)
                return shake_hands();
            ws_.socket().connect_tls(url_.host, [this](error_code refused) {
                if (refused)
                    return opened(cannot_connect("TLS: " + ws_.socket().words_of(refused)));
                shake_hands();
            });
        });
    }

    void shake_hands() {
        ws_.socket().expires_never(); // from here on the WebSocket keeps the time
        ws_.shake_hands(url_.authority(), url_.path, [this](const Result<void>& shaken) {
            if (shaken)
                return opened(shaken);
            Error why = cannot_connect(shaken.error().message);
            if (shaken.error().is(WebSocketEnd::declined))
                why.kind = Failure::for_good;
            why.retry_after_ms =
                std::min(shaken.error().retry_after_ms, protocol::limits::retry_after_ms_max);
            opened(why);
        });
    }

    // ---- from there on ----

    void read() {
        ws_.read([this](const Result<sockets::WebSocket::Message>& message) {
            if (!message)
                return finish(why_ended(message.error()));
            if (!message->binary)
                close("the server sent a text message");
            else if (!closing_)
                events_.on_message(message->bytes);
            if (finished_)
                return;
            read();
            look_what_waits();
        });
    }

    std::string why_ended(const Error& error) const {
        // What it said last, also where it then went without a word of TCP.
        if (const auto [code, reason] = ws_.peer_close();
            code != 0 || error.is(WebSocketEnd::closed)) {
            return reason.empty() ? fmt::format("the server closed the connection (code {})", code)
                                  : fmt::format("the server closed the connection (code {}: {})",
                                                code, reason);
        }
        if (error.is(WebSocketEnd::silent))
            return fmt::format("the server was silent for {} s", idle_timeout.count());
        return fmt::format("the connection broke ({})",
                           why_not_written_.empty() ? error.message : why_not_written_);
    }

    /// Of who talks without end, no longer than until then, or a few milliseconds: the next call goes on.
    std::size_t work_on_what_is_ready(std::chrono::steady_clock::time_point until) {
        const auto end = std::max(until, std::chrono::steady_clock::now() + work_at_once_max);
        std::size_t worked = 0;
        while (io_.poll_one() > 0) {
            ++worked;
            if (std::chrono::steady_clock::now() >= end)
                break;
        }
        return worked;
    }

    void write() {
        writing_ = !outbox_.empty() && !finished_;
        if (!writing_ || reads_first_)
            return;
        // A peer that has said its last word answers with a reset, after which nothing more can be read: so what it said comes
        // first, but for one that never ends.
        if (!ws_.socket().has_unread())
            return write_first();
        reads_first_ = true;
        reads_first_until_ = std::chrono::steady_clock::now() + reads_first_max;
        look_what_waits();
    }

    /// After what was read, and now and then: pings and parts of messages end no read.
    void look_what_waits() {
        if (!reads_first_ || finished_)
            return;
        if (!ws_.socket().has_unread() || std::chrono::steady_clock::now() >= reads_first_until_) {
            reads_first_ = false;
            reads_first_timer_.cancel();
            return write_first();
        }
        reads_first_timer_.expires_after(reads_first_looks);
        reads_first_timer_.async_wait([this](error_code gone) {
            if (!gone)
                look_what_waits();
        });
    }

    void write_first() {
        ws_.write(outbox_.front(), [this](const Result<void>& written) {
            if (!written) {
                writing_ = false; // the reader ends by it
                why_not_written_ = written.error().message;
                return;
            }
            waiting_bytes_ -= outbox_.front().size();
            outbox_.pop_front();
            write();
        });
    }

    void tick() {
        ticker_.expires_after(tick_interval);
        ticker_.async_wait([this](error_code gone) {
            if (gone || closing_ || finished_)
                return;
            events_.on_tick();
            tick();
        });
    }

    /// The reader ends with it, or the patience with a peer that does not answer.
    void say_goodbye(std::string reason) {
        if (!open_ || finished_)
            return finish(std::move(reason));
        goodbye_ = reason;
        ticker_.expires_after(close_patience);
        ticker_.async_wait([this, reason](error_code gone) {
            if (!gone)
                finish(reason);
        });
        ws_.close({normal_closure, {}}, [this, reason = std::move(reason)] { finish(reason); });
    }

    void finish(std::string reason) {
        if (finished_)
            return;
        finished_ = true;
        closing_ = true;
        work_.reset();
        ticker_.cancel();
        reads_first_timer_.cancel();
        ws_.socket().close();
        if (reading_)
            events_.on_closed(goodbye_.empty() ? std::move(reason) : goodbye_);
        io_.stop(); // the timer for silence would keep the thread for as long as it is patient
    }

    const Url url_;
    const WebSocketOptions options_;
    MessageStreamEvents events_;
    const std::shared_ptr<asio::ssl::context> tls_context_; ///< longer than what is under way
    asio::io_context io_{1};
    /// Keeps the thread until finish(), also where nothing is being waited for.
    std::optional<asio::executor_work_guard<asio::io_context::executor_type>> work_ =
        asio::make_work_guard(io_);
    sockets::NameLookup lookup_{io_};
    sockets::WebSocket ws_;
    asio::steady_timer ticker_;
    asio::steady_timer reads_first_timer_;
    bool reads_first_ = false; ///< a write waits until what is there has been read
    std::chrono::steady_clock::time_point reads_first_until_;
    std::deque<protocol::Bytes> outbox_;
    bool writing_ = false;
    bool answered_ = false; ///< opened_ has its value
    bool open_ = false;
    bool reading_ = false;
    bool finished_ = false;
    std::string goodbye_;
    std::string why_not_written_;
    std::atomic<bool> closing_ = false;
    std::atomic<bool> named_ = false; ///< addresses of the host's name are there
    std::atomic<std::size_t> waiting_bytes_ = 0;
    std::promise<Result<void>> opened_;
    std::promise<void> over_promise_;
    std::future<void> over_ = over_promise_.get_future();
    std::thread thread_;
};

Result<std::unique_ptr<MessageStream>>
open_stream(const Url& url, const WebSocketOptions& options,
            std::shared_ptr<asio::ssl::context> tls_context) {
    auto stream = std::make_unique<SocketStream>(url, options, std::move(tls_context));
    if (options.threadless)
        stream->begin();
    else
        SEAWAY_TRY(stream->connect());
    return std::unique_ptr<MessageStream>(std::move(stream));
}

} // namespace

Result<std::unique_ptr<MessageStream>> open_websocket(const Url& url,
                                                      const WebSocketOptions& options) {
    try {
        if (!url.tls)
            return open_stream(url, options, nullptr);
        Result<std::shared_ptr<asio::ssl::context>> context = tls_context(options.ca_file);
        if (!context)
            return context.error();
        return open_stream(url, options, std::move(*context));
    } catch (const std::exception& problem) {
        return failed(Failure::cannot_connect,
                      fmt::format("cannot connect to {}: {}", url.authority(), problem.what()));
    }
}

} // namespace seaway::client
