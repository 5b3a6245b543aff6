// SPDX-License-Identifier: Apache-2.0
// Bindings: the buffers and views that one use of a kernel (or of a graphics pipeline) works on.
// Made once, used in many recordings; the resources must outlive it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/result.h"
#include "gpu/buffer.h"
#include "gpu/device.h"
#include "gpu/spirv.h"

namespace seaway::gpu {

/// What stands behind one binding number. Exactly one of the three is used, as the binding's type
/// demands; use the makers.
struct Resource {
    VkDescriptorBufferInfo buffer{};
    VkBufferView texels = VK_NULL_HANDLE;
    VkDescriptorImageInfo image{};
};

inline Resource whole(const Buffer& buffer) {
    return {.buffer = {buffer.get(), 0, buffer.size_bytes()}};
}
inline Resource part(const Buffer& buffer, std::size_t offset_bytes, std::size_t range_bytes) {
    return {.buffer = {buffer.get(), offset_bytes, range_bytes}};
}
inline Resource texels(const TexelView& view) {
    return {.texels = view.get()};
}
inline Resource sampled(VkSampler sampler, VkImageView view, VkImageLayout layout) {
    return {.image = {sampler, view, layout}};
}

/// Layout of set 0 for these bindings, visible to `stages`.
Result<OwnedSetLayout> create_set_layout(Device& device, std::span<const ShaderBinding> bindings,
                                         VkShaderStageFlags stages);

/// An error names the binding of a buffer that is longer than a shader may see of one.
Result<void> check_ranges(std::span<const ShaderBinding> bindings,
                          std::span<const Resource> resources,
                          const VkPhysicalDeviceLimits& limits);

class Bindings {
  public:
    Bindings() = default;
    /// One resource a binding, in the order of `bindings`; each must have count 1. An error names the device and its
    /// limit.
    static Result<Bindings> create(Device& device, VkDescriptorSetLayout layout,
                                   std::span<const ShaderBinding> bindings,
                                   std::span<const Resource> resources);
    VkDescriptorSet get() const { return set_; }

  private:
    OwnedDescriptorPool pool_;
    VkDescriptorSet set_ = VK_NULL_HANDLE; // owned by the pool
};

} // namespace seaway::gpu
