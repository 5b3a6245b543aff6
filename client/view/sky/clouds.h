// SPDX-License-Identifier: Apache-2.0
// One layer of clouds from noise: how much of what lies behind it is left in a direction, and what it
// sends itself. shaders/view/sky.glsl has the same formula; a test holds the two together.
//
// A slab at the height of the base whose optical depth is noise above a threshold. From below one sees
// light that came through it, by a two-stream solution (Eddington's: Tdiff = 1 / (1 + 0.75 (1 - g) tau), Shettle and Weinman 1970),
// from above what it turns back, and around the sun the light that went straight on, in two lobes.
// Clouds far away fade into the air like the sea does. A value; pure; thread-safe.
#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "base/thread_pool.h"
#include "client/view/sky/look.h"

namespace seaway::client {

/// Noise that repeats after `columns` by `rows` texels, of even distribution: the share of texels below x
/// is x. Two octaves-sums: x the clouds' pattern, y its detail.
std::vector<glm::vec2> cloud_noise(int columns, int rows, ThreadPool& pool);

/// Sides of a period of the noise, in sizes of clouds.
inline const glm::dvec2 cloud_periods(12, 4);
/// After so many periods all that is looked up in the noise repeats: pattern, detail and region, whose scales times it are
/// whole. A place is kept modulo it. In floats it is exact to a hundredth of a texel.
inline constexpr double cloud_wrap_periods = 100;

/// A layer of clouds over an eye, and the light that it meets.
struct CloudLayer {
    double height_m = 0;  ///< above the eye; below 0: below it
    double threshold = 2; ///< of the noise
    double optical_depth = 0;
    glm::dvec2 origin{0.0}; ///< of the eye in the noise, periods, 0 .. cloud_wrap_periods
    glm::dvec2 period_m{1.0};
    double curvature_per_m = 0;
    glm::dvec3 to_light{0, 0, 1};
    glm::dvec3 light{0.0};  ///< of sun or moon, normal to the beam, klx
    glm::dvec3 sky{0.0};    ///< on the level, klx
    double sunlit = 1;      ///< share of the air below that the light reaches
    glm::dvec3 shaded{0.0}; ///< source of the air's light where it does not, kcd/m2
};

struct CloudSeen {
    double left = 1;          ///< share of the light behind
    glm::dvec3 radiance{0.0}; ///< of the layer itself, kcd/m2
    double distance_m = 0;    ///< 0: no clouds that way
};

/// Threshold of the noise for a share of the sky.
double cloud_threshold(double coverage);
/// Optical depth by noise: pattern at the place, detail at shaders::cloud_detail_scale times it, and how cloudy the
/// region is, the pattern at shaders::cloud_region_scale times it.
double cloud_depth(const CloudLayer& layer, double pattern, double detail, double region);

/// noise: as cloud_noise made it.
CloudSeen clouds_seen(const CloudLayer& layer, const std::vector<glm::vec2>& noise, int columns,
                      int rows, const glm::dvec3& direction);
/// Share of the beam of sun or moon that goes straight through the clouds to a point of the sea. `sea`: the layer as it
/// stands over the sea, its origin at the point that `place_m` counts from.
double beam_share(const CloudLayer& sea, const std::vector<glm::vec2>& noise, int columns, int rows,
                  const glm::dvec2& place_m);
/// Of light that falls on the level through clouds, averaged over the layer: what goes straight, of the
/// beam, and what comes through at all.
struct CloudShare {
    double straight;
    double diffuse;
};
/// Clouds before a colour that is seen through all of the air; source: of the air's light before them; left: of light on
/// the way to the clouds.
glm::dvec3 before(const CloudSeen& seen, const glm::dvec3& clear, const glm::dvec3& source,
                  const glm::dvec3& left);
/// The same before a sky, whose own light tells the source. depth: of the air above the eye, straight up.
glm::dvec3 behind_clouds(const CloudLayer& layer, const CloudSeen& seen, const glm::dvec3& clear,
                         const glm::dvec3& depth, const glm::dvec3& left, double direction_z);
CloudShare mean_cloud_share(const CloudLayer& layer, const std::vector<glm::vec2>& noise);

} // namespace seaway::client
