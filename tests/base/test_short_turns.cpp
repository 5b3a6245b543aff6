// SPDX-License-Identifier: Apache-2.0
// Turns of threads that others wait for, asked of the system itself.
#include <array>
#include <cstdint>
#include <cstring>
#include <thread>

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "base/short_turns.h"

namespace seaway {
namespace {

/// What sched_getattr(2) says of the calling thread.
struct Turns {
    int policy;
    int nice;
    std::uint64_t runtime_ns;
};

Turns turns() {
    std::array<unsigned char, 48>
        attributes{}; // size, policy, flags, nice, priority, runtime and two more
    EXPECT_EQ(::syscall(SYS_sched_getattr, 0, attributes.data(), attributes.size(), 0), 0);
    std::uint32_t policy = 0;
    std::int32_t nice = 0;
    std::uint64_t runtime_ns = 0;
    std::memcpy(&policy, &attributes[4], sizeof policy);
    std::memcpy(&nice, &attributes[16], sizeof nice);
    std::memcpy(&runtime_ns, &attributes[24], sizeof runtime_ns);
    return {static_cast<int>(policy), nice, runtime_ns};
}

/// Asked by a thread of its own: Linux before 6.12 takes no notice, and a container may forbid it.
bool system_grants_turns() {
    bool granted = false;
    std::thread([&] {
        std::array<unsigned char, 48> attributes{};
        const std::uint32_t size = attributes.size();
        const std::uint64_t runtime_ns = 100'000;
        std::memcpy(attributes.data(), &size, sizeof size);
        std::memcpy(&attributes[24], &runtime_ns, sizeof runtime_ns);
        granted = ::syscall(SYS_sched_setattr, 0, attributes.data(), 0) == 0 &&
                  turns().runtime_ns == runtime_ns;
    }).join();
    return granted;
}

TEST(ShortTurns, are_a_tenth_of_a_millisecond_where_the_system_grants_any_and_change_nothing_else) {
    const bool granted = system_grants_turns();
    std::thread([granted] {
        ASSERT_EQ(::setpriority(PRIO_PROCESS, 0, ::getpriority(PRIO_PROCESS, 0) + 1), 0);
        const Turns before = turns();
        take_short_turns();
        const Turns after = turns();
        EXPECT_EQ(after.policy, before.policy);
        EXPECT_EQ(after.nice, before.nice);
        EXPECT_EQ(after.runtime_ns, granted ? 100'000u : before.runtime_ns);
    }).join();
}

TEST(ShortTurns, are_not_taken_by_a_thread_to_which_a_host_gave_another_policy) {
    std::thread([] {
        const sched_param none{};
        ASSERT_EQ(::sched_setscheduler(0, SCHED_BATCH, &none), 0);
        const Turns before = turns();
        take_short_turns();
        EXPECT_EQ(turns().policy, SCHED_BATCH);
        EXPECT_EQ(turns().runtime_ns, before.runtime_ns);
    }).join();
}

} // namespace
} // namespace seaway
