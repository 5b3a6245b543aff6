// SPDX-License-Identifier: Apache-2.0
#include "client/view/sea_maps.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <thread>

namespace seaway::client {

namespace {

constexpr int channels = 4;
constexpr int nodes_min = 64;
constexpr int nodes_max = 1024;

void for_each_row(int rows, const std::function<void(int)>& work) {
    const int count = static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1u, 16u));
    std::vector<std::jthread> threads;
    for (int t = 0; t < count; ++t)
        threads.emplace_back([&, t] {
            for (int row = t; row < rows; row += count)
                work(row);
        });
}

std::size_t chain_texels(int nodes, int layers) {
    std::size_t count = 0;
    for (int side = nodes; side > 0; side /= 2)
        count += static_cast<std::size_t>(side) * static_cast<std::size_t>(side * layers);
    return count;
}

/// Means of 2 x 2; an even side at every level, so that the average is exact.
void build_mips(std::vector<float>& texels, int nodes, int layers) {
    std::size_t above = 0;
    for (int side = nodes / 2; side > 0; side /= 2) {
        const int parent = 2 * side;
        const std::size_t here = above + static_cast<std::size_t>(parent) *
                                             static_cast<std::size_t>(parent * layers * channels);
        for_each_row(side * layers, [&](int row) {
            const int layer = row / side;
            const int y = row % side;
            const float* a = &texels[above + static_cast<std::size_t>((layer * parent + 2 * y) *
                                                                      parent * channels)];
            const float* b = a + parent * channels;
            float* out =
                &texels[here + static_cast<std::size_t>((layer * side + y) * side * channels)];
            for (int x = 0; x < side; ++x)
                for (int c = 0; c < channels; ++c) {
                    const int left = 2 * x * channels + c;
                    out[x * channels + c] =
                        0.25f * (a[left] + a[left + channels] + b[left] + b[left + channels]);
                }
        });
        above = here;
    }
}

/// Values of one periodic line of `count` texels, `stride` floats apart, to the coefficients of the
/// cubic B-spline through them (Unser 1999); all channels but the last, which is foam.
void to_coefficients(float* line, int count, std::size_t stride) {
    constexpr float pole = -0.26794919f; // sqrt(3) - 2
    constexpr int memory = 14;           // |pole|^14 = 1e-8
    const auto at = [&](int i) { return line + static_cast<std::size_t>(i) * stride; };
    for (int c = 0; c < channels - 1; ++c) {
        float carry = 0;
        for (int i = count - memory; i < count; ++i)
            carry = 6.0f * at(i)[c] + pole * carry;
        for (int i = 0; i < count; ++i) {
            carry = 6.0f * at(i)[c] + pole * carry;
            at(i)[c] = carry;
        }
        carry = 0;
        for (int i = memory - 1; i >= 0; --i)
            carry = pole * (carry - at(i)[c]);
        for (int i = count - 1; i >= 0; --i) {
            carry = pole * (carry - at(i)[c]);
            at(i)[c] = carry;
        }
    }
}

void to_coefficients(std::vector<float>& texels, int nodes, int layers) {
    const auto side = static_cast<std::size_t>(nodes);
    for_each_row(nodes * layers, [&](int row) {
        to_coefficients(&texels[static_cast<std::size_t>(row) * side * channels], nodes, channels);
    });
    for_each_row(nodes * layers, [&](int column) {
        const auto layer = static_cast<std::size_t>(column / nodes);
        const auto x = static_cast<std::size_t>(column % nodes);
        to_coefficients(&texels[(layer * side * side + x) * channels], nodes, side * channels);
    });
}

/// The ratio of a foam map at a node of the finer grid; linear in space.
double foam_at(const sea::Keyframe& keyframe, int nodes, int x, int y) {
    const std::span<const float> plane = keyframe.plane(sea::Field::foam);
    const int fine = std::max(nodes / keyframe.size, 1),
              coarse = std::max(keyframe.size / nodes, 1);
    const auto texel = [&](int column, int row) {
        const int mask = keyframe.size - 1;
        return static_cast<double>(
            plane[static_cast<std::size_t>((row & mask) * keyframe.size + (column & mask))]);
    };
    const int column = x * coarse / fine, row = y * coarse / fine;
    const double s = static_cast<double>(x % fine) / fine, t = static_cast<double>(y % fine) / fine;
    return (1 - t) * ((1 - s) * texel(column, row) + s * texel(column + 1, row)) +
           t * ((1 - s) * texel(column, row + 1) + s * texel(column + 1, row + 1));
}

/// Foam between two keyframes, linear in time; a cascade without foam is average everywhere.
double foam_between(const CascadeFrame& cascade, sea::TimeUs time_us, int nodes, int x, int y) {
    if (!cascade.foam_before || !cascade.foam_after)
        return 1.0;
    const double before = foam_at(*cascade.foam_before, nodes, x, y);
    const sea::TimeUs interval_us = cascade.foam_after->time_us - cascade.foam_before->time_us;
    if (interval_us <= 0)
        return before;
    const double share = static_cast<double>(time_us - cascade.foam_before->time_us) /
                         static_cast<double>(interval_us);
    return before + share * (foam_at(*cascade.foam_after, nodes, x, y) - before);
}

/// One cascade alone, at the nodes of row `y`.
void fill_row(SeaMaps& maps, const sea::Surface& surface, const CascadeFrame& frame,
              sea::TimeUs time_us, int cascade, int y) {
    const std::size_t row = static_cast<std::size_t>((cascade * maps.nodes + y) * maps.nodes);
    const double spacing_m = frame.spec.length_m / maps.nodes;
    for (int x = 0; x < maps.nodes; ++x) {
        const sea::LagrangianPoint p = surface.at(x * spacing_m, y * spacing_m, time_us);
        const std::size_t at = (row + static_cast<std::size_t>(x)) * channels;
        const auto put = [&](std::vector<float>& map, double a, double b, double c, double d) {
            map[at] = static_cast<float>(a);
            map[at + 1] = static_cast<float>(b);
            map[at + 2] = static_cast<float>(c);
            map[at + 3] = static_cast<float>(d);
        };
        put(maps.displacement, p.displacement_x, p.displacement_y, p.height,
            foam_between(frame, time_us, maps.nodes, x, y));
        put(maps.gradient, p.slope_x, p.slope_y, p.strain_xx, p.strain_yy);
        put(maps.moment, p.strain_xy, p.slope_x * p.slope_x, p.slope_y * p.slope_y,
            p.slope_x * p.slope_y);
    }
}

SeaStatistics statistics_of(const SeaMaps& maps, const sea::Choppiness& choppiness) {
    SeaStatistics out;
    const std::size_t texels =
        static_cast<std::size_t>(maps.nodes) * static_cast<std::size_t>(maps.nodes);
    double variance = 0;
    for (int c = 0; c < maps.cascades; ++c) {
        double squares = 0, slopes = 0, height_max = 0, moved_max = 0;
        for (std::size_t i = 0; i < texels; ++i) {
            const std::size_t at = (static_cast<std::size_t>(c) * texels + i) * channels;
            const float* d = &maps.displacement[at];
            const double height = static_cast<double>(d[2]);
            squares += height * height;
            height_max = std::max(height_max, std::abs(height));
            moved_max = std::max(moved_max, std::hypot(choppiness.x * static_cast<double>(d[0]),
                                                       choppiness.y * static_cast<double>(d[1])));
            slopes +=
                static_cast<double>(maps.moment[at + 1]) + static_cast<double>(maps.moment[at + 2]);
        }
        variance += squares / static_cast<double>(texels);
        out.crest_m += height_max;
        out.reach_m += moved_max;
        out.finest_slope_variance = slopes / static_cast<double>(texels);
        out.slope_variance += out.finest_slope_variance;
    }
    out.significant_height_m = 4 * std::sqrt(variance);
    return out;
}

} // namespace

int map_nodes(const SeaFrame& frame) {
    int size = nodes_min;
    for (const CascadeFrame& cascade : frame.cascades)
        size = std::max(size, 2 * cascade.spec.size);
    return std::min(size, nodes_max);
}

SeaMaps build_maps(const SeaFrame& frame) {
    SeaMaps maps;
    maps.nodes = map_nodes(frame);
    maps.cascades = static_cast<int>(frame.cascades.size());
    const std::size_t floats = chain_texels(maps.nodes, maps.cascades) * channels;
    for (std::vector<float>* map : {&maps.displacement, &maps.gradient, &maps.moment})
        map->resize(floats);
    for (int c = 0; c < maps.cascades; ++c) {
        const CascadeFrame& cascade = frame.cascades[static_cast<std::size_t>(c)];
        const sea::Surface surface({cascade.keyframes}, frame.choppiness, {}, {});
        for_each_row(maps.nodes,
                     [&](int y) { fill_row(maps, surface, cascade, frame.time_us, c, y); });
    }
    for (std::vector<float>* map : {&maps.displacement, &maps.gradient, &maps.moment})
        build_mips(*map, maps.nodes, maps.cascades);
    maps.statistics = statistics_of(maps, frame.choppiness);
    to_coefficients(maps.displacement, maps.nodes, maps.cascades);
    return maps;
}

} // namespace seaway::client
