// SPDX-License-Identifier: Apache-2.0
// What a SPIR-V module says of itself: bindings, push constants, workgroup size. The shader
// declares, C++ reads it here and compares.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "gpu/vulkan.h"

namespace seaway::gpu {

struct ShaderBinding {
    std::uint32_t set = 0;
    std::uint32_t binding = 0;
    std::uint32_t count = 1; ///< array length
    VkDescriptorType type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    std::string name; ///< of the variable, or of its block if that has none
};

struct ShaderInterface {
    VkShaderStageFlagBits stage = VK_SHADER_STAGE_COMPUTE_BIT;
    std::string entry_point;
    std::vector<ShaderBinding> bindings; ///< by set, then binding
    std::uint32_t push_constant_bytes = 0;
    std::array<std::uint32_t, 3> local_size{1, 1, 1}; ///< compute only
};

/// Reads one entry point. An error if the words are no SPIR-V module.
Result<ShaderInterface> reflect(std::span<const std::uint32_t> words);

/// "storage buffer", "uniform texel buffer", ... for messages.
const char* descriptor_type_name(VkDescriptorType type);

} // namespace seaway::gpu
