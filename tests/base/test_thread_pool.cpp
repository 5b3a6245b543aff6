// SPDX-License-Identifier: Apache-2.0
#include "base/thread_pool.h"

#include <array>

#include <gtest/gtest.h>

namespace seaway::sea {
namespace {

struct Tally {
    std::array<std::atomic<int>, 100> runs{};
    const Tally* before = nullptr; ///< must be complete
    std::atomic<int> early{0};

    bool complete() const {
        for (const auto& count : runs)
            if (count != 1)
                return false;
        return true;
    }
    static void run(const void* context, int chunk, int) {
        auto& tally = *static_cast<Tally*>(const_cast<void*>(context));
        if (tally.before && !tally.before->complete())
            ++tally.early;
        ++tally.runs[static_cast<std::size_t>(chunk)];
    }
};

TEST(ThreadPool, every_chunk_runs_once_and_after_the_phase_it_waits_for) {
    for (int threads : {1, 2, 5}) {
        ThreadPool pool(threads);
        EXPECT_EQ(pool.threads(), threads);
        for (int repeat = 0; repeat < 200; ++repeat) {
            Tally first, second, third;
            second.before = &first;
            third.before = &second;
            const Phase phases[] = {{Tally::run, &first, 100},
                                    {Tally::run, &second, 100, 0},
                                    {Tally::run, &third, 100, 1}};
            pool.run(phases);
            ASSERT_TRUE(first.complete() && second.complete() && third.complete());
            ASSERT_EQ(second.early + third.early, 0);
        }
    }
}

TEST(ThreadPool, an_empty_run_returns) {
    ThreadPool pool(2);
    pool.run({});
    const Phase nothing[] = {{Tally::run, nullptr, 0}};
    pool.run(nothing);
}

} // namespace
} // namespace seaway::sea
