// SPDX-License-Identifier: Apache-2.0
#include "base/thread_pool.h"

#include <array>
#include <chrono>
#include <thread>

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

TEST(ThreadPool, to_follow_a_phase_of_no_chunks_is_to_follow_what_came_before_it) {
    // All chains of six phases of which any may be empty: what is awaited is the nearest with chunks.
    for (unsigned empty = 0; empty < 64; ++empty) {
        std::vector<Phase> phases;
        for (int i = 0; i < 6; ++i)
            phases.push_back({nullptr, nullptr, empty >> i & 1u ? 0 : 2, i - 1});
        for (int i = 0; i < 6; ++i) {
            int nearest = i - 1;
            while (nearest >= 0 && (empty >> nearest & 1u))
                --nearest;
            EXPECT_EQ(awaited_phase(phases, static_cast<std::size_t>(i)), nearest);
        }
    }
}

TEST(ThreadPool, no_thread_slips_past_a_phase_of_no_chunks) {
    struct Slow {
        std::atomic<bool> done{false};
        static void run(const void* context, int, int) {
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
            static_cast<Slow*>(const_cast<void*>(context))->done = true;
        }
    };
    struct After {
        const Slow* slow;
        std::atomic<int> early{0};
        static void run(const void* context, int, int) {
            auto& after = *static_cast<After*>(const_cast<void*>(context));
            after.early += !after.slow->done;
        }
    };
    ThreadPool pool(3);
    for (int repeat = 0; repeat < 20; ++repeat) {
        Slow slow;
        After after{&slow};
        const Phase phases[] = {{Slow::run, &slow, 1},
                                {After::run, nullptr, 0, 0},
                                {After::run, nullptr, 0, 1},
                                {After::run, &after, 8, 2}};
        pool.run(phases);
        ASSERT_EQ(after.early, 0);
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
