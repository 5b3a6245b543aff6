// SPDX-License-Identifier: Apache-2.0
#include "tests/load/swarm/mutator.h"

#include <poll.h>

#include "tests/load/swarm/peer.h"

namespace seaway::tests::swarm {

using protocol::Bytes;

Bytes Mutator::message() {
    const auto id = static_cast<std::uint32_t>(draw_.below(1000));
    const protocol::TileWish wish{
        .cascades = draw_.one_of({1u, 7u, 0xffffffffu}),
        .fields = sea::FieldSet::from_bits(static_cast<std::uint32_t>(draw_.below(1u << 13))),
        .error_m = 0.1f,
        .compact = draw_.below(2) == 0};
    switch (draw_.below(8)) {
    case 0:
        return protocol::hello("mutator", "");
    case 1:
        return protocol::subscribe(id, wish, 2);
    case 2:
        return protocol::unsubscribe();
    case 3:
        return protocol::ack(draw_.below(1000), std::vector<std::uint64_t>(draw_.below(10), 7));
    case 4: {
        std::vector<sea::TimeUs> times(draw_.below(9), 5'000'000);
        return protocol::fetch(id, times, wish);
    }
    case 5:
        return protocol::ping(id, 7);
    default: {
        std::vector<sea::QueryPoint> points(draw_.below(30), sea::QueryPoint{1, 2, 3'000'000});
        return protocol::query(id, points, draw_.below(4) == 0);
    }
    }
}

/// Bits flipped, bytes at the ends of their range, cut off, or a piece of another message.
Bytes Mutator::mutated(Bytes bytes) {
    switch (draw_.below(8)) {
    case 0:
        bytes.resize(draw_.below(bytes.size() + 1));
        return bytes;
    case 1: {
        const Bytes other = message();
        for (std::size_t i = draw_.below(other.size()); i < std::min(bytes.size(), other.size());
             ++i)
            bytes[i] = other[i];
        return bytes;
    }
    default:
        for (std::uint64_t changes = 1 + draw_.below(4); changes > 0; --changes) {
            std::uint8_t& byte = bytes[draw_.below(bytes.size())];
            byte = draw_.below(2) == 0 ? static_cast<std::uint8_t>(byte ^ (1u << draw_.below(8)))
                                       : draw_.one_of<std::uint8_t>({0, 1, 0x7f, 0x80, 0xff});
        }
        return bytes;
    }
}

std::uint64_t Mutator::attack(std::vector<std::uint8_t>& scratch) {
    Peer peer(port_, 0);
    Tally nobody;
    const Stage nothing;
    std::uint64_t sent = 0;
    for (std::uint64_t left = 1 + draw_.below(40); left > 0; --left) {
        if (draw_.below(50) == 0) { // no frame that a client sends
            const Bytes frame = mutated({0x82, 0x84, 0, 0, 0, 0, 1, 2, 3, 4});
            peer.say(frame.data(), frame.size());
        } else {
            peer.send(mutated(message()));
        }
        ++sent;
        if (!peer.take(scratch, nobody, nothing))
            return sent;
    }
    pollfd readable{.fd = peer.handle(), .events = POLLIN, .revents = 0};
    while (draw_.below(8) != 0 && ::poll(&readable, 1, 2) > 0)
        if (!peer.take(scratch, nobody, nothing))
            break;
    return sent;
}

} // namespace seaway::tests::swarm
