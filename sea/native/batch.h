// SPDX-License-Identifier: Apache-2.0
// Batch: the memory and the phases of one call of NativeRunner. It says what is to be done, in
// chunks and in which order; whoever runs the phases (a ThreadPool, or a test in every order that
// they allow) gets the same maps to the bit.
//
// One caller at a time. The phases of prepare() are valid until the next.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/aligned_floats.h"
#include "base/thread_pool.h"
#include "sea/native/kernels.h"
#include "sea/native/native_runner.h"

namespace seaway::sea::native {

class Batch {
  public:
    static constexpr std::size_t buffers_max = 2;

    /// Workers that may run a chunk at the same time; each has scratch of its own.
    explicit Batch(int workers) : workers_(workers) {}

    /// `held`: how many buffers of lines the tasks take in turn (schedule.h); 0: as their size has
    /// it. Throws std::bad_alloc.
    std::span<const Phase> prepare(std::span<const NativeTask> tasks, std::size_t held = 0);

    /// Of one task of the last prepare() whose phases have run, while no later task has had its
    /// buffer, and before trim().
    std::vector<NativeLines> lines(std::size_t task) const;

    /// Each trims_a_look-th call lets go of the buffers of lines where no task since the last look had need of such large ones.
    static constexpr int trims_a_look = 8;
    void trim();
    std::size_t lines_floats() const { return lines_floats_; } ///< of each buffer

  private:
    /// One task as the kernels take it.
    struct Work {
        const Kernels* kernels;
        ColumnPass columns;
        RowPass rows;
        RowField fields[linear_field_count];
        int rows_a_chunk;
        const std::vector<AlignedFloats>* scratch; ///< one a worker
    };
    /// Makes room for these tasks; returns the floats of one buffer that they need.
    std::size_t grow(std::span<const NativeTask> tasks);
    void lay_out(const NativeTask& task, float* lines, Work& work) const;
    static void list_fields(const NativeTask& task, Work& work);
    static void run_columns(const void* context, int chunk, int worker);
    static void run_rows(const void* context, int chunk, int worker);

    int workers_;
    std::vector<AlignedFloats> scratch_; ///< one a worker
    std::size_t scratch_floats_ = 0;
    AlignedFloats lines_[buffers_max]; ///< between the passes
    std::size_t lines_floats_ = 0;
    std::size_t lines_needed_ = 0; ///< since trim() looked
    int trims_ = 0;
    std::vector<Work> work_;
    std::vector<Phase> phases_;
};

} // namespace seaway::sea::native
