// SPDX-License-Identifier: Apache-2.0
// The clock of this machine for what follows another one (base/clock_filter.h) or UTC: never set, and it goes on while the machine
// sleeps, where the system has such a clock.
#pragma once

#include <cstdint>

namespace seaway {

/// Microseconds since some moment. Thread-safe; some tens of nanoseconds.
std::int64_t local_now_us();

} // namespace seaway
