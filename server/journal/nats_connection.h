// SPDX-License-Identifier: Apache-2.0
// One connection to NATS that is made when it is needed and let go when it fails: what was written to it is never sent a
// second time behind anybody's back. Its files are read anew for each connection. Hosts are tried one after the other, from the one that was there
// last, each for nats_patience_ms and what it takes to look its name up: 2 s a name server that does not answer. For one thread at a time, but for connect_no_more().
#pragma once

#include <memory>
#include <string>

#include "base/result.h"
#include "server/journal/nats_place.h"

// Of nats.h, which no header of ours includes.
using natsConnection = struct __natsConnection;

namespace seaway::server {

/// Patience with one host that is connected to, and with one answer.
inline constexpr int nats_patience_ms = 1000;

class NatsConnection {
  public:
    /// Errors: a file that cannot be read, or is not what it should be. Connects to nobody.
    static Result<NatsConnection> make(NatsPlace place);
    NatsConnection(NatsConnection&&) noexcept;
    ~NatsConnection();

    /// Errors are of kind LogFailure::unreachable, also of a file that is broken by now, but where a host says that the credentials are
    /// wrong, or TLS.
    Result<natsConnection*> get();
    void drop();
    /// From now on get() has a connection that there is, or an error at once; under way no further host is tried. Any thread.
    void connect_no_more();

    const NatsPlace& place() const { return place_; }

  private:
    struct Parts;
    NatsConnection(NatsPlace place, std::unique_ptr<Parts> parts);

    NatsPlace place_;
    std::unique_ptr<Parts> parts_;
};

} // namespace seaway::server
