// SPDX-License-Identifier: Apache-2.0
#include "server/device/vulkan_batch.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstring>

#include <fmt/format.h>

#include "base/check.h"
#include "shaders/shared/synthesis.h"

namespace seaway::server {

using gpu::Buffer;
using gpu::Stage;

namespace {

constexpr std::size_t vec4_bytes = 16;

} // namespace

int VulkanBatch::max_jobs(int maps) const {
    if (maps > capacity_maps_)
        return 0;
    if (kernels_.size() > largest_batched_size || maps == 0)
        return 1;
    return std::clamp(capacity_maps_ / maps, 1, most_jobs);
}

void VulkanBatch::write(Buffer& buffer, std::span<const std::byte> bytes) {
    if (!buffer.mapped().empty()) {
        std::memcpy(buffer.mapped().data(), bytes.data(), bytes.size());
        return;
    }
    commands_.update(buffer, bytes);
}

Result<void> VulkanBatch::record(std::span<const Job> jobs, const Packing& packing,
                                 const After& after, std::size_t passes,
                                 std::optional<std::size_t> first_held) {
    if (packing.maps > capacity_maps_)
        return Error{DeviceError::cannot_do_this_sea,
                     fmt::format("{} maps of size {} at once: {} binds {}", packing.maps,
                                 kernels_.size(), device_.info().name, capacity_maps_)};
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
    const Target& target = first_held ? held_ : own_;
    const auto first_map = static_cast<std::uint32_t>(first_held.value_or(0));
    const shaders::SynthesisPush push{static_cast<std::uint32_t>(packing.sources),
                                      static_cast<std::uint32_t>(packing.fields),
                                      static_cast<std::uint32_t>(packing.maps), first_map};
    const auto count = static_cast<std::uint32_t>(jobs.size());
    for (std::size_t i = 0; i < passes; ++i) {
        if (i > 0)
            commands_.barrier(Stage::compute, Stage::compute);
        const bool last = i + 1 == kernels_.passes.size();
        dispatch(kernels_.passes[i], last ? target.last : bindings_[i], push, count);
        stamp();
    }
    if (after.jacobian != nullptr) {
        commands_.barrier(Stage::compute, Stage::compute);
        dispatch_jacobian(target, packing, *after.jacobian, first_map, count);
        stamp();
    }
    if (after.foam != nullptr) {
        record_foam(target, *after.foam);
        stamp();
    }
    if (first_held)
        commands_.barrier(Stage::compute, Stage::host); // they stay where they are
    else if (passes == 0 || passes == kernels_.passes.size())
        finish(*target.maps, map_bytes() * jobs.size() * push.maps);
    else
        finish(scratch_[(passes - 1) % 2], pass_floats(passes - 1, packing) * sizeof(float));
    return commands_.end();
}

void VulkanBatch::record_foam(const Target& target, const FoamWork& foam) {
    constexpr std::size_t a_group = 4 * shaders::foam_quads * shaders::synthesis_workgroup;
    const auto groups = static_cast<std::uint32_t>(points() / a_group);
    shaders::FoamPush push{0};
    for (const std::uint32_t count : foam.rounds) {
        commands_.barrier(Stage::compute, Stage::compute);
        commands_.dispatch(kernels_.foam, target.foam, std::as_bytes(std::span(&push, 1)), groups,
                           1, count);
        push.first_step += count;
    }
    if (!foam.copies.empty())
        commands_.barrier(Stage::compute, Stage::copy);
    for (const FoamWork::Copy& copy : foam.copies)
        commands_.copy(*foam.histories, *target.maps, map_bytes(), copy.history * vec4_bytes,
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

void VulkanBatch::dispatch_jacobian(const Target& target, const Packing& packing,
                                    const sea::Choppiness& choppiness, std::uint32_t first_map,
                                    std::uint32_t jobs) {
    const auto map = [&](sea::Field field) {
        return static_cast<std::uint32_t>(packing.map_of(field));
    };
    const shaders::JacobianPush push{static_cast<std::uint32_t>(packing.maps),
                                     first_map,
                                     map(sea::Field::strain_xx),
                                     map(sea::Field::strain_yy),
                                     map(sea::Field::strain_xy),
                                     map(sea::Field::jacobian),
                                     static_cast<float>(choppiness.x),
                                     static_cast<float>(choppiness.y),
                                     static_cast<std::uint32_t>(kernels_.size())};
    const auto groups = static_cast<std::uint32_t>(points() / 4 / shaders::synthesis_workgroup);
    commands_.dispatch(kernels_.jacobian, target.jacobian, std::as_bytes(std::span(&push, 1)),
                       groups, 1, jobs);
}

void VulkanBatch::finish(const Buffer& result, std::size_t bytes) {
    if (readback_.size_bytes() == 0) {
        commands_.barrier(Stage::compute, Stage::host);
        return;
    }
    if (bytes == 0)
        return;
    commands_.barrier(Stage::compute, Stage::copy);
    commands_.copy(result, readback_, bytes);
    commands_.barrier(Stage::copy, Stage::host);
}

Result<void> VulkanBatch::run(std::span<const Job> jobs, const Packing& packing, const After& after,
                              std::optional<std::size_t> first_held) {
    SEAWAY_CHECK((packing.fields > 0 || after.foam != nullptr) && !jobs.empty(), "nothing to run");
    SEAWAY_CHECK(jobs.size() == 1 || static_cast<int>(jobs.size()) <= max_jobs(packing.maps),
                 "too many jobs");
    SEAWAY_CHECK(after.foam == nullptr || after.foam->steps.size() <= shaders::foam_steps_max,
                 "more steps of foam than there is room for");
    if (after.foam != nullptr)
        SEAWAY_TRY(bind_foam(first_held ? held_ : own_, *after.foam->histories));
    const std::size_t passes = packing.fields > 0 ? kernels_.passes.size() : 0;
    SEAWAY_TRY(record(jobs, packing, after, passes, first_held));
    const auto start = std::chrono::steady_clock::now();
    SEAWAY_TRY(device_.submit_and_wait(commands_));
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
    maps_ = static_cast<std::size_t>(packing.maps);
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

void VulkanBatch::read_map(int job, int map, std::span<float> out) const {
    const std::byte* from = (readback_.size_bytes() ? readback_ : *own_.maps).mapped().data();
    const std::size_t index = static_cast<std::size_t>(job) * maps_ + static_cast<std::size_t>(map);
    std::memcpy(out.data(), from + index * map_bytes(), map_bytes());
}

} // namespace seaway::server
