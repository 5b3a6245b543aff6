// SPDX-License-Identifier: Apache-2.0
// How many processors this process may use, which in a container is not how many the machine has.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

namespace seaway {

/// The least of what its affinity leaves (`taskset`, cpusets: Docker's --cpuset-cpus) and of the time that its control groups
/// give it a period, rounded up (cpu.max of cgroup v2, its own and those above: CPUQuota= of a unit, Docker's --cpus, limits
/// of Kubernetes); at least 1. More threads than that wait for each other. std::thread::hardware_concurrency() sees neither.
/// A few reads of small files: to be asked once.
int usable_processors();

/// The same where control groups stand in `groups` and `own` says which is this process's.
int usable_processors(const std::filesystem::path& groups, const std::filesystem::path& own);

/// Of "QUOTA PERIOD", us, as in cpu.max: so many processors, rounded up. None of "max PERIOD" and of what it is not. Pure.
std::optional<int> processors_of_quota(std::string_view cpu_max);

} // namespace seaway
