// SPDX-License-Identifier: Apache-2.0
#include "tests/support/fault_proxy.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <deque>
#include <list>
#include <optional>
#include <thread>
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>

#include "tests/support/draw.h"

namespace seaway::tests {

namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using Clock = std::chrono::steady_clock;
using error_code = boost::system::error_code;

constexpr std::size_t chunk_bytes = 4096;

struct Flip {
    std::uint64_t byte = 0;
    unsigned bit = 0;
};

/// What all connections of a proxy share; of its thread, but for the counts.
struct Line {
    LineFaults faults;
    bool stalled = false;
    Draw draw;
    std::optional<std::uint64_t> cut_after[2]; ///< of the next connection, by way
    std::optional<Flip> flip[2];
    std::atomic<int> open = 0;
    std::atomic<std::uint64_t> carried[2] = {0, 0};
};

class Pair;

/// One direction of a connection.
class OneWay {
  public:
    OneWay(Pair& pair, Line& line, int way, tcp::socket& from, tcp::socket& to)
        : pair_(pair), line_(line), way_(way), from_(from), to_(to), timer_(from.get_executor()),
          cut_after_(std::exchange(line.cut_after[way], std::nullopt)),
          flip_(std::exchange(line.flip[way], std::nullopt)) {}

    void read();
    void carry();
    void stop() { timer_.cancel(); }

  private:
    struct Chunk {
        std::vector<std::uint8_t> bytes;
        Clock::time_point due;
        bool last = false; ///< the connection breaks behind it
    };

    void took(std::size_t count);
    void spoil(std::vector<std::uint8_t>& bytes);

    Pair& pair_;
    Line& line_;
    const int way_;
    tcp::socket& from_;
    tcp::socket& to_;
    asio::steady_timer timer_;
    std::optional<std::uint64_t> cut_after_;
    std::optional<Flip> flip_;
    std::vector<std::uint8_t> buffer_ = std::vector<std::uint8_t>(chunk_bytes);
    std::deque<Chunk> held_;
    std::size_t held_bytes_ = 0;
    std::uint64_t come_ = 0; ///< bytes
    Clock::time_point last_due_{};
    Clock::time_point line_free_{};
    bool reading_ = false;
    bool writing_ = false;
    bool at_end_ = false; ///< nothing more will come
};

/// A client's connection and the one to the server. Lives while a handler holds it.
class Pair : public std::enable_shared_from_this<Pair> {
  public:
    Pair(Line& line, tcp::socket client)
        : line_(line), client_(std::move(client)), server_(client_.get_executor()) {
        ++line_.open;
    }
    ~Pair() { --line_.open; }
    Pair(const Pair&) = delete;
    Pair& operator=(const Pair&) = delete;

    void start(int server_port) {
        error_code error;
        server_.connect(
            {asio::ip::address_v4::loopback(), static_cast<unsigned short>(server_port)}, error);
        if (error)
            return reset();
        for (tcp::socket* socket : {&client_, &server_})
            socket->set_option(tcp::no_delay(true), error);
        // What a kernel holds is no part of the line.
        client_.set_option(asio::socket_base::send_buffer_size(32 * 1024), error);
        server_.set_option(asio::socket_base::receive_buffer_size(32 * 1024), error);
        up_.emplace(*this, line_, 0, client_, server_);
        down_.emplace(*this, line_, 1, server_, client_);
        up_->read();
        down_->read();
    }
    /// Both sides, so that neither thinks it an end in order.
    void reset() {
        error_code ignored;
        for (tcp::socket* socket : {&client_, &server_}) {
            socket->set_option(asio::socket_base::linger(true, 0), ignored);
            socket->close(ignored);
        }
        if (up_) {
            up_->stop();
            down_->stop();
        }
    }
    void go_on() {
        if (up_) {
            up_->carry();
            down_->carry();
        }
    }

  private:
    Line& line_;
    tcp::socket client_;
    tcp::socket server_;
    std::optional<OneWay> up_;
    std::optional<OneWay> down_;
};

void OneWay::read() {
    if (reading_ || at_end_ || held_bytes_ >= line_.faults.buffer_bytes)
        return;
    reading_ = true;
    from_.async_read_some(asio::buffer(buffer_), [this, pair = pair_.shared_from_this()](
                                                     error_code error, std::size_t count) {
        reading_ = false;
        if (error == asio::error::eof) {
            at_end_ = true;
            return carry();
        }
        if (error)
            return pair->reset();
        took(count);
    });
}

void OneWay::took(std::size_t count) {
    Chunk chunk{{buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(count)},
                Clock::now()};
    spoil(chunk.bytes);
    if (cut_after_ && come_ >= *cut_after_) {
        chunk.bytes.resize(chunk.bytes.size() - (come_ - *cut_after_));
        chunk.last = at_end_ = true;
    }
    const auto jitter = static_cast<double>(line_.faults.jitter.count());
    chunk.due += line_.faults.delay +
                 std::chrono::microseconds(std::llround(line_.draw.uniform(-jitter, jitter)));
    if (line_.faults.bytes_per_s > 0 && way_ == 1) {
        const std::chrono::duration<double> takes(static_cast<double>(count) /
                                                  line_.faults.bytes_per_s);
        line_free_ =
            std::max(line_free_, Clock::now()) + std::chrono::duration_cast<Clock::duration>(takes);
        chunk.due = std::max(chunk.due, line_free_ + line_.faults.delay);
    }
    last_due_ = chunk.due = std::max(chunk.due, last_due_);
    held_bytes_ += chunk.bytes.size();
    held_.push_back(std::move(chunk));
    carry();
    read();
}

void OneWay::spoil(std::vector<std::uint8_t>& bytes) {
    if (flip_ && flip_->byte >= come_ && flip_->byte < come_ + bytes.size())
        bytes[flip_->byte - come_] ^= static_cast<std::uint8_t>(1u << flip_->bit);
    come_ += bytes.size();
}

void OneWay::carry() {
    if (writing_ || line_.stalled || !to_.is_open())
        return;
    if (held_.empty()) {
        error_code ignored;
        if (at_end_)
            to_.shutdown(tcp::socket::shutdown_send, ignored);
        return;
    }
    writing_ = true;
    timer_.expires_at(held_.front().due);
    timer_.async_wait([this, pair = pair_.shared_from_this()](error_code waited) {
        writing_ = false;
        if (waited || line_.stalled)
            return;
        writing_ = true;
        asio::async_write(to_, asio::buffer(held_.front().bytes),
                          [this, pair](error_code error, std::size_t count) {
                              writing_ = false;
                              if (error || held_.front().last)
                                  return pair->reset();
                              line_.carried[way_] += count;
                              held_bytes_ -= count;
                              held_.pop_front();
                              read();
                              carry();
                          });
    });
}

} // namespace

struct FaultProxy::Impl {
    Impl(int port, const LineFaults& faults, std::uint64_t seed)
        : server_port(port), line{.faults = faults, .draw = Draw(seed)},
          acceptor(io, {asio::ip::address_v4::loopback(), 0}),
          taken(static_cast<int>(acceptor.local_endpoint().port())) {
        accept();
        thread = std::thread([this] { io.run(); });
    }
    ~Impl() {
        asio::post(io, [this] {
            acceptor.close();
            cut();
        });
        thread.join();
    }

    void accept() {
        acceptor.async_accept([this](error_code error, tcp::socket socket) {
            if (!acceptor.is_open())
                return;
            if (!error) {
                const auto pair = std::make_shared<Pair>(line, std::move(socket));
                pairs.remove_if([](const auto& known) { return known.expired(); });
                pairs.push_back(pair);
                pair->start(server_port);
            }
            accept();
        });
    }
    void cut() {
        for (const auto& known : pairs)
            if (const auto pair = known.lock())
                pair->reset();
        pairs.clear();
    }

    std::atomic<int> server_port;
    asio::io_context io{1};
    Line line;
    tcp::acceptor acceptor;
    const int taken;
    std::list<std::weak_ptr<Pair>> pairs;
    std::thread thread;
};

FaultProxy::FaultProxy(int server_port, LineFaults faults, std::uint64_t seed)
    : impl_(std::make_unique<Impl>(server_port, faults, seed)) {}
FaultProxy::~FaultProxy() = default;

void FaultProxy::lead_to(int server_port) {
    impl_->server_port = server_port;
}

int FaultProxy::port() const {
    return impl_->taken;
}

void FaultProxy::set(const LineFaults& faults) {
    asio::post(impl_->io, [this, faults] { impl_->line.faults = faults; });
}

void FaultProxy::stall(bool stalled) {
    asio::post(impl_->io, [this, stalled] {
        impl_->line.stalled = stalled;
        for (const auto& known : impl_->pairs)
            if (const auto pair = known.lock())
                pair->go_on();
    });
}

void FaultProxy::cut() {
    asio::post(impl_->io, [this] { impl_->cut(); });
}

void FaultProxy::cut_next_after(Way way, std::uint64_t bytes) {
    asio::post(impl_->io,
               [this, way, bytes] { impl_->line.cut_after[static_cast<int>(way)] = bytes; });
}

void FaultProxy::flip_next_at(Way way, std::uint64_t byte, unsigned bit) {
    asio::post(impl_->io, [this, way, byte, bit] {
        impl_->line.flip[static_cast<int>(way)] = Flip{byte, bit};
    });
}

int FaultProxy::connections() const {
    return impl_->line.open;
}

std::uint64_t FaultProxy::bytes_carried(Way way) const {
    return impl_->line.carried[static_cast<int>(way)];
}

} // namespace seaway::tests
