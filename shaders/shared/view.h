// SPDX-License-Identifier: Apache-2.0
// What the view's shaders are told of a frame. Read by C++ and by GLSL (std140).
//
// Local frame: metres east, north, up from the point of the mean sea surface below the camera, so
// that floats are small where it matters; what depends on the place in the world is reduced modulo
// its period on the CPU, in double precision.
#ifndef SEAWAY_SHADERS_SHARED_VIEW_H
#define SEAWAY_SHADERS_SHARED_VIEW_H

#ifdef __cplusplus
#include <array>
namespace seaway::shaders {
struct alignas(16) vec4 {
    float x = 0, y = 0, z = 0, w = 0;
};
struct alignas(16) mat4 {
    std::array<float, 16> column_major{};
};
#define SEAWAY_SHARED_CONSTANT inline constexpr int
#else
#define SEAWAY_SHARED_CONSTANT const int
#endif

SEAWAY_SHARED_CONSTANT view_cascades_max = 8;

/// Foam noise repeats after this many metres.
SEAWAY_SHARED_CONSTANT view_noise_period_m = 256;

struct ViewValues {
    mat4 clip_from_local;
    mat4 local_from_clip; ///< directions: of a point at depth 0 on the picture
    vec4 camera;          ///< local position; w: angle of a pixel, rad
    vec4 sun_direction;   ///< towards it; w: cosine of the disk's radius
    vec4 sun_irradiance;  ///< at the sea, normal to the beam, klx; w: radiance of the disk / that
    vec4 sky_irradiance;  ///< on a horizontal plane, klx
    vec4 water;           ///< diffuse reflectance of the water body; w: significant height, m
    vec4 mesh;            ///< apex x, y (local); first azimuth and step, rad
    vec4 sea;             ///< choppiness x, y; 1/(2 earth radius), 1/m; aerial extinction, 1/m
    vec4 foam;            ///< Jacobian that breaks; softness of that; noise origin x, y, m
    vec4 foam_mean;       ///< coverage, 0: no foam; level of its noise; variance of all slopes
    vec4 detail;          ///< origin u, v; scale 1/m; variance of slope of waves beyond all maps
    vec4 detail_turn;     ///< cosine, sine of its turn; amplitude, 0 or 1; number of cascades
    vec4 counts;          ///< columns of the mesh; rows; debug view; cascade that it shows
    vec4 cascade[view_cascades_max]; ///< origin u, v; 1/length, 1/m; texel, m
};

#ifdef __cplusplus
static_assert(sizeof(ViewValues) == 16 * (8 + 12 + view_cascades_max));
} // namespace seaway::shaders
#endif
#undef SEAWAY_SHARED_CONSTANT

#endif
