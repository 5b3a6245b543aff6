// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/surface_sheets.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "sea/surface/hermite.h"

namespace seaway::sea {

namespace {

constexpr int rounds_max = 4;
constexpr double worth_another_round = 0.7;
/// Patches are in single precision.
constexpr double rounding_m = 1e-6;

/// The bounds of one pair mixed at a time between its keyframes.
class Mixed {
  public:
    Mixed(const SplinePair& pair, TimeUs time_us, const StrainBounds& before,
          const StrainBounds& after)
        : w_(hermite_weights(pair.before->time_us(), pair.after->time_us(), time_us)),
          before_(before), after_(after) {}

    double range_m() const {
        return value(&StrainBounds::range_m) + rate(&StrainBounds::range_rate);
    }
    void squeeze(Squeeze& sum) const {
        const double xy_rate = rate(&StrainBounds::xy_rate);
        sum.add(value(&StrainBounds::xx_min) - rate(&StrainBounds::xx_rate),
                value(&StrainBounds::yy_min) - rate(&StrainBounds::yy_rate),
                value(&StrainBounds::xy_min) - xy_rate, value(&StrainBounds::xy_max) + xy_rate);
    }

  private:
    double value(float StrainBounds::*part) const {
        return w_.value[0] * static_cast<double>(before_.*part) +
               w_.value[2] * static_cast<double>(after_.*part);
    }
    double rate(float StrainBounds::*part) const {
        return std::abs(w_.value[1]) * static_cast<double>(before_.*part) +
               std::abs(w_.value[3]) * static_cast<double>(after_.*part);
    }

    HermiteWeights w_;
    const StrainBounds& before_;
    const StrainBounds& after_;
};

Mixed whole_tile(const SplinePair& pair, TimeUs time_us) {
    return {pair, time_us, pair.before->windows().whole_tile(), pair.after->windows().whole_tile()};
}

Mixed around(const SplinePair& pair, TimeUs time_us, Vec2 at, double radius_m) {
    return {pair, time_us, pair.before->windows().around(at.x, at.y, radius_m),
            pair.after->windows().around(at.x, at.y, radius_m)};
}

} // namespace

SurfaceSheets::SurfaceSheets(const Surface& surface, TimeUs time_us)
    : PatchSheets(surface.choppiness()), surface_(surface), time_us_(time_us),
      sideways_(std::max(surface.choppiness().x, surface.choppiness().y)) {
    const MapError& error = surface.map_error();
    blur_m_ =
        rounding_m + sideways_ * error.interpolation_displacement_m + error.codec_displacement_m;
    strain_blur_ = sideways_ * error.interpolation_strain + error.codec_strain;
}

std::optional<Box> SurfaceSheets::others(Vec2 target, const Vec2* root, bool) {
    const std::vector<SplinePair>& pairs = surface_.pairs();
    double radius_m = blur_m_;
    for (const SplinePair& pair : pairs)
        radius_m += sideways_ * whole_tile(pair, time_us_).range_m();
    if (root != nullptr) {
        radius_m = radius_around(*root, radius_m);
        if (!(radius_m > 0))
            return std::nullopt;
    }
    std::vector<double> reach_m;
    for (const SplinePair& pair : pairs)
        reach_m.push_back(sideways_ * whole_tile(pair, time_us_).range_m());
    const Vec2 middle = root != nullptr ? *root : target;
    return narrowed(Box::around(middle, radius_m, radius_m), target, reach_m, root != nullptr);
}

double SurfaceSheets::radius_around(Vec2 root, double radius_m) const {
    const std::vector<SplinePair>& pairs = surface_.pairs();
    for (int round = 0; round < rounds_max; ++round) {
        double others_m = blur_m_;
        for (const SplinePair& pair : pairs)
            others_m += sideways_ * around(pair, time_us_, root, radius_m).range_m();
        double less_m = std::min(radius_m, others_m);
        Squeeze squeeze(surface_.choppiness());
        for (const SplinePair& pair : pairs) {
            const Mixed here = around(pair, time_us_, root, radius_m);
            here.squeeze(squeeze);
            others_m -= sideways_ * here.range_m();
            if (const double smallest = squeeze.smallest(); smallest > 0)
                less_m = std::min(less_m, others_m / smallest);
        }
        if (squeeze.smallest() > strain_blur())
            return 0;
        const bool again = less_m < worth_another_round * radius_m;
        radius_m = less_m;
        if (!again)
            break;
    }
    return radius_m;
}

DisplacementPatch SurfaceSheets::patch(std::size_t cascade, const Box& box) const {
    const SplinePair& pair = surface_.pairs()[cascade];
    const int size = pair.before->size();
    const HermiteWeights w =
        hermite_weights(pair.before->time_us(), pair.after->time_us(), time_us_);
    const std::size_t pitch = static_cast<std::size_t>(size + SplineMap::border);
    DisplacementPatch patch(box.low.x, box.high.x, box.low.y, box.high.y,
                            pair.before->length_m() / size);
    const auto wrapped = [&](long line) {
        return static_cast<std::size_t>((line % size + size) % size + 1);
    };
    float* out = patch.coefficients.data();
    for (int j = 0; j < patch.rows; ++j) {
        const std::size_t row = wrapped(patch.row0 + j) * pitch;
        for (int i = 0; i < patch.columns; ++i, out += 2) {
            const std::size_t texel = (row + wrapped(patch.column0 + i)) * SplineMap::channels;
            const float* before = pair.before->coefficients().data() + texel;
            const float* after = pair.after->coefficients().data() + texel;
            for (int c = 1; c <= 2; ++c) // D_x and D_y; their rates stand four further on
                out[c - 1] = static_cast<float>(w.value[0] * static_cast<double>(before[c]) +
                                                w.value[1] * static_cast<double>(before[c + 4]) +
                                                w.value[2] * static_cast<double>(after[c]) +
                                                w.value[3] * static_cast<double>(after[c + 4]));
        }
    }
    return patch;
}

} // namespace seaway::sea
