// SPDX-License-Identifier: Apache-2.0
#include "server/device/vulkan_batch.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include <fmt/format.h>

#include "base/spare_memory.h"
#include "shaders/shared/synthesis.h"

namespace seaway::server {

using gpu::Buffer;
using gpu::Stage;

int VulkanBatch::max_jobs(int maps) const {
    if (maps > capacity_maps_)
        return 0;
    if (!batches(device_, kernels_.size()) || maps == 0)
        return 1;
    return std::clamp(capacity_maps_ / maps, 1, most_jobs);
}

void VulkanBatch::write(Slot& slot, Buffer& buffer, std::span<const std::byte> bytes) {
    if (!buffer.mapped().empty()) {
        std::memcpy(buffer.mapped().data(), bytes.data(), bytes.size());
        return;
    }
    slot.commands.update(buffer, bytes);
}

Result<void> VulkanBatch::record(Slot& slot, std::span<const Job> jobs, const Packing& packing,
                                 const After& after, std::size_t passes,
                                 std::optional<std::size_t> first_held) {
    if (packing.maps > capacity_maps_)
        return Error{DeviceError::cannot_do_this_sea,
                     fmt::format("{} maps of size {} at once: {} binds {}", packing.maps,
                                 kernels_.size(), device_.info().name, capacity_maps_)};
    scratch_needed_bytes_ =
        std::max(scratch_needed_bytes_,
                 jobs.size() * static_cast<std::size_t>(packing.maps) * scratch_map_bytes());
    std::vector<shaders::SynthesisJob> texels;
    for (const Job& job : jobs) {
        const auto time = static_cast<std::uint64_t>(job.phase_time_us);
        texels.push_back(
            {static_cast<std::uint32_t>(job.cascade), static_cast<std::uint32_t>(time),
             static_cast<std::uint32_t>(time >> 32),
             std::bit_cast<std::uint32_t>(steps_[static_cast<std::size_t>(job.cascade)])});
    }
    SEAWAY_TRY(slot.commands.begin());
    if (time_passes_)
        slot.timer.reset(slot.commands);
    if (any_under_way()) { // whose kernels read what is written now
        slot.commands.barrier(Stage::compute, Stage::copy);
        slot.commands.barrier(Stage::compute, Stage::compute);
    }
    write(slot, jobs_, std::as_bytes(std::span(texels)));
    write(slot, rows_, std::as_bytes(std::span(packing.rows)));
    if (after.foam != nullptr && !after.foam->steps.empty())
        write(slot, foam_steps_, std::as_bytes(std::span(after.foam->steps)));
    if (after.rounding != nullptr) {
        write(slot, scales_, std::as_bytes(std::span(after.rounding->scales)));
        slot.commands.fill(slot.rounded, 0, shaders::rounded_maps_max * sizeof(std::uint32_t));
    }
    if (jobs_.mapped().empty())
        slot.commands.barrier(Stage::copy, Stage::compute);
    const Target& target = first_held ? held_ : slot.target;
    const shaders::SynthesisPush push{static_cast<std::uint32_t>(packing.sources),
                                      static_cast<std::uint32_t>(packing.fields),
                                      static_cast<std::uint32_t>(packing.maps),
                                      static_cast<std::uint32_t>(first_held.value_or(0))};
    const auto count = static_cast<std::uint32_t>(jobs.size());
    record_passes(slot, target, packing, after, passes, push, count);
    if (first_held)
        slot.commands.barrier(Stage::compute, Stage::host); // they stay where they are
    else if (&slot == &own_) // of the ring's the transfer queue does it
        record_readback(slot, packing, passes);
    return slot.commands.end();
}

void VulkanBatch::record_readback(Slot& slot, const Packing& packing, std::size_t passes) {
    if (passes == 0 || passes == kernels_.passes.size()) {
        if (slot.readback.size_bytes() == 0)
            return slot.commands.barrier(Stage::compute, Stage::host);
        slot.commands.barrier(Stage::compute, Stage::copy);
        copy_out(slot, slot.commands);
    } else
        read_back(slot, scratch_[(passes - 1) % 2],
                  pass_floats(passes - 1, packing) * sizeof(float));
}

void VulkanBatch::record_passes(Slot& slot, const Target& target, const Packing& packing,
                                const After& after, std::size_t passes,
                                const shaders::SynthesisPush& push, std::uint32_t jobs) {
    stamp(slot);
    for (std::size_t i = 0; i < passes; ++i) {
        if (i > 0)
            slot.commands.barrier(Stage::compute, Stage::compute);
        const bool last = i + 1 == kernels_.passes.size();
        dispatch(slot, kernels_.passes[i], last ? target.last : bindings_[i], push, jobs);
        stamp(slot);
    }
    if (after.jacobian != nullptr) {
        slot.commands.barrier(Stage::compute, Stage::compute);
        dispatch_jacobian(slot, target, packing, *after.jacobian, push.first_map, jobs);
        stamp(slot);
    }
    if (after.foam != nullptr) {
        record_foam(slot, target, *after.foam);
        stamp(slot);
    }
    if (after.rounding != nullptr) {
        record_rounding(slot, push.first_map);
        stamp(slot);
    }
}

void VulkanBatch::record_foam(Slot& slot, const Target& target, const FoamWork& foam) {
    const std::size_t a_group = std::size_t{4} * kernels_.foam_quads * shaders::synthesis_workgroup;
    const auto groups = static_cast<std::uint32_t>(points() / a_group);
    shaders::FoamPush push{0};
    for (const std::uint32_t count : foam.rounds) {
        slot.commands.barrier(Stage::compute, Stage::compute);
        slot.commands.dispatch(kernels_.foam, target.foam, std::as_bytes(std::span(&push, 1)),
                               groups, 1, count);
        push.first_step += count;
    }
}

// Groups go last: drivers that cut a dispatch in halves then cut each source and field in halves.
void VulkanBatch::dispatch(Slot& slot, const SynthesisKernels::Pass& pass,
                           const gpu::Bindings& bindings, const shaders::SynthesisPush& push,
                           std::uint32_t jobs) {
    std::uint32_t parts = 1;
    if (pass.kind == shaders::PassKind::lines_x)
        parts = push.fields;
    else if (pass.kind != shaders::PassKind::evolve)
        parts = push.sources;
    slot.commands.dispatch(pass.kernel, bindings, std::as_bytes(std::span(&push, 1)), parts, jobs,
                           pass.groups);
}

void VulkanBatch::dispatch_jacobian(Slot& slot, const Target& target, const Packing& packing,
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
    slot.commands.dispatch(kernels_.jacobian, target.jacobian, std::as_bytes(std::span(&push, 1)),
                           groups, 1, jobs);
}

void VulkanBatch::trim() {
    let_ring_go();
    if (!device_.info().is_cpu() || ++trims_ % VulkanMaps::kept_trims != 0)
        return;
    for (const Buffer& scratch : scratch_)
        if (scratch.mapped().size() > scratch_needed_bytes_)
            give_back_pages(scratch.mapped().subspan(scratch_needed_bytes_));
    scratch_needed_bytes_ = 0;
}

void VulkanBatch::read_back(Slot& slot, const Buffer& result, std::size_t bytes) {
    if (slot.readback.size_bytes() == 0) {
        slot.commands.barrier(Stage::compute, Stage::host);
        return;
    }
    slot.commands.barrier(Stage::compute, Stage::copy);
    travel(slot.commands, result, slot.readback, bytes);
    slot.commands.barrier(Stage::copy, Stage::host);
}

} // namespace seaway::server
