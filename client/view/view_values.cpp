// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "client/view/renderer.h"
#include "client/view/water_optics.h"

namespace seaway::client {

namespace {

constexpr double detail_turn_rad = 0.37;
/// Gravity waves give way to capillary ones here, and slopes fade, rad/m (Elfouhaily, Chapron, Katsaros and Vandemark 1997).
constexpr double shortest_waves_radpm = 370;
/// Width of the Jacobian's range at the edge of a breaking crest, where a pixel resolves everything.
constexpr double breaking_softness = 0.03;

float narrow(double value) {
    return static_cast<float>(value);
}
shaders::vec2 narrow(const glm::dvec2& v) {
    return {narrow(v.x), narrow(v.y)};
}
shaders::vec3 narrow(const glm::dvec3& v) {
    return {narrow(v.x), narrow(v.y), narrow(v.z)};
}
shaders::mat4 narrow(const glm::dmat4& m) {
    shaders::mat4 out;
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            out.column_major[static_cast<std::size_t>(4 * column + row)] = narrow(m[column][row]);
    return out;
}

glm::dvec2 fraction(const glm::dvec2& value) {
    return value - glm::floor(value);
}

/// Noise of cells of 2^-level metres is the coarsest of foam: patches are smaller than waves.
int foam_level(double significant_height_m) {
    constexpr double heights_per_cell = 0.6;
    const double cell_m = heights_per_cell * std::max(significant_height_m, 1e-3);
    return static_cast<int>(std::clamp(std::round(-std::log2(cell_m)), -4.0, 4.0));
}

/// Waves beyond the finest cascade: its variance of slope a factor of wavenumber goes on.
struct Tail {
    double copy_scale = 1;     ///< the finest cascade's copy is this much smaller
    double copy_amplitude = 0; ///< 0: no copy
    double slope_share =
        0; ///< variance of slope beyond the copy, each axis, over that of the copy, both axes
};

Tail tail_of(const SeaFrame& frame) {
    Tail tail;
    const sea::Band& band = frame.cascades.back().band;
    // A single cascade holds the peak too: its slopes say nothing of shorter waves.
    if (frame.cascades.size() < 2 || band.k_lo_radpm <= 0)
        return tail;
    tail.copy_scale = band.k_hi_radpm / band.k_lo_radpm;
    tail.copy_amplitude = 1;
    const double beyond = shortest_waves_radpm / (band.k_hi_radpm * tail.copy_scale);
    tail.slope_share = 0.5 * std::log(std::max(beyond, 1.0)) / std::log(tail.copy_scale);
    return tail;
}

void set_light(shaders::ViewValues& out, const Sky& sky) {
    const double disk_cosine = std::cos(Sky::sun_radius_rad);
    const double disk_sr = 2 * std::numbers::pi * (1 - disk_cosine);
    out.sun_direction = narrow(sky.light_direction());
    out.sun_disk_cosine = narrow(disk_cosine);
    out.sun_irradiance_klx = narrow(sky.light_irradiance());
    out.sun_disk_per_sr = narrow(1 / disk_sr);
    out.sky_irradiance_klx = narrow(sky.sky_irradiance());
    out.sky = sky.values();
}

/// The way of daylight down over the depth: of the beam, bent by the surface, and of light from all over the sky, whose mean
/// cosine under water is 0.86.
double down_path(const Sky& sky) {
    constexpr double index = shaders::water_index, path_of_sky = 1 / 0.86;
    const double up = std::max(sky.light_direction().z, 0.0);
    const double beam = luminance_of(sky.light_irradiance()) * up;
    const double all = beam + luminance_of(sky.sky_irradiance());
    const double path_of_beam = 1 / std::sqrt(1 - (1 - up * up) / (index * index));
    return all > 0 ? (beam * path_of_beam + (all - beam) * path_of_sky) / all : path_of_sky;
}

void set_water(shaders::ViewValues& out, const SeaFrame& frame, const Sky& sky) {
    const WaterLook look = water_look(frame.water, frame.depth_m, frame.significant_height_m);
    out.water_reflectance = narrow(look.reflectance);
    out.water.attenuation_per_m = narrow(look.attenuation_per_m);
    out.water.depth_m = narrow(frame.depth_m);
    out.water.crest = narrow(look.crest);
    out.water.floor_seen = look.floor_seen ? 1 : 0;
    out.water.bubbles = narrow(look.bubbles);
    out.water.down_path = narrow(down_path(sky) / slant_of_attenuation(frame.water.type));
    out.water.floor_reflectance = narrow(look.floor);
    out.water.floor_attenuation_per_m = narrow(look.floor_attenuation_per_m);
}

/// Rows of foam along the wind begin at 9 m/s (Beaufort 5), where foam covers half a percent.
void set_rows_of_wind(shaders::ViewValues& out, const SeaFrame& frame, const glm::dvec2& camera_m) {
    constexpr double first_cover = 0.005, full_cover = 0.02, strongest = 0.8;
    const double azimuth_rad = glm::radians(90 - (frame.mean_from_deg + 180));
    const glm::dvec2 turn(std::cos(azimuth_rad), std::sin(azimuth_rad));
    const glm::dvec2 downwind(glm::dot(turn, camera_m), turn.x * camera_m.y - turn.y * camera_m.x);
    const glm::dvec2 cells =
        downwind * glm::dvec2(shaders::view_rows_a_metre_along, shaders::view_rows_a_metre_across);
    const double period = shaders::view_noise_period_m; // of noise in cells of one
    out.wind_turn = narrow(turn);
    out.foam_rows_origin = narrow(fraction(cells / period) * period);
    out.foam_rows =
        narrow(strongest *
               std::clamp((frame.foam_mean - first_cover) / (full_cover - first_cover), 0.0, 1.0));
}

void set_detail(shaders::ViewValues& out, const SeaFrame& frame, const glm::dvec2& camera_m,
                const RenderOptions& options) {
    const Tail tail = tail_of(frame);
    const double maps_per_m = tail.copy_scale / frame.cascades.back().spec.length_m;
    const double c = std::cos(detail_turn_rad), s = std::sin(detail_turn_rad);
    const glm::dvec2 turned(c * camera_m.x - s * camera_m.y, s * camera_m.x + c * camera_m.y);
    out.detail_origin = narrow(fraction(turned * maps_per_m));
    out.detail_maps_per_m = narrow(maps_per_m);
    out.detail_turn = narrow(glm::dvec2(c, s));
    out.detail_amplitude = options.detail ? narrow(tail.copy_amplitude) : 0.0f;
    out.detail_slope_share = options.detail ? narrow(tail.slope_share) : 0.0f;
}

} // namespace

void set_display(shaders::ViewValues& values, const Display& display, double scale) {
    values.exposure = narrow(display.exposure);
    values.bloom = narrow(display.bloom);
    set_debug_colours(values.debug, display);
    values.picture_per_shown = narrow(glm::dvec2(scale));
}

shaders::ViewValues view_values(const SeaFrame& frame, const Camera& camera, const Sky& sky,
                                const Mesh& mesh, const RenderOptions& options,
                                const DebugChoice& debug, const Display& display) {
    shaders::ViewValues out;
    const glm::dmat4 clip_from_local = camera.clip_from_local();
    out.clip_from_local = narrow(clip_from_local);
    out.local_from_clip = narrow(glm::inverse(clip_from_local));
    out.camera_m = narrow(glm::dvec3(0, 0, camera.z_m));
    out.pixel_rad = narrow(camera.pixel_rad());
    set_light(out, sky);
    set_water(out, frame, sky);
    out.significant_height_m = narrow(frame.significant_height_m);
    if (!options.air)
        out.sky.rayleigh_per_m = out.sky.aerosol_per_m = {};

    out.mesh_apex_m = narrow(mesh.apex_m);
    out.mesh_azimuth_rad = narrow(mesh.azimuth_rad);
    out.mesh_step_rad = narrow(mesh.step_rad);
    out.mesh_columns = mesh.columns;
    out.mesh_rows = static_cast<int>(mesh.rows_m.size());
    out.choppiness = {narrow(frame.choppiness.x), narrow(frame.choppiness.y)};
    out.curvature_per_m = narrow(1 / (2 * earth_radius_m));
    out.reach_m = narrow(frame.reach_m);

    const glm::dvec2 camera_m(camera.x_m, camera.y_m);
    const double noise_m = shaders::view_noise_period_m;
    out.foam_noise_origin_m = narrow(fraction(camera_m / noise_m) * noise_m);
    out.foam_threshold = narrow(frame.foam_threshold);
    out.foam_softness = narrow(breaking_softness);
    out.foam_mean = narrow(frame.foam_mean);
    out.foam_level = foam_level(frame.significant_height_m);
    set_rows_of_wind(out, frame, camera_m);
    set_detail(out, frame, camera_m, options);

    out.what = static_cast<int>(debug.view);
    out.what_cascade = shown_cascade(debug, static_cast<int>(frame.cascades.size()));
    set_debug(out.debug, frame, camera, debug);
    out.probes = options.quality.probes;
    out.between_levels = options.quality.between_levels ? 1 : 0;
    set_display(out, display, options.quality.scale);
    return out;
}

} // namespace seaway::client
