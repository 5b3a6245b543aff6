// SPDX-License-Identifier: Apache-2.0
// What a process has used, as Linux says, and how busy the machine is besides.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include <sys/types.h>
#include <unistd.h>

#include "tests/support/process_status.h"
#include "tests/support/read_file.h"

namespace seaway::tests::swarm {

struct Figures {
    double cpu_s = 0;                        ///< all threads, those that have ended included
    std::map<std::string, double> threads_s; ///< by number, on a processor
    double resident_mb = 0;
};

inline Figures figures_of(pid_t pid) {
    const std::filesystem::path folder = "/proc/" + std::to_string(pid);
    Figures figures;
    const std::string text = read_file(folder / "stat");
    std::istringstream after_name(text.substr(std::min(text.size(), text.rfind(')') + 2)));
    std::string word;
    for (int field = 3; field <= 15 && after_name >> word; ++field)
        if (field >= 14) // user and system time
            figures.cpu_s += std::stod(word) / static_cast<double>(::sysconf(_SC_CLK_TCK));
    for (const auto& task : std::filesystem::directory_iterator(folder / "task")) {
        std::ifstream schedule(task.path() / "schedstat");
        double ns = 0;
        if (schedule >> ns)
            figures.threads_s[task.path().filename()] = 1e-9 * ns;
    }
    figures.resident_mb = 1e-6 * memory_bytes(pid);
    return figures;
}

/// Of the busiest thread between two looks, s.
inline double busiest_s(const Figures& before, const Figures& after) {
    double most = 0;
    for (const auto& [thread, seconds] : after.threads_s) {
        const auto then = before.threads_s.find(thread);
        most = std::max(most, seconds - (then == before.threads_s.end() ? 0 : then->second));
    }
    return most;
}

/// Mean number of those that wanted a processor, over the last minute.
inline double machine_load() {
    std::ifstream file("/proc/loadavg");
    double load = 0;
    file >> load;
    return load;
}

} // namespace seaway::tests::swarm
