// SPDX-License-Identifier: Apache-2.0
// Mutator: a client that says Hello and then messages with mistakes in them, and sometimes frames with mistakes in
// them, until it is sent away or has had enough.
#pragma once

#include <vector>

#include "protocol/messages.h"
#include "tests/support/draw.h"

namespace seaway::tests::swarm {

class Mutator {
  public:
    Mutator(int port, std::uint64_t seed) : port_(port), draw_(seed) {}

    /// One connection; how many messages it has sent.
    std::uint64_t attack(std::vector<std::uint8_t>& scratch);

  private:
    protocol::Bytes message();
    protocol::Bytes mutated(protocol::Bytes bytes);

    const int port_;
    Draw draw_;
};

} // namespace seaway::tests::swarm
