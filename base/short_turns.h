// SPDX-License-Identifier: Apache-2.0
// Threads that others wait for, and that have little to do each time.
#pragma once

namespace seaway {

/// From now on this thread's turns on a processor are 0.1 ms long, and come sooner: who is woken with a shorter turn than the
/// one who runs goes first, on Linux 6.12 and later (sched_setattr, whose `sched_runtime` that is of a thread of the usual policy; earlier ones
/// take no notice). Its share of the processor stays what it is. Nothing changes for a thread that a host has given another policy.
void take_short_turns() noexcept;

} // namespace seaway
