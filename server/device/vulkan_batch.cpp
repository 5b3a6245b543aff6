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
                                 const sea::Choppiness* choppiness, std::size_t passes) {
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
    if (choppiness != nullptr) {
        commands_.barrier(Stage::compute, Stage::compute);
        dispatch_jacobian(packing, *choppiness, count);
        stamp();
    }
    const std::size_t map_bytes = points() * jobs.size() * sizeof(float);
    const std::size_t bytes = passes == kernels_.passes.size()
                                  ? map_bytes * push.fields
                                  : pass_floats(passes - 1, packing) * sizeof(float);
    finish(target(passes - 1), bytes, choppiness != nullptr ? map_bytes : 0);
    return commands_.end();
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

void VulkanBatch::finish(const Buffer& result, std::size_t bytes, std::size_t jacobian_bytes) {
    if (readback_.size_bytes() == 0) {
        commands_.barrier(Stage::compute, Stage::host);
        return;
    }
    commands_.barrier(Stage::compute, Stage::copy);
    commands_.copy(result, readback_, bytes);
    if (jacobian_bytes > 0)
        commands_.copy(jacobian_, readback_, jacobian_bytes, 0, jacobian_offset_);
    commands_.barrier(Stage::copy, Stage::host);
}

Result<void> VulkanBatch::run(std::span<const Job> jobs, const Packing& packing,
                              const sea::Choppiness* choppiness) {
    SEAWAY_CHECK(packing.fields > 0 && !jobs.empty(), "nothing to run");
    SEAWAY_CHECK(static_cast<int>(jobs.size()) <= max_jobs(packing.fields), "too many jobs");
    SEAWAY_TRY(record(jobs, packing, choppiness, kernels_.passes.size()));
    const auto start = std::chrono::steady_clock::now();
    SEAWAY_TRY(device_.submit_and_wait(commands_));
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
    fields_ = static_cast<std::size_t>(packing.fields);
    dispatches_ += kernels_.passes.size() + (choppiness != nullptr ? 1 : 0);
    return read_timer(wall.count());
}

void VulkanBatch::stamp() {
    if (time_passes_)
        timer_.stamp(commands_);
}

Result<void> VulkanBatch::read_timer(double wall_seconds) {
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
    return {};
}

void VulkanBatch::read_plane(int job, int plane, std::span<float> out) const {
    const std::byte* from = (readback_.size_bytes() ? readback_ : maps()).mapped().data();
    const std::size_t index =
        static_cast<std::size_t>(job) * fields_ + static_cast<std::size_t>(plane);
    std::memcpy(out.data(), from + index * points() * sizeof(float), points() * sizeof(float));
}

void VulkanBatch::read_jacobian(int job, std::span<float> out) const {
    const std::byte* from = readback_.size_bytes() ? readback_.mapped().data() + jacobian_offset_
                                                   : jacobian_.mapped().data();
    std::memcpy(out.data(), from + static_cast<std::size_t>(job) * points() * sizeof(float),
                points() * sizeof(float));
}

} // namespace seaway::server
