// SPDX-License-Identifier: Apache-2.0
// MessageStream over Boost.Beast: one io thread a connection, coroutines on it, no locks.
#include <atomic>
#include <chrono>
#include <deque>
#include <exception>
#include <future>
#include <optional>
#include <thread>
#include <type_traits>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/connect.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/field.hpp>
#include <boost/beast/ssl.hpp>
#include <boost/beast/websocket.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <fmt/format.h>

#include "client/failure.h"
#include "client/message_stream.h"
#include "protocol/limits.h"

namespace seaway::client {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using boost::system::error_code;
using std::chrono::milliseconds;

constexpr milliseconds tick_interval{50};
constexpr milliseconds close_patience{1000};
constexpr std::chrono::seconds idle_timeout{30};

using PlainStream = websocket::stream<beast::tcp_stream>;
using TlsStream = websocket::stream<beast::ssl_stream<beast::tcp_stream>>;

auto into(error_code& problem) {
    return asio::redirect_error(asio::use_awaitable, problem);
}

milliseconds to_milliseconds(double seconds) {
    return milliseconds(static_cast<std::int64_t>(seconds * 1e3));
}

/// Runs on its own thread until closed. Every member but the atomics and io_ belongs to it.
template <class Stream>
class WebSocket final : public MessageStream {
  public:
    static constexpr bool tls = std::is_same_v<Stream, TlsStream>;

    WebSocket(const Url& url, const WebSocketOptions& options,
              std::shared_ptr<asio::ssl::context> tls_context)
        : url_(url), options_(options), tls_context_(std::move(tls_context)), ws_(make_stream()),
          ticker_(io_) {}

    ~WebSocket() override {
        close("closed by this client");
        if (thread_.joinable()) {
            if (over_.wait_for(close_patience) == std::future_status::timeout)
                io_.stop();
            thread_.join();
        }
    }

    Result<void> connect() {
        std::promise<Result<void>> opened;
        std::future<Result<void>> result = opened.get_future();
        asio::co_spawn(io_, open(std::move(opened)), asio::detached);
        thread_ = std::thread([this] { run(); });
        // Steps have their own time limits; name resolution has none.
        const auto patience = to_milliseconds(options_.connect_timeout_s) + close_patience;
        if (result.wait_for(patience) == std::future_status::timeout) {
            io_.stop();
            return cannot_connect(fmt::format("no answer in {} s", options_.connect_timeout_s));
        }
        return result.get();
    }

    void start(MessageStreamEvents events) override {
        asio::post(io_, [this, events = std::move(events)]() mutable {
            events_ = std::move(events);
            reading_ = true;
            asio::co_spawn(io_, read_all(), asio::detached);
            asio::co_spawn(io_, tick(), asio::detached);
        });
    }

    bool send(protocol::Bytes message) override {
        const std::size_t bytes = message.size();
        if (closing_ || waiting_bytes_.fetch_add(bytes) + bytes > waiting_bytes_max) {
            if (!closing_)
                waiting_bytes_ -= bytes;
            return false;
        }
        asio::post(io_, [this, message = std::move(message)]() mutable {
            outbox_.push_back(std::move(message));
            if (!writing_ && open_) {
                writing_ = true;
                asio::co_spawn(io_, write_all(), asio::detached);
            }
        });
        return true;
    }

    void close(std::string reason) override {
        if (closing_.exchange(true))
            return;
        asio::post(io_, [this, reason = std::move(reason)]() mutable {
            asio::co_spawn(io_, say_goodbye(std::move(reason)), asio::detached);
        });
    }

  private:
    Stream make_stream() {
        if constexpr (tls)
            return Stream(io_, *tls_context_);
        else
            return Stream(io_);
    }

    Error cannot_connect(std::string_view why) const {
        return failed(Failure::cannot_connect,
                      fmt::format("cannot connect to {}://{}: {}", tls ? "wss" : "ws",
                                  url_.authority(), why));
    }

    void run() {
        try {
            io_.run();
        } catch (const std::exception& problem) {
            finish(fmt::format("the network thread failed: {}", problem.what()));
        }
        over_promise_.set_value();
    }

    asio::awaitable<void> open(std::promise<Result<void>> opened) {
        Result<void> result;
        try {
            result = co_await reach();
        } catch (const std::exception& problem) {
            result = cannot_connect(problem.what());
        }
        open_ = result.has_value();
        opened.set_value(std::move(result));
    }

    asio::awaitable<Result<void>> reach() {
        error_code problem;
        asio::ip::tcp::resolver resolver(io_);
        const auto endpoints = co_await resolver.async_resolve(url_.host, url_.port, into(problem));
        if (problem)
            co_return cannot_connect(
                fmt::format("the name does not resolve ({})", problem.message()));
        beast::tcp_stream& tcp = beast::get_lowest_layer(ws_);
        tcp.expires_after(to_milliseconds(options_.connect_timeout_s));
        co_await tcp.async_connect(endpoints, into(problem));
        if (problem)
            co_return cannot_connect(problem.message());
        tcp.socket().set_option(asio::ip::tcp::no_delay(true), problem);
        if constexpr (tls) {
            if (const Result<void> prepared = prepare_tls(); !prepared)
                co_return prepared.error();
            co_await ws_.next_layer().async_handshake(asio::ssl::stream_base::client,
                                                      into(problem));
            if (problem)
                co_return cannot_connect(fmt::format("TLS: {}", problem.message()));
        }
        tcp.expires_never(); // from here on the WebSocket keeps the time
        co_return co_await shake_hands();
    }

    Result<void> prepare_tls() {
        if constexpr (tls) {
            // What the macro SSL_set_tlsext_host_name does, without its old-style cast. Addresses
            // are no names (RFC 6066).
            error_code no_address;
            asio::ip::make_address(url_.host, no_address);
            std::string name = url_.host;
            if (no_address &&
                !SSL_ctrl(ws_.next_layer().native_handle(), SSL_CTRL_SET_TLSEXT_HOSTNAME,
                          TLSEXT_NAMETYPE_host_name, name.data()))
                return cannot_connect("TLS does not take the host name");
            ws_.next_layer().set_verify_mode(asio::ssl::verify_peer);
            ws_.next_layer().set_verify_callback(asio::ssl::host_name_verification(url_.host));
        }
        return {};
    }

    asio::awaitable<Result<void>> shake_hands() {
        ws_.set_option(websocket::stream_base::timeout{to_milliseconds(options_.connect_timeout_s),
                                                       idle_timeout, true});
        ws_.set_option(websocket::stream_base::decorator([this](websocket::request_type& request) {
            request.set(beast::http::field::user_agent, options_.user_agent);
            request.set(beast::http::field::sec_websocket_protocol,
                        beast::string_view(protocol::websocket_subprotocol.data(),
                                           protocol::websocket_subprotocol.size()));
        }));
        ws_.read_message_max(protocol::limits::server_message_bytes_max);
        ws_.binary(true);
        error_code problem;
        websocket::response_type response;
        co_await ws_.async_handshake(response, url_.authority(), url_.path, into(problem));
        if (problem == websocket::error::upgrade_declined)
            co_return cannot_connect(
                fmt::format("the server answers HTTP {} at {}", response.result_int(), url_.path));
        if (problem)
            co_return cannot_connect(
                fmt::format("this is no WebSocket server ({})", problem.message()));
        const auto chosen = response[beast::http::field::sec_websocket_protocol];
        if (std::string_view(chosen.data(), chosen.size()) != protocol::websocket_subprotocol)
            co_return cannot_connect(
                fmt::format("the server does not speak {}", protocol::websocket_subprotocol));
        co_return Result<void>();
    }

    asio::awaitable<void> read_all() {
        beast::flat_buffer buffer;
        while (!finished_) {
            error_code problem;
            co_await ws_.async_read(buffer, into(problem));
            if (problem) {
                finish(why_ended(problem));
                co_return;
            }
            if (!ws_.got_binary()) {
                close("the server sent a text message");
                continue;
            }
            const auto bytes = buffer.cdata();
            if (!closing_)
                events_.on_message({static_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
            buffer.clear();
        }
    }

    std::string why_ended(const error_code& problem) const {
        if (problem == websocket::error::closed) {
            const websocket::close_reason& reason = ws_.reason();
            return reason.reason.empty()
                       ? fmt::format("the server closed the connection (code {})",
                                     static_cast<unsigned>(reason.code))
                       : fmt::format("the server closed the connection (code {}: {})",
                                     static_cast<unsigned>(reason.code), reason.reason.c_str());
        }
        if (problem == beast::error::timeout)
            return fmt::format("the server was silent for {} s", idle_timeout.count());
        return fmt::format("the connection broke ({})", problem.message());
    }

    asio::awaitable<void> write_all() {
        while (!outbox_.empty() && !finished_) {
            error_code problem;
            co_await ws_.async_write(asio::buffer(outbox_.front()), into(problem));
            if (problem)
                break; // the reader finds out why
            waiting_bytes_ -= outbox_.front().size();
            outbox_.pop_front();
        }
        writing_ = false;
    }

    asio::awaitable<void> tick() {
        while (!finished_) {
            error_code problem;
            ticker_.expires_after(tick_interval);
            co_await ticker_.async_wait(into(problem));
            if (!finished_ && !closing_)
                events_.on_tick();
        }
    }

    /// The reader ends with it, or io_ is stopped when the peer does not answer.
    asio::awaitable<void> say_goodbye(std::string reason) {
        if (open_ && !finished_) {
            error_code problem;
            goodbye_ = reason;
            websocket::close_reason why(websocket::close_code::normal);
            ticker_.cancel();
            co_await ws_.async_close(why, into(problem));
        }
        finish(std::move(reason));
    }

    void finish(std::string reason) {
        if (finished_)
            return;
        finished_ = true;
        closing_ = true;
        work_.reset();
        ticker_.cancel();
        error_code ignored;
        beast::get_lowest_layer(ws_).socket().close(ignored);
        if (reading_)
            events_.on_closed(goodbye_.empty() ? std::move(reason) : goodbye_);
    }

    const Url url_;
    const WebSocketOptions options_;
    MessageStreamEvents events_;
    asio::io_context io_{1};
    /// Keeps the thread until finish(), also where nothing is being waited for.
    std::optional<asio::executor_work_guard<asio::io_context::executor_type>> work_ =
        asio::make_work_guard(io_);
    std::shared_ptr<asio::ssl::context> tls_context_;
    Stream ws_;
    asio::steady_timer ticker_;
    std::deque<protocol::Bytes> outbox_;
    bool writing_ = false;
    bool open_ = false;
    bool reading_ = false;
    bool finished_ = false;
    std::string goodbye_;
    std::atomic<bool> closing_ = false;
    std::atomic<std::size_t> waiting_bytes_ = 0;
    std::promise<void> over_promise_;
    std::future<void> over_ = over_promise_.get_future();
    std::thread thread_;
};

Result<std::shared_ptr<asio::ssl::context>> make_tls_context(const WebSocketOptions& options) {
    auto context = std::make_shared<asio::ssl::context>(asio::ssl::context::tls_client);
    error_code problem;
    context->set_options(asio::ssl::context::no_tlsv1 | asio::ssl::context::no_tlsv1_1, problem);
    context->set_default_verify_paths(problem);
    if (!options.ca_file.empty()) {
        context->load_verify_file(options.ca_file, problem);
        if (problem)
            return failed(Failure::bad_argument, fmt::format("certificates in '{}': {}",
                                                             options.ca_file, problem.message()));
    }
    return context;
}

template <class Stream>
Result<std::unique_ptr<MessageStream>>
open_stream(const Url& url, const WebSocketOptions& options,
            std::shared_ptr<asio::ssl::context> tls_context) {
    auto stream = std::make_unique<WebSocket<Stream>>(url, options, std::move(tls_context));
    SEAWAY_TRY(stream->connect());
    return std::unique_ptr<MessageStream>(std::move(stream));
}

} // namespace

Result<std::unique_ptr<MessageStream>> open_websocket(const Url& url,
                                                      const WebSocketOptions& options) {
    try {
        if (!url.tls)
            return open_stream<PlainStream>(url, options, nullptr);
        Result<std::shared_ptr<asio::ssl::context>> context = make_tls_context(options);
        if (!context)
            return context.error();
        return open_stream<TlsStream>(url, options, std::move(*context));
    } catch (const std::exception& problem) {
        return failed(Failure::cannot_connect,
                      fmt::format("cannot connect to {}: {}", url.authority(), problem.what()));
    }
}

} // namespace seaway::client
