// SPDX-License-Identifier: Apache-2.0
// A PeerLine in NATS: the subject seaway.<WORLD>.clock, over a connection of its own, so that no look at the log is in the way.
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "server/journal/nats_connection.h"
#include "server/journal/peer_line.h"

namespace seaway::server {

class NatsPeers final : public PeerLine {
  public:
    explicit NatsPeers(NatsConnection connection);
    ~NatsPeers() override;

    void begin(std::function<std::string()> say,
               std::function<void(const std::string&)> hear) override;

  private:
    void run();
    /// Until the connection fails, or it is asked to stop.
    void exchange();

    NatsConnection connection_;
    const std::string subject_;
    std::function<std::string()> say_;
    std::function<void(const std::string&)> hear_;
    std::atomic<bool> stopping_ = false;
    std::thread thread_;
};

} // namespace seaway::server
