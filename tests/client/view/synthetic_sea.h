// SPDX-License-Identifier: Apache-2.0
// Seas for the renderer without a server: keyframes from the CPU's transform, at the intervals that
// the error budget gives.
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>
#include <string>

#include "client/view/sea/sea_frame.h"
#include "sea/native/native_runner.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/waves/realize.h"

namespace seaway::client {

class SyntheticSea {
  public:
    explicit SyntheticSea(sea::RealizationPtr sea, double height_error_m = 0.01)
        : sea_(std::move(sea)), budget_(sea::plan_budget(*sea_, height_error_m)) {}
    explicit SyntheticSea(sea::Realization sea)
        : SyntheticSea(std::make_shared<const sea::Realization>(std::move(sea))) {}

    SeaFrame at(sea::TimeUs time_us) {
        SeaFrame frame;
        frame.time_us = time_us;
        frame.choppiness = sea_->choppiness;
        frame.significant_height_m = 4 * std::sqrt(variance());
        frame.error = sea::map_error(budget_, 0);
        frame.reach_m = 6 * std::sqrt(variance()) * sea_->choppiness.largest();
        for (std::size_t c = 0; c < sea_->cascades.size(); ++c) {
            const sea::TimeUs interval_us = budget_.cascades[c].interval_us;
            const sea::TimeUs before_us = time_us - time_us % interval_us;
            frame.cascades.push_back({sea_->cascades[c].spec,
                                      sea_->cascades[c].band,
                                      {map(c, before_us), map(c, before_us + interval_us)}});
        }
        return frame;
    }

    /// All cascades together: what a query would be answered from.
    sea::Surface surface(const SeaFrame& frame) const {
        std::vector<sea::SplinePair> pairs;
        for (const CascadeFrame& cascade : frame.cascades)
            pairs.push_back(cascade.keyframes);
        return {pairs, sea_->choppiness, fold_search(budget_), sea::map_error(budget_, 0)};
    }

    const sea::Realization& realization() const { return *sea_; }

    /// Of heights, m2.
    double variance() const {
        double sum = 0;
        for (const sea::CascadeModes& cascade : sea_->cascades)
            for (const auto& h0 : cascade.h0)
                sum += 2 * std::norm(h0);
        return sum;
    }

  private:
    sea::SplineMapPtr map(std::size_t cascade, sea::TimeUs time_us) {
        const sea::CascadeModes& modes = sea_->cascades[cascade];
        Result<sea::NativeTransform> transform =
            sea::NativeTransform::create(modes, sea_->choppiness);
        SEAWAY_CHECK(transform.has_value(), "the test asks for a size that there is not");
        sea::Keyframe keyframe;
        keyframe.cascade = static_cast<int>(cascade);
        keyframe.time_us = time_us;
        keyframe.size = modes.spec.size;
        keyframe.length_m = modes.spec.length_m;
        keyframe.fields = sea::surface_fields;
        keyframe.values.resize(static_cast<std::size_t>(keyframe.fields.size()) *
                               keyframe.plane_size());
        const sea::NativeTask task{&*transform, sea_->phase_time(time_us), keyframe.fields,
                                   keyframe.values};
        runner_.run({&task, 1});
        return std::make_shared<const sea::SplineMap>(keyframe);
    }

    sea::RealizationPtr sea_;
    sea::ErrorBudget budget_;
    sea::NativeRunner runner_;
};

} // namespace seaway::client
