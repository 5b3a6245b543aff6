// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/surface_sheets.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <span>

namespace seaway::sea {

namespace {

constexpr int rounds_max = 6;
constexpr double worth_another_round = 0.8;
/// Patches are in single precision.
constexpr double rounding_m = 1e-6;

typedef float F4 __attribute__((vector_size(16)));

static_assert(sizeof(StrainBounds) == 2 * sizeof(F4));

/// Of `value` times a map and `rate` times its time rates as a mean of the map carried on and back, as far as that goes.
/// The cubic between two keyframes has no value below 0.
F4 weights_of_bounds(double value, double rate, double carried_s) {
    const double carried = value * carried_s;
    const double turned = std::clamp(rate, -carried, carried) / carried_s;
    return F4{static_cast<float>(0.5 * (value + turned)),
              static_cast<float>(0.5 * (value - turned)),
              static_cast<float>(std::max(std::abs(rate) - carried, 0.0)), 0};
}

} // namespace

SurfaceSheets::SurfaceSheets(const Surface& surface, TimeUs time_us)
    : PatchSheets(surface.choppiness()), surface_(surface),
      more_sideways_(surface.choppiness().largest()),
      less_sideways_(std::min(surface.choppiness().x, surface.choppiness().y)) {
    blur_m_ = rounding_m + surface.fold_blur_m();
    height_blur_m_ = rounding_m + surface.flat_height_bound_m();
    strain_blur_ = surface.fold_strain_blur();
    const std::span<const SplinePair> pairs = surface.pairs();
    std::array<Gentleness, surface_pairs_max> anywhere;
    reach_all_m_ = blur_m_;
    for (std::size_t c = 0; c < pairs.size(); ++c) {
        const SplinePair& pair = pairs[c];
        const HermiteWeights& w = weights_[c] =
            hermite_weights(pair.before->time_us(), pair.after->time_us(), time_us);
        bound_weights_[c] = {
            weights_of_bounds(w.value[0], w.value[1], pair.before->windows().carried_s()),
            weights_of_bounds(w.value[2], w.value[3], pair.after->windows().carried_s())};
        anywhere[c] =
            mixed(c, pair.before->windows().whole_tile(), pair.after->windows().whole_tile());
        reach_m_[c] = anywhere[c].range_m;
        reach_all_m_ += reach_m_[c];
    }
    // What is known of the whole tiles may do already.
    reach_all_m_ = less_than(reach_all_m_, [&](std::size_t c) { return anywhere[c]; });
}

SurfaceSheets::Cells SurfaceSheets::cells(Vec2 place) const {
    Cells cells;
    for (std::size_t c = 0; c < surface_.pairs().size(); ++c)
        cells[c] = surface_.pairs()[c].before->windows().cell(place.x, place.y);
    return cells;
}

SurfaceSheets::Gentleness SurfaceSheets::mixed(std::size_t cascade, const StrainBounds& before,
                                               const StrainBounds& after) const {
    struct Parts { // of a StrainBounds
        F4 ranges, strains;
        explicit Parts(const StrainBounds& of) { std::memcpy(this, &of, sizeof of); }
    };
    const Parts first(before), second(after);
    const BoundWeights& w = bound_weights_[cascade];
    const F4 ranges = w.before * first.ranges + w.after * second.ranges;
    const F4 strains = w.before * first.strains + w.after * second.strains;
    const auto strain_min = static_cast<double>(strains[0] + strains[1] - strains[2]);
    return {more_sideways_ * static_cast<double>(ranges[0] + ranges[1] + ranges[2]),
            strain_min * (strain_min < 0 ? more_sideways_ : less_sideways_)};
}

std::optional<Box> SurfaceSheets::others(Vec2 target, const Vec2* root, bool) {
    const std::span<const SplinePair> pairs = surface_.pairs();
    double radius_m = blur_m_; // how far solutions lie from the target
    for (std::size_t c = 0; c < pairs.size(); ++c)
        radius_m += reach_m_[c];
    if (root != nullptr) {
        radius_m = radius_around(cells(*root));
        if (!(radius_m > 0))
            return std::nullopt;
    }
    const Vec2 middle = root != nullptr ? *root : target;
    return narrowed(Box::around(middle, radius_m, radius_m), target,
                    {reach_m_.data(), pairs.size()}, root != nullptr);
}

bool SurfaceSheets::single(Vec2 target, Vec2 root, const Cells& cells) const {
    return alone(cells) || !SurfaceSheets(*this).others(target, &root, false);
}

void SurfaceSheets::fetch(const Cells& cells) const {
    for (std::size_t c = 0; c < surface_.pairs().size(); ++c) {
        const SplinePair& pair = surface_.pairs()[c];
        const std::size_t place = pair.before->windows().place(cells[c], reach_all_m_);
        __builtin_prefetch(&pair.before->windows().at(place));
        __builtin_prefetch(&pair.after->windows().at(place));
    }
}

template <class Of>
double SurfaceSheets::less_than(double radius_m, Of of) const {
    const std::size_t count = surface_.pairs().size();
    double others_m = blur_m_;
    double least = 1;
    for (std::size_t c = 0; c < count; ++c) {
        others_m += of(c).range_m;
        least += of(c).stretch;
    }
    if (least > strain_blur_)
        return 0;
    double less_m = std::min(radius_m, others_m);
    double smallest = 1;
    for (std::size_t c = 0; c < count; ++c) {
        smallest += of(c).stretch;
        others_m -= of(c).range_m;
        if (smallest > 0)
            less_m = std::min(less_m, others_m / smallest);
    }
    return less_m;
}

double SurfaceSheets::radius_around(const Cells& cells) const {
    const std::span<const SplinePair> pairs = surface_.pairs();
    double radius_m = reach_all_m_;
    std::array<Gentleness, surface_pairs_max> here;
    for (int round = 0; round < rounds_max && radius_m > 0; ++round) {
        for (std::size_t c = 0; c < pairs.size(); ++c) {
            const StrainWindows& before = pairs[c].before->windows();
            const std::size_t place = before.place(cells[c], radius_m);
            here[c] = mixed(c, before.at(place), pairs[c].after->windows().at(place));
        }
        const double less_m = less_than(radius_m, [&](std::size_t c) { return here[c]; });
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
