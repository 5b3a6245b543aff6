// SPDX-License-Identifier: Apache-2.0
// Points, rows and frames of a measurement are independent of each other: all cores work on them.
#pragma once

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

#include "base/processors.h"

namespace seaway::bench {

/// Calls work(0) to work(count - 1), in a thread for each processor that it may use; returns when all are
/// done. `work` may be called by several threads together.
template <class Work>
void in_threads(int count, const Work& work) {
    std::atomic<int> next{0};
    std::vector<std::jthread> threads;
    for (int i = usable_processors(); i > 0; --i)
        threads.emplace_back([&] {
            for (int n = next++; n < count; n = next++)
                work(n);
        });
}

/// Likewise work(begin, end) for parts of 0 .. count - 1 of `each` or fewer.
template <class Work>
void in_parts(std::size_t count, std::size_t each, const Work& work) {
    in_threads(static_cast<int>((count + each - 1) / each), [&](int part) {
        const std::size_t begin = static_cast<std::size_t>(part) * each;
        work(begin, std::min(count, begin + each));
    });
}

} // namespace seaway::bench
