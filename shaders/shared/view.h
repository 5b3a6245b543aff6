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
struct alignas(16) vec4 {
    float x = 0, y = 0, z = 0, w = 0;
};
struct alignas(16) mat4 {
    std::array<float, 16> column_major{};
};
#define SEAWAY_SHARED_CONSTANT inline constexpr int
#define SEAWAY_SHARED_NUMBER inline constexpr float
#define SEAWAY_STD140_ELEMENT alignas(16)
#else
#define SEAWAY_SHARED_CONSTANT const int
#define SEAWAY_SHARED_NUMBER const float
#define SEAWAY_STD140_ELEMENT
#endif

SEAWAY_SHARED_CONSTANT view_cascades_max = 8;

/// Invocations of a group of the view's compute shaders.
SEAWAY_SHARED_CONSTANT view_group = 64;

// How numbers of a debug view lie along its bar of colours (client/view/debug/colours.h).
SEAWAY_SHARED_CONSTANT view_spacing_linear = 0;
SEAWAY_SHARED_CONSTANT view_spacing_logarithmic = 1;
SEAWAY_SHARED_CONSTANT view_spacing_root = 2;
SEAWAY_SHARED_CONSTANT view_spacing_repeated = 3;
SEAWAY_SHARED_CONSTANT view_stops = 8; ///< of a palette

/// Rows of foam along the wind: cells of 40 m by 5 m.
SEAWAY_SHARED_NUMBER view_rows_a_metre_along = 0.025f;
SEAWAY_SHARED_NUMBER view_rows_a_metre_across = 0.2f;

/// Of refraction, sea water in the middle of what is seen.
SEAWAY_SHARED_NUMBER water_index = 1.34f;

// A layer of clouds: of its noise to optical depth (the CPU makes what the tables hold, the GPU what a pixel shows).
SEAWAY_SHARED_NUMBER cloud_detail_scale = 4.0f; ///< of places in the noise
SEAWAY_SHARED_NUMBER cloud_region_scale = 0.27f;
SEAWAY_SHARED_NUMBER cloud_softness = 0.35f; ///< of noise, from the edge of a cloud to its middle
SEAWAY_SHARED_NUMBER cloud_detail_share = 0.25f; ///< of the pattern's range
SEAWAY_SHARED_NUMBER cloud_region_share = 0.5f;
SEAWAY_SHARED_NUMBER cloud_diffuse_loss = 0.1125f; ///< 0.75 (1 - g), g = 0.85: droplets of clouds
SEAWAY_SHARED_NUMBER cloud_mean_slant = 1.66f;     ///< of diffuse light through a thin slab
SEAWAY_SHARED_NUMBER cloud_straight_loss = 0.25f;
SEAWAY_SHARED_NUMBER cloud_thickness_m = 500.0f; ///< that shades itself
// Lobes of what droplets scatter (Henyey and Greenstein 1941), and the share of the first.
SEAWAY_SHARED_NUMBER cloud_forward = 0.85f;
SEAWAY_SHARED_NUMBER cloud_backward = -0.3f;
SEAWAY_SHARED_NUMBER cloud_forward_share = 0.8f;

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
SEAWAY_SHARED_CONSTANT view_displacement = 10;
SEAWAY_SHARED_CONSTANT view_gradient = 11;
SEAWAY_SHARED_CONSTANT view_reflected = 12;
SEAWAY_SHARED_CONSTANT view_density = 13;
SEAWAY_SHARED_CONSTANT view_wireframe = 14;
SEAWAY_SHARED_CONSTANT view_age = 15;
SEAWAY_SHARED_CONSTANT view_bound = 16;
SEAWAY_SHARED_CONSTANT view_map_displacement = 17;
SEAWAY_SHARED_CONSTANT view_map_slope = 18;
SEAWAY_SHARED_CONSTANT view_map_gradient = 19;
SEAWAY_SHARED_CONSTANT view_map_jacobian = 20;
SEAWAY_SHARED_CONSTANT view_map_roughness = 21;
SEAWAY_SHARED_CONSTANT view_map_foam = 22;

/// A cascade on the device: where its maps lie in the local frame, and in the buffers
/// (client/view/sea/device_sea.h).
struct SEAWAY_STD140_ELEMENT ViewCascade {
    vec4 hermite;           ///< weights of value and rate before, value and rate after
    vec2 origin;            ///< of the local frame in the tile, 0 .. 1
    float maps_per_m;       ///< 1 / length of the tile
    float foam_share;       ///< of the keyframe after, in time; below 0: no foam
    int points;             ///< of the keyframes' grid, a side
    int nodes;              ///< of the gradients' grid, a side: a power of two times as many
    int displacement_first; ///< where level 0 lies, texels
    int gradient_first;     ///< likewise
    int before_first;       ///< where the keyframes lie, four floats each
    int after_first;
    int foam_before_first;
    int foam_after_first;
    int gradient_levels; ///< from this one on a texel is as long as the longest wave: the tile's mean
    int displacement_levels; ///< likewise
    int spare_0, spare_1;
};

// Tables of the sky, layers of one array of images: see client/view/sky/sky.h.
SEAWAY_SHARED_CONSTANT sky_columns = 384;
SEAWAY_SHARED_CONSTANT sky_rows = 128;
SEAWAY_SHARED_CONSTANT sky_layer_sea = 0; ///< all around a point of the sea; mips are blurred
SEAWAY_SHARED_CONSTANT sky_layer_eye =
    1; ///< sky above, source of the air's light below the horizon
SEAWAY_SHARED_CONSTANT sky_layer_cloud = 2; ///< noise of clouds, periodic
SEAWAY_SHARED_CONSTANT sky_layers = 3;
SEAWAY_SHARED_CONSTANT sky_mips = 6; ///< that are blurred: 0, 0.04, 0.08 .. 0.64 rad

struct SEAWAY_STD140_ELEMENT SkyValues {
    vec3 to_sun;
    float azimuth_rad; ///< of the tables' first column
    vec3 sun_low;      ///< mean radiance of the disc at its lower edge, kcd/m2
    float dip_rad;     ///< of the horizon, at the eye
    vec3 sun_high;     ///< and at its upper edge
    float disc_rad;    ///< radius of sun and moon
    vec3 to_moon;
    float star_klx;        ///< of a star of magnitude 0; 0: none are drawn
    vec3 moon;             ///< radiance of its lit part
    float curvature_per_m; ///< 1 / (2 radius of the planet)
    vec3 star_x;           ///< rows of the turn from the local frame to that of the stars
    float cloud_height_m;  ///< above the eye; below 0: below it
    vec3 star_y;
    float cloud_threshold; ///< of the noise; above 1.5: no clouds
    vec3 star_z;
    float cloud_depth;   ///< optical, where they are thickest
    vec3 rayleigh_per_m; ///< at the sea
    float rayleigh_scale_m;
    vec3 aerosol_per_m; ///< extinction at the sea
    float aerosol_scale_m;
    vec3 zenith_depth;   ///< optical depth of the air above the eye
    float cloud_sunlit;  ///< share of the air below the clouds that the light reaches
    vec3 cloud_light;    ///< of sun or moon, normal to the beam, at the clouds, klx
    float cloud_patches; ///< clear beam over its mean below the clouds; 0: one light everywhere
    vec3 cloud_sky;      ///< of the sky, on the level, at the clouds, klx
    float unused_3;
    vec3 to_light; ///< sun or moon, whichever is brighter
    float unused_4;
    vec3 cloud_shaded; ///< source of that air's light elsewhere, kcd/m2
    float unused_5;
    vec2 cloud_origin; ///< of the eye in the noise, periods, modulo what all scales repeat after
    vec2 cloud_per_m;  ///< periods a metre
};

/// Water by its optical type: client/view/water_optics.h.
struct SEAWAY_STD140_ELEMENT WaterValues {
    vec3 attenuation_per_m; ///< of light under water
    float depth_m;          ///< still
    vec3 crest;             ///< of light that shines through a crest, what comes out
    int floor_seen;         ///< 1: through the water
    vec3 bubbles;           ///< of light on water full of bubbles, likewise
    float down_path;        ///< of daylight over the depth, in such ways as attenuation is for
    vec3 floor_reflectance; ///< of the sea floor, above the surface, through no water
    float unused_6;
    vec3 floor_attenuation_per_m; ///< of light that has been there
    float unused_7;
};

/// What views of numbers are told besides (client/view/debug/).
struct SEAWAY_STD140_ELEMENT ViewDebug {
    vec4 stop[view_stops];               ///< of the palette: sRGB, place on the bar
    vec4 fold;                           ///< colour of what folds
    vec4 empty;                          ///< colour where there is no number
    vec4 keyframe_ms[view_cascades_max]; ///< since the one before, to the one after, between both
    /// Variances that a height's bound is made of, m2: anywhere in a cell; between grid points, east and
    /// north; of coding.
    vec4 height_loss[view_cascades_max];
    vec4 displacement_loss[view_cascades_max]; ///< likewise, of D
    vec4 coded_relief[view_cascades_max];      ///< MapLoss's, of heights and of D
    vec4 area;                                 ///< where a flat map lies, pixels: left, top, sides
    float low;                                 ///< numbers at the ends of the bar
    float high;
    int spacing;
    int flip;
    int stops;
    int channel;      ///< that is shown; below 0: three as red, green, blue
    float fold_below; ///< numbers below it have the colour of folds
    int mip;
    float bound_sigmas;
    float height_bound_m; ///< beside the variances
    float displacement_bound_m;
    float fold_blur; ///< what maps may be wrong by of the gradient of the sideways motion
};

struct ViewValues {
    mat4 clip_from_local;
    mat4 local_from_clip; ///< directions: of a point at depth 0 on the picture

    vec3 camera_m;           ///< local position
    float pixel_rad;         ///< angle of a pixel
    vec3 sun_direction;      ///< towards sun or moon, whichever is brighter; unit
    float sun_disk_cosine;   ///< of the angle of the disk's radius
    vec3 sun_irradiance_klx; ///< at the sea, normal to the beam
    float sun_disk_per_sr;   ///< radiance of the disk over that irradiance
    vec3 sky_irradiance_klx; ///< on a horizontal plane
    float bloom_per_shown;   ///< texels of the finest level of bloom a pixel shown
    vec3 water_reflectance;  ///< diffuse, of deep water
    float significant_height_m;

    vec2 mesh_apex_m;       ///< local
    float mesh_azimuth_rad; ///< of the first column
    float mesh_step_rad;    ///< from column to column
    vec2 choppiness;
    float curvature_per_m; ///< 1 / (2 earth radius): a point drops by this times distance squared
    float reach_m;         ///< no point is moved further by the waves

    vec2 foam_noise_origin_m;
    float foam_threshold; ///< Jacobian that breaks
    float foam_softness;  ///< of that, where the pixel resolves everything
    float foam_mean;      ///< coverage, 0 .. 1; 0: no foam
    int foam_level;       ///< of its coarsest noise: cells of 2^-level metres

    // Waves beyond the finest cascade: a copy of it, smaller and turned.
    float detail_amplitude; ///< 1; 0: no copy
    float detail_maps_per_m;
    vec2 detail_origin; ///< of the local frame in the copy, 0 .. 1
    vec2 detail_turn;   ///< cosine and sine
    float
        detail_slope_share; ///< of waves beyond the copy, each axis, over that of the copy, both axes

    int cascades;
    int mesh_columns;
    int mesh_rows;
    int what;               ///< view_final ..
    int what_cascade;       ///< that is shown; below 0: all
    int probes;             ///< of a pixel's strip, at most
    int between_levels;     ///< 1: linear between levels of maps; 0: the nearest
    float exposure;         ///< factor to a picture in which white is 1
    vec2 picture_per_shown; ///< pixels drawn a pixel shown
    vec2 wind_turn;         ///< where waves run to, unit
    vec2 foam_rows_origin;  ///< of the local frame in the rows along the wind, cells
    float foam_rows;        ///< how strong those are, 0 .. 1
    float bloom;            ///< share of the light that is spread
    int bloom_columns;      ///< of its finest level
    int bloom_lines;
    float eye_depth_m; ///< below the water's surface; 0: above it
    ViewCascade cascade[view_cascades_max];
    SkyValues sky;
    WaterValues water;
    ViewDebug debug;
};

#ifdef __cplusplus
static_assert(offsetof(ViewValues, camera_m) == 128 && offsetof(ViewValues, foam_mean) == 256);
static_assert(offsetof(ViewValues, detail_origin) == 272 && offsetof(ViewValues, cascade) == 384);
static_assert(sizeof(ViewCascade) == 80);
static_assert(sizeof(SkyValues) == 16 * 16);
static_assert(sizeof(WaterValues) == 5 * 16);
static_assert(offsetof(ViewValues, sky) == 384 + 80 * view_cascades_max);
static_assert(offsetof(ViewValues, water) == offsetof(ViewValues, sky) + sizeof(SkyValues));
static_assert(sizeof(ViewDebug) == 16 * (view_stops + 2 + 4 * view_cascades_max + 4));
} // namespace seaway::shaders
#endif
#undef SEAWAY_SHARED_CONSTANT
#undef SEAWAY_SHARED_NUMBER
#undef SEAWAY_STD140_ELEMENT

#endif
