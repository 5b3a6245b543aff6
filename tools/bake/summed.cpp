// SPDX-License-Identifier: Apache-2.0
#include "tools/bake/summed.h"

#include <algorithm>
#include <cmath>

#include "sea/foam/foam.h"
#include "sea/surface/maps/spline_map.h"

namespace seaway::bake {

using sea::Field;
using sea::FieldSet;
using sea::Keyframe;

namespace {

/// Up to six planes under the names that a SplineMap samples, in its order.
sea::SplineMap spline_of(const Keyframe& keyframe, std::span<const std::span<const float>> planes) {
    Keyframe renamed;
    renamed.size = keyframe.size;
    renamed.length_m = keyframe.length_m;
    renamed.fields = sea::surface_fields;
    renamed.values.resize(6 * renamed.plane_size());
    for (std::size_t i = 0; i < planes.size(); ++i)
        std::copy(planes[i].begin(), planes[i].end(),
                  renamed.values.begin() + static_cast<std::ptrdiff_t>(i * renamed.plane_size()));
    return sea::SplineMap(renamed);
}

constexpr int channel_of[6] = {0, 1, 2, 4, 5, 6}; // SplineSample's

/// Calls f(node, plane, value) for every grid point of `tile` and each of up to six planes.
template <class F>
void sample_planes(const Keyframe& tile, const Keyframe& source,
                   std::span<const std::span<const float>> planes, const F& f) {
    const sea::SplineMap spline = spline_of(source, planes);
    const double spacing = tile.length_m / tile.size;
    std::size_t node = 0;
    for (int y = 0; y < tile.size; ++y)
        for (int x = 0; x < tile.size; ++x, ++node) {
            const sea::SplineSample sample = spline.sample(x * spacing, y * spacing);
            for (std::size_t i = 0; i < planes.size(); ++i)
                f(node, i, sample.value[channel_of[i]]);
        }
}

void add_linear(Keyframe& tile, const Keyframe& source, const std::vector<Field>& fields) {
    for (std::size_t first = 0; first < fields.size(); first += 6) {
        const std::size_t count = std::min<std::size_t>(6, fields.size() - first);
        std::vector<std::span<const float>> planes;
        std::vector<float*> sums;
        for (std::size_t i = first; i < first + count; ++i) {
            planes.push_back(source.plane(fields[i]));
            sums.push_back(tile.plane(fields[i]).data());
        }
        sample_planes(tile, source, planes, [&](std::size_t node, std::size_t plane, float value) {
            sums[plane][node] += value;
        });
    }
}

void put_jacobian(Keyframe& tile, const sea::Choppiness& choppiness) {
    const auto xx = tile.plane(Field::strain_xx), yy = tile.plane(Field::strain_yy),
               xy = tile.plane(Field::strain_xy);
    const auto lx = static_cast<float>(choppiness.x), ly = static_cast<float>(choppiness.y);
    const auto jacobian = tile.plane(Field::jacobian);
    for (std::size_t i = 0; i < jacobian.size(); ++i)
        jacobian[i] = (1 + lx * xx[i]) * (1 + ly * yy[i]) - lx * ly * xy[i] * xy[i];
}

/// Coverage of all cascades' ratios at every point. A spline of the ratios may dip below zero
/// beside a fresh crest; there is no less foam than none.
void put_foam(Keyframe& tile, const CascadeMaps& maps) {
    const std::size_t cascades = maps.foam_ratios.size();
    std::vector<float> ratios(tile.plane_size() * cascades);
    for (std::size_t c = 0; c < cascades; ++c)
        sample_planes(tile, *maps.keyframes[c], {&maps.foam_ratios[c], 1},
                      [&](std::size_t node, std::size_t, float ratio) {
                          ratios[node * cascades + c] = std::max(ratio, 0.0f);
                      });
    const auto foam = tile.plane(Field::foam);
    for (std::size_t i = 0; i < foam.size(); ++i)
        foam[i] = static_cast<float>(
            sea::foam_coverage(maps.foam_mean, std::span(ratios).subspan(i * cascades, cascades)));
}

/// `from` reduced to `fields`, which it holds.
Keyframe only(const Keyframe& from, FieldSet fields) {
    Keyframe reduced = from;
    reduced.fields = fields;
    reduced.values.clear();
    for (const Field field : fields) {
        const auto plane = from.plane(field);
        reduced.values.insert(reduced.values.end(), plane.begin(), plane.end());
    }
    return reduced;
}

} // namespace

bool summed_tile_repeats(const sea::Realization& sea) {
    const double longest_m = sea.cascades.front().spec.length_m;
    return std::all_of(sea.cascades.begin(), sea.cascades.end(), [&](const auto& cascade) {
        const double times = longest_m / cascade.spec.length_m;
        return std::abs(times - std::round(times)) < 1e-9 * times;
    });
}

int summed_size(const sea::Realization& sea) {
    int size = 0;
    for (const sea::CascadeModes& cascade : sea.cascades)
        size = std::max(size, cascade.spec.size);
    return size;
}

Keyframe sum_cascades(const sea::Realization& sea, const CascadeMaps& maps, FieldSet fields) {
    Keyframe tile;
    tile.cascade = -1;
    tile.epoch = maps.keyframes.front()->epoch;
    tile.time_us = maps.keyframes.front()->time_us;
    tile.size = summed_size(sea);
    tile.length_m = sea.cascades.front().spec.length_m;
    tile.fields = fields.contains(Field::jacobian) ? fields | sea::strain_fields : fields;
    tile.values.resize(static_cast<std::size_t>(tile.fields.size()) * tile.plane_size());
    std::vector<Field> linear;
    for (const Field field : tile.fields)
        if (sea::is_linear(field))
            linear.push_back(field);
    for (const sea::KeyframePtr& source : maps.keyframes)
        add_linear(tile, *source, linear);
    if (fields.contains(Field::jacobian))
        put_jacobian(tile, sea.choppiness);
    if (fields.contains(Field::foam))
        put_foam(tile, maps);
    return tile.fields == fields ? tile : only(tile, fields);
}

} // namespace seaway::bake
