// SPDX-License-Identifier: Apache-2.0
// FaultProxy: a bad line between a client and a server on loopback, in user space: it delays, jitters, stalls,
// is slow, flips bits and breaks, TCP connection by TCP connection. A thread of its own; everything is
// thread-safe. What it does by lot is the same for the same seed and the same bytes, but for time.
//
//     FaultProxy line(server_port, {.delay = 30ms, .jitter = 10ms});
//     connect_to(line.port());
//     line.stall(true);
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>

namespace seaway::tests {

/// What a line is like, each way for itself.
struct LineFaults {
    std::chrono::microseconds delay{0};
    std::chrono::microseconds jitter{0}; ///< up to so much more or less; bytes stay in order
    double bytes_per_s = 0;              ///< from the server to the client; 0: as fast as can be
    /// That the line holds each way before it takes no more, besides what the sockets hold.
    std::size_t buffer_bytes = 64 * 1024;
};

class FaultProxy {
  public:
    /// Listens on a free port of 127.0.0.1 and connects to `server_port` there for each who comes.
    explicit FaultProxy(int server_port, LineFaults faults = {}, std::uint64_t seed = 1);
    ~FaultProxy();
    FaultProxy(const FaultProxy&) = delete;
    FaultProxy& operator=(const FaultProxy&) = delete;

    int port() const;
    /// Who comes from now on is led to another server.
    void lead_to(int server_port);
    /// From now on, also of connections that there are.
    void set(const LineFaults& faults);
    /// Carries nothing until it is told to again; nobody is told.
    void stall(bool stalled);
    /// Resets every connection; who comes later is let through.
    void cut();

    enum class Way { to_server, to_client };
    /// The next connection is reset, both sides, when so many bytes have come this way.
    void cut_next_after(Way way, std::uint64_t bytes);
    /// Of the next connection a bit of this byte is flipped.
    void flip_next_at(Way way, std::uint64_t byte, unsigned bit);

    int connections() const;                    ///< that are open
    std::uint64_t bytes_carried(Way way) const; ///< of all connections

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace seaway::tests
