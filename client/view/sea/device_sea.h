// SPDX-License-Identifier: Apache-2.0
// DeviceSea: the sea of a moment in the device's memory, as the shaders of the view read it. Keyframes are copied
// there once, when they first appear, or stand there already (standing_maps.h); interpolation in time, gradients and their mip levels are computed there
// for every frame.
//
//     Result<DeviceSea> sea = DeviceSea::create(device, {.nodes_a_point = 2});
//     sea->take(frame);             // copies what is new
//     sea->describe(frame, camera_m, values);
//     sea->record(commands, values_buffer);  // after it the maps are ready for compute and drawing
//
// Squares of slope are averaged beside slopes: the difference is the variance that a filtered lookup has lost, which
// the shading turns into roughness (LEAN maps, Olano and Baker 2010).
//
// Not thread-safe. One frame may be under way on the device while the next is prepared: what it reads of keyframes
// stays.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "base/result.h"
#include "client/view/sea/sea_frame.h"
#include "client/view/sea/standing_maps.h"
#include "gpu/buffer.h"
#include "gpu/commands.h"
#include "gpu/kernel.h"
#include "shaders/shared/view.h"

namespace seaway::client {

struct DeviceSeaOptions {
    /// Nodes of the gradients a grid point of the keyframes, a side: 1 or 2. The shortest waves have 3 points, and
    /// lookups are linear between nodes.
    int nodes_a_point = 2;
    static constexpr int nodes_min = 64;   ///< more nodes a point where a grid is coarser
    static constexpr int nodes_max = 1024; ///< no more than the points where it is finer
};

class DeviceSea {
  public:
    /// Nodes a side of the gradients of a grid of so many points a side.
    static int nodes_of(int points, const DeviceSeaOptions& options);

    DeviceSea() = default;
    static Result<DeviceSea> create(gpu::Device& device, const DeviceSeaOptions& options);

    /// Maps of this frame have room. Where they have none, take() makes it of what frames under way read: they must be
    /// waited for first.
    bool fits(const SeaFrame& frame) const;

    /// Copies keyframes that are not there yet. frame: 1 .. shaders::view_cascades_max cascades. An error: the
    /// device lacks memory.
    Result<void> take(const SeaFrame& frame, const gpu::Buffer& values);

    /// Where the maps of `frame`, which was taken, lie: in memory, and seen from `camera_m` (world).
    void describe(const SeaFrame& frame, const glm::dvec2& camera_m,
                  shaders::ViewValues& values) const;

    /// The passes from keyframes to mip levels. The view's values must be in the buffer that take() was told.
    void record(gpu::Commands& commands, const gpu::Buffer& values);

    /// [cascade][level][y][x]: Dx, Dy, eta, foam / its mean. Level 0: coefficients of cubic splines; others: means.
    const gpu::TexelView& displacements() const { return displacement_texels_; }
    /// [cascade][level][y][x]: GradientTexel of shaders/view/gradient_texel.glsl.
    const gpu::TexelView& gradients() const { return gradient_texels_; }
    const gpu::Buffer& displacement_buffer() const { return displacements_; }
    const gpu::Buffer& gradient_buffer() const { return gradients_; }
    /// Changes whenever those are others.
    std::uint64_t generation() const { return generation_; }
    /// Maps of keyframes that were copied since the start: splines and foam. None of what stands there.
    std::uint64_t copies() const { return copies_; }
    /// Copies that the next record() makes on the device. Frames that see no sea take it and do not record.
    std::size_t waiting() const { return pending_.size(); }

  private:
    static constexpr int slots = 4; ///< two of this frame, two of the one that is under way
    /// Which maps lie where. What has been copied need not live on; weak, a pointer is never another map's.
    struct Slots {
        std::weak_ptr<const void> holds[slots];
        std::uint64_t used[slots] = {};                         ///< by which frame last
        int find(const std::shared_ptr<const void>& map) const; ///< -1: nowhere
        int oldest() const;
    };
    struct Cascade {
        int points = 0, nodes = 0;
        int displacement_first = 0, gradient_first = 0;
        gpu::Buffer keyframes; ///< none where they stand on the device already
        gpu::TexelView texels;
        gpu::Buffer staging; ///< where the CPU cannot see `keyframes`
        Slots splines, foams;
        std::map<VkBuffer, gpu::Bindings> mix; ///< by buffer of values
    };
    struct Copy {
        std::size_t cascade, first, count; ///< floats
        Slots Cascade::*kept;
        int slot;
    };
    struct Sets {
        gpu::Bindings gradients, mips;
    };

    Result<void> allocate(const SeaFrame& frame);
    Result<void> allocate_keyframes(Cascade& cascade);
    static void describe_standing(const CascadeFrame::Standing& from, sea::TimeUs time_us,
                                  shaders::ViewCascade& out);
    static void describe_copied(const Cascade& kept, const CascadeFrame& from, sea::TimeUs time_us,
                                shaders::ViewCascade& out);
    Result<void> bind(const gpu::Buffer& values);
    Result<void> create_kernels();
    void put(std::size_t cascade, const CascadeFrame& from);
    void copy(std::size_t cascade, Slots& kept, const std::shared_ptr<const void>& map,
              std::span<const float> floats, std::size_t first, std::size_t stride);
    void forget_unwanted();

    gpu::Device* device_ = nullptr;
    DeviceSeaOptions options_;
    gpu::Kernel mix_, level_0_, mips_;
    std::vector<Cascade> cascades_;
    gpu::Buffer displacements_, gradients_;
    gpu::TexelView displacement_texels_, gradient_texels_;
    std::map<VkBuffer, Sets> sets_; ///< by buffer of values
    std::vector<Copy> pending_;     ///< from staging buffers
    StandingMaps standing_;
    bool stands_ = false; ///< what was taken last does
    std::uint64_t generation_ = 0, copies_ = 0, frame_ = 0;
};

} // namespace seaway::client
