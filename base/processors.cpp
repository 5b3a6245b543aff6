// SPDX-License-Identifier: Apache-2.0
#include "base/processors.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <sched.h>
#include <string>
#include <thread>

namespace seaway {
namespace {

int processors_of_affinity() {
    cpu_set_t allowed;
    if (::sched_getaffinity(0, sizeof allowed, &allowed) == 0)
        return CPU_COUNT(&allowed);
    return static_cast<int>(std::thread::hardware_concurrency()); // a machine of more than 1024
}

std::string first_line(const std::filesystem::path& path) {
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    return line;
}

/// Below the root of the groups; "" is the root, which is also where this cannot be told.
std::filesystem::path own_group(const std::filesystem::path& own) {
    std::ifstream file(own);
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("0::/"))
            return line.substr(4);
    return {};
}

} // namespace

std::optional<int> processors_of_quota(std::string_view cpu_max) {
    long long quota_us = 0;
    long long period_us = 0;
    const char* const end = cpu_max.data() + cpu_max.size();
    const auto quota = std::from_chars(cpu_max.data(), end, quota_us);
    if (quota.ec != std::errc{} || quota.ptr == end || *quota.ptr != ' ')
        return std::nullopt;
    const auto period = std::from_chars(quota.ptr + 1, end, period_us);
    if (period.ec != std::errc{} || quota_us <= 0 || period_us <= 0)
        return std::nullopt;
    const long long whole = (quota_us - 1) / period_us + 1;
    return static_cast<int>(std::min<long long>(whole, 1 << 20));
}

int usable_processors(const std::filesystem::path& groups, const std::filesystem::path& own) {
    int least = processors_of_affinity();
    for (std::filesystem::path group = own_group(own);; group = group.parent_path()) {
        if (const auto given = processors_of_quota(first_line(groups / group / "cpu.max")))
            least = std::min(least, *given);
        if (group.empty())
            return std::max(1, least);
    }
}

int usable_processors() {
    return usable_processors("/sys/fs/cgroup", "/proc/self/cgroup");
}

} // namespace seaway
