// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/vulkan_kernels.h"

#include <string>

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

Result<SynthesisKernels> SynthesisKernels::create(gpu::Device& device, int size) {
    std::string sizes;
    for (const shaders::Transform& transform : shaders::synthesis_transforms()) {
        sizes += (sizes.empty() ? "" : ", ") + std::to_string(transform.size);
        if (transform.size != size)
            continue;
        SynthesisKernels made;
        made.size = size;
        made.design = transform.design;
        for (const shaders::Pass& pass : transform.passes) {
            Result<gpu::Kernel> kernel =
                gpu::Kernel::create(device, pass.shader.name, pass.shader.spirv,
                                    made.passes.empty() ? first_pass() : later_pass());
            if (!kernel)
                return kernel.error();
            made.passes.push_back({std::move(*kernel), pass.groups});
        }
        Result<gpu::Kernel> jacobian = gpu::Kernel::create(
            device, shaders::jacobian().name, shaders::jacobian().spirv, jacobian_pass());
        if (!jacobian)
            return jacobian.error();
        made.jacobian = std::move(*jacobian);
        return made;
    }
    return Error{"no Vulkan kernels for a cascade of size " + std::to_string(size) +
                 "; there are " + sizes};
}

} // namespace seaway::server
