// SPDX-License-Identifier: Apache-2.0
// A demand on a sea, served second by second of sea time as the server does: what is due is computed,
// foam goes on, tiles are encoded once. What that takes is counted.
//
// For one thread; demands on the same device take turns.
#pragma once

#include <cstdint>
#include <vector>

#include "base/result.h"
#include "server/device/synthesizer.h"
#include "server/simulation/effect_plan.h"
#include "server/simulation/foam_maps.h"
#include "server/simulation/running_sea.h"
#include "server/simulation/schedule.h"

namespace seaway::bench {

/// What a demand took.
struct Spent {
    double maps_s = 0;   ///< CPU time of synthesis and foam
    double stream_s = 0; ///< of encoding
    double bytes = 0;
    double transforms = 0; ///< those that foam steps through are among them
    double keyframes = 0;

    Spent& operator+=(const Spent& more);
    Spent operator-(const Spent& less) const;
    Spent operator/(double divisor) const;
};

/// Demands begin at this time; before it foam has a past.
inline constexpr sea::TimeUs demand_start_us = 100'000'000;

/// Foam of every cascade as it is at demand_start_us; it walks through hundreds of ticks for that.
Result<server::FoamMaps> foam_at_start(const server::RunningSeaPtr& sea,
                                       server::Synthesizer& device);

class StreamedDemand {
  public:
    /// Fields of each cascade. `foam` as of foam_at_start(); the device has the sea.
    StreamedDemand(server::RunningSeaPtr sea, server::Synthesizer& device,
                   std::vector<sea::FieldSet> fields, const server::FoamMaps& foam);

    /// Goes on for a time; where no whole number of intervals fills it, now a keyframe more, now one less.
    Result<Spent> run(sea::TimeUs duration_us);

    const std::vector<sea::FieldSet>& fields() const { return fields_; }

  private:
    Result<void> serve(const std::vector<server::KeyframeRequest>& due, Spent& spent);
    Result<void> encode(const sea::Keyframe& keyframe, Spent& spent) const;

    const server::RunningSeaPtr sea_;
    server::Synthesizer& device_;
    const std::vector<sea::FieldSet> fields_;
    server::EffectPlan plan_;
    server::SeaCoursePtr course_;
    server::Schedule schedule_;
    server::FoamMaps foam_;
    sea::TimeUs now_us_ = demand_start_us;
};

} // namespace seaway::bench
