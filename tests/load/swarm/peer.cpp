// SPDX-License-Identifier: Apache-2.0
#include "tests/load/swarm/peer.h"

#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include "sea/surface/budget/spending.h"

namespace seaway::tests::swarm {

namespace {

/// As server/simulation/schedule.h has it: a keyframe is due its interval and this before its time.
constexpr std::size_t scratch_bytes = 1u << 20;

[[noreturn]] void give_up(const char* what) {
    std::perror(what);
    std::_Exit(4);
}

} // namespace

double clock_s() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

Peer::Peer(int port, int receive_buffer_bytes) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    const int yes = 1;
    ::setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    ::setsockopt(socket_, SOL_SOCKET, SO_TIMESTAMPNS, &yes, sizeof yes);
    if (receive_buffer_bytes > 0)
        ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receive_buffer_bytes,
                     sizeof receive_buffer_bytes);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
        give_up("a peer cannot connect");
    const std::string upgrade =
        "GET /v1/stream HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: Upgrade\r\n"
        "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
        "Sec-WebSocket-Protocol: seaway.v1\r\n\r\n";
    say(upgrade.data(), upgrade.size());
    std::string header;
    for (char c = 0; header.find("\r\n\r\n") == std::string::npos; header.push_back(c))
        if (::read(socket_, &c, 1) != 1)
            give_up("a peer is not answered");
    if (!header.starts_with("HTTP/1.1 101")) {
        std::fprintf(stderr, "a peer is not taken: %s\n",
                     header.substr(0, header.find('\r')).c_str());
        std::_Exit(4);
    }
    send(protocol::hello("swarm", ""));
    std::vector<std::uint8_t> scratch;
    Tally nobody;
    const Stage nothing;
    while (!welcomed_ || intervals_us_.empty())
        if (!take(scratch, nobody, nothing))
            give_up("a peer is sent away");
}

Peer::~Peer() {
    ::close(socket_);
}

void Peer::say(const void* bytes, std::size_t size) {
    (void)!::send(socket_, bytes, size, MSG_NOSIGNAL); // an end is seen by take()
}

/// Masked with zeros.
void Peer::send(const protocol::Bytes& message) {
    const std::size_t n = message.size();
    protocol::Bytes frame{0x82};
    if (n < 126) {
        frame.push_back(static_cast<std::uint8_t>(0x80 | n));
    } else {
        const int bytes = n < 65536 ? 2 : 8;
        frame.push_back(bytes == 2 ? 0xfe : 0xff);
        for (int byte = bytes - 1; byte >= 0; --byte)
            frame.push_back(static_cast<std::uint8_t>(n >> (8 * byte)));
    }
    frame.insert(frame.end(), 4, 0);
    frame.insert(frame.end(), message.begin(), message.end());
    say(frame.data(), frame.size());
}

bool Peer::take(std::vector<std::uint8_t>& scratch, Tally& tally, const Stage& stage) {
    const int how = welcomed_ && !intervals_us_.empty() ? MSG_DONTWAIT : 0;
    scratch.resize(scratch_bytes);
    const std::size_t before = rest_.size();
    std::copy(rest_.begin(), rest_.end(), scratch.begin());
    const ssize_t count = receive(std::span(scratch).subspan(before), how);
    if (count == 0)
        return false;
    if (count < 0)
        return errno == EAGAIN || errno == EINTR;
    const std::span<const std::uint8_t> all(scratch.data(),
                                            before + static_cast<std::size_t>(count));
    const std::span<const std::uint8_t> rest = all.subspan(parse(all, tally, stage));
    rest_.assign(rest.begin(), rest.end());
    return true;
}

/// With the time at which the system had the last of them, which it says by its clock of the day.
ssize_t Peer::receive(std::span<std::uint8_t> room, int how) {
    iovec where{.iov_base = room.data(), .iov_len = room.size()};
    alignas(cmsghdr) std::array<char, 256> words{};
    msghdr message{};
    message.msg_iov = &where;
    message.msg_iovlen = 1;
    message.msg_control = words.data();
    message.msg_controllen = words.size();
    const ssize_t count = ::recvmsg(socket_, &message, how);
    const double now_s = clock_s();
    there_s_ = now_s;
    for (cmsghdr* word = count > 0 ? CMSG_FIRSTHDR(&message) : nullptr; word != nullptr;
         word = CMSG_NXTHDR(&message, word)) {
        if (word->cmsg_level != SOL_SOCKET || word->cmsg_type != SCM_TIMESTAMPNS)
            continue;
        timespec came{};
        timespec day{};
        std::memcpy(&came, CMSG_DATA(word), sizeof came);
        ::clock_gettime(CLOCK_REALTIME, &day);
        there_s_ -= static_cast<double>(day.tv_sec - came.tv_sec) +
                    1e-9 * static_cast<double>(day.tv_nsec - came.tv_nsec);
    }
    return count;
}

/// The bytes of whole frames.
std::size_t Peer::parse(std::span<const std::uint8_t> bytes, Tally& tally, const Stage& stage) {
    std::size_t at = 0;
    while (bytes.size() - at >= 2) {
        std::size_t length = bytes[at + 1] & 0x7fu;
        const std::size_t wide = length == 126 ? 2 : length == 127 ? 8 : 0;
        const std::size_t head = 2 + wide;
        if (bytes.size() - at < head)
            break;
        if (wide > 0)
            length = 0;
        for (std::size_t i = 0; i < wide; ++i)
            length = length << 8 | bytes[at + 2 + i];
        if (bytes.size() - at < head + length)
            break;
        const unsigned kind = bytes[at] & 0x0fu;
        const auto payload = bytes.subspan(at + head, length);
        if (kind == 2) {
            on_message(payload, tally, stage);
        } else if (kind == 9) { // a ping
            protocol::Bytes pong{0x8a, static_cast<std::uint8_t>(0x80 | length), 0, 0, 0, 0};
            pong.insert(pong.end(), payload.begin(), payload.end());
            say(pong.data(), pong.size());
        }
        at += head + length;
    }
    return at;
}

/// The server is trusted: nothing is verified.
void Peer::on_message(std::span<const std::uint8_t> bytes, Tally& tally, const Stage& stage) {
    const wire::Message& message = *wire::GetMessage(bytes.data());
    if (stage.measure) {
        ++tally.messages;
        tally.bytes += bytes.size();
    }
    if (const auto* tile = message.body_as_Tile()) {
        on_tile(*tile, tally, stage);
    } else if (const auto* welcome = message.body_as_Welcome()) {
        welcomed_ = true;
        sea_time_us_ = welcome->sea_time_us();
        acknowledgements_.begin(welcome->keyframes_per_ack_max());
    } else if (const auto* state = message.body_as_SeaState()) {
        intervals_us_.clear();
        for (const wire::CascadeInfo* cascade : *state->cascades())
            intervals_us_.push_back(cascade->interval_us());
    } else if (const auto* subscribed = message.body_as_Subscribed()) {
        fields_ = subscribed->fields();
        say_ack(acknowledgements_.granted(subscribed->credit()), tally, stage);
    } else if (const auto* pong = message.body_as_Pong()) {
        sea_time_us_ = pong->sea_time_us();
        ++answers_;
    } else if (message.body_as_QueryReply() != nullptr) {
        ++answers_;
    } else if (message.body_as_Refused() != nullptr) {
        ++answers_;
        ++tally.refused;
    }
}

void Peer::on_tile(const wire::Tile& tile, Tally& tally, const Stage& stage) {
    if (tile.part() + 1 < tile.parts())
        return;
    std::uint32_t& come = begun_[tile.keyframe()];
    come |= 1u << static_cast<unsigned>(tile.field()) | tile.follows();
    if ((come & fields_) != fields_)
        return;
    begun_.erase(tile.keyframe());
    say_ack(acknowledgements_.complete(tile.keyframe()), tally, stage);
    on_keyframe(tile, tally, stage);
}

void Peer::say_ack(const std::optional<protocol::Bytes>& ack, Tally& tally, const Stage& stage) {
    if (!ack)
        return;
    send(*ack);
    if (stage.measure)
        ++tally.acks;
}

void Peer::on_keyframe(const wire::Tile& tile, Tally& tally, const Stage& stage) {
    const std::int64_t interval = interval_us(tile.cascade());
    std::int64_t& newest = newest_us_[tile.cascade()];
    if (stage.measure) {
        ++tally.keyframes;
        if (newest != 0 && tile.time_us() > newest + interval)
            tally.lost += static_cast<std::uint64_t>((tile.time_us() - newest) / interval - 1);
        const double due_s =
            1e-6 * static_cast<double>(tile.time_us() - interval - sea::publish_lead_us);
        tally.age.add(clock_s() + stage.sea_minus_clock_s - due_s);
        tally.age_there.add(there_s_ + stage.sea_minus_clock_s - due_s);
    }
    newest = std::max(newest, tile.time_us());
}

} // namespace seaway::tests::swarm
