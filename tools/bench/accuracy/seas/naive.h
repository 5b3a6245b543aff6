// SPDX-License-Identifier: Apache-2.0
// What Seaway does not do, done for the comparison: bilinear filtering, linear interpolation in time or
// none, maps of 16 bits, a fixed number of fixed-point steps. Nothing outside the bench may use this.
// Whole ways from maps to answers, whose cost and error the bench measures on real seas; tests/naive has
// single mistakes, each beside the test of its hard case.
//
// Pure; thread-safe.
#pragma once

#include <span>
#include <vector>

#include "sea/surface/inverse.h"
#include "sea/surface/maps/hermite.h"
#include "sea/surface/maps/keyframe.h"
#include "sea/surface/maps/spline_map.h"
#include "tools/bench/accuracy/seas/configuration.h"
#include "tools/bench/accuracy/seas/half.h"

namespace seaway::bench {

/// Nearest of 65535 values evenly spread over +-range.
float rounded_to_snorm16(float value, float range);

/// Rounds every map of a keyframe; the range of snorm16 is the map's own.
void round_maps(sea::Keyframe& keyframe, MapFormat format);

/// Weights of (value before, rate before, value after, rate after) as in sea/surface/maps/hermite.h.
sea::HermiteWeights time_weights(TimeRule rule, sea::TimeUs before_us, sea::TimeUs after_us,
                                 sea::TimeUs time_us);

/// One cascade between two keyframes, by any rules. Bilinear filtering needs maps of all linear
/// fields, and takes slopes and strains from them.
class NaiveCascade {
  public:
    NaiveCascade(sea::KeyframePtr before, sea::KeyframePtr after, SpaceRule space, TimeRule time);

    /// Adds the undisplaced point.
    void add(double x_m, double y_m, sea::TimeUs time_us, sea::LagrangianPoint& sum) const;

  private:
    /// A keyframe with its fields side by side, [y][x][field].
    struct Texels {
        sea::KeyframePtr keyframe;
        std::vector<float> values;
        sea::SplineMapPtr spline;
    };
    static Texels prepared(sea::KeyframePtr keyframe, SpaceRule space);
    sea::LagrangianPoint at(const Texels& texels, double x_m, double y_m) const;

    Texels before_;
    Texels after_;
    SpaceRule space_;
    TimeRule time_;
};

/// X <- x - lambda D(X), `steps` times from X = x; then what is at X. Never flagged as folded.
sea::Answer fixed_point_answer(const sea::QueryPoint& point, int steps,
                               const sea::Choppiness& choppiness, sea::LagrangianField field);

} // namespace seaway::bench
