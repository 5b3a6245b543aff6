// SPDX-License-Identifier: Apache-2.0
// Batches whose chunks run in every order that their phases allow, by one hand or by many slow ones:
// the maps are those of each task alone, to the bit.
#include "sea/native/batch.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <new>
#include <numeric>
#include <thread>

#include <gtest/gtest.h>

#include "sea/native/native_transform.h"
#include "tests/sea/native/random_modes.h"
#include "tests/support/allocations.h"

namespace seaway::sea::native {
namespace {

const FieldSet fields{Field::height, Field::displacement_y, Field::jacobian};
constexpr int keyframes = 3;

std::size_t draw(std::uint64_t& seed, std::size_t below) {
    return static_cast<std::size_t>((next_number(seed) + 1) / 2 * static_cast<double>(below)) %
           below;
}

/// Keyframes of four cascades in one batch, some of the cascades without waves.
class Sea {
  public:
    explicit Sea(unsigned empty) {
        const int sizes[] = {128, 256, 64, 128};
        for (unsigned c = 0; c < 4; ++c)
            cascades_.push_back(std::move(*NativeTransform::create(
                random_modes(sizes[c], empty >> c & 1u ? 0 : sizes[c] / 3.0, c + 1), {})));
        for (int keyframe = 0; keyframe < keyframes; ++keyframe)
            for (const NativeTransform& cascade : cascades_) {
                planes_.emplace_back(
                    static_cast<std::size_t>(fields.size() * cascade.size() * cascade.size()));
                expected_.push_back(planes_.back());
                const TimeUs time_us = 1'000'000 * keyframe;
                tasks_.push_back({&cascade, time_us, fields, planes_.back()});
                NativeRunner alone(1);
                const NativeTask task{&cascade, time_us, fields, expected_.back()};
                alone.run({&task, 1});
            }
    }
    std::span<const NativeTask> tasks() const { return tasks_; }
    void forget() {
        for (auto& plane : planes_)
            std::fill(plane.begin(), plane.end(), NAN);
    }
    bool right() const { return planes_ == expected_; }

  private:
    std::vector<NativeTransform> cascades_;
    std::vector<std::vector<float>> planes_, expected_;
    std::vector<NativeTask> tasks_;
};

/// One chunk after the other, each time any that the pool would let begin.
void run_in_some_order(std::span<const Phase> phases, int workers, std::uint64_t seed) {
    std::vector<std::vector<int>> left(phases.size());
    for (std::size_t p = 0; p < phases.size(); ++p) {
        left[p].resize(static_cast<std::size_t>(phases[p].chunks));
        std::iota(left[p].begin(), left[p].end(), 0);
    }
    for (;;) {
        std::vector<std::size_t> ready;
        for (std::size_t p = 0; p < phases.size(); ++p) {
            const int awaited = awaited_phase(phases, p);
            if (!left[p].empty() &&
                (awaited < 0 || left[static_cast<std::size_t>(awaited)].empty()))
                ready.push_back(p);
        }
        if (ready.empty())
            return;
        // Mostly the latest phase: it is what lies furthest from the order of a quiet machine.
        const std::size_t p = draw(seed, 4) ? ready.back() : ready[draw(seed, ready.size())];
        const std::size_t at = draw(seed, left[p].size());
        const int chunk = left[p][at];
        left[p].erase(left[p].begin() + static_cast<std::ptrdiff_t>(at));
        phases[p].run(phases[p].context, chunk,
                      static_cast<int>(draw(seed, static_cast<std::size_t>(workers))));
    }
}

TEST(Batch, every_order_of_chunks_gives_the_same_bits_with_empty_cascades_in_any_place) {
    for (unsigned empty = 0; empty < 16; ++empty) {
        Sea sea(empty);
        Batch batch(3);
        for (std::size_t held : {1u, 2u})
            for (std::uint64_t seed = 1; seed <= 4; ++seed) {
                sea.forget();
                run_in_some_order(batch.prepare(sea.tasks(), held), 3, seed);
                ASSERT_TRUE(sea.right())
                    << "empty cascades " << empty << ", " << held << " buffers, order " << seed;
            }
    }
}

/// A phase whose chunks come in another order and late: a thread that loses its core at the worst time.
struct Slowed {
    Phase phase;
    std::vector<int> order;
    std::vector<int> delay_us;

    static void run(const void* context, int chunk, int worker) {
        const auto& slowed = *static_cast<const Slowed*>(context);
        const auto at = static_cast<std::size_t>(chunk);
        if (slowed.delay_us[at] > 0)
            std::this_thread::sleep_for(std::chrono::microseconds(slowed.delay_us[at]));
        slowed.phase.run(slowed.phase.context, slowed.order[at], worker);
    }
};

void run_slowed(ThreadPool& pool, std::span<const Phase> phases, std::uint64_t seed) {
    std::vector<Slowed> slowed;
    for (const Phase& phase : phases) {
        Slowed& one = slowed.emplace_back(Slowed{phase, {}, {}});
        for (int chunk = 0; chunk < phase.chunks; ++chunk) {
            one.order.insert(one.order.begin() +
                                 static_cast<std::ptrdiff_t>(draw(seed, one.order.size() + 1)),
                             chunk);
            one.delay_us.push_back(draw(seed, 8) ? 0 : static_cast<int>(draw(seed, 400)));
        }
    }
    std::vector<Phase> run;
    for (const Slowed& one : slowed)
        run.push_back({Slowed::run, &one, one.phase.chunks, one.phase.after});
    pool.run(run);
}

TEST(Batch, threads_that_lose_their_core_change_nothing) {
    ThreadPool pool(4);
    for (unsigned empty = 0; empty < 16; ++empty) {
        Sea sea(empty);
        Batch batch(pool.threads());
        for (std::size_t held : {1u, 2u})
            for (std::uint64_t seed = 1; seed <= 4; ++seed) {
                sea.forget();
                run_slowed(pool, batch.prepare(sea.tasks(), held), seed);
                ASSERT_TRUE(sea.right())
                    << "empty cascades " << empty << ", " << held << " buffers, delays " << seed;
            }
    }
}

// Naive: lines that one keyframe of all fields needed are held for good.
TEST(Batch, lets_go_of_lines_that_tasks_no_longer_need_and_makes_the_same_maps) {
    Sea sea(0);
    Batch batch(1);
    const auto runs = [&batch](std::span<const NativeTask> tasks) {
        run_in_some_order(batch.prepare(tasks), 1, 1);
    };
    const auto trimmed = [&batch](int looks) {
        for (int trim = 0; trim < looks * Batch::trims_a_look; ++trim)
            batch.trim();
        return batch.lines_floats();
    };
    const std::span<const NativeTask> all = sea.tasks(), small = all.subspan(2, 1);
    runs(small);
    const std::size_t of_small = batch.lines_floats();
    runs(all);
    const std::size_t of_all = batch.lines_floats();
    EXPECT_GT(of_all, 4 * of_small);
    EXPECT_EQ(trimmed(1), of_all) << "they were needed since the last look";
    runs(small);
    EXPECT_EQ(trimmed(1), 0u) << "such large ones were not";
    runs(small);
    EXPECT_EQ(batch.lines_floats(), of_small);
    EXPECT_EQ(trimmed(1), of_small) << "these were";
    EXPECT_EQ(trimmed(1), 0u) << "nothing was";
    sea.forget();
    runs(all);
    EXPECT_TRUE(sea.right());
}

// Naive: what is let go of to make room for a larger task is still taken to be there.
TEST(Batch, that_has_no_memory_for_a_larger_task_does_the_smaller_ones_as_before) {
    const NativeTransform small = *NativeTransform::create(random_modes(64, 20, 1), {});
    // Blocks of a megabyte and more are mapped (base/aligned_floats.h), where none can be made to fail here.
    const NativeTransform large = *NativeTransform::create(random_modes(128, 20, 2), {});
    const auto planes_of = [](const NativeTransform& cascade) {
        return std::vector<float>(
            static_cast<std::size_t>(fields.size() * cascade.size() * cascade.size()));
    };
    std::vector<float> expected = planes_of(small), planes = planes_of(large);
    NativeRunner(1).run(std::vector<NativeTask>{{&small, 5, fields, expected}});
    std::size_t refused = 0, made_again = 0;
    for (std::size_t after = 0;; ++after) {
        NativeRunner runner(2);
        std::vector<float> again = planes_of(small);
        runner.run(std::vector<NativeTask>{{&small, 5, fields, again}});
        const std::vector<NativeTask> more{{&large, 5, fields, planes}};
        bool all = true;
        try {
            const tests::NoMemoryOnce none(after);
            runner.run(more);
        } catch (const std::bad_alloc&) {
            all = false;
            ++refused;
        }
        const std::vector<NativeTask> smaller{{&small, 5, fields, again}};
        const auto asks_for_memory = [&] {
            std::fill(again.begin(), again.end(), NAN);
            const tests::Allocations counted;
            runner.run(smaller);
            EXPECT_EQ(again, expected) << after;
            return counted.count();
        };
        const std::size_t at_first = asks_for_memory();
        made_again += at_first > asks_for_memory() ? 1 : 0;
        if (all)
            break;
    }
    EXPECT_GE(refused, 4u) << "scratch of two workers, and two buffers of lines";
    EXPECT_EQ(made_again, 2u) << "what was let go of";
}

} // namespace
} // namespace seaway::sea::native
