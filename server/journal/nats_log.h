// SPDX-License-Identifier: Apache-2.0
// A SharedLog in NATS with JetStream: the stream SEAWAY_<WORLD> with the one subject seaway.<WORLD>.log, kept in files for ever.
//
// The stream is made where it is missing, and judged where it is there: one that forgets, is kept in memory or takes other
// subjects is named and left as it is.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/journal/nats_connection.h"
#include "server/journal/shared_log.h"

namespace seaway::server {

class NatsLog final : public SharedLog {
  public:
    explicit NatsLog(NatsConnection connection);

    Result<Tail> tail() override;
    Result<std::vector<Stored>> read(std::uint64_t first, std::uint64_t last) override;
    Result<std::uint64_t> write(const std::string& message, const std::string& id,
                                std::uint64_t expected_last) override;
    void connect_no_more() override { connection_.connect_no_more(); }

  private:
    Result<void> make_stream();
    /// Lets the connection go. What comes of no answer: `why`, or that this user has not the rights, which NATS says aside.
    Error unanswered(natsConnection* connection, ErrorKind kind, const std::string& why);

    NatsConnection connection_;
    const std::string stream_;
    const std::string subject_;
    bool may_make_ = true; ///< until it was found: what was there and has gone is named
};

} // namespace seaway::server
