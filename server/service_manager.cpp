// SPDX-License-Identifier: Apache-2.0
#include "server/service_manager.h"

#include <cstdint>

#include <fmt/format.h>
#include <systemd/sd-daemon.h>

namespace seaway::server {

ServiceManager::ServiceManager() : pat_every_(std::chrono::hours(1)) {
    std::uint64_t limit_us = 0;
    if (sd_watchdog_enabled(0, &limit_us) > 0 && limit_us > 1)
        pat_every_ = std::chrono::microseconds(limit_us / 2);
}

void ServiceManager::starting() {
    const auto now = std::chrono::steady_clock::now();
    if (now - starting_said_ < std::chrono::seconds(1))
        return;
    starting_said_ = now;
    const auto limit_us = std::chrono::microseconds(starting_limit).count();
    sd_notify(0, fmt::format("EXTEND_TIMEOUT_USEC={}", limit_us).c_str());
}

void ServiceManager::ready(const std::string& status) const {
    sd_notify(0, ("READY=1\nSTATUS=" + status).c_str());
}

void ServiceManager::alive() const {
    sd_notify(0, "WATCHDOG=1");
}

void ServiceManager::stopping() const {
    sd_notify(0, "STOPPING=1");
}

} // namespace seaway::server
