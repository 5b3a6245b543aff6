// SPDX-License-Identifier: Apache-2.0
#include "client/view/sky/clouds.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>

#include "client/view/sky/transmittance.h"
#include "shaders/shared/view.h"

namespace seaway::client {

namespace {

using std::numbers::pi;

/// 0 .. 1 by lattice point and octave (PCG, Jarzynski and Olano 2020).
double hash(std::uint32_t x, std::uint32_t y, std::uint32_t octave) {
    std::uint32_t state = x * 1664525u + y * 22695477u + octave * 747796405u + 2891336453u;
    for (int i = 0; i < 2; ++i) {
        state = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
        state ^= state >> 22u;
    }
    return state / 4294967296.0;
}

/// Value noise, periodic.
double noise_at(double x, double y, int period_x, int period_y, std::uint32_t octave) {
    const double fx = x - std::floor(x), fy = y - std::floor(y);
    const double sx = fx * fx * fx * (fx * (6 * fx - 15) + 10);
    const double sy = fy * fy * fy * (fy * (6 * fy - 15) + 10);
    const int x0 = static_cast<int>(std::floor(x)) % period_x, x1 = (x0 + 1) % period_x;
    const int y0 = static_cast<int>(std::floor(y)) % period_y, y1 = (y0 + 1) % period_y;
    const auto at = [&](int px, int py) {
        return hash(static_cast<std::uint32_t>(px), static_cast<std::uint32_t>(py), octave);
    };
    return std::lerp(std::lerp(at(x0, y0), at(x1, y0), sx), std::lerp(at(x0, y1), at(x1, y1), sx),
                     sy);
}

/// A sum of octaves, the first of which has `cells` cells down the map.
double octaves(double u, double v, int columns, int rows, int cells, int count, bool billows) {
    double sum = 0, weight = 1;
    for (int i = 0; i < count; ++i, cells *= 2, weight *= 0.55) {
        const int across = cells * columns / rows;
        const double n =
            noise_at(u * across, v * cells, across, cells, static_cast<std::uint32_t>(i));
        sum += weight * (billows ? 1 - std::abs(2 * n - 1) : n);
    }
    return sum;
}

/// Replaces values by their rank, 0 .. 1.
void equalise(std::vector<glm::vec2>& values, int component) {
    std::vector<std::size_t> order(values.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return values[a][component] < values[b][component];
    });
    for (std::size_t i = 0; i < order.size(); ++i)
        values[order[i]][component] =
            (static_cast<float>(i) + 0.5f) / static_cast<float>(order.size());
}

glm::dvec2 sample(const std::vector<glm::vec2>& noise, int columns, int rows,
                  const glm::dvec2& at) {
    const double x = (at.x - std::floor(at.x)) * columns, y = (at.y - std::floor(at.y)) * rows;
    const int x0 = static_cast<int>(x - 0.5 + columns) % columns, x1 = (x0 + 1) % columns;
    const int y0 = static_cast<int>(y - 0.5 + rows) % rows, y1 = (y0 + 1) % rows;
    const double fx = x - 0.5 - std::floor(x - 0.5), fy = y - 0.5 - std::floor(y - 0.5);
    const auto texel = [&](int px, int py) {
        return glm::dvec2(noise[static_cast<std::size_t>(py * columns + px)]);
    };
    return glm::mix(glm::mix(texel(x0, y0), texel(x1, y0), fx),
                    glm::mix(texel(x0, y1), texel(x1, y1), fx), fy);
}

double henyey(double g, double cosine) {
    const double base = 1 + g * g - 2 * g * cosine;
    return (1 - g * g) / (4 * pi * base * std::sqrt(base));
}

double light_cosine(const CloudLayer& layer) {
    return std::max(layer.to_light.z, 0.2); // clouds have sides: a low sun lights them
}

double depth_at(const CloudLayer& layer, const std::vector<glm::vec2>& noise, int columns, int rows,
                const glm::dvec2& at) {
    return cloud_depth(layer, sample(noise, columns, rows, at).x,
                       sample(noise, columns, rows, at * double{shaders::cloud_detail_scale}).y,
                       sample(noise, columns, rows, at * double{shaders::cloud_region_scale}).x);
}

/// Of the square of the cosine at which a ray meets a layer, what the layer's height over the sphere adds.
double bent(const CloudLayer& layer) {
    return 4 * layer.height_m * layer.curvature_per_m;
}

} // namespace

std::vector<glm::vec2> cloud_noise(int columns, int rows, ThreadPool& pool) {
    std::vector<glm::vec2> out(static_cast<std::size_t>(columns * rows));
    for_rows(pool, rows, [&](int y) {
        for (int x = 0; x < columns; ++x) {
            const double u = (x + 0.5) / columns, v = (y + 0.5) / rows;
            out[static_cast<std::size_t>(y * columns + x)] =
                glm::vec2(octaves(u, v, columns, rows, 4, 5, false),
                          octaves(u, v, columns, rows, 8, 4, true));
        }
    });
    equalise(out, 0);
    equalise(out, 1);
    return out;
}

double cloud_threshold(double coverage) {
    if (coverage <= 0)
        return 2;
    // Towards 1 the threshold goes below all noise, so that no hole is left.
    return 1 - coverage - 0.7 * std::max(coverage - 0.7, 0.0) / 0.3;
}

double cloud_depth(const CloudLayer& layer, double pattern, double detail, double region) {
    const double above = pattern + shaders::cloud_detail_share * (detail - 0.5) +
                         shaders::cloud_region_share * (region - 0.5) - layer.threshold;
    const double share = std::clamp(above / shaders::cloud_softness, 0.0, 1.0);
    return layer.optical_depth * share * share; // thin at their edges
}

CloudSeen clouds_seen(const CloudLayer& layer, const std::vector<glm::vec2>& noise, int columns,
                      int rows, const glm::dvec3& direction) {
    if (layer.threshold > 1.5)
        return {};
    const double s = direction.z, rise = bent(layer), under = s * s + rise;
    if (under <= 0 || (rise > 0 && s < 0) || (rise <= 0 && s >= 0))
        return {};
    const double cosine = std::sqrt(under);
    CloudSeen seen;
    seen.distance_m = 2 * std::abs(layer.height_m) / (std::abs(s) + cosine);
    const glm::dvec2 at = layer.origin + glm::dvec2(direction) * seen.distance_m / layer.period_m;
    const double depth = depth_at(layer, noise, columns, rows, at);
    const double mu = light_cosine(layer);
    const glm::dvec2 aside =
        glm::dvec2(layer.to_light) * (shaders::cloud_thickness_m / mu) / layer.period_m;
    const double lightwards = depth_at(layer, noise, columns, rows, at + aside);
    const double shade = std::clamp((1 + shaders::cloud_diffuse_loss * depth) /
                                        (1 + shaders::cloud_diffuse_loss * lightwards),
                                    0.5, 1.6);
    const double through = 1 / (1 + shaders::cloud_diffuse_loss * depth);
    // A sea is as bright on all sides: what is scattered on the way up is made up for by its neighbours' light.
    seen.left = layer.height_m > 0 ? std::exp(-depth / std::max(cosine, 0.05)) : through;
    const glm::dvec3 beam = layer.light * mu * (through - std::exp(-depth / mu)) * shade;
    const glm::dvec3 sky = layer.sky * (through - std::exp(-shaders::cloud_mean_slant * depth));
    // Of thin clouds the beam's light goes on nearly straight, of thick ones everywhere.
    const double angle = glm::dot(direction, layer.to_light);
    const double lobes =
        shaders::cloud_forward_share * henyey(shaders::cloud_forward, angle) +
        (1 - shaders::cloud_forward_share) * henyey(shaders::cloud_backward, angle);
    const double straight = std::exp(-shaders::cloud_straight_loss * depth);
    // Seen aslant a thin cloud is brighter, as it hides more: 1.66 is the mean slant of what falls on the level.
    const double aslant = (1 - std::exp(-depth / std::max(cosine, 0.05))) /
                          std::max(1 - std::exp(-shaders::cloud_mean_slant * depth), 1e-6);
    const glm::dvec3 passed = aslant * (beam * glm::mix(1 / pi, lobes / mu, straight) + sky / pi);
    const glm::dvec3 returned = (layer.light * mu * shade + layer.sky) * ((1 - through) / pi);
    seen.radiance = layer.height_m > 0 ? passed : returned;
    return seen;
}

glm::dvec3 before(const CloudSeen& seen, const glm::dvec3& clear, const glm::dvec3& source,
                  const glm::dvec3& left) {
    return clear * seen.left + left * seen.radiance + (1 - seen.left) * (1.0 - left) * source;
}

glm::dvec3 behind_clouds(const CloudLayer& layer, const CloudSeen& seen, const glm::dvec3& clear,
                         const glm::dvec3& depth, const glm::dvec3& left, double direction_z) {
    // A sky's light over what its air holds back is its source.
    const glm::dvec3 held = 1.0 - glm::exp(-depth / std::max(direction_z, 0.03));
    const glm::dvec3 source = glm::mix(layer.shaded, clear / held, layer.sunlit);
    return before(seen, clear, source, left);
}

double beam_share(const CloudLayer& sea, const std::vector<glm::vec2>& noise, int columns, int rows,
                  const glm::dvec2& place_m) {
    if (sea.threshold > 1.5)
        return 1;
    const double s = sea.to_light.z;
    const double distance_m = 2 * sea.height_m / (s + std::sqrt(s * s + bent(sea)));
    const glm::dvec2 at =
        sea.origin + (place_m + distance_m * glm::dvec2(sea.to_light)) / sea.period_m;
    return std::exp(-depth_at(sea, noise, columns, rows, at) / light_cosine(sea));
}

CloudShare mean_cloud_share(const CloudLayer& layer, const std::vector<glm::vec2>& noise) {
    CloudShare sum{0, 0};
    const double mu = light_cosine(layer);
    for (std::size_t i = 0; i < noise.size(); ++i) {
        // Which values meet is not as in the sky; how they are distributed is.
        const double detail = static_cast<double>(noise[(i * 7919) % noise.size()].y);
        const double region = static_cast<double>(noise[(i * 104729) % noise.size()].x);
        const double depth = cloud_depth(layer, static_cast<double>(noise[i].x), detail, region);
        sum.straight += std::exp(-depth / mu);
        sum.diffuse += 1 / (1 + shaders::cloud_diffuse_loss * depth);
    }
    const auto count = static_cast<double>(noise.size());
    return {sum.straight / count, sum.diffuse / count};
}

} // namespace seaway::client
