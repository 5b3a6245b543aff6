// SPDX-License-Identifier: Apache-2.0
// Progress: whether a server comes on, looked at each second: what the watchdog of systemd hears while it does, and what the log
// says once where it stops and once where it goes on again. One thread's.
#pragma once

#include <chrono>
#include <string>

#include "server/host/host.h"

namespace seaway::server {

class Progress {
  public:
    /// The simulation, and for how long the threads of the sockets have not come on. True: the watchdog may hear so.
    bool comes_on(const Health& simulation, std::chrono::steady_clock::duration sockets_silent);

  private:
    std::string stuck_; ///< why, as the log has it; empty: it comes on
};

} // namespace seaway::server
