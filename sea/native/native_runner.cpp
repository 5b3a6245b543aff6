// SPDX-License-Identifier: Apache-2.0
#include "sea/native/native_runner.h"

#include <algorithm>
#include <array>
#include <bit>
#include <vector>

#include "base/check.h"
#include "base/thread_pool.h"
#include "sea/native/native_state.h"

namespace seaway::sea {

namespace native {

/// One task as the kernels take it.
struct Work {
    const Kernels* kernels;
    ColumnPass columns;
    RowPass rows;
    RowField fields[linear_field_count];
    int rows_a_chunk;
    const std::vector<AlignedFloats>* scratch; ///< one a worker
};

struct RunnerState {
    static constexpr std::size_t lines_held_max = 2;

    explicit RunnerState(int threads) : pool(threads) {}

    ThreadPool pool;
    std::vector<AlignedFloats> scratch; ///< one a worker
    std::size_t scratch_floats = 0;
    AlignedFloats lines[lines_held_max]; ///< between the passes
    std::size_t lines_floats = 0;
    std::vector<Work> work;
    std::vector<Phase> phases;
};

} // namespace native

namespace {

using native::RunnerState;
using native::Work;

constexpr std::size_t overlap_bytes_max = 2u << 20;

std::size_t line_pitch(int size) {
    return static_cast<std::size_t>(size / 2 + 16);
}

float* plane_of(const NativeTask& task, Field field) {
    const auto size = static_cast<std::size_t>(task.cascade->size());
    const auto index = static_cast<std::size_t>(task.fields.index_of(field));
    return task.fields.contains(field) ? task.planes.data() + index * size * size : nullptr;
}

int base_of(Field field) {
    return native::recipe(info(field)).base;
}

constexpr Field strains[] = {Field::strain_xx, Field::strain_yy, Field::strain_xy};

/// Which bases and fields a task needs, and where they go.
void list_fields(const NativeTask& task, const native::TransformState& cascade, Work& work) {
    std::array<Field, linear_field_count> order{};
    int count = 0, scratch_rows = 0;
    std::uint32_t bases = 0, sources = 0;
    for (Field field : NativeRunner::transformed(task.fields)) {
        order[static_cast<std::size_t>(count++)] = field;
        bases |= 1u << base_of(field);
        sources |= 1u << (base_of(field) / 3);
    }
    std::stable_sort(order.begin(), order.begin() + count,
                     [](Field a, Field b) { return base_of(a) < base_of(b); });
    work.rows.odd_bases = 0;
    for (int i = 0; i < count; ++i) {
        const Field field = order[static_cast<std::size_t>(i)];
        float* plane = plane_of(task, field);
        int strain = -1;
        for (int s = 0; s < 3; ++s)
            if (field == strains[s])
                work.rows.strain[strain = s] = i;
        const bool read_again = strain >= 0 && task.fields.contains(Field::jacobian);
        work.fields[i] = {std::popcount(bases & ((1u << base_of(field)) - 1u)),
                          cascade.scale[static_cast<std::size_t>(field)],
                          info(field).imaginary,
                          plane,
                          plane ? 0 : scratch_rows++,
                          cascade.kernels->size >= native::smallest_streamed_size && plane &&
                              !read_again && reinterpret_cast<std::uintptr_t>(plane) % 16 == 0};
        if (base_of(field) % 3 == 1)
            work.rows.odd_bases |= 1u << work.fields[i].base;
    }
    work.columns.bases = bases;
    work.columns.sources = sources;
    work.rows.base_count = std::popcount(bases);
    work.rows.field_count = count;
    work.rows.jacobian = plane_of(task, Field::jacobian);
}

void prepare(const NativeTask& task, const native::TransformState& cascade, float* lines,
             const RunnerState& state, Work& work) {
    const int size = cascade.kernels->size;
    work.kernels = cascade.kernels;
    work.scratch = &state.scratch;
    work.rows_a_chunk = std::clamp(4096 / size, 4, size);
    list_fields(task, cascade, work);
    native::ColumnPass& columns = work.columns;
    columns.blocks = cascade.blocks.data();
    columns.records = cascade.records.get();
    columns.over_k = cascade.over_k.get();
    columns.omega = cascade.omega.get();
    columns.block_count = static_cast<int>(cascade.blocks.size());
    columns.time_us = static_cast<std::uint64_t>(task.phase_time_us);
    std::copy(cascade.ky, cascade.ky + 3, columns.ky);
    columns.plan = cascade.plan;
    columns.lines = lines;
    columns.line_pitch = line_pitch(size);
    native::RowPass& rows = work.rows;
    rows.lines = lines;
    rows.line_pitch = columns.line_pitch;
    rows.columns = columns.block_count * cascade.kernels->lanes;
    rows.plan = cascade.plan;
    rows.fields = work.fields;
    rows.choppiness[0] = static_cast<float>(cascade.choppiness.x);
    rows.choppiness[1] = static_cast<float>(cascade.choppiness.y);
}

void run_columns(const void* context, int chunk, int worker) {
    const auto& work = *static_cast<const Work*>(context);
    work.kernels->columns(work.columns, chunk,
                          (*work.scratch)[static_cast<std::size_t>(worker)].get());
}

void run_rows(const void* context, int chunk, int worker) {
    const auto& work = *static_cast<const Work*>(context);
    const int begin = chunk * work.rows_a_chunk;
    work.kernels->rows(work.rows, begin, std::min(begin + work.rows_a_chunk, work.kernels->size),
                       (*work.scratch)[static_cast<std::size_t>(worker)].get());
}

/// Lines held at a time: with two, columns of a task overlap the last rows of the one before and
/// nobody waits; large ones do better to stay in the cache.
std::size_t lines_held(std::size_t lines_floats) {
    return lines_floats * sizeof(float) <= overlap_bytes_max ? 2 : 1;
}

void schedule(RunnerState& state, std::size_t held) {
    const std::size_t tasks = state.work.size();
    std::vector<int> rows_phase(tasks), columns_phase(tasks);
    state.phases.clear();
    const auto add = [&](const Phase& phase) {
        state.phases.push_back(phase);
        return static_cast<int>(state.phases.size()) - 1;
    };
    const std::size_t ahead = held - 1;
    for (std::size_t i = 0; i < tasks + ahead; ++i) {
        if (i < tasks) {
            const Work& work = state.work[i];
            columns_phase[i] = add({run_columns, &work, work.columns.block_count,
                                    i >= held ? rows_phase[i - held] : -1});
        }
        if (i >= ahead) {
            const Work& work = state.work[i - ahead];
            const int chunks = (work.kernels->size + work.rows_a_chunk - 1) / work.rows_a_chunk;
            rows_phase[i - ahead] = add({run_rows, &work, chunks, columns_phase[i - ahead]});
        }
    }
}

} // namespace

NativeRunner::NativeRunner(int threads) : state_(std::make_unique<RunnerState>(threads)) {}
NativeRunner::~NativeRunner() = default;

int NativeRunner::threads() const {
    return state_->pool.threads();
}

FieldSet NativeRunner::transformed(FieldSet fields) {
    if (fields.contains(Field::jacobian))
        fields |= {Field::strain_xx, Field::strain_yy, Field::strain_xy};
    return FieldSet::from_bits(fields.bits() & ((1u << linear_field_count) - 1u));
}

void NativeRunner::run(std::span<const NativeTask> tasks) {
    RunnerState& state = *state_;
    std::size_t scratch = 0, lines = 0;
    for (const NativeTask& task : tasks) {
        const native::Kernels& kernels = *task.cascade->state_->kernels;
        const auto size = static_cast<std::size_t>(kernels.size);
        SEAWAY_CHECK(!task.fields.contains(Field::foam), "foam is not synthesised");
        SEAWAY_CHECK(task.planes.size() ==
                         static_cast<std::size_t>(task.fields.size()) * size * size,
                     "planes do not match fields and size");
        const auto fields = static_cast<std::size_t>(transformed(task.fields).size());
        scratch = std::max(scratch, kernels.scratch_floats);
        lines = std::max(lines, size * fields * 2 * line_pitch(kernels.size));
    }
    if (scratch > state.scratch_floats) {
        state.scratch.clear();
        for (int worker = 0; worker < threads(); ++worker)
            state.scratch.push_back(native::allocate_floats(scratch));
        state.scratch_floats = scratch;
    }
    if (lines > state.lines_floats) {
        for (native::AlignedFloats& held : state.lines)
            held = native::allocate_floats(lines);
        state.lines_floats = lines;
    }
    const std::size_t held = lines_held(lines);
    state.work.resize(tasks.size());
    for (std::size_t i = 0; i < tasks.size(); ++i)
        prepare(tasks[i], *tasks[i].cascade->state_, state.lines[i % held].get(), state,
                state.work[i]);
    schedule(state, held);
    state.pool.run(state.phases);
}

} // namespace seaway::sea
