// SPDX-License-Identifier: Apache-2.0
// The pipelines of one transform size, checked against what this side believes of them.
#pragma once

#include <memory>
#include <vector>

#include "base/result.h"
#include "gpu/kernel.h"
#include "shaders/synthesis.h"

namespace seaway::server {

struct SynthesisKernels {
    struct Pass {
        gpu::Kernel kernel;
        std::uint32_t groups; ///< workgroups in x
    };
    int size = 0;
    std::string_view design;
    std::vector<Pass> passes;
    gpu::Kernel jacobian;

    /// The error names the kernel, or says which sizes there are.
    static Result<SynthesisKernels> create(gpu::Device& device, int size);
};

} // namespace seaway::server
