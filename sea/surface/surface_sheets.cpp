// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/surface_sheets.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <span>

namespace seaway::sea {

namespace {

constexpr int rounds_max = 4;
constexpr double worth_another_round = 0.7;
/// Patches are in single precision.
constexpr double rounding_m = 1e-6;

typedef float F4 __attribute__((vector_size(16)));
typedef double D4 __attribute__((vector_size(32)));

static_assert(offsetof(StrainBounds, xy_size) == offsetof(StrainBounds, range_m) + 12 &&
                  offsetof(StrainBounds, xy_rate) == offsetof(StrainBounds, range_rate) + 12,
              "the four bounds of values and of rates lie side by side");

} // namespace

SurfaceSheets::SurfaceSheets(const Surface& surface, TimeUs time_us)
    : PatchSheets(surface.choppiness()), surface_(surface),
      sideways_(std::max(surface.choppiness().x, surface.choppiness().y)) {
    blur_m_ = rounding_m + surface.fold_blur_m();
    height_blur_m_ = rounding_m + surface.flat_height_bound_m();
    strain_blur_ = surface.fold_strain_blur();
    for (std::size_t c = 0; c < surface.pairs().size(); ++c) {
        const SplinePair& pair = surface.pairs()[c];
        weights_[c] = hermite_weights(pair.before->time_us(), pair.after->time_us(), time_us);
    }
    reach_all_m_ = blur_m_;
    for (std::size_t c = 0; c < surface.pairs().size(); ++c) {
        const SplinePair& pair = surface.pairs()[c];
        reach_m_[c] =
            mixed(c, pair.before->windows().whole_tile(), pair.after->windows().whole_tile())
                .range_m;
        reach_all_m_ += reach_m_[c];
    }
}

SurfaceSheets::Gentleness SurfaceSheets::mixed(std::size_t cascade, const StrainBounds& before,
                                               const StrainBounds& after) const {
    const HermiteWeights& w = weights_[cascade];
    // All four parts at once: range, xx, yy, xy.
    const auto four = [](const float& first) {
        F4 parts;
        std::memcpy(&parts, &first, sizeof parts);
        return __builtin_convertvector(parts, D4);
    };
    const D4 value = w.value[0] * four(before.range_m) + w.value[2] * four(after.range_m);
    const D4 rate = std::abs(w.value[1]) * four(before.range_rate) +
                    std::abs(w.value[3]) * four(after.range_rate);
    const D4 bound = value + rate * D4{1, -1, -1, 1};
    return {sideways_ * bound[0], bound[1], bound[2], bound[3]};
}

std::optional<Box> SurfaceSheets::others(Vec2 target, const Vec2* root, bool) {
    const std::span<const SplinePair> pairs = surface_.pairs();
    double radius_m = reach_all_m_;
    if (root != nullptr) {
        radius_m = radius_around(*root, radius_m);
        if (!(radius_m > 0))
            return std::nullopt;
    }
    const Vec2 middle = root != nullptr ? *root : target;
    return narrowed(Box::around(middle, radius_m, radius_m), target,
                    {reach_m_.data(), pairs.size()}, root != nullptr);
}

bool SurfaceSheets::single(Vec2 target, Vec2 root) const {
    return alone(root) || !SurfaceSheets(*this).others(target, &root, false);
}

void SurfaceSheets::fetch(Vec2 root) const {
    for (const SplinePair& pair : surface_.pairs()) {
        const std::size_t place = pair.before->windows().place(root.x, root.y, 0);
        __builtin_prefetch(&pair.before->windows().at(place));
        __builtin_prefetch(&pair.after->windows().at(place));
    }
}

double SurfaceSheets::radius_around(Vec2 root, double radius_m) const {
    const std::span<const SplinePair> pairs = surface_.pairs();
    std::array<Gentleness, surface_pairs_max> here;
    for (int round = 0; round < rounds_max; ++round) {
        double others_m = blur_m_;
        for (std::size_t c = 0; c < pairs.size(); ++c) {
            const StrainWindows &before = pairs[c].before->windows(),
                                &after = pairs[c].after->windows();
            const std::size_t place = before.place(root.x, root.y, radius_m);
            here[c] = mixed(c, before.at(place), after.at(place));
            others_m += here[c].range_m;
        }
        double less_m = std::min(radius_m, others_m);
        Squeeze squeeze(surface_.choppiness());
        for (std::size_t c = 0; c < pairs.size(); ++c) {
            squeeze.add(here[c].xx_min, here[c].yy_min, here[c].xy_size);
            others_m -= here[c].range_m;
            if (const double smallest = squeeze.smallest(); smallest > 0)
                less_m = std::min(less_m, others_m / smallest);
        }
        if (squeeze.smallest() > strain_blur_)
            return 0;
        const bool again = less_m < worth_another_round * radius_m;
        radius_m = less_m;
        if (!again)
            break;
    }
    return radius_m;
}

SheetPatch SurfaceSheets::patch(std::size_t cascade, const Box& box) const {
    const SplinePair& pair = surface_.pairs()[cascade];
    const int size = pair.before->size();
    const std::size_t pitch = static_cast<std::size_t>(size + SplineMap::border);
    SheetPatch patch(box.low.x, box.high.x, box.low.y, box.high.y, pair.before->length_m() / size,
                     size);
    const auto wrapped = [&](long line) {
        return static_cast<std::size_t>((line % size + size) % size + 1);
    };
    F4 w[4];
    for (int i = 0; i < 4; ++i)
        w[i] = F4{} + static_cast<float>(weights_[cascade].value[i]);
    const float* before = pair.before->coefficients().data();
    const float* after = pair.after->coefficients().data();
    float* moved = patch.moved.data();
    float* height = patch.height.data();
    for (int j = 0; j < patch.y.count; ++j) {
        const std::size_t row = wrapped(patch.y.first + j) * pitch;
        std::size_t column = wrapped(patch.x.first);
        for (int i = 0; i < patch.x.count; ++i, moved += 2, ++height) {
            const std::size_t texel = (row + column) * SplineMap::channels;
            column = column < static_cast<std::size_t>(size) ? column + 1 : 1;
            F4 parts[4]; // values and rates, before and after
            std::memcpy(parts, before + texel, 2 * sizeof(F4));
            std::memcpy(parts + 2, after + texel, 2 * sizeof(F4));
            const F4 now = w[0] * parts[0] + w[1] * parts[1] + w[2] * parts[2] + w[3] * parts[3];
            *height = now[spline_channel::height];
            moved[0] = now[spline_channel::displacement_x];
            moved[1] = now[spline_channel::displacement_y];
        }
    }
    return patch;
}

} // namespace seaway::sea
