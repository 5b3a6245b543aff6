// SPDX-License-Identifier: Apache-2.0
#include "sea/native/batch.h"

#include <algorithm>
#include <array>
#include <bit>

#include "base/check.h"
#include "sea/native/native_state.h"
#include "sea/native/schedule.h"

namespace seaway::sea::native {

namespace {

/// Above this, lines do better to stay in the cache than to be two.
constexpr std::size_t overlap_bytes_max = 2u << 20;

std::size_t line_pitch(int size) {
    return static_cast<std::size_t>(size / 2 + 16);
}

float* plane_of(const NativeTask& task, Field field) {
    const auto size = static_cast<std::size_t>(task.cascade->size());
    const auto plane = [&](std::span<float> planes, FieldSet fields) {
        return planes.data() + static_cast<std::size_t>(fields.index_of(field)) * size * size;
    };
    if (task.fields.contains(field))
        return plane(task.planes, task.fields);
    const bool beside = strain_fields.contains(field) && !task.strains.empty();
    return beside ? plane(task.strains, strain_fields) : nullptr;
}

int base_of(Field field) {
    return recipe(info(field)).base;
}

constexpr Field strains[] = {Field::strain_xx, Field::strain_yy, Field::strain_xy};

} // namespace

/// Which bases and fields a task needs, and where they go.
void Batch::list_fields(const NativeTask& task, Work& work) {
    const TransformState& cascade = *task.cascade->state_;
    std::array<Field, linear_field_count> order{};
    int count = 0, scratch_rows = 0;
    std::uint32_t bases = 0, sources = 0;
    for (Field field : task.transformed()) {
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
                          cascade.kernels->size >= smallest_streamed_size && plane && !read_again &&
                              reinterpret_cast<std::uintptr_t>(plane) % 16 == 0};
        if (base_of(field) % 3 == 1)
            work.rows.odd_bases |= 1u << work.fields[i].base;
    }
    work.columns.bases = bases;
    work.columns.sources = sources;
    work.rows.base_count = std::popcount(bases);
    work.rows.field_count = count;
    work.rows.jacobian = plane_of(task, Field::jacobian);
}

void Batch::lay_out(const NativeTask& task, float* lines, Work& work) const {
    const TransformState& cascade = *task.cascade->state_;
    const int size = cascade.kernels->size;
    work.kernels = cascade.kernels;
    work.scratch = &scratch_;
    work.rows_a_chunk = std::clamp(4096 / size, 4, size);
    list_fields(task, work);
    ColumnPass& columns = work.columns;
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
    RowPass& rows = work.rows;
    rows.lines = lines;
    rows.line_pitch = columns.line_pitch;
    rows.columns = columns.block_count * cascade.kernels->lanes;
    rows.plan = cascade.plan;
    rows.fields = work.fields;
    rows.choppiness[0] = static_cast<float>(cascade.choppiness.x);
    rows.choppiness[1] = static_cast<float>(cascade.choppiness.y);
}

void Batch::run_columns(const void* context, int chunk, int worker) {
    const auto& work = *static_cast<const Work*>(context);
    work.kernels->columns(work.columns, chunk,
                          (*work.scratch)[static_cast<std::size_t>(worker)].get());
}

void Batch::run_rows(const void* context, int chunk, int worker) {
    const auto& work = *static_cast<const Work*>(context);
    const int begin = chunk * work.rows_a_chunk;
    work.kernels->rows(work.rows, begin, std::min(begin + work.rows_a_chunk, work.kernels->size),
                       (*work.scratch)[static_cast<std::size_t>(worker)].get());
}

std::size_t Batch::grow(std::span<const NativeTask> tasks) {
    std::size_t scratch = 0, lines = 0;
    for (const NativeTask& task : tasks) {
        const Kernels& kernels = *task.cascade->state_->kernels;
        const auto size = static_cast<std::size_t>(kernels.size);
        const auto fields = static_cast<std::size_t>(task.transformed().size());
        scratch = std::max(scratch, kernels.scratch_floats);
        lines = std::max(lines, size * fields * 2 * line_pitch(kernels.size));
    }
    if (scratch > scratch_floats_) {
        scratch_floats_ = 0; // should there be no memory for all of them
        scratch_.clear();
        for (int worker = 0; worker < workers_; ++worker)
            scratch_.push_back(allocate_floats(scratch));
        scratch_floats_ = scratch;
    }
    lines_needed_ = std::max(lines_needed_, lines);
    if (lines > lines_floats_) {
        for (AlignedFloats& buffer : lines_)
            buffer = allocate_floats(lines);
        lines_floats_ = lines;
    }
    return lines;
}

std::span<const Phase> Batch::prepare(std::span<const NativeTask> tasks, std::size_t held) {
    const std::size_t lines_floats = grow(tasks);
    if (held == 0)
        held = lines_floats * sizeof(float) <= overlap_bytes_max ? buffers_max : 1;
    work_.resize(tasks.size());
    std::vector<TaskChunks> chunks;
    for (std::size_t i = 0; i < tasks.size(); ++i) {
        lay_out(tasks[i], lines_[lines_of(i, held)].get(), work_[i]);
        const Work& work = work_[i];
        chunks.push_back({work.columns.block_count,
                          (work.kernels->size + work.rows_a_chunk - 1) / work.rows_a_chunk});
    }
    phases_.clear();
    for (const ScheduledPass& pass : schedule(chunks, held))
        phases_.push_back({pass.pass == Pass::columns ? run_columns : run_rows, &work_[pass.task],
                           pass.chunks, pass.after});
    return phases_;
}

void Batch::trim() {
    if (++trims_ % trims_a_look != 0)
        return;
    if (lines_needed_ < lines_floats_) {
        for (AlignedFloats& buffer : lines_)
            buffer.reset();
        lines_floats_ = 0;
    }
    lines_needed_ = 0;
}

std::vector<NativeLines> Batch::lines(std::size_t task) const {
    static constexpr const char* source_names[source_count] = {"h", "h/k", "dh/dt", "dh/dt/k"};
    static constexpr const char* power_names[3] = {"", " ky", " ky^2"};
    const Work& work = work_[task];
    const auto size = static_cast<std::size_t>(work.kernels->size), half = size / 2;
    const auto wanted = static_cast<std::size_t>(work.rows.base_count);
    std::vector<NativeLines> all;
    for (std::size_t base = 0; base < base_count; ++base) {
        if ((work.columns.bases >> base & 1u) == 0)
            continue;
        NativeLines lines{std::string(source_names[base / 3]) + power_names[base % 3],
                          std::vector<std::complex<float>>(size * half)};
        const std::size_t written =
            std::min(half, static_cast<std::size_t>(std::max(work.rows.columns, 0)));
        for (std::size_t y = 0; y < size; ++y) {
            const float* re =
                work.rows.lines + (y * wanted + all.size()) * 2 * work.rows.line_pitch;
            for (std::size_t x = 0; x < written; ++x)
                lines.values[y * half + x] = {re[x], re[x + work.rows.line_pitch]};
        }
        all.push_back(std::move(lines));
    }
    return all;
}

} // namespace seaway::sea::native
