// SPDX-License-Identifier: Apache-2.0
// The cheapest configuration that is accurate enough for a sea, found by laws and by measurement.
//
// Layouts of a fixed space (space.h) come in the order of their prices. What their tiles leave out, and
// what the laws expect of a budget, prunes; the others are measured against the sum of all waves, on
// the scene's own seed, then on fresh ones and in a rougher and a calmer sea, until one keeps the target
// with a fifth to spare in all of them. Since the order is one and what keeps a tight target keeps a
// loose one, a looser target never costs more.
//
// For one thread; truths are summed in as many as it may use.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "sea/certificate/certificate.h"
#include "tools/bench/accuracy/truth/truth.h"
#include "tools/bench/tune/prices.h"
#include "tools/bench/tune/space.h"

namespace seaway::bench {

/// What is asked for.
struct Target {
    double height_error_m = 0.05;           ///< of heights against all waves of the spectrum
    double percentile = 99;                 ///< of places and times
    std::optional<double> slope_error = {}; ///< rms, against the waves that the tiles hold
    std::optional<double> budget_ms = {};   ///< of CPU a second of sea
    std::optional<double> bytes_per_s = {}; ///< of one stream
};

/// What is measured stays below the target by this factor: the next seed is another one.
inline constexpr double margin = 1.2;

struct TuneOptions {
    std::string device = "native";
    std::string folder; ///< for truths; made if it is not there
    std::uint64_t seed = 1;
    Sampling sampling{256, 8, false};
    double envelope_share = 0.1; ///< the sea may be so much rougher and calmer
    int fresh_seeds = 2;
    std::function<void(const std::string&)> progress = {};
};

struct Candidate {
    Layout layout;
    double height_error_m = 0;
    Price price;
    double expected_m = 0;     ///< by the laws, at the percentile, without margin
    double expected_slope = 0; ///< likewise, rms
};

/// What limits a configuration, and by how much: rms of heights.
struct Limits {
    double waves_left_out_m = 0;
    double maps_m = 0; ///< interpolation and codec
};

struct Outcome {
    bool reached = false;
    Candidate
        best; ///< the cheapest that keeps the target; else the most accurate that keeps the limits
    std::vector<sea::MeasuredError> measured; ///< of it
    Limits limits;
    std::vector<std::string>
        runners_up; ///< those that were measured before, and why they were not taken
    std::optional<Candidate>
        without_limits; ///< not reached for --budget-ms or --bytes-per-second alone
    int layouts = 0, priced = 0, tried = 0;
};

/// The scene with the tiles and the budget of a candidate.
sea::Scene with_candidate(sea::Scene scene, const Candidate& candidate);
Configuration configuration_of(const sea::Scene& scene, const std::string& device);

/// The sea with every wind sea and swell larger by a factor, periods by its root, as seas grow. Systems
/// that are given wave by wave or measured stay.
sea::Scene grown(sea::Scene scene, double factor);

/// From the smallest to the largest of the scene and of what it is grown to by 1 - share and 1 + share, as
/// they are requested; of share 0 the scene alone.
Result<sea::Envelope> measured_envelope(const sea::Scene& scene, double share);

/// Seeds of no other use: number 0, 1, ... of what the options' seed gives.
std::uint64_t fresh_seed(std::uint64_t seed, std::uint64_t number);

/// One sea measured. `name` is what the certificate calls it.
Result<sea::MeasuredError> measure_error(const sea::Scene& scene, const std::string& name,
                                         double percentile, const TuneOptions& options,
                                         Devices& devices);

/// Against a sum of shorter waves too: those of a finest tile with four times as many points a side (two
/// from 256 on). What it leaves out is added as by measure_error.
Result<double> measure_beside_finer(const sea::Scene& scene, double percentile,
                                    const TuneOptions& options, Devices& devices);

/// Errors: what the scene or the device cannot do. A target that cannot be had is an Outcome.
Result<Outcome> tune(const sea::Scene& scene, const Target& target, const TuneSpace& space,
                     const TuneOptions& options, Prices& prices, Devices& devices);

} // namespace seaway::bench
