// SPDX-License-Identifier: Apache-2.0
// VulkanBatch: runs that are under way, one of its own and a ring of those that others follow.
#include <algorithm>
#include <cstring>

#include "base/check.h"
#include "gpu/call.h"
#include "server/device/vulkan_batch.h"
#include "shaders/shared/synthesis.h"

namespace seaway::server {

using Clock = std::chrono::steady_clock;

namespace {

/// Of rounded maps, behind the numbers that say which do not fit.
constexpr std::size_t words_at = shaders::rounded_maps_max * sizeof(std::uint32_t);

} // namespace

bool VulkanBatch::any_under_way() const {
    return own_.under_way || std::ranges::any_of(ring_, &Slot::under_way);
}

VulkanBatch::RunId VulkanBatch::free_slot() const {
    const auto free = std::ranges::find(ring_, false, &Slot::under_way);
    SEAWAY_CHECK(free != ring_.end(), "a run of the ring is finished before the next but two");
    return static_cast<RunId>(free - ring_.begin());
}

Result<bool> VulkanBatch::can_be_followed() {
    if (ring_lacks_memory_)
        return false;
    Slot& slot = ring_[static_cast<std::size_t>(free_slot())];
    if (slot.maps.size_bytes() != 0)
        return true;
    const Result<void> made = make(slot);
    ring_lacks_memory_ = !made && gpu::is_out_of_memory(made.error());
    if (!made && !ring_lacks_memory_)
        return made.error();
    let_ring_go();
    return !ring_lacks_memory_;
}

void VulkanBatch::let_ring_go() {
    for (Slot& slot : ring_)
        if (ring_lacks_memory_ && !slot.under_way)
            slot = {};
}

Result<bool> VulkanBatch::can_round(bool more) {
    Slot& slot = slot_of(more ? free_slot() : own);
    const bool made_before = slot.rounding.get() != VK_NULL_HANDLE;
    if (made_before || rounding_lacks_memory_)
        return made_before;
    const Result<void> made = make_rounding(slot);
    rounding_lacks_memory_ = !made && gpu::is_out_of_memory(made.error());
    if (!made && !rounding_lacks_memory_)
        return made.error();
    if (rounding_lacks_memory_)
        slot.rounded = {}; // it may be the rest that there was no memory for
    return !rounding_lacks_memory_;
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
    const RunId id = more ? free_slot() : own;
    Slot& slot = slot_of(id);
    if (!more)
        let_ring_go(); // what was under way when the memory was lacking
    if (after.foam != nullptr)
        SEAWAY_TRY(bind_foam(first_held ? held_ : slot.target, *after.foam->histories));
    if (after.rounding != nullptr)
        SEAWAY_TRY(make_rounding(slot));
    const std::size_t passes = packing.fields > 0 ? kernels_.passes.size() : 0;
    slot.jobs = jobs.size();
    slot.maps_a_job = static_cast<std::size_t>(packing.maps);
    slot.asked =
        static_cast<std::size_t>(after.rounding != nullptr ? after.rounding->asked : packing.asked);
    slot.is_rounded = after.rounding != nullptr;
    slot.foam = after.foam != nullptr;
    SEAWAY_TRY(record(slot, jobs, packing, after, passes, first_held));
    SEAWAY_TRY(submit(slot, more));
    dispatches_ += passes + (after.jacobian != nullptr) +
                   (after.foam != nullptr ? after.foam->rounds.size() : 0) +
                   (after.rounding != nullptr);
    return id;
}

Result<void> VulkanBatch::record_copying(Slot& slot) {
    SEAWAY_TRY(slot.copying.begin());
    copy_out(slot, slot.copying);
    return slot.copying.end();
}

void VulkanBatch::copy_out(const Slot& slot, gpu::Commands& commands) {
    const std::size_t maps = slot.jobs * slot.asked;
    if (maps == 0)
        return; // what histories go on by stays there
    if (slot.is_rounded) {
        travel(commands, slot.rounded, slot.readback, maps * sizeof(std::uint32_t));
        travel(commands, slot.rounded, slot.readback, maps * map_bytes() / 2, words_at, words_at);
    } else if (slot.asked == slot.maps_a_job) {
        travel(commands, *slot.target.maps, slot.readback, maps * map_bytes());
    } else {
        for (std::size_t job = 0; job < slot.jobs; ++job) {
            const std::size_t at = job * slot.maps_a_job * map_bytes();
            travel(commands, *slot.target.maps, slot.readback, slot.asked * map_bytes(), at, at);
        }
    }
    commands.barrier(gpu::Stage::copy, gpu::Stage::host);
}

void VulkanBatch::travel(gpu::Commands& commands, const gpu::Buffer& from, const gpu::Buffer& to,
                         std::size_t bytes, std::size_t from_at, std::size_t to_at) {
    commands.copy(from, to, bytes, from_at, to_at);
    travelled_bytes_ += bytes;
}

Result<void> VulkanBatch::submit(Slot& slot, bool copies) {
    slot.copied = 0;
    if (copies)
        SEAWAY_TRY(record_copying(slot));
    slot.started = Clock::now();
    SEAWAY_TRY_LET(slot.ticket, device_.submit(slot.commands));
    slot.under_way = true;
    if (copies) {
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
        const double foam = pass_seconds_[pass_seconds_.size() - (slot.is_rounded ? 2 : 1)];
        device_seconds_ -= foam;
        foam_seconds_ += foam;
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

void VulkanBatch::record_rounding(Slot& slot, std::uint32_t first_map) {
    const shaders::RoundPush push{first_map, static_cast<std::uint32_t>(slot.maps_a_job),
                                  static_cast<std::uint32_t>(slot.asked),
                                  static_cast<std::uint32_t>(kernels_.size())};
    const auto groups = static_cast<std::uint32_t>(points() / 8 / shaders::synthesis_workgroup);
    slot.commands.barrier(gpu::Stage::compute, gpu::Stage::compute);
    slot.commands.dispatch(kernels_.round, slot.rounding, std::as_bytes(std::span(&push, 1)),
                           groups, push.asked, static_cast<std::uint32_t>(slot.jobs));
}

bool VulkanBatch::fits(RunId run, int job, int map) const {
    const Slot& slot = slot_of(run);
    const std::size_t index =
        static_cast<std::size_t>(job) * slot.asked + static_cast<std::size_t>(map);
    return slot.readback.mapped_as<std::uint32_t>()[index] == 0;
}

std::span<const std::int16_t> VulkanBatch::steps(RunId run, int job, int map) const {
    const Slot& slot = slot_of(run);
    const std::size_t index =
        static_cast<std::size_t>(job) * slot.asked + static_cast<std::size_t>(map);
    return slot.readback.mapped_as<std::int16_t>().subspan(
        words_at / sizeof(std::int16_t) + index * points(), points());
}

// What was computed still stands there: a place of the ring is its run's until all of it has been read.
Result<void> VulkanBatch::read_exactly(RunId run, std::span<const MapOf> maps) {
    Slot& slot = slot_of(run);
    slot.is_rounded = false;
    SEAWAY_TRY(slot.commands.begin());
    slot.commands.barrier(gpu::Stage::compute, gpu::Stage::copy);
    for (const MapOf& one : maps) {
        const std::size_t at = map_bytes() * (static_cast<std::size_t>(one.job) * slot.maps_a_job +
                                              static_cast<std::size_t>(one.map));
        travel(slot.commands, *slot.target.maps, slot.readback, map_bytes(), at, at);
    }
    slot.commands.barrier(gpu::Stage::copy, gpu::Stage::host);
    SEAWAY_TRY(slot.commands.end());
    return device_.submit_and_wait(slot.commands);
}

} // namespace seaway::server
