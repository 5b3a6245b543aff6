// SPDX-License-Identifier: Apache-2.0
// How a connection begins: a stream, hello, the first sea state.
#include <algorithm>

#include <fmt/format.h>

#include "client/link/connection.h"
#include "client/link/failure.h"

namespace seaway::client {

namespace {

using std::chrono::steady_clock;

/// How often who waits for a welcome looks whether it is to give up.
constexpr std::chrono::milliseconds stop_looks{50};

} // namespace

Result<std::unique_ptr<Connection>> Connection::begin(const ConnectOptions& options,
                                                      ConnectionEvents events,
                                                      const OpenStream& open_stream) {
    std::unique_ptr<Connection> connection(new Connection(std::move(events)));
    SEAWAY_TRY(connection->begin_opening(options, open_stream));
    return connection;
}

Result<std::unique_ptr<Connection>> Connection::open(const ConnectOptions& options,
                                                     ConnectionEvents events,
                                                     const OpenStream& open_stream) {
    SEAWAY_TRY_LET(std::unique_ptr<Connection> connection,
                   begin(options, std::move(events), open_stream));
    SEAWAY_TRY(connection->wait_for_sea());
    return connection;
}

Result<void> Connection::begin_opening(const ConnectOptions& options,
                                       const OpenStream& open_stream) {
    options_ = options;
    const Result<Url> url = parse_url(options.url);
    if (!url)
        return url.error();
    opening_until_ = steady_clock::now() + std::chrono::duration_cast<steady_clock::duration>(
                                               std::chrono::duration<double>(options.timeout_s));
    WebSocketOptions socket_options;
    socket_options.connect_timeout_s = options.timeout_s;
    socket_options.ca_file = options.ca_file;
    socket_options.stop = options.stop;
    socket_options.threadless = options.threadless;
    Result<std::unique_ptr<MessageStream>> stream = open_stream(*url, socket_options);
    if (!stream)
        return stream.error();
    stream_ = std::move(*stream);
    if (!options.threadless)
        hello_sent_us_ = local_now_us();
    stream_->start({[this](std::span<const std::uint8_t> bytes) { on_message(bytes); },
                    [this] { on_tick(); }, [this](const std::string& reason) { on_closed(reason); },
                    [this](const Result<void>& opened) { on_opened(opened); }});
    if (!options.threadless)
        say_hello();
    return {};
}

void Connection::say_hello() {
    stream_->send(protocol::hello(options_.name, options_.token));
}

void Connection::on_opened(const Result<void>& opened) {
    if (opened) {
        hello_sent_us_ = local_now_us();
        return say_hello();
    }
    const std::scoped_lock lock(opening_mutex_);
    not_opened_ = opened.error();
}

Result<void> Connection::wait_for_sea() {
    for (;;) {
        const auto look_again = std::min(opening_until_, steady_clock::now() + stop_looks);
        if (options_.threadless)
            stream_->work(look_again);
        std::unique_lock lock(opening_mutex_);
        if (!options_.threadless)
            opening_.wait_until(lock, look_again,
                                [this] { return end_ || (welcomed_ && sea_known_); });
        if (std::optional<Result<void>> how = opened_held())
            return *std::move(how);
    }
}

std::optional<Result<void>> Connection::opened() {
    const std::scoped_lock lock(opening_mutex_);
    return opened_held();
}

std::optional<Result<void>> Connection::opened_held() {
    if (not_opened_)
        return *not_opened_;
    if (end_) {
        Error why =
            failed(end_->is(Failure::for_good) ? Failure::for_good : Failure::cannot_connect,
                   fmt::format("{} turns us away: {}", options_.url, end_->message));
        why.retry_after_ms = end_->retry_after_ms;
        return why;
    }
    if (welcomed_ && sea_known_) {
        open_ = true;
        return Result<void>();
    }
    if (!options_.stop.stop_requested() && steady_clock::now() < opening_until_)
        return std::nullopt;
    return failed(Failure::cannot_connect,
                  fmt::format("{} accepts the connection but sends no {} in {} s", options_.url,
                              welcomed_ ? "sea state" : "welcome", options_.timeout_s));
}

} // namespace seaway::client
