// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/tune/space.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace seaway::bench {

namespace {

/// A tile of `size` points goes on where one that is so many times longer ends.
double ratio_max(int size) {
    return 0.5 * sea::band_end_share_of_nyquist * size / sea::band_start_steps;
}

/// Four digits: a scene is read by people, and lengths without a common multiple stay so.
double rounded(double length_m) {
    const double step = std::pow(10.0, std::floor(std::log10(length_m)) - 3);
    return std::round(length_m / step) * step;
}

double end_of(const sea::CascadeSpec& tile) {
    return sea::band_end_share_of_nyquist * tile.nyquist_radpm();
}

/// Tiles evenly apart on a logarithmic axis; none if a gap would be left or they lie too near.
std::optional<Layout> layout(double longest_m, double k_end_radpm, int size, int finest_size,
                             int more_tiles) {
    constexpr double ratio_min = 1.5;
    const double finest_m =
        sea::band_end_share_of_nyquist * std::numbers::pi * finest_size / k_end_radpm;
    if (finest_m * ratio_min > longest_m)
        return std::nullopt;
    const double octaves = std::log(longest_m / finest_m);
    const int steps =
        static_cast<int>(std::ceil(octaves / std::log(0.999 * ratio_max(size)))) + more_tiles;
    const double ratio = std::exp(octaves / steps);
    if (steps + 1 > sea::scene_cascades_max || ratio < ratio_min)
        return std::nullopt;
    Layout made;
    for (int i = 0; i <= steps; ++i)
        made.cascades.push_back({i == 0 ? longest_m : rounded(longest_m / std::pow(ratio, i)),
                                 i == steps ? finest_size : size});
    made.k_end_radpm = end_of(made.cascades.back());
    if (!sea::assign_bands(made.cascades))
        return std::nullopt;
    return made;
}

bool same(const Layout& a, const Layout& b) {
    return std::equal(a.cascades.begin(), a.cascades.end(), b.cascades.begin(), b.cascades.end(),
                      [](const sea::CascadeSpec& x, const sea::CascadeSpec& y) {
                          return x.length_m == y.length_m && x.size == y.size;
                      });
}

} // namespace

TuneSpace whole_space() {
    TuneSpace space;
    for (int i = 0; i <= 37; ++i)
        space.k_ends_radpm.push_back(0.08 * std::pow(2.0, i / 3.0));
    for (int i = -50; i <= 0; ++i)
        space.height_errors_m.push_back(std::round(std::pow(10.0, i / 10.0 + 7)) / 1e7);
    return space;
}

std::vector<Layout> layouts(const TuneSpace& space, double longest_tile_m) {
    std::vector<Layout> all;
    const auto add = [&all](std::optional<Layout> made) {
        if (made && std::none_of(all.begin(), all.end(),
                                 [&](const Layout& held) { return same(held, *made); }))
            all.push_back(*std::move(made));
    };
    for (const int size : space.sizes) {
        const sea::CascadeSpec alone{longest_tile_m, size};
        add(Layout{{alone}, end_of(alone)});
        for (const double k_end_radpm : space.k_ends_radpm)
            for (const int more : space.more_tiles)
                for (const int divisor : space.finest_divisors)
                    if (size / divisor >= 64)
                        add(layout(longest_tile_m, k_end_radpm, size, size / divisor, more));
    }
    return all;
}

} // namespace seaway::bench
