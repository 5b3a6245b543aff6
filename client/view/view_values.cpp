// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "client/view/renderer.h"

namespace seaway::client {

namespace {

/// North Sea water: diffuse reflectance of the body below the surface, red, green, blue.
const glm::dvec3 water_reflectance(0.008, 0.024, 0.026);

constexpr double detail_turn_rad = 0.37;
/// Gravity waves give way to capillary ones here, and slopes fade, rad/m (Cox and Munk 1954).
constexpr double shortest_waves_radpm = 370;
/// Of the Jacobian at the edge of a breaking crest, where a pixel resolves everything.
constexpr double breaking_softness = 0.03;

shaders::vec4 vector(const glm::dvec3& v, double w = 0) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z),
            static_cast<float>(w)};
}
shaders::vec4 vector(double x, double y, double z, double w) {
    return vector(glm::dvec3(x, y, z), w);
}

shaders::mat4 matrix(const glm::dmat4& m) {
    shaders::mat4 out;
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            out.column_major[static_cast<std::size_t>(4 * column + row)] =
                static_cast<float>(m[column][row]);
    return out;
}

double fraction(double value) {
    return value - std::floor(value);
}

/// Noise of cells of 2^-level metres is the coarsest of foam: patches are smaller than waves.
double foam_level(double significant_height_m) {
    constexpr double heights_per_cell = 0.6;
    return std::clamp(
        std::round(-std::log2(heights_per_cell * std::max(significant_height_m, 1e-3))), -4.0, 4.0);
}

/// Waves beyond the finest cascade: its variance of slope a factor of wavenumber goes on.
struct Tail {
    double copy_scale = 1;     ///< the finest cascade's copy is this much smaller
    double copy_amplitude = 0; ///< 0: no copy
    double slope_variance = 0; ///< of what lies beyond the copy, each axis
};

Tail tail_of(const SeaFrame& frame, const SeaStatistics& sea) {
    Tail tail;
    const sea::Band& band = frame.cascades.back().band;
    // A single cascade holds the peak too: its slopes say nothing of shorter waves.
    if (frame.cascades.size() < 2 || band.k_lo_radpm <= 0)
        return tail;
    tail.copy_scale = band.k_hi_radpm / band.k_lo_radpm;
    tail.copy_amplitude = 1;
    const double per_octave = sea.finest_slope_variance / std::log(tail.copy_scale);
    const double beyond = shortest_waves_radpm / (band.k_hi_radpm * tail.copy_scale);
    tail.slope_variance = 0.5 * per_octave * std::log(std::max(beyond, 1.0));
    return tail;
}

} // namespace

shaders::ViewValues view_values(const SeaFrame& frame, const SeaMaps& maps, const Camera& camera,
                                const Sky& sky, const Mesh& mesh, const RenderOptions& options,
                                const DebugChoice& debug) {
    shaders::ViewValues out;
    const glm::dmat4 clip_from_local = camera.clip_from_local();
    out.clip_from_local = matrix(clip_from_local);
    out.local_from_clip = matrix(glm::inverse(clip_from_local));
    out.camera = vector(0, 0, camera.z_m, camera.pixel_rad());
    const double disk_cosine = std::cos(Sky::sun_radius_rad);
    out.sun_direction = vector(sky.sun_direction(), disk_cosine);
    const double disk_solid_angle = 2 * std::numbers::pi * (1 - disk_cosine);
    out.sun_irradiance = vector(sky.sun_irradiance(), 1 / disk_solid_angle);
    out.sky_irradiance = vector(sky.sky_irradiance());
    out.water = vector(water_reflectance, maps.statistics.significant_height_m);
    out.mesh = vector(mesh.apex_m.x, mesh.apex_m.y, mesh.azimuth_rad, mesh.step_rad);
    out.sea = vector(frame.choppiness.x, frame.choppiness.y, 1 / (2 * earth_radius_m),
                     std::log(50.0) / options.visibility_m);
    const double noise_m = shaders::view_noise_period_m;
    out.foam =
        vector(frame.foam_threshold, breaking_softness, fraction(camera.x_m / noise_m) * noise_m,
               fraction(camera.y_m / noise_m) * noise_m);

    // A node lies in the middle of its texel.
    const double half_texel = 0.5 / maps.nodes;
    const Tail tail = tail_of(frame, maps.statistics);
    const double finest_m = frame.cascades.back().spec.length_m;
    const double scale = tail.copy_scale / finest_m;
    const double c = std::cos(detail_turn_rad), s = std::sin(detail_turn_rad);
    out.detail = vector(fraction((c * camera.x_m - s * camera.y_m) * scale + half_texel),
                        fraction((s * camera.x_m + c * camera.y_m) * scale + half_texel), scale,
                        options.detail ? tail.slope_variance : 0.0);
    out.detail_turn = vector(c, s, options.detail ? tail.copy_amplitude : 0.0, maps.cascades);
    out.foam_mean = vector(frame.foam_mean, foam_level(frame.significant_height_m),
                           maps.statistics.slope_variance, 0);
    out.counts =
        vector(mesh.columns, static_cast<double>(mesh.rows_m.size()),
               static_cast<double>(debug.view), std::min(debug.cascade, maps.cascades - 1));
    for (std::size_t i = 0; i < frame.cascades.size(); ++i) {
        const double length_m = frame.cascades[i].spec.length_m;
        out.cascade[i] = vector(fraction(camera.x_m / length_m) + half_texel,
                                fraction(camera.y_m / length_m) + half_texel, 1 / length_m,
                                length_m / maps.nodes);
    }
    return out;
}

} // namespace seaway::client
