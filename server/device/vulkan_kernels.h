// SPDX-License-Identifier: Apache-2.0
// The pipelines of one transform size, checked against what this side believes of them.
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "gpu/kernel.h"
#include "sea/waves/realization.h"
#include "shaders/synthesis.h"

namespace seaway::server {

struct SynthesisKernels {
    struct Pass {
        gpu::Kernel kernel;
        shaders::PassKind kind;
        std::uint32_t groups;     ///< workgroups a part
        std::uint32_t row_texels; ///< as shaders::Pass has it
    };
    const shaders::Transform* transform = nullptr;
    std::vector<Pass> passes;
    gpu::Kernel jacobian;
    gpu::Kernel foam;
    std::uint32_t foam_quads = 0; ///< of its invocations
    gpu::Kernel round;

    int size() const { return transform->size; }

    static Result<SynthesisKernels> create(gpu::Device& device,
                                           const shaders::Transform& transform);
};

/// Transforms of a size that the device could run, those first that are faster where nothing is measured: by subgroups,
/// then those for any. With `band_limited` only these, without it only the others. Empty: no such size. `to_be_tried`:
/// also those that hold more numbers in a lane than a GPU is believed to have registers for.
std::vector<const shaders::Transform*> fitting_transforms(const gpu::DeviceInfo& device, int size,
                                                          bool band_limited,
                                                          bool to_be_tried = false);

/// Whether a transform that is band-limited knows all of its modes.
bool fits_band(const sea::CascadeModes* cascade);

/// "64, 128, ...", for messages.
std::string transform_sizes();

} // namespace seaway::server
