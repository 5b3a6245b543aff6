// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "tools/bench/accuracy/measure/laws.h"
#include "tools/bench/accuracy/measure/measure.h"
#include "tools/bench/tune/total_error.h"
#include "tools/bench/tune/tuner.h"

namespace seaway::bench {

namespace {

/// Of heights, anywhere, where the true surface does not fold.
std::vector<double> height_errors(const std::vector<Sample>& samples) {
    std::vector<double> errors;
    for (const Sample& s : samples)
        if (s.kind == PointKind::anywhere && !(s.truth.flags & sea::answer_folded))
            errors.push_back(s.answer.height_m - s.truth.height_m);
    return errors;
}

struct Measured {
    std::vector<Sample> samples;
    Missing missing; ///< that the truth leaves out
    double hs_m;
};

Result<Measured> measured_against(const sea::Scene& scene, const Waves& truth_waves,
                                  const TuneOptions& options, Devices& devices) {
    const Configuration configuration = configuration_of(scene, options.device);
    SEAWAY_TRY_LET(const Truth truth, reference_truth(truth_waves, options.sampling, scene.sea.seed,
                                                      options.folder + "/truth"));
    SEAWAY_TRY_LET(const auto sea, ConfiguredSea::create(scene, configuration, devices));
    Measured measured;
    SEAWAY_TRY_LET(measured.samples, sample_answers(*sea, truth, {}));
    measured.missing = missing_waves(truth_waves);
    measured.hs_m = 4.0 * std::sqrt(variance_of(*sea->waves().all));
    return measured;
}

} // namespace

std::uint64_t fresh_seed(std::uint64_t seed, std::uint64_t number) {
    std::uint64_t z = seed * 0x9e3779b97f4a7c15u + (number + 1) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (z ^ (z >> 31)) >> 1;
}

sea::Scene with_candidate(sea::Scene scene, const Candidate& candidate) {
    scene.cascades = candidate.layout.cascades;
    scene.accuracy.height_error_m = candidate.height_error_m;
    return scene;
}

Configuration configuration_of(const sea::Scene& scene, const std::string& device) {
    Configuration configuration = balanced(scene);
    configuration.device = device;
    if (!scene.accuracy.streams())
        configuration.codec_error_m = 0.0;
    if (!scene.effects.choppy)
        configuration.choppiness = 0.0;
    return configuration;
}

Result<sea::MeasuredError> measure_error(const sea::Scene& scene, const std::string& name,
                                         double percentile, const TuneOptions& options,
                                         Devices& devices) {
    SEAWAY_TRY_LET(const Waves waves,
                   configured_waves(scene, configuration_of(scene, options.device)));
    SEAWAY_TRY_LET(const Measured measured, measured_against(scene, waves, options, devices));
    const std::vector<Figure> all = figures(measured.samples, measured.hs_m);
    sea::MeasuredError error;
    error.sea = name;
    error.seed = scene.sea.seed;
    error.hs_m = measured.hs_m;
    error.rms_m = value_of(all, "rms_m");
    error.p99_m = value_of(all, "p99_m");
    error.max_m = value_of(all, "max_m");
    error.slope_rms = value_of(all, "slope_rms");
    error.waves_left_out_m = measured.missing.rms_m();
    error.total_rms_m = std::hypot(error.rms_m, error.waves_left_out_m);
    error.total_m =
        percentile_with_normal(height_errors(measured.samples), error.waves_left_out_m, percentile);
    return error;
}

Result<double> measure_beside_finer(const sea::Scene& scene, double percentile,
                                    const TuneOptions& options, Devices& devices) {
    Configuration finer = configuration_of(scene, options.device);
    sea::CascadeSpec& finest = finer.cascades.back();
    finest.size *= finest.size < 256 ? 4 : 2;
    SEAWAY_TRY_LET(const Waves waves, configured_waves(scene, finer));
    SEAWAY_TRY_LET(const Measured measured, measured_against(scene, waves, options, devices));
    return percentile_with_normal(height_errors(measured.samples), measured.missing.rms_m(),
                                  percentile);
}

sea::Scene grown(sea::Scene scene, double factor) {
    for (sea::WaveSystem& system : scene.sea.systems) {
        if (auto* wind = std::get_if<sea::WindSea>(&system)) {
            wind->wind_speed_10m_mps *= factor;
            wind->significant_height_m.reset(); // it is its constant that stays
            if (wind->wind_speed_19m5_mps)
                *wind->wind_speed_19m5_mps *= factor;
        } else if (auto* swell = std::get_if<sea::Swell>(&system)) {
            swell->significant_height_m *= factor;
            swell->peak_period_s *= std::sqrt(factor);
        }
    }
    return scene;
}

Result<sea::Envelope> measured_envelope(const sea::Scene& scene, double share) {
    const auto point = [](const sea::Scene& one) -> Result<sea::SeaPoint> {
        SEAWAY_TRY_LET(const sea::Realization realized, sea::realize(one));
        return sea_point(one, sea::summarize(one.sea, realized).requested);
    };
    SEAWAY_TRY_LET(const sea::SeaPoint given, point(scene));
    sea::Envelope seas = envelope_of(given);
    if (!(share > 0))
        return seas;
    for (const double factor : {1.0 - share, 1.0 + share}) {
        SEAWAY_TRY_LET(const sea::SeaPoint other, point(grown(scene, factor)));
        seas.add(other);
    }
    return seas;
}

} // namespace seaway::bench
