// SPDX-License-Identifier: Apache-2.0
// As on a full disk: while `write` runs, no file of this process becomes longer than so many bytes.
#pragma once

#include <csignal>
#include <cstddef>

#include <sys/resource.h>

namespace seaway::tests {

template <class Write>
auto on_full_disk(std::size_t bytes_max, const Write& write) {
    const auto handler = std::signal(SIGXFSZ, SIG_IGN); // so that writing fails instead
    rlimit before{};
    getrlimit(RLIMIT_FSIZE, &before);
    rlimit limit = before;
    limit.rlim_cur = bytes_max;
    setrlimit(RLIMIT_FSIZE, &limit);
    auto result = write();
    setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    return result;
}

} // namespace seaway::tests
