// SPDX-License-Identifier: Apache-2.0
// What the synthesis kernels and their callers share. Read by C++ and by GLSL.
#ifndef SEAWAY_SHADERS_SHARED_SYNTHESIS_H
#define SEAWAY_SHADERS_SHARED_SYNTHESIS_H

#ifdef __cplusplus
#include <cstdint>
namespace seaway::shaders {
using uint = std::uint32_t;
#define SEAWAY_SHARED_CONSTANT inline constexpr uint
#else
#define SEAWAY_SHARED_CONSTANT const uint
#endif

/// Invocations a workgroup, all kernels: within the 128 that every device has.
SEAWAY_SHARED_CONSTANT synthesis_workgroup = 64;

// A field is m(kx) times a source, i m(kx) for odd derivatives; a source is s(ky, 1/k) h or
// s(ky, 1/k) dh/dt. Fields that differ by a power of kx share their source, and with it the
// transform along y. 1/k is coth(kd)/k on depth d. What the kernels know of them is rows of
// numbers, in vec4:
//   two for each source:
//     weights of 1, ky, 1/k, ky/k | weight of ky^2/k, 1 for dh/dt, fields: first, end
//   one for each field, from first_field_texel on:
//     weights of 1, kx, kx^2, 1 to multiply by i
//   one for each field, from first_map_texel on:
//     which of the maps of its job it becomes
// A real field needs what is real: i goes with fields that are odd in k, and with no others.
SEAWAY_SHARED_CONSTANT max_sources = 16;
SEAWAY_SHARED_CONSTANT max_fields = 16;
SEAWAY_SHARED_CONSTANT first_field_texel = 2 * max_sources;
SEAWAY_SHARED_CONSTANT first_map_texel = first_field_texel + max_fields;
SEAWAY_SHARED_CONSTANT row_texels_max = first_map_texel + max_fields;

/// One keyframe of a batch, a texel of RGBA32UI.
struct SynthesisJob {
    uint cascade;  ///< which block of the mode buffers
    uint time_low; ///< sea time, microseconds, two's complement
    uint time_high;
    uint wavenumber_step; ///< bits of a float, rad/m
};

struct SynthesisPush {
    uint sources;   ///< a job
    uint fields;    ///< a job
    uint maps;      ///< a job
    uint first_map; ///< of the first job, in maps of the target
};

/// The Jacobian kernel makes one map of three.
struct JacobianPush {
    uint maps;      ///< a job
    uint first_map; ///< of the first job
    uint map_xx;    ///< of a job, as the others
    uint map_yy;
    uint map_xy;
    uint map_jacobian;
    float choppiness_x;
    float choppiness_y;
    uint size; ///< grid points a side
};

// The foam kernel takes histories a step further, each its own in one dispatch. The steps stand in a buffer of texels
// RGBA32UI. Places are counted in vec4 of their buffers.
SEAWAY_SHARED_CONSTANT foam_step_texels = 6;
SEAWAY_SHARED_CONSTANT foam_steps_max = 128;
/// Points of an invocation, in vec4, which share the fetches of a step: a processor spares them, a GPU wants
/// invocations. Specialisation constant 0.
SEAWAY_SHARED_CONSTANT foam_quads_on_cpu = 4;
SEAWAY_SHARED_CONSTANT foam_quads_on_gpu = 1;
/// Flags of a step.
SEAWAY_SHARED_CONSTANT foam_looks = 1; ///< at strains
SEAWAY_SHARED_CONSTANT foam_keeps = 2; ///< the history is what the step leaves
SEAWAY_SHARED_CONSTANT foam_shows = 4; ///< a map is

struct FoamPush {
    uint first_step; ///< of the dispatch, one a z
};

/// ratio = ratio * remains + breaking * source + added, as sea::FoamTick; shown: 1 + departure * (ratio - 1), of
/// departure 1 the very ratio.
struct FoamStep {
    float threshold, bias, choppiness_x, choppiness_y;
    float choppiness_xy, variance, difference, shear;
    float curvature, difference_rest, shear_rest, cross_rest;
    float constant_rest, remains, source, added;
    uint strain_xx, strain_yy, strain_xy; ///< places of maps
    uint flags;
    uint history; ///< place of its map
    uint shown;   ///< place of a map
    float departure;
    uint unused;
};

/// Maps that are rounded together at most, and steps from zero that a sample of 16 bits may be.
SEAWAY_SHARED_CONSTANT rounded_maps_max = 1024;
SEAWAY_SHARED_CONSTANT rounded_steps_max = 32767;

struct RoundPush {
    uint first_map; ///< of the first job
    uint maps;      ///< a job has
    uint asked;     ///< of which the first so many are rounded
    uint size;      ///< grid points a side
};

/// Of the kernel that measures arithmetic, vec4 each.
SEAWAY_SHARED_CONSTANT peak_chains = 2;
SEAWAY_SHARED_CONSTANT peak_steps = 16;

struct PeakPush {
    uint rounds; ///< of peak_steps products and sums of each chain
    float factor;
    float added;
};

#ifdef __cplusplus
static_assert(sizeof(PeakPush) == 12);
static_assert(sizeof(RoundPush) == 16);
static_assert(sizeof(FoamPush) == 4);
static_assert(sizeof(FoamStep) == 16 * foam_step_texels);
static_assert(sizeof(SynthesisJob) == 16);
static_assert(sizeof(SynthesisPush) == 16);
static_assert(sizeof(JacobianPush) == 36);
} // namespace seaway::shaders
#endif
#undef SEAWAY_SHARED_CONSTANT

#endif
