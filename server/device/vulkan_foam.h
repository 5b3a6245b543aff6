// SPDX-License-Identifier: Apache-2.0
// VulkanFoam: the foam maps of one size in a device's memory, side by side in one buffer, so that one dispatch takes
// any of them on (shaders/compute/foam.comp). The buffer grows as maps are opened; maps that are let go leave
// their place to the next.
//
// For one thread, but that a map may be let go on any.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "base/result.h"
#include "gpu/buffer.h"
#include "server/device/synthesizer.h"
#include "shaders/shared/synthesis.h"

namespace seaway::server {

class VulkanFoam {
  public:
    /// Maps of so many bytes together at most.
    VulkanFoam(gpu::Device& device, int size, std::size_t bytes_max);
    /// As many as the device binds at once.
    VulkanFoam(gpu::Device& device, int size);
    VulkanFoam(const VulkanFoam&) = delete;
    VulkanFoam& operator=(const VulkanFoam&) = delete;
    /// All maps are lost.
    ~VulkanFoam();

    /// DeviceError::out_of_memory: no more can be bound at once.
    Result<FoamMapPtr> open(const FoamMap* from);

    /// Of all maps; another one, and larger, after some open().
    const gpu::Buffer& histories() const { return *histories_; }
    /// Where a map of this object stands in it, in vec4.
    std::uint32_t place(const FoamMap& map) const;

  private:
    struct Slots;
    struct Map;
    Result<void> grow();

    gpu::Device& device_;
    std::size_t map_bytes_;
    std::size_t slots_max_;
    std::shared_ptr<Slots> slots_;
    std::unique_ptr<gpu::Buffer> histories_; ///< null until a map is opened
};

/// What is done to histories of one size (shaders/shared/synthesis.h).
struct FoamWork {
    const gpu::Buffer* histories = nullptr;
    std::vector<shaders::FoamStep> steps;
    std::vector<std::uint32_t>
        rounds; ///< how many steps each dispatch takes: no two of one history

    bool empty() const { return steps.empty(); }
};

/// Whether one of these requests has a turn of the same map.
bool has_turn_of(std::span<const std::size_t> indices, std::span<const KeyframeRequest> requests,
                 const FoamTurn* turn);

/// What the turns of these requests, of one size, do, those of one map after each other. `histories`: null where none has
/// a turn. `place`: where a map of one of them stands. Ticks are counted in `ticks`.
FoamWork foam_work(const VulkanFoam* histories, std::span<const KeyframeRequest> requests,
                   std::span<const std::size_t> indices,
                   const std::function<std::uint32_t(std::size_t job, sea::Field field)>& place,
                   std::uint64_t& ticks);

/// The numbers of a tick, as the kernel takes them; places and flags are the caller's.
shaders::FoamStep foam_step(const sea::FoamTick& tick);

} // namespace seaway::server
