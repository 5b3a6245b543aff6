// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/accuracy/guard.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>
#include <string_view>

#include <fmt/format.h>

#include "base/text_file.h"
#include "tools/bench/accuracy/knobs.h"
#include "tools/bench/accuracy/measure/measure.h"
#include "tools/bench/accuracy/result_file.h"
#include "tools/bench/accuracy/seas/configured_sea.h"
#include "tools/bench/accuracy/seas/sea_states.h"
#include "tools/bench/accuracy/truth/truth.h"

namespace seaway::bench {

namespace {

constexpr std::uint64_t seed = 20;
constexpr Sampling sampling{128, 8};
constexpr const char* guard_header = "state,configuration,metric,value";
constexpr std::size_t bytes_max = 1 << 20;

/// Errors of answers. Means and percentages of sets are left out: they are differences of small numbers.
constexpr std::string_view guarded[] = {"rms_m",
                                        "p99_m",
                                        "crest_rms_m",
                                        "steep_rms_m",
                                        "slope_rms",
                                        "velocity_rms_mps",
                                        "missing_rms_m",
                                        "flicker_m",
                                        "codec_over_bound",
                                        "beyond_bound_pct",
                                        "transform_error"};

/// What a budget delivers: presets by name.
std::vector<Trial> presets(const sea::Scene& scene) {
    std::vector<Trial> trials;
    for (const Named& named : named_configurations(scene))
        for (const std::string_view name : {"precise", "balanced", "fast"})
            if (named.name == name)
                trials.push_back({named.name,
                                  named.configuration,
                                  Measurement::answers,
                                  {.flicker = name != "precise"}});
    return trials;
}

/// What no budget decides: one source of error each.
std::vector<Trial> kernels(const sea::Scene& scene) {
    Configuration space = clean(scene);
    for (sea::CascadeSpec& cascade : space.cascades)
        cascade.size = 64;
    Configuration time = clean(scene);
    time.interval_us = 500'000;
    Configuration codec = clean(scene);
    codec.codec_error_m = 0.02;
    Configuration sum = clean(scene);
    sum.evaluator = Evaluator::direct_sum;
    Configuration steep = clean(scene);
    steep.choppiness = 1.3;
    Configuration transform = clean(scene);
    transform.cascades = {{500.0, 256}};
    Configuration lavapipe = transform;
    lavapipe.device = "lavapipe";
    return {{"grids of 64", space},
            {"keyframes 0.5 s apart", time},
            {"codec 0.02 m", codec},
            {"all waves summed", sum, Measurement::answers, {.every = 4}},
            {"choppiness 1.3", steep, Measurement::answers, {.every = 2}},
            {"transform native", transform, Measurement::transform},
            {"transform lavapipe", lavapipe, Measurement::transform}};
}

class Guard {
  public:
    Result<void> measure(const std::string& state, const sea::Scene& scene, const Trial& trial);
    std::vector<GuardedFigure> figures;

  private:
    Devices devices_;
};

Result<void> Guard::measure(const std::string& state, const sea::Scene& scene, const Trial& trial) {
    std::vector<Figure> all;
    if (trial.measurement == Measurement::transform) {
        SEAWAY_TRY_LET(all, measure_transform(scene, trial.configuration, devices_));
    } else {
        SEAWAY_TRY_LET(const Waves waves, configured_waves(scene, trial.configuration));
        SEAWAY_TRY_LET(all,
                       measure_errors(scene, trial.configuration,
                                      summed_truth(waves, sampling, seed), trial.extent, devices_));
    }
    for (const Figure& figure : all)
        if (std::find(std::begin(guarded), std::end(guarded), figure.metric) != std::end(guarded))
            figures.push_back({state, trial.value, figure.metric, figure.value});
    return {};
}

std::string name_of(const GuardedFigure& figure) {
    return fmt::format("{}, {}: {}", figure.state, figure.configuration, figure.metric);
}

bool same_name(const GuardedFigure& a, const GuardedFigure& b) {
    return a.state == b.state && a.configuration == b.configuration && a.metric == b.metric;
}

const GuardedFigure* find(std::span<const GuardedFigure> figures, const GuardedFigure& like) {
    const auto found = std::find_if(figures.begin(), figures.end(),
                                    [&](const GuardedFigure& f) { return same_name(f, like); });
    return found == figures.end() ? nullptr : &*found;
}

std::string change(double before, double now) {
    return before > 0 ? fmt::format("{:.4g}, was {:.4g} ({:+.0f} %)", now, before,
                                    100 * (now / before - 1))
                      : fmt::format("{:.4g}, was 0", now);
}

std::optional<GuardedFigure> parsed_row(const std::string& line) {
    std::istringstream row(line);
    GuardedFigure figure;
    std::string value;
    if (!std::getline(row, figure.state, ',') || !std::getline(row, figure.configuration, ',') ||
        !std::getline(row, figure.metric, ',') || !std::getline(row, value))
        return std::nullopt;
    const auto [end, failed] =
        std::from_chars(value.data(), value.data() + value.size(), figure.value);
    const bool whole = failed == std::errc() && end == value.data() + value.size();
    return whole && figure.value >= 0 && std::isfinite(figure.value) ? std::optional(figure)
                                                                     : std::nullopt;
}

} // namespace

Result<std::vector<GuardedFigure>> guarded_figures() {
    Guard guard;
    for (const char* state : {"gale_deep", "calm_shallow"}) {
        SEAWAY_TRY_LET(const sea::Scene scene, sea_state(state, seed));
        for (const Trial& trial : presets(scene))
            SEAWAY_TRY(guard.measure(state, scene, trial));
    }
    SEAWAY_TRY_LET(const sea::Scene scene, sea_state("gale_deep", seed));
    for (const Trial& trial : kernels(scene))
        SEAWAY_TRY(guard.measure("gale_deep", scene, trial));
    return std::move(guard.figures);
}

std::string guard_csv(std::span<const GuardedFigure> figures) {
    std::string text = fmt::format("# Errors that `seaway-bench guard` compares with; a run of it, "
                                   "seed {}, {} points at each of {} "
                                   "times.\n# Made anew, where errors are meant to be others, by "
                                   "`seaway-bench guard --renew`.\n{}\n",
                                   seed, sampling.points, sampling.times, guard_header);
    for (const GuardedFigure& figure : figures)
        text += fmt::format("{},{},{},{:.5g}\n", figure.state, figure.configuration, figure.metric,
                            figure.value);
    return text;
}

Result<std::vector<GuardedFigure>> parse_guard_csv(const std::string& text,
                                                   const std::string& name) {
    std::istringstream lines(text);
    std::vector<GuardedFigure> figures;
    bool headed = false;
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
        ++number;
        if (line.empty() || line[0] == '#')
            continue;
        if (!headed) {
            if (line != guard_header)
                return Error{fmt::format("{}:{}: not \"{}\"", name, number, guard_header)};
            headed = true;
            continue;
        }
        const std::optional<GuardedFigure> figure = parsed_row(line);
        if (!figure)
            return Error{fmt::format("{}:{}: not a row of \"{}\", with a value of 0 or more", name,
                                     number, guard_header)};
        if (find(figures, *figure))
            return Error{fmt::format("{}:{}: stands there twice", name, number)};
        figures.push_back(*figure);
    }
    if (figures.empty())
        return Error{name + ": no figures"};
    return figures;
}

GuardFindings compare_with_baseline(std::span<const GuardedFigure> baseline,
                                    std::span<const GuardedFigure> measured) {
    GuardFindings findings;
    for (const GuardedFigure& before : baseline) {
        const GuardedFigure* now = find(measured, before);
        if (!now)
            findings.failures.push_back(name_of(before) + " is not measured any more");
        else if (!(now->value <= (1 + guard_share_max) * before.value))
            findings.failures.push_back(
                fmt::format("{} has grown: {}", name_of(before), change(before.value, now->value)));
        else if (now->value < (1 - guard_share_max) * before.value)
            findings.told.push_back(fmt::format("{} has fallen: {}", name_of(before),
                                                change(before.value, now->value)));
    }
    for (const GuardedFigure& now : measured)
        if (!find(baseline, now))
            findings.failures.push_back(name_of(now) + " has no figure to compare with");
    return findings;
}

Result<bool> run_guard(const GuardOptions& options) {
    std::vector<GuardedFigure> baseline;
    if (!options.renew) { // before measuring: a wrong path is told at once
        const Result<std::string> text = read_text_file(options.baseline, bytes_max);
        if (!text)
            return Error{fmt::format("{}: {}", options.baseline, text.error().message)};
        SEAWAY_TRY_LET(baseline, parse_guard_csv(*text, options.baseline));
    }
    SEAWAY_TRY_LET(const std::vector<GuardedFigure> measured, guarded_figures());
    if (options.renew) {
        SEAWAY_TRY(write_result(options.baseline, guard_csv(measured)));
        fmt::print("{}: {} figures\n", options.baseline, measured.size());
        return true;
    }
    const GuardFindings findings = compare_with_baseline(baseline, measured);
    for (const std::vector<std::string>& lines : {findings.failures, findings.told})
        for (const std::string& line : lines)
            fmt::print("{}\n", line);
    fmt::print("{} figures: {} have grown by more than {:.0f} % or stand alone, {} have fallen as "
               "much{}\n",
               measured.size(), findings.failures.size(), 100 * guard_share_max,
               findings.told.size(),
               findings.failures.empty() && findings.told.empty()
                   ? ""
                   : ". Where that is meant: seaway-bench guard --renew");
    return findings.failures.empty();
}

} // namespace seaway::bench
