// SPDX-License-Identifier: Apache-2.0
// Crew: the processes of a swarm. Each holds its share of the sessions, all in one thread.
#pragma once

#include <string>
#include <vector>

#include <sys/types.h>

#include "protocol/messages.h"
#include "tests/load/swarm/tally.h"

namespace seaway::tests::swarm {

struct Errand {
    int port = 0;
    int readers = 0;
    int stalled = 0;            ///< subscribe and never read
    int askers = 0;             ///< ask single points, timed
    double asks_a_second = 100; ///< of each of them; the next one waits for the answer
    double pings_a_second = 0;  ///< of each reader
    bool floods = false;        ///< as many points at far times as a session may have under way
    std::uint64_t mutates =
        0; ///< sends messages with mistakes in them, by lot from this seed; 0: does not
    protocol::TileWish wish = {};
    int credit = 4;
    int nice = 0; ///< how far it stands back for whoever else wants the processor
};

/// Children until they are told to end. Not thread-safe; for a process of one thread.
class Crew {
  public:
    explicit Crew(Stage& stage) : stage_(stage) {}
    ~Crew(); ///< ends those that are left, by their number
    Crew(const Crew&) = delete;
    Crew& operator=(const Crew&) = delete;

    void send(const Errand& errand);
    /// Waits for all; false if one has failed.
    bool come_home();
    const std::vector<const Tally*>& tallies() const { return tallies_; }

  private:
    Stage& stage_;
    std::vector<pid_t> children_;
    std::vector<const Tally*> tallies_;
};

} // namespace seaway::tests::swarm
