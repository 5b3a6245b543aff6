// SPDX-License-Identifier: Apache-2.0
#include "base/short_turns.h"

#include <cstdint>

#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace seaway {

namespace {

/// `struct sched_attr` of sched_setattr(2) as it was at first. glibc has it since 2.41; the header of Linux itself cannot be
/// read beside older ones.
struct Attributes {
    std::uint32_t size;
    std::uint32_t policy;
    std::uint64_t flags;
    std::int32_t nice;
    std::uint32_t priority;
    std::uint64_t runtime_ns;
    std::uint64_t deadline_ns;
    std::uint64_t period_ns;
};
static_assert(sizeof(Attributes) == 48);

constexpr std::uint64_t turn_ns = 100'000; // the shortest that the system grants

} // namespace

void take_short_turns() noexcept {
    Attributes attributes{};
    if (::syscall(SYS_sched_getattr, 0, &attributes, sizeof attributes, 0) != 0 ||
        attributes.policy != SCHED_OTHER)
        return;
    attributes.size = sizeof attributes;
    attributes.runtime_ns = turn_ns;
    (void)::syscall(SYS_sched_setattr, 0, &attributes, 0); // refused: turns stay as they are
}

} // namespace seaway
