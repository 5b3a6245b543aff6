// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/accuracy/accuracy.h"

#include <algorithm>
#include <filesystem>
#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/elapsed.h"
#include "base/instructions.h"
#include "client/link/url.h"
#include "server/device/device_choice.h"
#include "tools/bench/accuracy/journal.h"
#include "tools/bench/accuracy/knobs.h"
#include "tools/bench/accuracy/measure/error_map.h"
#include "tools/bench/accuracy/measure/measure.h"
#include "tools/bench/accuracy/progress.h"
#include "tools/bench/accuracy/seas/sea_states.h"

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
    Sampling sampling = options.quick  ? Sampling{384, 8}
                        : options.full ? Sampling{4096, 32}
                                       : Sampling{1024, 16};
    if (options.points > 0)
        sampling.points = options.points;
    if (options.times > 0)
        sampling.times = options.times;
    return sampling;
}

Result<void> check(const AccuracyOptions& options) {
    const Sampling sampling = sampling_of(options);
    if (options.quick && options.seeds > sampling.times)
        return Error{fmt::format("--seeds is {}, allowed are 1 to {} with --quick: seeds share the "
                                 "times",
                                 options.seeds, sampling.times)};
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
    bool fresh_seeds;
};

bool is_of_a_server(const Trial& trial) {
    return trial.measurement == Measurement::batch && trial.batch.asked == Asked::socket;
}

Result<std::vector<Job>> jobs_of(const AccuracyOptions& options) {
    std::vector<Job> all;
    for (const std::string_view state : sea_state_names()) {
        if (!options.states.empty() && !holds(options.states, state))
            continue;
        SEAWAY_TRY_LET(const sea::Scene scene, sea_state(state, options.seed));
        const bool swept =
            options.full || !options.states.empty() ||
            (options.quick ? holds(swept_states_quick, state) : holds(swept_states, state));
        for (const Knob& knob : knobs()) {
            if (!options.knobs.empty() && !holds(options.knobs, knob.name))
                continue;
            if (!swept && !holds(everywhere, knob.name))
                continue;
            for (Trial& trial : knob.trials(scene, options.device)) {
                if (is_of_a_server(trial) && options.server.empty())
                    continue;
                // Half a second of two cores each: a quick run has them where they tell most.
                if (!options.quick && trial.configuration.evaluator == Evaluator::maps)
                    trial.extent.octaves = trial.extent.flicker = true;
                all.push_back({std::string(state), knob.name, std::move(trial), knob.fresh_seeds});
            }
        }
    }
    return all;
}

/// Before anything is measured: the first batch over a socket may be minutes away.
Result<void> check_server(const std::string& server, const std::vector<Job>& jobs) {
    if (server.empty())
        return {};
    if (const Result<client::Url> url = client::parse_url(server); !url)
        return Error{"--server: " + url.error().message};
    if (std::none_of(jobs.begin(), jobs.end(),
                     [](const Job& job) { return is_of_a_server(job.trial); }))
        return Error{
            fmt::format("--server {}: none of these knobs asks a server; batch does", server)};
    return {};
}

class Run {
  public:
    Run(const AccuracyOptions& options, std::vector<Job> jobs, Journal journal)
        : options_(options), jobs_(std::move(jobs)), sampling_(sampling_of(options)),
          journal_(std::move(journal)), costs_(options.quick ? 7 : 15) {}

    Result<void> all();

  private:
    Result<void> one(const Job& job);
    Result<std::vector<Figure>> measured(const Job& job, const sea::Scene& scene);
    /// The seas of a trial: of the first seed, or of each.
    Result<std::vector<DrawnSea>> drawn(const Job& job) const;

    const AccuracyOptions& options_;
    std::vector<Job> jobs_;
    Sampling sampling_;
    Journal journal_;
    Devices devices_;
    StageCosts costs_;
    int added_ = 0;
};

Result<std::vector<DrawnSea>> Run::drawn(const Job& job) const {
    std::vector<DrawnSea> seas;
    const int count = job.fresh_seeds ? options_.seeds : 1;
    for (int i = 0; i < count; ++i) {
        const std::uint64_t seed = options_.seed + static_cast<std::uint64_t>(i);
        Sampling sampling = sampling_;
        if (options_.quick) { // time number n belongs to seed n modulo their count
            sampling.first_time = i;
            sampling.time_step = count;
        }
        sampling.film = i == 0;
        SEAWAY_TRY_LET(const sea::Scene scene, sea_state(job.state, seed));
        SEAWAY_TRY_LET(Waves waves, configured_waves(scene, job.trial.configuration));
        SEAWAY_TRY_LET(Truth truth,
                       reference_truth(waves, sampling, seed, options_.out + "/truth"));
        seas.push_back({std::move(waves), std::move(truth)});
    }
    return seas;
}

Result<std::vector<Figure>> Run::measured(const Job& job, const sea::Scene& scene) {
    const Configuration& configuration = job.trial.configuration;
    switch (job.trial.measurement) {
    case Measurement::layout:
        return measure_layout(scene, configuration);
    case Measurement::transform:
        return measure_transform(scene, configuration, devices_);
    case Measurement::batch:
        return measure_batch(scene, configuration, job.trial.batch, options_.server, devices_);
    case Measurement::answers:
        break;
    }
    SEAWAY_TRY_LET(const std::vector<DrawnSea> seas, drawn(job));
    SEAWAY_TRY_LET(std::vector<Figure> figures,
                   measure(seas, configuration, job.trial.extent, devices_, costs_));
    double sum_error_m = 0;
    for (const DrawnSea& sea : seas)
        sum_error_m = std::max(sum_error_m, sea.truth.sum_error_m);
    figures.push_back(exact("truth_error_m", sum_error_m + truth_tolerance_m));
    return figures;
}

Result<void> Run::one(const Job& job) {
    SEAWAY_TRY_LET(Place where, place_of(job.trial.configuration, devices_));
    if (is_of_a_server(job.trial)) // another server's figures are not those of this one
        where.device = "server at " + options_.server;
    const TrialName name{job.state, std::string(job.knob), job.trial.value, where.device};
    if (journal_.has(name))
        return {};
    const double start = process_cpu_seconds();
    SEAWAY_TRY_LET(const sea::Scene scene, sea_state(job.state, options_.seed));
    SEAWAY_TRY_LET(const std::vector<Figure> figures, measured(job, scene));
    ++added_;
    return journal_.add(name, where, figures, process_cpu_seconds() - start);
}

Result<void> Run::all() {
    Progress progress(static_cast<int>(jobs_.size()));
    int without_device = 0;
    for (const Job& job : jobs_) {
        progress.begin(fmt::format("{}, {} {}", job.state, job.knob, job.trial.value));
        const int before = added_;
        // A device that this machine does not have is left out, unless it is the one asked for.
        const bool another = job.trial.configuration.device != options_.device;
        if (another && !server::choose_device(job.trial.configuration.device)) {
            progress.done(true);
            ++without_device;
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
    fmt::print("{}/accuracy.csv: {} trials measured, {} were there already{}\n", options_.out,
               added_, static_cast<int>(jobs_.size()) - added_ - without_device,
               without_device > 0
                   ? fmt::format(", {} left out for want of their device", without_device)
                   : "");
    return {};
}

} // namespace

Result<void> run_accuracy(const AccuracyOptions& options) {
    SEAWAY_TRY(check(options));
    SEAWAY_TRY_LET(std::vector<Job> jobs, jobs_of(options));
    SEAWAY_TRY(check_server(options.server, jobs));
    const Sampling sampling = sampling_of(options);
    std::error_code failed;
    std::filesystem::create_directories(options.out, failed);
    std::string settings =
        fmt::format("seaway-bench accuracy, seed {}, {} points at each of {} times", options.seed,
                    sampling.points, sampling.times);
    if (options.seeds > 1)
        settings += fmt::format("; named configurations on seeds {} to {}{}", options.seed,
                                options.seed + static_cast<std::uint64_t>(options.seeds) - 1,
                                options.quick ? ", which share the times" : "");
    SEAWAY_TRY_LET(Journal journal, Journal::open(options.out + "/accuracy.csv", settings));
    return Run(options, std::move(jobs), std::move(journal)).all();
}

} // namespace seaway::bench
