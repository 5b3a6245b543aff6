// SPDX-License-Identifier: Apache-2.0
// Peer: one WebSocket session of a swarm over a bare socket, as cheap as can be: a load must not cost more
// than the server that it is for. It takes what comes, acknowledges whole keyframes as our clients do, and says what it
// has seen of them; it decodes nothing.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "client/held/acknowledgements.h"
#include "protocol/messages.h"
#include "tests/load/swarm/tally.h"

namespace seaway::tests::swarm {

class Peer {
  public:
    /// Connects and waits for Welcome. `receive_buffer_bytes`: 0 leaves the system's. Ends the process
    /// with a line if there is no such server.
    Peer(int port, int receive_buffer_bytes);
    ~Peer();
    Peer(const Peer&) = delete;
    Peer& operator=(const Peer&) = delete;

    int handle() const { return socket_; }
    void send(const protocol::Bytes& message);
    void say(const void* bytes, std::size_t size); ///< as they are
    /// Takes all that has come; false: the session has ended. `scratch` is for all peers of a thread.
    bool take(std::vector<std::uint8_t>& scratch, Tally& tally, const Stage& stage);

    /// The interval of the keyframes of a cascade, 0 before the sea is known.
    std::int64_t interval_us(std::size_t cascade) const {
        return cascade < intervals_us_.size() ? intervals_us_[cascade] : 0;
    }
    std::size_t cascades() const { return intervals_us_.size(); }
    std::uint32_t answers() const { return answers_; }        ///< and refusals, of requests
    std::int64_t sea_time_us() const { return sea_time_us_; } ///< of the last Pong or Welcome
    /// When the last of what take() took had come to this system, as clock_s() says it: who takes it may have
    /// waited for a processor since.
    double there_s() const { return there_s_; }

  private:
    std::size_t parse(std::span<const std::uint8_t> bytes, Tally& tally, const Stage& stage);
    void on_message(std::span<const std::uint8_t> bytes, Tally& tally, const Stage& stage);
    void on_tile(const wire::Tile& tile, Tally& tally, const Stage& stage);
    void on_keyframe(const wire::Tile& tile, Tally& tally, const Stage& stage);
    ssize_t receive(std::span<std::uint8_t> room, int how);
    void say_ack(const std::optional<protocol::Bytes>& ack, Tally& tally, const Stage& stage);

    int socket_;
    std::vector<std::uint8_t> rest_; ///< the beginning of a message
    std::vector<std::int64_t> intervals_us_;
    std::uint32_t fields_ = 0;                     ///< granted
    std::map<std::uint64_t, std::uint32_t> begun_; ///< fields that have come, by keyframe
    std::map<int, std::int64_t> newest_us_;        ///< by cascade
    client::Acknowledgements acknowledgements_;
    std::uint32_t answers_ = 0;
    std::int64_t sea_time_us_ = 0;
    double there_s_ = 0;
    bool welcomed_ = false;
};

/// Seconds of the steady clock, the same one in all processes.
double clock_s();

} // namespace seaway::tests::swarm
