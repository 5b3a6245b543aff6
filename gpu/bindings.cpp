// SPDX-License-Identifier: Apache-2.0
#include "gpu/bindings.h"

#include "base/check.h"
#include "gpu/call.h"

namespace seaway::gpu {

Result<OwnedSetLayout> create_set_layout(Device& device, std::span<const ShaderBinding> bindings,
                                         VkShaderStageFlags stages) {
    std::vector<VkDescriptorSetLayoutBinding> slots;
    for (const ShaderBinding& binding : bindings)
        slots.push_back({binding.binding, binding.type, binding.count, stages, nullptr});
    const VkDescriptorSetLayoutCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
        .bindingCount = static_cast<std::uint32_t>(slots.size()),
        .pBindings = slots.data()};
    VkDescriptorSetLayout layout = VK_NULL_HANDLE;
    SEAWAY_TRY(call("vkCreateDescriptorSetLayout", vkCreateDescriptorSetLayout, device.get(), &info,
                    nullptr, &layout));
    return OwnedSetLayout(device.get(), layout);
}

Result<void> check_ranges(std::span<const ShaderBinding> bindings,
                          std::span<const Resource> resources,
                          const VkPhysicalDeviceLimits& limits) {
    for (std::size_t i = 0; i < bindings.size(); ++i) {
        const bool storage = bindings[i].type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        if (!storage && bindings[i].type != VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER)
            continue;
        const std::uint32_t most =
            storage ? limits.maxStorageBufferRange : limits.maxUniformBufferRange;
        if (resources[i].buffer.range > most)
            return Error{"\"" + bindings[i].name + "\" of " +
                         std::to_string(resources[i].buffer.range) + " bytes: a shader may see " +
                         std::to_string(most)};
    }
    return {};
}

Result<Bindings> Bindings::create(Device& device, VkDescriptorSetLayout layout,
                                  std::span<const ShaderBinding> bindings,
                                  std::span<const Resource> resources) {
    SEAWAY_CHECK(bindings.size() == resources.size(), "one resource a binding");
    if (const Result<void> fit = check_ranges(bindings, resources, device.limits()); !fit)
        return Error{device.info().name + ": " + fit.error().message};
    Bindings made;
    std::vector<VkDescriptorPoolSize> sizes;
    for (const ShaderBinding& binding : bindings)
        sizes.push_back({binding.type, 1});
    const VkDescriptorPoolCreateInfo pool_info{
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
        .maxSets = 1,
        .poolSizeCount = static_cast<std::uint32_t>(sizes.size()),
        .pPoolSizes = sizes.data()};
    VkDescriptorPool pool = VK_NULL_HANDLE;
    SEAWAY_TRY(call("vkCreateDescriptorPool", vkCreateDescriptorPool, device.get(), &pool_info,
                    nullptr, &pool));
    made.pool_ = OwnedDescriptorPool(device.get(), pool);
    const VkDescriptorSetAllocateInfo set_info{.sType =
                                                   VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                               .descriptorPool = pool,
                                               .descriptorSetCount = 1,
                                               .pSetLayouts = &layout};
    SEAWAY_TRY(call("vkAllocateDescriptorSets", vkAllocateDescriptorSets, device.get(), &set_info,
                    &made.set_));

    std::vector<VkWriteDescriptorSet> writes;
    for (std::size_t i = 0; i < bindings.size(); ++i) {
        SEAWAY_CHECK(bindings[i].count == 1, "arrays of resources are not bound here");
        writes.push_back({.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                          .dstSet = made.set_,
                          .dstBinding = bindings[i].binding,
                          .descriptorCount = 1,
                          .descriptorType = bindings[i].type,
                          .pImageInfo = &resources[i].image,
                          .pBufferInfo = &resources[i].buffer,
                          .pTexelBufferView = &resources[i].texels});
    }
    vkUpdateDescriptorSets(device.get(), static_cast<std::uint32_t>(writes.size()), writes.data(),
                           0, nullptr);
    return made;
}

} // namespace seaway::gpu
