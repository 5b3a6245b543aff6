// SPDX-License-Identifier: Apache-2.0
// ServiceManager: what systemd is told of a service of Type=notify with a watchdog (sd_notify(3),
// sd_watchdog_enabled(3)). Where nobody has asked, nothing is said.
#pragma once

#include <chrono>
#include <string>

namespace seaway::server {

class ServiceManager {
  public:
    ServiceManager();

    /// It is on its way and not there yet: as long as this is said within starting_limit, and again, a start may take longer
    /// than TimeoutStartSec=. Said once a second at most, however often it is called; by one thread.
    void starting();
    /// It serves; `status` is a line for `systemctl status`.
    void ready(const std::string& status) const;
    /// It has come on: to be said every pat_every(), or it is killed.
    void alive() const;
    void stopping() const;

    /// Half of what the watchdog waits; an hour where there is none.
    std::chrono::microseconds pat_every() const { return pat_every_; }

    static constexpr std::chrono::seconds starting_limit{60};

  private:
    std::chrono::microseconds pat_every_;
    std::chrono::steady_clock::time_point starting_said_{};
};

} // namespace seaway::server
