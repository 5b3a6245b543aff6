// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/vulkan_kernels.h"

#include <set>

#include "shaders/shared/synthesis.h"

namespace seaway::server {

namespace {

constexpr VkDescriptorType texel_buffer = VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
constexpr VkDescriptorType storage_buffer = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;

gpu::KernelExpectation first_pass() {
    return {.bindings = {{"modes", texel_buffer},
                         {"rates", texel_buffer},
                         {"jobs", texel_buffer},
                         {"rows", texel_buffer},
                         {"Target", storage_buffer}},
            .push_constant_bytes = sizeof(shaders::SynthesisPush),
            .local_size = {shaders::synthesis_workgroup, 1, 1}};
}

gpu::KernelExpectation later_pass() {
    return {.bindings = {{"source", texel_buffer}, {"Target", storage_buffer}},
            .push_constant_bytes = sizeof(shaders::SynthesisPush),
            .local_size = {shaders::synthesis_workgroup, 1, 1}};
}

gpu::KernelExpectation jacobian_pass() {
    return {.bindings = {{"maps", texel_buffer}, {"Jacobian", storage_buffer}},
            .push_constant_bytes = sizeof(shaders::JacobianPush),
            .local_size = {shaders::synthesis_workgroup, 1, 1}};
}

} // namespace

Result<SynthesisKernels> SynthesisKernels::create(gpu::Device& device,
                                                  const shaders::Transform& transform) {
    SynthesisKernels made;
    made.transform = &transform;
    const auto add = [&](std::vector<Pass>& passes, const shaders::Pass& pass,
                         const gpu::KernelExpectation& expected) -> Result<void> {
        Result<gpu::Kernel> kernel =
            gpu::Kernel::create(device, pass.shader.name, pass.shader.spirv, expected,
                                {.full_subgroups = transform.subgroup_size != 0});
        if (!kernel)
            return kernel.error();
        passes.push_back({std::move(*kernel), pass.groups});
        return {};
    };
    for (const shaders::Pass& pass : transform.passes)
        if (Result<void> added =
                add(made.passes, pass, made.passes.empty() ? first_pass() : later_pass());
            !added)
            return added.error();
    if (!transform.single_field_last.shader.name.empty())
        if (Result<void> added = add(made.single_field, transform.single_field_last, later_pass());
            !added)
            return added.error();
    Result<gpu::Kernel> jacobian = gpu::Kernel::create(device, shaders::jacobian().name,
                                                       shaders::jacobian().spirv, jacobian_pass());
    if (!jacobian)
        return jacobian.error();
    made.jacobian = std::move(*jacobian);
    return made;
}

std::vector<const shaders::Transform*> fitting_transforms(const gpu::DeviceInfo& device, int size,
                                                          bool band_limited) {
    std::vector<const shaders::Transform*> fitting;
    for (const shaders::Transform& transform : shaders::synthesis_transforms()) {
        const bool runs =
            transform.subgroup_size == 0 ||
            (device.subgroup_shuffle && device.subgroup_size == transform.subgroup_size);
        if (transform.size == size && transform.band_limited == band_limited && runs)
            fitting.push_back(&transform);
    }
    return fitting;
}

std::string transform_sizes() {
    std::set<int> sizes;
    for (const shaders::Transform& transform : shaders::synthesis_transforms())
        sizes.insert(transform.size);
    std::string text;
    for (const int size : sizes)
        text += (text.empty() ? "" : ", ") + std::to_string(size);
    return text;
}

} // namespace seaway::server
