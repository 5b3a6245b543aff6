// SPDX-License-Identifier: Apache-2.0
// Short names of the kinds of descriptors that kernels and passes of Seaway take.
#pragma once

#include "gpu/vulkan.h"

namespace seaway::gpu {

inline constexpr VkDescriptorType uniform = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
inline constexpr VkDescriptorType storage = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
inline constexpr VkDescriptorType texel_buffer = VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
inline constexpr VkDescriptorType texture = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;

} // namespace seaway::gpu
