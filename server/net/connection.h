// SPDX-License-Identifier: Apache-2.0
// The two lives of a connection: HTTP first, then, after an upgrade, a stream. The functions are
// templates only so that this header need not know Boost; each is instantiated in its .cpp for
// plain TCP and for TLS. Of the io thread alone.
#pragma once

#include <memory>
#include <string>

#include "server/net/core.h"

namespace seaway::server {

/// One connection of Core::connections, for as long as it lives.
class ConnectionSlot {
  public:
    explicit ConnectionSlot(std::shared_ptr<Core> core) : core_(std::move(core)) {
        ++core_->connections;
    }
    ~ConnectionSlot() {
        if (core_ != nullptr)
            --core_->connections;
    }
    ConnectionSlot(ConnectionSlot&& other) noexcept : core_(std::move(other.core_)) {}
    ConnectionSlot& operator=(ConnectionSlot&&) = delete;
    ConnectionSlot(const ConnectionSlot&) = delete;
    ConnectionSlot& operator=(const ConnectionSlot&) = delete;

    const std::shared_ptr<Core>& core() const { return core_; }

  private:
    std::shared_ptr<Core> core_;
};

/// Serves HTTP on an accepted stream (TLS: handshake first) until it closes or is upgraded.
/// Defined in http_connection.cpp.
template <class Stream>
void serve_http(ConnectionSlot slot, Stream stream, std::string peer);

/// Answers the upgrade `request` and serves the session. Defined in stream_connection.cpp.
template <class Stream, class Request>
void serve_stream(ConnectionSlot slot, Stream stream, const Request& request, std::string peer);

} // namespace seaway::server
