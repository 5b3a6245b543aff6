// SPDX-License-Identifier: Apache-2.0
// The two lives of a connection: HTTP first, then, after an upgrade, a stream. Of the io thread alone.
#pragma once

#include <memory>
#include <string>

#include "server/net/core.h"

namespace seaway::sockets {
class Socket;
struct Upgrade;
} // namespace seaway::sockets

namespace seaway::server {

/// One of a count of Core, for as long as it lives.
template <int Core::*count>
class Slot {
  public:
    explicit Slot(std::shared_ptr<Core> core) : core_(std::move(core)) { ++(*core_.*count); }
    ~Slot() {
        if (core_ != nullptr)
            --(*core_.*count);
    }
    Slot(Slot&& other) noexcept : core_(std::move(other.core_)) {}
    Slot& operator=(Slot&&) = delete;
    Slot(const Slot&) = delete;
    Slot& operator=(const Slot&) = delete;

    const std::shared_ptr<Core>& core() const { return core_; }

  private:
    std::shared_ptr<Core> core_;
};

using ConnectionSlot = Slot<&Core::connections>;
using UpgradeSlot = Slot<&Core::upgrades>;

/// Serves HTTP on an accepted stream (TLS: handshake first) until it closes or is upgraded.
/// Defined in http_connection.cpp.
void serve_http(ConnectionSlot slot, sockets::Socket socket, std::string peer);

/// Answers the upgrade and serves the session. Defined in stream_connection.cpp.
void serve_stream(ConnectionSlot slot, sockets::Socket socket, const sockets::Upgrade& upgrade,
                  std::string peer);

} // namespace seaway::server
