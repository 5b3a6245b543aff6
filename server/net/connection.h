// SPDX-License-Identifier: Apache-2.0
// The two lives of a connection: HTTP first, then, after an upgrade, a stream. Of the io thread alone.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "server/net/core.h"
#include "server/net/gate.h"

namespace seaway::sockets {
class Socket;
struct Upgrade;
} // namespace seaway::sockets

namespace seaway::server {

/// One connection of a door, and of its address, for as long as it lives.
class ConnectionSlot {
  public:
    ConnectionSlot(std::shared_ptr<Core> core, Door& door, const AddressPtr& address)
        : core_(std::move(core)), door_(&door), of_address_(address) {
        ++door.connections;
    }
    ~ConnectionSlot() {
        if (core_ != nullptr)
            --door_->connections;
    }
    ConnectionSlot(ConnectionSlot&& other) noexcept = default;
    ConnectionSlot& operator=(ConnectionSlot&&) = delete;
    ConnectionSlot(const ConnectionSlot&) = delete;
    ConnectionSlot& operator=(const ConnectionSlot&) = delete;

    const std::shared_ptr<Core>& core() const { return core_; }
    Door& door() const { return *door_; }

  private:
    std::shared_ptr<Core> core_;
    Door* door_;
    Counted<&Address::connections> of_address_;
};

/// An upgrade under way, for as long as it lives.
class UpgradeSlot {
  public:
    explicit UpgradeSlot(std::shared_ptr<Core> core) : core_(std::move(core)) { ++core_->upgrades; }
    ~UpgradeSlot() { --core_->upgrades; }
    UpgradeSlot(const UpgradeSlot&) = delete;
    UpgradeSlot& operator=(const UpgradeSlot&) = delete;

  private:
    std::shared_ptr<Core> core_;
};

/// Serves HTTP on an accepted stream (TLS: handshake first) until it closes or is upgraded.
/// Defined in http_connection.cpp.
void serve_http(ConnectionSlot slot, sockets::Socket socket, Peer peer);

/// Serves a bulk map and ends with it. Defined in map_connection.cpp.
void serve_map(ConnectionSlot slot, sockets::Socket socket, Peer peer,
               std::map<std::string, std::string> parameters);

/// Answers the upgrade and serves the session; `standing` is what the upgrade's token was worth.
/// Defined in stream_connection.cpp.
void serve_stream(ConnectionSlot slot, sockets::Socket socket, const sockets::Upgrade& upgrade,
                  Peer peer, Standing standing);

} // namespace seaway::server
