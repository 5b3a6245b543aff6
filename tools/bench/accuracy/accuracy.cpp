// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/accuracy/accuracy.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/instructions.h"
#include "server/device/device_choice.h"
#include "tools/bench/accuracy/error_map.h"
#include "tools/bench/accuracy/journal.h"
#include "tools/bench/accuracy/knobs.h"
#include "tools/bench/accuracy/measure.h"
#include "tools/bench/accuracy/progress.h"
#include "tools/bench/accuracy/sea_states.h"

namespace seaway::bench {

namespace {

/// The knobs that all six sea states are tried with, whatever the extent.
constexpr std::string_view everywhere[] = {"named", "format"};
/// Where the others are tried, unless every state is asked for.
constexpr std::string_view swept_states_quick[] = {"gale_deep"};
constexpr std::string_view swept_states[] = {"gale_deep", "storm_shallow"};

template <class Range>
bool holds(const Range& range, std::string_view name) {
    return std::find(std::begin(range), std::end(range), name) != std::end(range);
}

Sampling sampling_of(const AccuracyOptions& options) {
    Sampling sampling = options.quick  ? Sampling{512, 8}
                        : options.full ? Sampling{4096, 32}
                                       : Sampling{1024, 16};
    if (options.points > 0)
        sampling.points = options.points;
    if (options.times > 0)
        sampling.times = options.times;
    return sampling;
}

Result<void> check(const AccuracyOptions& options) {
    for (const std::string& state : options.states)
        SEAWAY_TRY(sea_state(state, options.seed));
    for (const std::string& name : options.knobs) {
        std::vector<std::string_view> names;
        for (const Knob& knob : knobs())
            names.push_back(knob.name);
        if (!holds(names, name))
            return Error{fmt::format("no knob is called \"{}\"; there are {}", name,
                                     fmt::join(names, ", "))};
    }
    return {};
}

struct Job {
    std::string state;
    std::string_view knob;
    Trial trial;
};

class Run {
  public:
    Run(const AccuracyOptions& options, Journal journal)
        : options_(options), sampling_(sampling_of(options)), journal_(std::move(journal)),
          costs_(options.quick ? 7 : 15) {}

    Result<void> all();

  private:
    Result<std::vector<Job>> jobs() const;
    Result<void> one(const Job& job);
    Result<std::vector<Figure>> measured(const Job& job, const sea::Scene& scene);
    Result<const Truth*> truth_of(const Waves& waves);

    const AccuracyOptions& options_;
    Sampling sampling_;
    Journal journal_;
    Devices devices_;
    StageCosts costs_;
    std::optional<Truth> truth_; ///< the last one
    sea::RealizationPtr truth_waves_;
    int added_ = 0;
};

Result<std::vector<Job>> Run::jobs() const {
    std::vector<Job> all;
    for (const std::string_view state : sea_state_names()) {
        if (!options_.states.empty() && !holds(options_.states, state))
            continue;
        SEAWAY_TRY_LET(const sea::Scene scene, sea_state(state, options_.seed));
        const bool swept =
            options_.full || !options_.states.empty() ||
            (options_.quick ? holds(swept_states_quick, state) : holds(swept_states, state));
        for (const Knob& knob : knobs()) {
            if (!options_.knobs.empty() && !holds(options_.knobs, knob.name))
                continue;
            if (!swept && !holds(everywhere, knob.name))
                continue;
            for (Trial& trial : knob.trials(scene, options_.device))
                all.push_back({std::string(state), knob.name, std::move(trial)});
        }
    }
    return all;
}

Result<const Truth*> Run::truth_of(const Waves& waves) {
    const auto same = [&](const sea::Realization& held) {
        if (held.cascades.size() != waves.all->cascades.size() ||
            held.choppiness.x != waves.all->choppiness.x)
            return false;
        for (std::size_t c = 0; c < held.cascades.size(); ++c)
            if (held.cascades[c].spec.length_m != waves.all->cascades[c].spec.length_m ||
                held.cascades[c].h0 != waves.all->cascades[c].h0)
                return false;
        return true;
    };
    if (!truth_ || !same(*truth_waves_)) {
        SEAWAY_TRY_LET(truth_,
                       reference_truth(waves, sampling_, options_.seed, options_.out + "/truth"));
        truth_waves_ = waves.all;
    }
    return &*truth_;
}

Result<std::vector<Figure>> Run::measured(const Job& job, const sea::Scene& scene) {
    const Configuration& configuration = job.trial.configuration;
    switch (job.trial.measurement) {
    case Measurement::layout:
        return measure_layout(scene, configuration);
    case Measurement::transform:
        return measure_transform(scene, configuration, devices_);
    case Measurement::answers:
        break;
    }
    SEAWAY_TRY_LET(const Waves waves, configured_waves(scene, configuration));
    SEAWAY_TRY_LET(const Truth* truth, truth_of(waves));
    SEAWAY_TRY_LET(std::vector<Figure> figures,
                   measure(scene, configuration, *truth, job.trial.extent, devices_, costs_));
    figures.push_back(exact("truth_error_m", truth->sum_error_m + truth_tolerance_m));
    return figures;
}

Result<void> Run::one(const Job& job) {
    SEAWAY_TRY_LET(const Place where, place_of(job.trial.configuration, devices_));
    const TrialName name{job.state, std::string(job.knob), job.trial.value, where.device};
    if (journal_.has(name))
        return {};
    const double start = cpu_seconds();
    SEAWAY_TRY_LET(const sea::Scene scene, sea_state(job.state, options_.seed));
    SEAWAY_TRY_LET(const std::vector<Figure> figures, measured(job, scene));
    ++added_;
    return journal_.add(name, where, figures, cpu_seconds() - start);
}

Result<void> Run::all() {
    SEAWAY_TRY_LET(const std::vector<Job> all, jobs());
    Progress progress(static_cast<int>(all.size()));
    for (const Job& job : all) {
        progress.begin(fmt::format("{}, {} {}", job.state, job.knob, job.trial.value));
        const int before = added_;
        // A device that this machine does not have is left out, unless it is the one asked for.
        const bool another = job.trial.configuration.device != options_.device;
        if (another && !server::choose_device(job.trial.configuration.device)) {
            progress.done(true);
            continue;
        }
        SEAWAY_TRY(one(job));
        progress.done(added_ == before);
    }
    if (options_.knobs.empty() || holds(options_.knobs, "named")) {
        progress.begin("error map");
        SEAWAY_TRY_LET(const sea::Scene gale, sea_state("gale_deep", options_.seed));
        SEAWAY_TRY(write_error_map(gale, options_.out + "/error_map.csv", devices_));
    }
    progress.finish();
    fmt::print("{}/accuracy.csv: {} trials measured, {} were there already\n", options_.out, added_,
               static_cast<int>(all.size()) - added_);
    return {};
}

} // namespace

Result<void> run_accuracy(const AccuracyOptions& options) {
    SEAWAY_TRY(check(options));
    const Sampling sampling = sampling_of(options);
    std::error_code failed;
    std::filesystem::create_directories(options.out, failed);
    const std::string settings =
        fmt::format("seaway-bench accuracy, seed {}, {} points at each of {} times", options.seed,
                    sampling.points, sampling.times);
    SEAWAY_TRY_LET(Journal journal, Journal::open(options.out + "/accuracy.csv", settings));
    return Run(options, std::move(journal)).all();
}

} // namespace seaway::bench
