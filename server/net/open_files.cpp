// SPDX-License-Identifier: Apache-2.0
#include "server/net/open_files.h"

#include <cerrno>
#include <cstring>

#include <fmt/format.h>
#include <sys/resource.h>

namespace seaway::server {

Result<void> raise_open_files(const NetOptions& options) {
    rlimit files{};
    if (getrlimit(RLIMIT_NOFILE, &files) != 0)
        return Error{fmt::format("the limit on open files is not known: {}", std::strerror(errno))};
    const rlim_t needed =
        static_cast<rlim_t>(options.connections_max) +
        static_cast<rlim_t>(options.health_listen.empty() ? 0 : options.health_connections_max) +
        other_files_max;
    const rlim_t most = files.rlim_max;
    files.rlim_cur = most;
    if (setrlimit(RLIMIT_NOFILE, &files) != 0)
        return Error{fmt::format("the limit on open files cannot be raised to {}: {}", most,
                                 std::strerror(errno))};
    if (most != RLIM_INFINITY && most < needed)
        return Error{
            fmt::format("--connections-max {}: {} open files are needed and {} are allowed; "
                        "raise the hard limit (ulimit -Hn, LimitNOFILE=) or take fewer",
                        options.connections_max, needed, most)};
    return {};
}

} // namespace seaway::server
