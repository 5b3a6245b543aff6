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
#include <cstddef>
namespace seaway::shaders {
// As std140 lays them out in a structure whose every vec3 is followed by one number.
struct alignas(8) vec2 {
    float x = 0, y = 0;
};
struct vec3 {
    float x = 0, y = 0, z = 0;
};
struct alignas(16) mat4 {
    std::array<float, 16> column_major{};
};
#define SEAWAY_SHARED_CONSTANT inline constexpr int
#define SEAWAY_STD140_ELEMENT alignas(16)
#else
#define SEAWAY_SHARED_CONSTANT const int
#define SEAWAY_STD140_ELEMENT
#endif

SEAWAY_SHARED_CONSTANT view_cascades_max = 8;

/// Foam noise repeats after this many metres.
SEAWAY_SHARED_CONSTANT view_noise_period_m = 256;

// What can be drawn; client/view/debug_views.h says what each shows.
SEAWAY_SHARED_CONSTANT view_final = 0;
SEAWAY_SHARED_CONSTANT view_height = 1;
SEAWAY_SHARED_CONSTANT view_place = 2;
SEAWAY_SHARED_CONSTANT view_normal = 3;
SEAWAY_SHARED_CONSTANT view_slope = 4;
SEAWAY_SHARED_CONSTANT view_jacobian = 5;
SEAWAY_SHARED_CONSTANT view_roughness = 6;
SEAWAY_SHARED_CONSTANT view_foam = 7;
SEAWAY_SHARED_CONSTANT view_cascade = 8;
SEAWAY_SHARED_CONSTANT view_grid = 9;

/// Where the maps of a cascade lie in the local frame.
struct SEAWAY_STD140_ELEMENT ViewCascade {
    vec2 origin;      ///< of the local frame in the map, 0 .. 1
    float maps_per_m; ///< 1 / length of the tile
    float texel_m;
};

struct ViewValues {
    mat4 clip_from_local;
    mat4 local_from_clip; ///< directions: of a point at depth 0 on the picture

    vec3 camera_m;           ///< local position
    float pixel_rad;         ///< angle of a pixel
    vec3 sun_direction;      ///< towards it, unit
    float sun_disk_cosine;   ///< of the angle of the disk's radius
    vec3 sun_irradiance_klx; ///< at the sea, normal to the beam
    float sun_disk_per_sr;   ///< radiance of the disk over that irradiance
    vec3 sky_irradiance_klx; ///< on a horizontal plane
    float extinction_per_m;  ///< of light in the air
    vec3 water_reflectance;  ///< diffuse, of the water body
    float significant_height_m;

    vec2 mesh_apex_m;       ///< local
    float mesh_azimuth_rad; ///< of the first column
    float mesh_step_rad;    ///< from column to column
    vec2 choppiness;
    float curvature_per_m; ///< 1 / (2 earth radius): a point drops by this times distance squared
    float slope_variance;  ///< of all maps, both axes

    vec2 foam_noise_origin_m;
    float foam_threshold; ///< Jacobian that breaks
    float foam_softness;  ///< of that, where the pixel resolves everything
    float foam_mean;      ///< coverage, 0 .. 1; 0: no foam
    int foam_level;       ///< of its coarsest noise: cells of 2^-level metres

    // Waves beyond the finest cascade: a copy of it, smaller and turned.
    float detail_amplitude; ///< 1; 0: no copy
    float detail_maps_per_m;
    vec2 detail_origin;          ///< of the local frame in the copy, 0 .. 1
    vec2 detail_turn;            ///< cosine and sine
    float detail_slope_variance; ///< of waves beyond the copy, each axis

    int cascades;
    int mesh_columns;
    int mesh_rows;
    int what;         ///< view_final ..
    int what_cascade; ///< that view_cascade shows
    ViewCascade cascade[view_cascades_max];
};

#ifdef __cplusplus
static_assert(offsetof(ViewValues, camera_m) == 128 && offsetof(ViewValues, foam_mean) == 256);
static_assert(offsetof(ViewValues, detail_origin) == 272 && offsetof(ViewValues, cascade) == 320);
static_assert(sizeof(ViewValues) == 320 + 16 * view_cascades_max);
} // namespace seaway::shaders
#endif
#undef SEAWAY_SHARED_CONSTANT
#undef SEAWAY_STD140_ELEMENT

#endif
