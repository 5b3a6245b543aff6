// SPDX-License-Identifier: Apache-2.0
#include "server/device/vulkan_kernels.h"

#include <set>

#include "gpu/descriptor_types.h"
#include "shaders/shared/synthesis.h"

namespace seaway::server {

namespace {

using gpu::storage;
using gpu::texel_buffer;

gpu::KernelExpectation expectation(shaders::PassKind kind) {
    gpu::KernelExpectation expected{.bindings = {},
                                    .push_constant_bytes = sizeof(shaders::SynthesisPush),
                                    .local_size = {shaders::synthesis_workgroup, 1, 1}};
    switch (kind) {
    case shaders::PassKind::evolve:
    case shaders::PassKind::evolve_source:
        expected.bindings = {{"modes", texel_buffer},
                             {"rates", texel_buffer},
                             {"jobs", texel_buffer},
                             {"rows", texel_buffer},
                             {"orbits", texel_buffer}};
        break;
    case shaders::PassKind::fields:
        expected.bindings = {
            {"source", texel_buffer}, {"jobs", texel_buffer}, {"rows", texel_buffer}};
        break;
    case shaders::PassKind::lines_y:
        expected.bindings = {{"source", texel_buffer}};
        break;
    case shaders::PassKind::lines_x:
        expected.bindings = {{"source", texel_buffer}, {"rows", texel_buffer}};
        break;
    }
    expected.bindings.push_back({"Target", storage});
    return expected;
}

gpu::KernelExpectation jacobian_pass() {
    return {.bindings = {{"maps", texel_buffer}, {"Target", storage}},
            .push_constant_bytes = sizeof(shaders::JacobianPush),
            .local_size = {shaders::synthesis_workgroup, 1, 1}};
}

gpu::KernelExpectation foam_pass() {
    return {.bindings = {{"maps", texel_buffer},
                         {"steps", texel_buffer},
                         {"before", texel_buffer},
                         {"Histories", storage},
                         {"Foam", storage}},
            .push_constant_bytes = sizeof(shaders::FoamPush),
            .local_size = {shaders::synthesis_workgroup, 1, 1}};
}

gpu::KernelExpectation round_pass() {
    return {.bindings = {{"maps", texel_buffer}, {"scales", texel_buffer}, {"Rounded", storage}},
            .push_constant_bytes = sizeof(shaders::RoundPush),
            .local_size = {shaders::synthesis_workgroup, 1, 1}};
}

Result<void> make(gpu::Kernel& place, gpu::Device& device, const shaders::Shader& shader,
                  const gpu::KernelExpectation& expected, const gpu::KernelOptions& options = {}) {
    SEAWAY_TRY_LET(place,
                   gpu::Kernel::create(device, shader.name, shader.spirv, expected, options));
    return {};
}

} // namespace

Result<SynthesisKernels> SynthesisKernels::create(gpu::Device& device,
                                                  const shaders::Transform& transform) {
    SynthesisKernels made;
    made.transform = &transform;
    for (const shaders::Pass& pass : transform.passes) {
        Result<gpu::Kernel> kernel =
            gpu::Kernel::create(device, pass.shader.name, pass.shader.spirv, expectation(pass.kind),
                                {.full_subgroups = transform.lanes != 0});
        if (!kernel)
            return kernel.error();
        made.passes.push_back({std::move(*kernel), pass.kind, pass.groups, pass.row_texels});
    }
    SEAWAY_TRY(make(made.jacobian, device, shaders::jacobian(), jacobian_pass()));
    made.foam_quads =
        device.info().is_cpu() ? shaders::foam_quads_on_cpu : shaders::foam_quads_on_gpu;
    SEAWAY_TRY(
        make(made.foam, device, shaders::foam(), foam_pass(), {.constants = {made.foam_quads}}));
    SEAWAY_TRY(make(made.round, device, shaders::round(), round_pass()));
    return made;
}

std::vector<const shaders::Transform*> fitting_transforms(const gpu::DeviceInfo& device, int size,
                                                          bool band_limited, bool to_be_tried) {
    // Modes a lane of which a GPU has registers; CPUs have caches.
    constexpr int most_modes_on_gpu = 32;
    std::vector<const shaders::Transform*> fitting, shared;
    for (const shaders::Transform& transform : shaders::synthesis_transforms()) {
        const auto lanes = static_cast<int>(transform.lanes);
        const bool runs =
            lanes == 0 || (device.subgroup_shuffle && device.subgroup_size_min >= transform.lanes &&
                           device.subgroup_size_max <= shaders::synthesis_workgroup &&
                           (device.is_cpu() || to_be_tried || size / lanes <= most_modes_on_gpu));
        if (transform.size == size && transform.band_limited == band_limited && runs)
            (transform.shares_memory ? shared : fitting).push_back(&transform);
    }
    if (!device.is_cpu())
        fitting.insert(fitting.begin(), shared.begin(), shared.end());
    else if (to_be_tried)
        fitting.insert(fitting.end(), shared.begin(), shared.end());
    return fitting;
}

bool fits_band(const sea::CascadeModes* cascade) {
    const int size = cascade->spec.size;
    const auto n = static_cast<std::size_t>(size);
    for (std::size_t i = 0; i < cascade->h0.size(); ++i)
        if (cascade->h0[i] != 0.0 &&
            !(shaders::fits_band(sea::signed_index(static_cast<int>(i % n), size), size) &&
              shaders::fits_band(sea::signed_index(static_cast<int>(i / n), size), size)))
            return false;
    return true;
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
