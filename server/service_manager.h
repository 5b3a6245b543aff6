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

    /// It serves; `status` is a line for `systemctl status`.
    void ready(const std::string& status) const;
    /// It has come on: to be said every pat_every(), or it is killed.
    void alive() const;
    void stopping() const;

    /// Half of what the watchdog waits; an hour where there is none.
    std::chrono::microseconds pat_every() const { return pat_every_; }

  private:
    std::chrono::microseconds pat_every_;
};

} // namespace seaway::server
