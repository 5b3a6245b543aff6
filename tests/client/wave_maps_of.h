// SPDX-License-Identifier: Apache-2.0
// A small windy sea whose waves a client has, with what its maps cost as a server says it.
#pragma once

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "client/wave_maps.h"
#include "sea/surface/budget/error_budget.h"
#include "tests/client/announced_scene.h"

namespace seaway::client {

class WaveMapsOf : public ::testing::Test {
  protected:
    const sea::RealizationPtr waves = tests::announced_waves();
    const sea::ErrorBudget budget = sea::plan_budget(*waves, 0.01);
    const sea::TimeUs interval_us = std::ranges::min(budget.cascades, {}, of_interval).interval_us;
    const SeaStatePtr state = told();
    static constexpr std::size_t cascades = 2;
    const sea::DirectSum truth{waves};
    std::mt19937_64 random{5};

    static sea::TimeUs of_interval(const sea::CascadeBudget& cascade) {
        return cascade.interval_us;
    }
    /// The sea of announced_scene.h with what its maps cost, as a server says it; all of one interval.
    SeaStatePtr told() const {
        auto values = std::make_shared<SeaState>(tests::announced());
        put(budget, *values);
        for (protocol::CascadeInfo& cascade : values->cascades)
            cascade.interval_us = interval_us;
        return values;
    }
    static void put(const sea::ErrorBudget& costs, SeaState& values) {
        values.interpolation_error_m = costs.interpolation_m;
        values.interpolation_displacement_m = costs.interpolation_displacement_m;
        values.interpolation_strain = costs.interpolation_strain;
        values.single_precision_m = costs.single_precision_m;
        values.single_precision_displacement_m = costs.single_precision_displacement_m;
        values.displacement_reach_m = costs.displacement_reach_m;
        values.rms_strain = costs.rms_strain;
        values.height_error_m = costs.height_error_m;
        for (const sea::CascadeBudget& cascade : costs.cascades)
            values.losses.push_back(cascade.loss);
    }
    OwnSeaPtr sea_off_by(const RebuiltError& error) const {
        return std::make_shared<const RebuiltSea>(waves, *state, error);
    }
    std::vector<sea::QueryPoint> points(std::size_t count, sea::TimeUs time_us) {
        std::uniform_real_distribution<double> place(-1e5, 1e5);
        std::vector<sea::QueryPoint> made;
        for (std::size_t i = 0; i < count; ++i)
            made.push_back({place(random), place(random), time_us});
        return made;
    }
    sea::Answer exact(const sea::QueryPoint& point) const {
        return sea::surface_at(point, {waves->choppiness, 1e-9, sea::FoldSearch{}},
                               truth.at_time(point.time_us));
    }
    /// So many points of one time are worth all of its keyframes.
    static constexpr std::size_t many = 1'000'000;
};

} // namespace seaway::client
