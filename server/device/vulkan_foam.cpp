// SPDX-License-Identifier: Apache-2.0
#include "server/device/vulkan_foam.h"

#include <algorithm>
#include <bit>
#include <map>
#include <mutex>
#include <vector>

#include <fmt/format.h>

#include "base/check.h"
#include "gpu/commands.h"
#include "server/device/vulkan_fields.h"

namespace seaway::server {

namespace {

constexpr std::size_t first_slots = 4;

/// What earlier submissions wrote is there for copies: whoever waited for them has made it available, but not visible to this one.
void after_all(gpu::Commands& commands) {
    commands.barrier(gpu::Stage::compute, gpu::Stage::copy);
    commands.barrier(gpu::Stage::copy, gpu::Stage::copy);
}

} // namespace

/// Which places are taken. Outlives the device.
struct VulkanFoam::Slots {
    std::mutex mutex;
    std::vector<bool> taken;
    bool lost = false;
};

struct VulkanFoam::Map final : FoamMap {
    Map(std::shared_ptr<Slots> all, std::size_t own) : slots(std::move(all)), slot(own) {}
    ~Map() override {
        const std::scoped_lock lock(slots->mutex);
        slots->taken[slot] = false;
    }
    bool lost() const override {
        const std::scoped_lock lock(slots->mutex);
        return slots->lost;
    }
    const std::shared_ptr<Slots> slots;
    const std::size_t slot;
};

VulkanFoam::VulkanFoam(gpu::Device& device, int size, std::size_t bytes_max)
    : device_(device),
      map_bytes_(static_cast<std::size_t>(size) * static_cast<std::size_t>(size) * sizeof(float)),
      slots_max_(bytes_max / map_bytes_), slots_(std::make_shared<Slots>()) {}

VulkanFoam::VulkanFoam(gpu::Device& device, int size)
    : VulkanFoam(device, size, gpu::bound_bytes_max(device, vec4_bytes)) {}

VulkanFoam::~VulkanFoam() {
    const std::scoped_lock lock(slots_->mutex);
    slots_->lost = true;
}

std::uint32_t VulkanFoam::place(const FoamMap& map) const {
    const Map& own = static_cast<const Map&>(map);
    SEAWAY_CHECK(own.slots == slots_, "a foam map of another size or device");
    return static_cast<std::uint32_t>(own.slot * map_bytes_ / vec4_bytes);
}

Result<void> VulkanFoam::grow() {
    const std::size_t before = slots_->taken.size();
    const std::size_t slots = std::min(std::max(2 * before, first_slots), slots_max_);
    if (slots == before)
        return Error{DeviceError::out_of_memory,
                     fmt::format("{} foam maps of {} bytes are all that is bound at once", before,
                                 map_bytes_)};
    SEAWAY_TRY_LET(gpu::Buffer made,
                   gpu::Buffer::create(device_, "foam histories", slots * map_bytes_,
                                       gpu::BufferKind::device));
    if (histories_)
        SEAWAY_TRY(gpu::run_once(device_, [&](gpu::Commands& commands) {
            after_all(commands);
            commands.copy(*histories_, made, before * map_bytes_);
            commands.barrier(gpu::Stage::copy, gpu::Stage::compute);
        }));
    auto histories = std::make_unique<gpu::Buffer>(std::move(made));
    const std::scoped_lock lock(slots_->mutex);
    slots_->taken.resize(slots, false);
    histories_ = std::move(histories);
    return {};
}

Result<FoamMapPtr> VulkanFoam::open(const FoamMap* from) {
    const auto free_slot = [&] {
        const std::scoped_lock lock(slots_->mutex);
        return static_cast<std::size_t>(std::ranges::find(slots_->taken, false) -
                                        slots_->taken.begin());
    };
    std::size_t slot = free_slot();
    if (slot == slots_->taken.size()) {
        SEAWAY_TRY(grow());
        slot = free_slot();
    }
    FoamMapPtr map = std::make_shared<Map>(slots_, slot);
    SEAWAY_TRY(gpu::run_once(device_, [&](gpu::Commands& commands) {
        after_all(commands);
        if (from != nullptr)
            commands.copy(*histories_, *histories_, map_bytes_, place(*from) * vec4_bytes,
                          slot * map_bytes_);
        else
            commands.fill(*histories_, std::bit_cast<std::uint32_t>(1.0f), map_bytes_,
                          slot * map_bytes_);
        commands.barrier(gpu::Stage::copy, gpu::Stage::compute);
    }));
    const std::scoped_lock lock(slots_->mutex);
    slots_->taken[slot] = true;
    return map;
}

shaders::FoamStep foam_step(const sea::FoamTick& t) {
    return {t.threshold,
            t.bias,
            t.choppiness_x,
            t.choppiness_y,
            t.choppiness_xy,
            t.variance,
            t.difference,
            t.shear,
            t.curvature,
            t.difference_rest,
            t.shear_rest,
            t.cross_rest,
            t.constant_rest,
            t.remains,
            t.source,
            t.added,
            0,
            0,
            0,
            t.looks() ? shaders::foam_looks : 0u,
            0,
            0,
            1.0f,
            0};
}

bool has_turn_of(std::span<const std::size_t> indices, std::span<const KeyframeRequest> requests,
                 const FoamTurn* turn) {
    return turn != nullptr && std::ranges::any_of(indices, [&](std::size_t i) {
               return requests[i].foam != nullptr && requests[i].foam->map == turn->map;
           });
}

FoamWork foam_work(const VulkanFoam* histories, std::span<const KeyframeRequest> requests,
                   std::span<const std::size_t> indices,
                   const std::function<std::uint32_t(std::size_t job, sea::Field field)>& place,
                   std::uint64_t& ticks) {
    FoamWork work;
    std::vector<std::vector<shaders::FoamStep>> rounds;
    std::map<const FoamMap*, std::size_t> taken; ///< rounds of each map
    for (std::size_t job = 0; job < indices.size(); ++job) {
        const KeyframeRequest& request = requests[indices[job]];
        if (request.foam == nullptr)
            continue;
        const FoamTurn& foam = *request.foam;
        work.histories = &histories->histories();
        const auto add = [&](const sea::FoamTick& tick, std::uint32_t flags) {
            shaders::FoamStep step = foam_step(tick);
            step.flags |= flags;
            if (tick.looks()) {
                step.strain_xx = place(job, sea::Field::strain_xx);
                step.strain_yy = place(job, sea::Field::strain_yy);
                step.strain_xy = place(job, sea::Field::strain_xy);
            }
            step.history = histories->place(*foam.map);
            step.shown = flags & shaders::foam_shows ? place(job, sea::Field::foam) : 0;
            step.departure = foam.shown.departure;
            const std::size_t round = taken[foam.map]++;
            rounds.resize(std::max(rounds.size(), round + 1));
            rounds[round].push_back(step);
        };
        const bool shows = request.fields.contains(sea::Field::foam);
        const bool at_once =
            foam.kept && shows && foam.shown.is_state(); // what is kept is what is shown
        if (foam.kept)
            add(*foam.kept, shaders::foam_keeps | (at_once ? shaders::foam_shows : 0u));
        if (shows && !at_once)
            add(foam.shown.tick, shaders::foam_shows);
        ticks += foam.kept.has_value() + (shows && foam.shown.tick.looks());
    }
    for (const std::vector<shaders::FoamStep>& round : rounds) {
        work.steps.insert(work.steps.end(), round.begin(), round.end());
        work.rounds.push_back(static_cast<std::uint32_t>(round.size()));
    }
    return work;
}

} // namespace seaway::server
