// SPDX-License-Identifier: Apache-2.0
// The schedule, proved: every state that threads can reach while they work through a batch, with the
// pool's own rule of what a chunk waits for and the schedule that the synthesizer runs.
#include "sea/native/schedule.h"

#include <algorithm>
#include <array>
#include <string>
#include <unordered_set>

#include <gtest/gtest.h>

#include "base/thread_pool.h"

namespace seaway::sea::native {
namespace {

/// Threads draw chunks in order, wait until they may begin, run, finish, each at any speed.
class Model {
  public:
    Model(std::span<const TaskChunks> tasks, std::size_t held, int threads)
        : passes_(schedule(tasks, held)), held_(held), threads_(threads) {
        std::vector<Phase> phases;
        for (std::size_t p = 0; p < passes_.size(); ++p) {
            phases.push_back({nullptr, nullptr, passes_[p].chunks, passes_[p].after});
            for (int chunk = 0; chunk < passes_[p].chunks; ++chunk)
                phase_of_.push_back(p);
        }
        for (std::size_t p = 0; p < phases.size(); ++p)
            awaited_.push_back(awaited_phase(phases, p));
    }

    /// What goes wrong in the first bad state that is found; empty: nothing, in all of them.
    std::string walk() {
        std::vector<State> open{State{}};
        while (!open.empty()) {
            const State state = open.back();
            open.pop_back();
            if (!seen_.insert(state.word()).second)
                continue;
            const std::size_t before = open.size();
            for (const State& next : next_states(state))
                open.push_back(next);
            if (!wrong_.empty())
                return wrong_;
            if (open.size() == before &&
                (state.next != static_cast<int>(phase_of_.size()) || state.busy() > 0))
                return "threads wait for each other";
        }
        return "";
    }
    std::size_t states() const { return seen_.size(); }

  private:
    static constexpr int idle = 63;
    struct State {
        int next = 0;                               ///< the chunk that is drawn next
        std::array<int, 3> drawn{idle, idle, idle}; ///< by each thread; threads are alike: sorted
        std::array<bool, 3> running{};
        int busy() const {
            return static_cast<int>(3 - std::count(drawn.begin(), drawn.end(), idle));
        }
        std::uint64_t word() const {
            std::array<int, 3> threads{};
            for (std::size_t i = 0; i < 3; ++i)
                threads[i] = drawn[i] * 2 + running[i];
            std::sort(threads.begin(), threads.end());
            return static_cast<std::uint64_t>(next) << 24 |
                   static_cast<std::uint64_t>(threads[0]) << 16 |
                   static_cast<std::uint64_t>(threads[1]) << 8 |
                   static_cast<std::uint64_t>(threads[2]);
        }
        bool finished(int chunk) const {
            return chunk < next && std::find(drawn.begin(), drawn.end(), chunk) == drawn.end();
        }
    };

    bool complete(const State& state, std::size_t pass) const {
        for (int chunk = 0; chunk < static_cast<int>(phase_of_.size()); ++chunk)
            if (phase_of_[static_cast<std::size_t>(chunk)] == pass && !state.finished(chunk))
                return false;
        return true;
    }

    /// A chunk of this pass begins: columns overwrite, so nobody may have anything left to do with
    /// what earlier tasks keep in that buffer; rows read, so their own columns must be there.
    void check_begin(const State& state, const ScheduledPass& begun) {
        for (std::size_t p = 0; p < passes_.size(); ++p) {
            const ScheduledPass& other = passes_[p];
            const bool overwritten = begun.pass == Pass::columns && other.task < begun.task &&
                                     lines_of(other.task, held_) == lines_of(begun.task, held_);
            const bool read =
                begun.pass == Pass::rows && other.pass == Pass::columns && other.task == begun.task;
            if ((overwritten || read) && !complete(state, p))
                wrong_ = (overwritten ? "lines in use are overwritten by task "
                                      : "lines are read early by task ") +
                         std::to_string(begun.task);
        }
    }

    std::vector<State> next_states(const State& state) {
        std::vector<State> result;
        for (std::size_t thread = 0; thread < static_cast<std::size_t>(threads_); ++thread) {
            State then = state;
            if (state.drawn[thread] == idle) {
                if (state.next == static_cast<int>(phase_of_.size()))
                    continue;
                then.drawn[thread] = then.next++;
            } else if (state.running[thread]) {
                then.drawn[thread] = idle;
                then.running[thread] = false;
            } else {
                const std::size_t pass = phase_of_[static_cast<std::size_t>(state.drawn[thread])];
                if (awaited_[pass] >= 0 &&
                    !complete(state, static_cast<std::size_t>(awaited_[pass])))
                    continue;
                check_begin(state, passes_[pass]);
                then.running[thread] = true;
            }
            result.push_back(then);
        }
        return result;
    }

    std::vector<ScheduledPass> passes_;
    std::vector<std::size_t> phase_of_; ///< of each chunk
    std::vector<int> awaited_;
    std::size_t held_;
    int threads_;
    std::unordered_set<std::uint64_t> seen_;
    std::string wrong_;
};

std::string text(std::span<const TaskChunks> tasks) {
    std::string result = "columns + rows:";
    for (const TaskChunks& task : tasks)
        result += " " + std::to_string(task.columns) + "+" + std::to_string(task.rows);
    return result;
}

/// Every batch of `count` tasks whose passes have the given numbers of chunks.
void expect_all_sound(std::size_t count, std::vector<TaskChunks> kinds) {
    std::size_t states = 0, batches = 1;
    for (std::size_t i = 0; i < count; ++i)
        batches *= kinds.size();
    for (std::size_t batch = 0; batch < batches; ++batch) {
        std::vector<TaskChunks> tasks;
        for (std::size_t i = 0, rest = batch; i < count; ++i, rest /= kinds.size())
            tasks.push_back(kinds[rest % kinds.size()]);
        for (std::size_t held : {1u, 2u})
            for (int threads : {1, 2, 3}) {
                Model model(tasks, held, threads);
                ASSERT_EQ(model.walk(), "")
                    << text(tasks) << ", " << held << " buffers, " << threads << " threads";
                states += model.states();
            }
    }
    EXPECT_GT(states, 1000u);
}

TEST(Schedule, no_order_of_threads_overwrites_lines_in_use_in_three_tasks_of_any_chunks) {
    expect_all_sound(3, {{0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 1}, {2, 2}});
}

TEST(Schedule, nor_in_six_tasks_with_empty_cascades_in_any_place) {
    expect_all_sound(6, {{0, 1}, {1, 2}});
}

TEST(Schedule, every_pass_of_every_task_stands_in_it_once) {
    const TaskChunks tasks[] = {{3, 4}, {0, 4}, {3, 4}};
    for (std::size_t held : {1u, 2u}) {
        int columns = 0, rows = 0;
        for (const ScheduledPass& pass : schedule(tasks, held))
            (pass.pass == Pass::columns ? columns : rows) += 1 << (4 * pass.task);
        EXPECT_EQ(columns, 0x111);
        EXPECT_EQ(rows, 0x111);
    }
    EXPECT_TRUE(schedule({}, 2).empty());
}

} // namespace
} // namespace seaway::sea::native
