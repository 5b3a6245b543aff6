// SPDX-License-Identifier: Apache-2.0
#include "server/process_metrics.h"

#include <filesystem>
#include <fstream>
#include <optional>

#include <sys/resource.h>
#include <unistd.h>

#include "base/elapsed.h"
#include "server/host/metrics_text.h"

namespace seaway::server {
namespace {

std::optional<double> open_files(const std::filesystem::path& process) {
    std::error_code error;
    double count = 0;
    for (std::filesystem::directory_iterator file(process / "fd", error), end;
         !error && file != end; file.increment(error))
        ++count;
    return error ? std::nullopt : std::optional(count);
}

} // namespace

std::string process_metrics_text(const std::filesystem::path& process) {
    rlimit files{};
    getrlimit(RLIMIT_NOFILE, &files);
    double pages = 0, resident_pages = 0;
    std::ifstream statm(process / "statm");
    const bool knows_memory = static_cast<bool>(statm >> pages >> resident_pages);

    MetricsText text("process_");
    text.one("cpu_seconds_total", "counter", "Processor time, of users and of the system.",
             process_cpu_seconds());
    // To look takes a free file. Where there is none they are left out: what nobody knows is not 0.
    if (knows_memory)
        text.one("resident_memory_bytes", "gauge", "Memory that is held.",
                 resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)));
    if (const std::optional<double> count = open_files(process))
        text.one("open_fds", "gauge", "Open files and connections.", *count);
    text.one("max_fds", "gauge", "How many there may be.", static_cast<double>(files.rlim_cur));
    return text.take();
}

} // namespace seaway::server
