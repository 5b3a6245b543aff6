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

/// A slot is one complex transform: two real fields a + i b. Its row is this many vec4:
///   0, 1: weights of field a over sea::Basis, in the order of that enumeration
///   2, 3: weights of field b
///   4:    flags, 0 or 1: a is of dh/dt; a is times i; b is of dh/dt; b is times i
SEAWAY_SHARED_CONSTANT slot_row_texels = 5;

/// Two real fields a slot, 11 linear fields.
SEAWAY_SHARED_CONSTANT max_slots = 6;

/// One keyframe of a batch, a texel of RGBA32UI.
struct SynthesisJob {
    uint cascade;  ///< which block of the mode buffers
    uint time_low; ///< sea time, microseconds, two's complement
    uint time_high;
    uint wavenumber_step; ///< bits of a float, rad/m
};

struct SynthesisPush {
    uint slots; ///< complex transforms a job
};

/// The Jacobian kernel reads three strain fields: plane = 2 slot + (0: first field, 1: second).
struct JacobianPush {
    uint slots;
    uint plane_xx;
    uint plane_yy;
    uint plane_xy;
    float choppiness_x;
    float choppiness_y;
    uint size; ///< grid points a side
};

#ifdef __cplusplus
static_assert(sizeof(SynthesisJob) == 16);
static_assert(sizeof(SynthesisPush) == 4);
static_assert(sizeof(JacobianPush) == 28);
} // namespace seaway::shaders
#endif
#undef SEAWAY_SHARED_CONSTANT

#endif
