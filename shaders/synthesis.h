// SPDX-License-Identifier: Apache-2.0
// The compute kernels of the synthesis, as SPIR-V embedded in the program. Written at build time by
// shaders/generate.py; what they read and write is in shaders/shared/synthesis.h.
//
// A transform of size N turns the modes of a batch of jobs into maps [y][x] of floats, some for each job,
// by way of sources (shaders/shared/synthesis.h). A target holds maps one after the other. Its passes run one after the other, a barrier
// between them; each is dispatched as (parts, jobs, groups), parts and bindings by its kind.
// modes: RGBA32F [cascade][Y][X] (h0(k), conj h0(-k)), rates: RG32UI likewise (low, high word of
// sea::Rate), both [cascade][X][Y] where `transposed`; jobs: RGBA32UI, SynthesisJob; rows:
// RGBA32F. Source and Target of a pass are two buffers of jobs * fields * scratch_complexes complex
// floats, taken in turns; source is read as RGBA32F.
//
// Constants; thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace seaway::shaders {

struct Shader {
    std::string_view name;
    std::span<const std::uint32_t> spirv;
};

enum class PassKind : std::uint8_t {
    evolve,        ///< one part;         modes, rates, jobs, rows -> Target
    evolve_source, ///< a part a source;  the same
    lines_y,       ///< a part a source;  source -> Target
    fields,        ///< a part a source;  source, jobs, rows -> Target
    lines_x,       ///< a part a field;   source, rows -> Target
};

struct Pass {
    Shader shader;
    PassKind kind;
    std::uint32_t groups; ///< workgroups a part
    /// vec4 in one of the N / 2 rows that a part leaves in memory; 0: it leaves maps.
    std::uint32_t row_texels;
};

struct Transform {
    int size;                ///< N
    std::string_view design; ///< "T8", "T16", "T32", "W", "G"
    std::uint32_t lanes;     ///< least size of a subgroup, with shuffles; 0: any device
    bool transposed;         ///< how modes stand
    bool shares_memory;      ///< within a workgroup: fast on GPUs, slow where a processor does it
    bool band_limited;       ///< fits_band() must hold of all modes
    std::uint32_t scratch_complexes; ///< a field
    std::span<const Pass> passes;
};

/// Whether a band-limited transform knows the mode n of a line: |n| < 0.3 N.
constexpr bool fits_band(int n, int size) {
    return (n < 0 ? -n : n) * 10 < 3 * size;
}

/// All, those for processors first, the faster ones of a size first. Sizes 64, 128, 256, 512, 1024, 2048.
std::span<const Transform> synthesis_transforms();

/// Bindings maps -> Target, which are the same, push constants JacobianPush, N^2 / 4 invocations a job.
Shader jacobian();

/// Bindings maps, steps, histories -> histories, foam; push constants FoamPush, N^2 / (4 quads) invocations a step,
/// which is a z; specialisation constant quads.
Shader foam();

/// Bindings maps, scales -> Rounded; push constants RoundPush, N^2 / 8 invocations a map, which is a y, of a job, which is a
/// z.
Shader round();

/// Bindings source -> Target, a vec4 an invocation; no push constants. Part of no synthesis: a measure of memory.
Shader copy();

/// Binding Target, a vec4 an invocation; push constants PeakPush. Part of no synthesis: a measure of arithmetic.
Shader peak();

} // namespace seaway::shaders
