// SPDX-License-Identifier: Apache-2.0
#include "server/service_manager.h"

#include <cstdint>

#include <systemd/sd-daemon.h>

namespace seaway::server {

ServiceManager::ServiceManager() : pat_every_(std::chrono::hours(1)) {
    std::uint64_t limit_us = 0;
    if (sd_watchdog_enabled(0, &limit_us) > 0 && limit_us > 1)
        pat_every_ = std::chrono::microseconds(limit_us / 2);
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
