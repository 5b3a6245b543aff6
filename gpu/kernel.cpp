// SPDX-License-Identifier: Apache-2.0
#include "gpu/kernel.h"

#include <algorithm>

#include "gpu/call.h"

namespace seaway::gpu {

namespace {

std::string words_of(const std::array<std::uint32_t, 3>& size) {
    return std::to_string(size[0]) + "x" + std::to_string(size[1]) + "x" + std::to_string(size[2]);
}

std::string quoted(std::string_view name, VkDescriptorType type) {
    return "\"" + std::string(name) + "\" (" + descriptor_type_name(type) + ")";
}

Result<void> compare(const ShaderInterface& shader, const KernelExpectation& expected) {
    for (std::size_t i = 0; i < std::max(shader.bindings.size(), expected.bindings.size()); ++i) {
        const std::string ours = i < expected.bindings.size()
                                     ? quoted(expected.bindings[i].name, expected.bindings[i].type)
                                     : "nothing";
        const bool in_place = i < shader.bindings.size() && shader.bindings[i].set == 0 &&
                              shader.bindings[i].binding == i;
        const std::string theirs = i < shader.bindings.size()
                                       ? quoted(shader.bindings[i].name, shader.bindings[i].type)
                                       : "nothing";
        if (ours != theirs || !in_place)
            return Error{"binding " + std::to_string(i) + " is " + theirs + " in the shader and " +
                         ours + " in the program"};
    }
    if (shader.push_constant_bytes != expected.push_constant_bytes)
        return Error{"push constants are " + std::to_string(shader.push_constant_bytes) +
                     " bytes in the shader and " + std::to_string(expected.push_constant_bytes) +
                     " in the program"};
    if (shader.local_size != expected.local_size)
        return Error{"workgroup is " + words_of(shader.local_size) + " in the shader and " +
                     words_of(expected.local_size) + " in the program"};
    return {};
}

Result<void> check_limits(const Device& device, const ShaderInterface& shader) {
    const VkPhysicalDeviceLimits& limits = device.limits();
    const auto [x, y, z] = shader.local_size;
    if (x * y * z > limits.maxComputeWorkGroupInvocations ||
        x > limits.maxComputeWorkGroupSize[0] || y > limits.maxComputeWorkGroupSize[1] ||
        z > limits.maxComputeWorkGroupSize[2])
        return Error{"workgroup of " + words_of(shader.local_size) + " is too large for " +
                     device.info().name};
    if (shader.push_constant_bytes > limits.maxPushConstantsSize)
        return Error{std::to_string(shader.push_constant_bytes) +
                     " bytes of push constants are too many for " + device.info().name};
    return {};
}

Result<OwnedPipeline> create_pipeline(Device& device, VkPipelineLayout layout,
                                      std::span<const std::uint32_t> spirv,
                                      const ShaderInterface& shader, const KernelOptions& options) {
    const VkShaderModuleCreateInfo module_info{.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                               .codeSize = spirv.size_bytes(),
                                               .pCode = spirv.data()};
    VkShaderModule handle = VK_NULL_HANDLE;
    SEAWAY_TRY(call("vkCreateShaderModule", vkCreateShaderModule, device.get(), &module_info,
                    nullptr, &handle));
    const OwnedShaderModule module(device.get(), handle);

    std::vector<VkSpecializationMapEntry> entries;
    for (std::uint32_t i = 0; i < options.constants.size(); ++i)
        entries.push_back({i, i * 4u, 4});
    const VkSpecializationInfo constants{static_cast<std::uint32_t>(entries.size()), entries.data(),
                                         options.constants.size() * 4, options.constants.data()};
    VkPipelineShaderStageCreateFlags flags = 0;
    if (options.full_subgroups)
        flags = VK_PIPELINE_SHADER_STAGE_CREATE_REQUIRE_FULL_SUBGROUPS_BIT;
    const VkComputePipelineCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                  .flags = flags,
                  .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                  .module = module.get(),
                  .pName = shader.entry_point.c_str(),
                  .pSpecializationInfo = entries.empty() ? nullptr : &constants},
        .layout = layout};
    VkPipeline pipeline = VK_NULL_HANDLE;
    SEAWAY_TRY(call("vkCreateComputePipelines", vkCreateComputePipelines, device.get(),
                    VkPipelineCache(VK_NULL_HANDLE), 1u, &info, nullptr, &pipeline));
    return OwnedPipeline(device.get(), pipeline);
}

Result<OwnedPipelineLayout> create_layout(Device& device, VkDescriptorSetLayout set,
                                          std::uint32_t push_constant_bytes) {
    const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT, 0, push_constant_bytes};
    const VkPipelineLayoutCreateInfo info{.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                          .setLayoutCount = 1,
                                          .pSetLayouts = &set,
                                          .pushConstantRangeCount = push.size ? 1u : 0u,
                                          .pPushConstantRanges = &push};
    VkPipelineLayout layout = VK_NULL_HANDLE;
    SEAWAY_TRY(call("vkCreatePipelineLayout", vkCreatePipelineLayout, device.get(), &info, nullptr,
                    &layout));
    return OwnedPipelineLayout(device.get(), layout);
}

} // namespace

Result<Kernel> Kernel::create(Device& device, std::string_view name,
                              std::span<const std::uint32_t> spirv,
                              const KernelExpectation& expected, const KernelOptions& options) {
    const auto failed = [&](const Error& error) {
        return Error{error.kind, "kernel \"" + std::string(name) + "\": " + error.message};
    };
    Kernel made;
    made.name_ = name;
    Result<ShaderInterface> shader = reflect(spirv);
    if (!shader)
        return failed(shader.error());
    made.interface_ = std::move(*shader);
    if (Result<void> same = compare(made.interface_, expected); !same)
        return failed(same.error());
    if (Result<void> fits = check_limits(device, made.interface_); !fits)
        return failed(fits.error());
    Result<OwnedSetLayout> set =
        create_set_layout(device, made.interface_.bindings, VK_SHADER_STAGE_COMPUTE_BIT);
    if (!set)
        return failed(set.error());
    made.set_layout_ = std::move(*set);
    Result<OwnedPipelineLayout> layout =
        create_layout(device, made.set_layout_.get(), made.interface_.push_constant_bytes);
    if (!layout)
        return failed(layout.error());
    made.layout_ = std::move(*layout);
    Result<OwnedPipeline> pipeline =
        create_pipeline(device, made.layout_.get(), spirv, made.interface_, options);
    if (!pipeline)
        return failed(pipeline.error());
    made.pipeline_ = std::move(*pipeline);
    return made;
}

} // namespace seaway::gpu
