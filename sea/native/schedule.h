// SPDX-License-Identifier: Apache-2.0
// The order of work of a batch of tasks. Each task has two passes: `columns` writes the lines of
// the task and `rows` reads them. Lines stand in `held` buffers that the tasks use in turn, so the
// columns of a task must not start before the rows of the task that had its buffer are complete.
//
// With two buffers the columns of a task overlap the last rows of the one before, and no thread
// idles between tasks. A cascade without waves has no chunks of columns; its passes stand in the
// order all the same, and the pool (base/thread_pool.h) waits through them.
//
// Pure. tests/sea/native/test_schedule.cpp walks every state that threads can reach.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace seaway::sea::native {

enum class Pass { columns, rows };

/// Chunks of the two passes of one task.
struct TaskChunks {
    int columns; ///< 0: no waves
    int rows;
};

struct ScheduledPass {
    Pass pass;
    std::size_t task;
    int chunks;
    int after; ///< index of the pass that it follows; -1: none
};

/// Which of the `held` buffers a task writes and reads.
inline std::size_t lines_of(std::size_t task, std::size_t held) {
    return task % held;
}

/// Passes in the order in which their chunks are to be handed out. `held`: 1 or 2 buffers.
std::vector<ScheduledPass> schedule(std::span<const TaskChunks> tasks, std::size_t held);

} // namespace seaway::sea::native
