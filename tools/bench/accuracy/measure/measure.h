// SPDX-License-Identifier: Apache-2.0
// One configuration on one sea, measured: what a row of the journal, a step of a tuner or a guard
// against regressions is made of.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "base/result.h"
#include "tools/bench/accuracy/measure/metrics.h"
#include "tools/bench/accuracy/measure/stage_costs.h"
#include "tools/bench/accuracy/seas/configured_sea.h"
#include "tools/bench/accuracy/truth/truth.h"

namespace seaway::bench {

/// Height queries a second that "work" counts beside the keyframes: forty hulls of 25 probes, ten times
/// a second.
inline constexpr double queries_per_s = 10'000.0;

struct Extent {
    int every = 1;                ///< take each so many-th point
    std::optional<int> time_base; ///< only times around this one, an index of time_bases_s
    bool octaves = false;         ///< energy and phase by octave too
    bool flicker = false;         ///< and the second of film
};

/// One of the seas that a configuration is measured on: of one spectrum, each of a seed of its own, as
/// configured_waves() has it of that configuration.
struct DrawnSea {
    Waves waves;
    Truth truth;
};

/// The answers of a configured sea beside the truth, at the extent's points.
Result<std::vector<Sample>> sample_answers(ConfiguredSea& sea, const Truth& truth,
                                           const Extent& extent);

/// Errors alone, nothing is timed: figures() of metrics.h; hs_m; missing_<where>_m; total_rms_m: error
/// against the spectrum, what is missing included; flicker_m; codec_over_bound: the codec's largest error
/// over its bound. The same figures every time. One ConfiguredSea at a time on a device.
Result<std::vector<Figure>> measure_errors(const sea::Scene& scene,
                                           const Configuration& configuration, const Truth& truth,
                                           const Extent& extent, Devices& devices);

/// What measure_errors() gives, over all points of all seas, and of several seas rms_m@seed=S, p99_m@seed=S,
/// hs_m@seed=S and p99_worst_m, the largest of them; predicted_rms_m and predicted_<source>_m of laws.h;
/// octaves as "energy_pct@k", "energy_worst_pct@k" and "phase_rad@k"; the costs of stage_costs.h; query_ns; work_ms_per_s =
/// keyframes + splines + encoding + queries_per_s answers. Laws, octaves, flicker and costs are of the
/// first sea. `seas` is not empty.
Result<std::vector<Figure>> measure(std::span<const DrawnSea> seas,
                                    const Configuration& configuration, const Extent& extent,
                                    Devices& devices, StageCosts& costs);

/// What a layout of tiles holds of a spectrum, without a single answer: missing_*_m, missing_slope_rms,
/// hs_scatter_pct (standard deviation over seeds of the tile's Hs), octaves asked for and held as
/// "asked_m@k", "held_m@k".
Result<std::vector<Figure>> measure_layout(const sea::Scene& scene,
                                           const Configuration& configuration);

/// Relative error of a device's height map at its grid points against the sum in double:
/// transform_error, and what float arithmetic is expected to cost, predicted_transform_error.
Result<std::vector<Figure>> measure_transform(const sea::Scene& scene,
                                              const Configuration& configuration, Devices& devices);

} // namespace seaway::bench
