// SPDX-License-Identifier: Apache-2.0
// Synthesizer on a Vulkan device: a GPU, or lavapipe where there is none.
//
// Cascades of one size and field list share their dispatches. Fields that nobody asked for cost
// nothing; the Jacobian computes the strains it needs. Kernels of a new size are compiled, checked
// and warmed up inside set_sea(), so that synthesize() never waits for a compiler.
#pragma once

#include <memory>
#include <string>

#include "base/result.h"
#include "server/device/synthesizer.h"
#include "server/device/vulkan_maps.h"
#include "server/device/vulkan_tuning.h"

namespace seaway::server {

struct VulkanOptions {
    std::string device = "auto";     ///< "auto", index or part of a name (gpu::pick_device)
    bool validation = false;         ///< Khronos validation layer; for tests
    bool staged = false;             ///< copy as on a discrete GPU; for tests
    bool any_device_kernels = false; ///< design W even where a faster one fits; for tests
    KernelTuning tuning = {};        ///< of designs of kernels
    /// That keyframes of one size may hold of device memory that the CPU reads in place; when all of it is held, they are
    /// copied.
    std::size_t held_map_bytes = held_map_bytes_max;
    bool maps_stay =
        false; ///< synthesize_there() is called; the bound above is of what it makes, on any device
};

/// A keyframe whose maps stand on the device alone, of the fields that were asked for, in the order of the table, one
/// after the other.
struct StandingKeyframe {
    sea::TimeUs time_us = 0;
    int size = 0;
    sea::FieldSet fields;
    const gpu::TexelView* maps =
        nullptr; ///< of four floats; as many bytes of other keyframes stand there, too
    std::size_t first_texel = 0;
    std::shared_ptr<const void>
        keeper; ///< the maps are given back with it, and must not be read after that
};

/// What tests and benchmarks may ask beyond the interface.
class VulkanSynthesizer : public Synthesizer {
  public:
    /// Messages of the validation layer so far (the first 16); empty without it.
    virtual std::vector<std::string> validation_messages() const = 0;

    /// As synthesize(), but nothing is read back: whoever uses the device may read the maps there, behind a barrier. Waves
    /// that no transform carries (stylised sines) are not in them. DeviceError::out_of_memory: too many are held.
    virtual Result<std::vector<StandingKeyframe>>
    synthesize_there(std::span<const KeyframeRequest> requests) = 0;
};

/// Cascade sizes 64, 128, 256, 512, 1024, 2048. An error names what is missing (no loader, no such
/// device) or what the self-check found wrong. set_sea() takes up to some seconds when a driver
/// compiles a size for the first time.
Result<std::unique_ptr<VulkanSynthesizer>> make_vulkan_synthesizer(const VulkanOptions& options);

/// On a device that is there, of which options say nothing.
Result<std::unique_ptr<VulkanSynthesizer>>
make_vulkan_synthesizer(std::shared_ptr<gpu::Device> device, const VulkanOptions& options);

} // namespace seaway::server
