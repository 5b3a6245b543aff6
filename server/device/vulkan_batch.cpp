// SPDX-License-Identifier: Apache-2.0
#include "server/device/vulkan_batch.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstring>

#include "base/check.h"
#include "shaders/shared/synthesis.h"

namespace seaway::server {

using gpu::Buffer;
using gpu::Stage;

namespace {

constexpr std::size_t vec4_bytes = 16;

} // namespace

int VulkanBatch::max_jobs(int fields) const {
    if (kernels_.size() > largest_batched_size || fields == 0)
        return 1;
    return std::clamp(capacity_fields_ / fields, 1, most_jobs);
}

void VulkanBatch::write(Buffer& buffer, std::span<const std::byte> bytes) {
    if (!buffer.mapped().empty()) {
        std::memcpy(buffer.mapped().data(), bytes.data(), bytes.size());
        return;
    }
    commands_.update(buffer, bytes);
}

Result<void> VulkanBatch::record(std::span<const Job> jobs, const Packing& packing,
                                 const After& after, std::size_t passes) {
    std::vector<shaders::SynthesisJob> texels;
    for (const Job& job : jobs) {
        const auto time = static_cast<std::uint64_t>(job.phase_time_us);
        texels.push_back(
            {static_cast<std::uint32_t>(job.cascade), static_cast<std::uint32_t>(time),
             static_cast<std::uint32_t>(time >> 32),
             std::bit_cast<std::uint32_t>(steps_[static_cast<std::size_t>(job.cascade)])});
    }
    SEAWAY_TRY(commands_.begin());
    if (time_passes_)
        timer_.reset(commands_);
    write(jobs_, std::as_bytes(std::span(texels)));
    write(rows_, std::as_bytes(std::span(packing.rows)));
    if (after.foam != nullptr && !after.foam->steps.empty())
        write(foam_steps_, std::as_bytes(std::span(after.foam->steps)));
    if (jobs_.mapped().empty())
        commands_.barrier(Stage::copy, Stage::compute);
    stamp();
    const shaders::SynthesisPush push{static_cast<std::uint32_t>(packing.sources),
                                      static_cast<std::uint32_t>(packing.fields)};
    const auto count = static_cast<std::uint32_t>(jobs.size());
    for (std::size_t i = 0; i < passes; ++i) {
        if (i > 0)
            commands_.barrier(Stage::compute, Stage::compute);
        dispatch(kernels_.passes[i], bindings_[i], push, count);
        stamp();
    }
    if (after.jacobian != nullptr) {
        commands_.barrier(Stage::compute, Stage::compute);
        dispatch_jacobian(packing, *after.jacobian, count);
        stamp();
    }
    if (after.foam != nullptr) {
        record_foam(*after.foam);
        stamp();
    }
    const std::size_t map_bytes = points() * jobs.size() * sizeof(float);
    const std::size_t bytes = passes == kernels_.passes.size() || passes == 0
                                  ? map_bytes * push.fields
                                  : pass_floats(passes - 1, packing) * sizeof(float);
    finish(passes == 0 ? maps() : target(passes - 1), bytes,
           after.jacobian != nullptr ? map_bytes : 0, after.foam != nullptr ? map_bytes : 0);
    return commands_.end();
}

void VulkanBatch::record_foam(const FoamWork& foam) {
    constexpr std::size_t a_group = 4 * shaders::foam_quads * shaders::synthesis_workgroup;
    const auto groups = static_cast<std::uint32_t>(points() / a_group);
    shaders::FoamPush push{0};
    for (const std::uint32_t count : foam.rounds) {
        commands_.barrier(Stage::compute, Stage::compute);
        commands_.dispatch(kernels_.foam, foam_bindings_, std::as_bytes(std::span(&push, 1)),
                           groups, 1, count);
        push.first_step += count;
    }
    if (!foam.copies.empty())
        commands_.barrier(Stage::compute, Stage::copy);
    for (const FoamWork::Copy& copy : foam.copies)
        commands_.copy(*foam.histories, foam_, points() * sizeof(float), copy.history * vec4_bytes,
                       copy.shown * vec4_bytes);
    if (!foam.copies.empty()) { // whoever reads maps, in place or by a copy
        commands_.barrier(Stage::copy, Stage::host);
        commands_.barrier(Stage::copy, Stage::copy);
    }
}

// Groups go last: drivers that cut a dispatch in halves then cut each source and field in halves.
void VulkanBatch::dispatch(const SynthesisKernels::Pass& pass, const gpu::Bindings& bindings,
                           const shaders::SynthesisPush& push, std::uint32_t jobs) {
    std::uint32_t parts = 1;
    if (pass.kind == shaders::PassKind::lines_y || pass.kind == shaders::PassKind::fields)
        parts = push.sources;
    if (pass.kind == shaders::PassKind::lines_x)
        parts = push.fields;
    commands_.dispatch(pass.kernel, bindings, std::as_bytes(std::span(&push, 1)), parts, jobs,
                       pass.groups);
}

void VulkanBatch::dispatch_jacobian(const Packing& packing, const sea::Choppiness& choppiness,
                                    std::uint32_t jobs) {
    const auto plane = [&](sea::Field field) {
        return static_cast<std::uint32_t>(packing.plane_of(field));
    };
    const shaders::JacobianPush push{static_cast<std::uint32_t>(packing.fields),
                                     plane(sea::Field::strain_xx),
                                     plane(sea::Field::strain_yy),
                                     plane(sea::Field::strain_xy),
                                     static_cast<float>(choppiness.x),
                                     static_cast<float>(choppiness.y),
                                     static_cast<std::uint32_t>(kernels_.size())};
    const auto groups = static_cast<std::uint32_t>(points() / 4 / shaders::synthesis_workgroup);
    commands_.dispatch(kernels_.jacobian, jacobian_bindings_, std::as_bytes(std::span(&push, 1)),
                       groups, 1, jobs);
}

void VulkanBatch::finish(const Buffer& result, std::size_t bytes, std::size_t jacobian_bytes,
                         std::size_t foam_bytes) {
    if (readback_.size_bytes() == 0) {
        commands_.barrier(Stage::compute, Stage::host);
        return;
    }
    commands_.barrier(Stage::compute, Stage::copy);
    if (bytes > 0)
        commands_.copy(result, readback_, bytes);
    if (jacobian_bytes > 0)
        commands_.copy(jacobian_, readback_, jacobian_bytes, 0, jacobian_offset_);
    if (foam_bytes > 0)
        commands_.copy(foam_, readback_, foam_bytes, 0, foam_offset_);
    commands_.barrier(Stage::copy, Stage::host);
}

Result<void> VulkanBatch::run(std::span<const Job> jobs, const Packing& packing,
                              const After& after) {
    SEAWAY_CHECK((packing.fields > 0 || after.foam != nullptr) && !jobs.empty(), "nothing to run");
    SEAWAY_CHECK(static_cast<int>(jobs.size()) <= max_jobs(packing.fields), "too many jobs");
    SEAWAY_CHECK(after.foam == nullptr || after.foam->steps.size() <= shaders::foam_steps_max,
                 "more steps of foam than there is room for");
    if (after.foam != nullptr)
        SEAWAY_TRY(bind_foam(*after.foam->histories));
    const std::size_t passes = packing.fields > 0 ? kernels_.passes.size() : 0;
    SEAWAY_TRY(record(jobs, packing, after, passes));
    const auto start = std::chrono::steady_clock::now();
    SEAWAY_TRY(device_.submit_and_wait(commands_));
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
    fields_ = static_cast<std::size_t>(packing.fields);
    dispatches_ += passes + (after.jacobian != nullptr) +
                   (after.foam != nullptr ? after.foam->rounds.size() : 0);
    return read_timer(wall.count(), after.foam != nullptr);
}

void VulkanBatch::stamp() {
    if (time_passes_)
        timer_.stamp(commands_);
}

Result<void> VulkanBatch::read_timer(double wall_seconds, bool foam) {
    if (!time_passes_) {
        device_seconds_ += wall_seconds;
        return {};
    }
    Result<std::vector<double>> seconds = timer_.read(device_);
    if (!seconds)
        return seconds.error();
    pass_seconds_ = std::move(*seconds);
    for (const double pass : pass_seconds_)
        device_seconds_ += pass;
    if (foam) {
        device_seconds_ -= pass_seconds_.back();
        foam_seconds_ += pass_seconds_.back();
    }
    return {};
}

void VulkanBatch::read(const Buffer& mapped, std::size_t readback_offset, std::size_t plane,
                       std::span<float> out) const {
    const std::byte* from = readback_.size_bytes() ? readback_.mapped().data() + readback_offset
                                                   : mapped.mapped().data();
    std::memcpy(out.data(), from + plane * points() * sizeof(float), points() * sizeof(float));
}

void VulkanBatch::read_plane(int job, int plane, std::span<float> out) const {
    read(maps(), 0, static_cast<std::size_t>(job) * fields_ + static_cast<std::size_t>(plane), out);
}

void VulkanBatch::read_jacobian(int job, std::span<float> out) const {
    read(jacobian_, jacobian_offset_, static_cast<std::size_t>(job), out);
}

void VulkanBatch::read_foam(int job, std::span<float> out) const {
    read(foam_, foam_offset_, static_cast<std::size_t>(job), out);
}

} // namespace seaway::server
