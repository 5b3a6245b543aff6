// SPDX-License-Identifier: Apache-2.0
// VulkanBatch: runs that are under way, one of its own and a ring of those that others follow.
#include <algorithm>
#include <cstring>

#include "base/check.h"
#include "server/device/vulkan_batch.h"
#include "shaders/shared/synthesis.h"

namespace seaway::server {

using Clock = std::chrono::steady_clock;

bool VulkanBatch::any_under_way() const {
    return own_.under_way || std::ranges::any_of(ring_, &Slot::under_way);
}

Result<VulkanBatch::RunId> VulkanBatch::free_slot() {
    const auto free = std::ranges::find(ring_, false, &Slot::under_way);
    SEAWAY_CHECK(free != ring_.end(), "a run of the ring is finished before the next but two");
    if (free->maps.size_bytes() == 0)
        SEAWAY_TRY(make(*free));
    return static_cast<RunId>(free - ring_.begin());
}

Result<void> VulkanBatch::run(std::span<const Job> jobs, const Packing& packing, const After& after,
                              std::optional<std::size_t> first_held) {
    const Result<RunId> started = start(jobs, packing, after, first_held, false);
    const Result<void> ran = started ? finish(*started) : Result<void>(started.error());
    if (!ran)
        abandon();
    return ran;
}

Result<VulkanBatch::RunId> VulkanBatch::start(std::span<const Job> jobs, const Packing& packing,
                                              const After& after,
                                              std::optional<std::size_t> first_held, bool more) {
    SEAWAY_CHECK((packing.fields > 0 || after.foam != nullptr) && !jobs.empty(), "nothing to run");
    SEAWAY_CHECK(jobs.size() == 1 || static_cast<int>(jobs.size()) <= max_jobs(packing.maps),
                 "too many jobs");
    SEAWAY_CHECK(after.foam == nullptr || after.foam->steps.size() <= shaders::foam_steps_max,
                 "more steps of foam than there is room for");
    SEAWAY_CHECK(!own_.under_way && !(more && first_held), "a run that others may follow");
    RunId id = own;
    if (more) {
        SEAWAY_TRY_LET(id, free_slot());
    }
    Slot& slot = slot_of(id);
    if (after.foam != nullptr)
        SEAWAY_TRY(bind_foam(first_held ? held_ : slot.target, *after.foam->histories));
    const std::size_t passes = packing.fields > 0 ? kernels_.passes.size() : 0;
    SEAWAY_TRY(record(slot, jobs, packing, after, passes, first_held));
    slot.maps_a_job = static_cast<std::size_t>(packing.maps);
    slot.foam = after.foam != nullptr;
    slot.bytes = map_bytes() * jobs.size() * slot.maps_a_job;
    SEAWAY_TRY(submit(slot, more ? slot.bytes : 0));
    dispatches_ += passes + (after.jacobian != nullptr) +
                   (after.foam != nullptr ? after.foam->rounds.size() : 0);
    return id;
}

Result<void> VulkanBatch::record_copying(Slot& slot, std::size_t bytes) {
    SEAWAY_TRY(slot.copying.begin());
    slot.copying.acquire_for_transfer(slot.maps);
    slot.copying.copy(slot.maps, slot.readback, bytes);
    slot.copying.barrier(gpu::Stage::copy, gpu::Stage::host);
    return slot.copying.end();
}

Result<void> VulkanBatch::submit(Slot& slot, std::size_t copied_bytes) {
    slot.copied = 0;
    if (copied_bytes > 0)
        SEAWAY_TRY(record_copying(slot, copied_bytes));
    slot.started = Clock::now();
    SEAWAY_TRY_LET(slot.ticket, device_.submit(slot.commands));
    slot.under_way = true;
    if (copied_bytes > 0) {
        SEAWAY_TRY_LET(slot.copied, device_.submit_transfer(slot.copying, slot.ticket));
    }
    return {};
}

Result<void> VulkanBatch::finish(RunId run) {
    Slot& slot = slot_of(run);
    SEAWAY_CHECK(slot.under_way, "a run that was started");
    SEAWAY_TRY(device_.wait(slot.ticket));
    // Runs follow each other: of two under way the second began when the first was done.
    const Clock::time_point now = Clock::now();
    const std::chrono::duration<double> wall = now - std::max(slot.started, computed_);
    computed_ = now;
    if (slot.copied > 0)
        SEAWAY_TRY(device_.wait_transfer(slot.copied));
    slot.under_way = false;
    return read_timer(slot, wall.count());
}

std::size_t VulkanBatch::travelled_bytes(RunId run) const {
    const Slot& slot = slot_of(run);
    return slot.readback.size_bytes() > 0 ? slot.bytes : 0;
}

void VulkanBatch::abandon() {
    const auto forget = [&](Slot& slot) {
        if (!slot.under_way)
            return;
        slot.under_way = false;
        // A device that cannot be waited for runs nothing any more (Device::wait).
        if (const Result<void> waited = device_.wait(slot.ticket); waited && slot.copied > 0)
            (void)device_.wait_transfer(slot.copied);
    };
    forget(own_);
    std::ranges::for_each(ring_, forget);
}

void VulkanBatch::stamp(Slot& slot) {
    if (time_passes_)
        slot.timer.stamp(slot.commands);
}

Result<void> VulkanBatch::read_timer(Slot& slot, double wall_seconds) {
    if (!time_passes_) {
        device_seconds_ += wall_seconds;
        return {};
    }
    SEAWAY_TRY_LET(pass_seconds_, slot.timer.read(device_));
    for (const double pass : pass_seconds_)
        device_seconds_ += pass;
    if (slot.foam) {
        device_seconds_ -= pass_seconds_.back();
        foam_seconds_ += pass_seconds_.back();
    }
    return {};
}

void VulkanBatch::read_map(RunId run, int job, int map, std::span<float> out) const {
    const Slot& slot = slot_of(run);
    const gpu::Buffer& there = slot.readback.size_bytes() > 0 ? slot.readback : *slot.target.maps;
    const std::size_t index =
        static_cast<std::size_t>(job) * slot.maps_a_job + static_cast<std::size_t>(map);
    std::memcpy(out.data(), there.mapped().data() + index * map_bytes(), map_bytes());
}

} // namespace seaway::server
