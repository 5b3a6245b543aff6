// SPDX-License-Identifier: Apache-2.0
#include "server/process_metrics.h"

#include <filesystem>
#include <fstream>
#include <iterator>

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

namespace seaway::server {
namespace {

double seconds(const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

} // namespace

double process_cpu_s() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::string process_metrics_text() {
    rlimit files{};
    getrlimit(RLIMIT_NOFILE, &files);
    double pages = 0, resident_pages = 0;
    std::ifstream("/proc/self/statm") >> pages >> resident_pages;
    std::error_code none;
    const auto open_files =
        std::distance(std::filesystem::directory_iterator("/proc/self/fd", none), {});

    std::string text;
    const auto add = [&text](const char* name, const char* type, const char* help, double value) {
        text += fmt::format("# HELP process_{0} {2}\n# TYPE process_{0} {1}\nprocess_{0} {3}\n",
                            name, type, help, value);
    };
    add("cpu_seconds_total", "counter", "Processor time, of users and of the system.",
        process_cpu_s());
    add("resident_memory_bytes", "gauge", "Memory that is held.",
        resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)));
    add("open_fds", "gauge", "Open files and connections.", static_cast<double>(open_files));
    add("max_fds", "gauge", "How many there may be.", static_cast<double>(files.rlim_cur));
    return text;
}

} // namespace seaway::server
