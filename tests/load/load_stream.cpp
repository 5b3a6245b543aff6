// SPDX-License-Identifier: Apache-2.0
// Load of one NetServer on loopback: N subscribers of whom S never read, keyframes of 64 x 64 at a
// fixed rate for a few seconds. Prints one CSV row: what the healthy ones saw (age of a keyframe
// when its last tile had arrived, gaps), processor time and memory of this process - server and
// clients together -, and the server's own counters. Bounded: ends by itself.
//
//     load_stream SUBSCRIBERS STALLED KEYFRAMES_PER_SECOND SECONDS
#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <string>
#include <thread>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include "server/net/server.h"
#include "tests/server/simulation/small_sea.h"

using namespace seaway;
using Clock = std::chrono::steady_clock;

namespace {

/// One WebSocket client by hand over a bare socket: the load must not cost more than the server.
class Peer {
  public:
    Peer(int port, bool reads) : reads_(reads), socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
        if (!reads) {
            const int bytes = 4096;
            ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
        }
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(static_cast<std::uint16_t>(port));
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        ok_ = ::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
        say("GET /v1/stream HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: Upgrade\r\nUpgrade: "
            "websocket\r\n"
            "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
            "Sec-WebSocket-Protocol: seaway.v1\r\n\r\n");
        std::string header;
        char c = 0;
        while (ok_ && header.find("\r\n\r\n") == std::string::npos && ::read(socket_, &c, 1) == 1)
            header.push_back(c);
        frame(protocol::hello("load", ""));
        frame(protocol::subscribe(1, {.fields = sea::surface_fields}, 4));
    }
    ~Peer() { ::close(socket_); }
    Peer(const Peer&) = delete;
    Peer& operator=(const Peer&) = delete;

    int handle() const { return socket_; }
    bool reads() const { return reads_; }

    /// Takes what has arrived; calls `on_message` with each complete message.
    template <class OnMessage>
    bool take(OnMessage on_message) {
        std::uint8_t some[65536];
        const ssize_t count = ::recv(socket_, some, sizeof some, MSG_DONTWAIT);
        if (count <= 0)
            return count < 0 && (errno == EAGAIN || errno == EINTR);
        bytes_.insert(bytes_.end(), some, some + count);
        std::size_t at = 0;
        while (bytes_.size() - at >= 2) {
            std::size_t header = 2;
            std::size_t length = bytes_[at + 1] & 0x7f;
            const std::size_t wide = length == 126 ? 2 : length == 127 ? 8 : 0;
            if (bytes_.size() - at < header + wide)
                break;
            if (wide > 0)
                length = 0;
            for (std::size_t i = 0; i < wide; ++i)
                length = length << 8 | bytes_[at + header + i];
            header += wide;
            if (bytes_.size() - at < header + length)
                break;
            if ((bytes_[at] & 0x0f) == 2)
                on_message(std::span(bytes_).subspan(at + header, length));
            at += header + length;
        }
        bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(at));
        return true;
    }
    void frame(const protocol::Bytes& message) {
        protocol::Bytes out{0x82, static_cast<std::uint8_t>(0x80 | message.size()), 0, 0, 0, 0};
        if (message.size() > 125)
            out = {0x82,
                   0xfe,
                   static_cast<std::uint8_t>(message.size() >> 8),
                   static_cast<std::uint8_t>(message.size()),
                   0,
                   0,
                   0,
                   0};
        out.insert(out.end(), message.begin(), message.end());
        say({reinterpret_cast<const char*>(out.data()), out.size()});
    }

    protocol::MessageReader reader{protocol::Sender::server};
    std::array<std::int64_t, 2> last{};
    int tiles = 0; ///< of the keyframe that is arriving

  private:
    void say(std::string_view text) {
        if (::send(socket_, text.data(), text.size(), MSG_NOSIGNAL) < 0)
            ok_ = false;
    }
    bool reads_;
    int socket_;
    bool ok_ = false;
    std::vector<std::uint8_t> bytes_;
};

double resident_mb() {
    std::ifstream in("/proc/self/statm");
    double total = 0;
    double resident = 0;
    in >> total >> resident;
    return resident * 4096 / 1e6;
}

double processor_seconds() {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

struct Seen {
    std::vector<double> age_ms;
    std::uint64_t bytes = 0;
    std::uint64_t gaps = 0;
};

/// When each keyframe was published: index n.
using Published = std::vector<std::atomic<std::int64_t>>;

void on_message(Peer& peer, std::span<const std::uint8_t> bytes, const Published& published,
                Seen& seen) {
    seen.bytes += bytes.size();
    const auto message = peer.reader.read(bytes);
    const wire::Tile* tile = message ? (*message)->body_as_Tile() : nullptr;
    if (tile == nullptr)
        return;
    const std::int64_t n = tile->time_us() / tests::interval_us;
    if (++peer.tiles % sea::surface_fields.size() != 0)
        return;
    peer.frame(protocol::ack(tile->keyframe()));
    if (n < 2) // the start of the subscription
        return;
    auto& last = peer.last.at(tile->cascade());
    seen.gaps += last != 0 && n != last + 1 ? 1 : 0;
    last = n;
    const std::int64_t now = Clock::now().time_since_epoch().count();
    seen.age_ms.push_back(1e-6 *
                          static_cast<double>(now - published.at(static_cast<std::size_t>(n))));
}

Seen read_all(std::vector<std::unique_ptr<Peer>>& peers, const Published& published,
              Clock::time_point end) {
    Seen seen;
    std::vector<pollfd> handles;
    for (const auto& peer : peers)
        handles.push_back({.fd = peer->handle(),
                           .events = peer->reads() ? short{POLLIN} : short{0},
                           .revents = 0});
    while (Clock::now() < end) {
        ::poll(handles.data(), handles.size(), 20);
        for (std::size_t i = 0; i < peers.size(); ++i)
            if (handles[i].revents != 0 && peers[i]->reads())
                (void)peers[i]->take([&](std::span<const std::uint8_t> bytes) {
                    on_message(*peers[i], bytes, published, seen);
                });
    }
    std::sort(seen.age_ms.begin(), seen.age_ms.end());
    return seen;
}

double quantile(const std::vector<double>& sorted, double share) {
    return sorted.empty()
               ? -1
               : sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

int number(const char* text, int lo, int hi) {
    int value = -1;
    std::from_chars(text, text + std::char_traits<char>::length(text), value);
    if (value < lo || value > hi) {
        fmt::print(stderr, "{} is not a number from {} to {}\n", text, lo, hi);
        std::exit(2);
    }
    return value;
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 5) {
        fmt::print(stderr, "usage: load_stream SUBSCRIBERS STALLED KEYFRAMES_PER_SECOND SECONDS\n");
        return 2;
    }
    const int subscribers = number(argv[1], 1, 500);
    const int stalled = number(argv[2], 0, 500);
    const int rate = number(argv[3], 1, 100);
    const int seconds = number(argv[4], 1, 60);
    spdlog::set_level(spdlog::level::off);

    tests::SmallSea sea;
    sea.size = 64;
    server::NetOptions options;
    options.listen = "127.0.0.1:0";
    options.connections_per_address = 0; // all of them are here
    auto net = server::NetServer::start(options, sea);
    if (!net) {
        fmt::print(stderr, "{}\n", net.error().message);
        return 4;
    }
    std::vector<std::unique_ptr<Peer>> peers;
    for (int i = 0; i < subscribers + stalled; ++i)
        peers.push_back(std::make_unique<Peer>((*net)->port(), i >= stalled));

    const int frames = rate * seconds;
    Published published(static_cast<std::size_t>(frames) + 3);
    const double before_mb = resident_mb();
    const double before_s = processor_seconds();
    const auto begin = Clock::now() + std::chrono::milliseconds(500);
    std::thread simulation([&] {
        for (int frame = 0; frame < frames; ++frame) {
            std::this_thread::sleep_until(begin +
                                          frame * std::chrono::microseconds(1'000'000 / rate));
            const std::int64_t n = frame + 2;
            published.at(static_cast<std::size_t>(n)) = Clock::now().time_since_epoch().count();
            for (int cascade = 0; cascade < 2; ++cascade)
                (*net)->publish(sea.keyframe(cascade, n, sea::surface_fields));
        }
    });
    const Seen seen =
        read_all(peers, published, begin + std::chrono::seconds(seconds) + std::chrono::seconds(1));
    simulation.join();
    fmt::print("subscribers,stalled,keyframes_per_s,seconds,keyframes_seen,keyframes_expected,gaps,"
               "megabytes_per_s,age_ms_p50,age_ms_p99,age_ms_max,cores_used,resident_mb_grown\n");
    fmt::print("{},{},{},{},{},{},{},{:.1f},{:.2f},{:.2f},{:.2f},{:.2f},{:.1f}\n", subscribers,
               stalled, rate, seconds, seen.age_ms.size(), 2 * frames * subscribers, seen.gaps,
               1e-6 * static_cast<double>(seen.bytes) / seconds, quantile(seen.age_ms, 0.5),
               quantile(seen.age_ms, 0.99), quantile(seen.age_ms, 1),
               (processor_seconds() - before_s) / (seconds + 1.5), resident_mb() - before_mb);
    return 0;
}
