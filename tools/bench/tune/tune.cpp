// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/tune/tune.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>

#include <fmt/format.h>

#include "base/messages.h"
#include "sea/certificate/certificate.h"
#include "tools/bench/accuracy/journal.h"
#include "tools/bench/accuracy/measure/measure.h"
#include "tools/bench/accuracy/result_file.h"
#include "tools/bench/tune/tuner.h"

namespace seaway::bench {

namespace {

std::string price_in_words(const Price& price) {
    return fmt::format("{:.3g} ms of CPU and {:.3g} kB a second", price.work_ms(),
                       1e-3 * price.bytes_per_s);
}

std::string tiles_in_words(const Candidate& c) {
    std::string words;
    for (const sea::CascadeSpec& cascade : c.layout.cascades)
        words += fmt::format("{}{:g} m of {}", words.empty() ? "" : ", ", cascade.length_m,
                             cascade.size);
    return fmt::format("{}; height_error_m = {:g}", words, c.height_error_m);
}

std::string now_utc() {
    const std::time_t now = std::time(nullptr);
    std::tm utc{};
    gmtime_r(&now, &utc);
    std::array<char, 32> text{};
    std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%MZ", &utc);
    return text.data();
}

std::string compiler() {
#if defined(__clang__)
    return "clang++ " __clang_version__;
#else
    return "g++ " __VERSION__;
#endif
}

std::string target_in_words(const Target& target) {
    std::string words =
        fmt::format("{} at p{:g}", sea::metres(target.height_error_m), target.percentile);
    if (target.slope_error)
        words += fmt::format(", slopes within {:g} rms", *target.slope_error);
    if (target.budget_ms)
        words += fmt::format(", at most {:g} ms a second", *target.budget_ms);
    if (target.bytes_per_s)
        words += fmt::format(", at most {:g} bytes a second", *target.bytes_per_s);
    return words;
}

Result<sea::Certificate> certificate_of(const sea::Scene& scene, const Target& target,
                                        const Outcome& outcome, const TuneOptions& options,
                                        const std::string& words, Devices& devices) {
    sea::Certificate c;
    c.cascades = scene.cascades;
    c.height_error_m = scene.accuracy.height_error_m;
    c.streams = scene.accuracy.streams();
    c.configuration_hash = configuration_hash(scene);
    c.spectrum_hash = spectrum_hash(scene);
    SEAWAY_TRY_LET(c.envelope, measured_envelope(scene, options.envelope_share));
    c.promised_m = target.height_error_m;
    c.percentile = target.percentile;
    c.promised_slope = target.slope_error;
    c.measured = outcome.measured;
    c.runners_up = outcome.runners_up;

    const Configuration configuration = configuration_of(scene, options.device);
    SEAWAY_TRY_LET(const Waves waves, configured_waves(scene, configuration));
    SEAWAY_TRY_LET(Truth truth, reference_truth(waves, options.sampling, scene.sea.seed,
                                                options.folder + "/truth"));
    const DrawnSea drawn{waves, std::move(truth)};
    StageCosts costs(7);
    SEAWAY_TRY_LET(const std::vector<Figure> all,
                   measure({&drawn, 1}, configuration, {}, devices, costs));
    for (const Figure& figure : all)
        for (const char* name :
             {"keyframe_cpu_ms_per_s", "spline_ms_per_s", "encode_ms_per_s", "decode_ms_per_s",
              "bytes_per_s", "memory_mb", "query_ns", "work_ms_per_s"})
            if (figure.metric == name)
                c.costs.emplace_back(figure.metric, figure.value);
    c.costs.emplace_back("composed_work_ms_per_s", outcome.best.price.work_ms());
    SEAWAY_TRY_LET(const Place place, place_of(configuration, devices));
    c.machine = place.machine;
    c.device = place.device;
    c.driver = place.driver;
    c.compiler = compiler();
    c.commit = place.commit;
    c.date_utc = now_utc();
    c.command = words;
    return c;
}

/// What the search leaves: a scene, and its certificate beside it.
struct Outputs {
    std::filesystem::path scene;
    std::string certificate; ///< as the scene names it

    explicit Outputs(const TuneCommand& command)
        : scene(!command.out.empty()
                    ? std::filesystem::path(command.out)
                    : std::filesystem::path(std::filesystem::path(command.scene).stem().string() +
                                            ".tuned.toml")),
          certificate(scene.stem().string() + ".certificate.json") {}
    std::filesystem::path certificate_path() const { return scene.parent_path() / certificate; }
};

/// Before an hour is spent on it.
Result<void> check_outputs(const TuneCommand& command) {
    const Outputs outputs(command);
    std::error_code none;
    if (std::filesystem::equivalent(outputs.scene, command.scene, none))
        return Error{fmt::format("--out: {} is the scene to search for", outputs.scene.string())};
    SEAWAY_TRY(check_result(outputs.certificate_path().string()));
    return check_result(outputs.scene.string());
}

/// What can be had instead, and what it would take.
void say_not_reached(const Target& target, const Outcome& outcome) {
    fmt::print("not reached: {}\n", target_in_words(target));
    if (outcome.measured.empty()) {
        fmt::print("no configuration keeps these limits: the cheapest layout costs more\n");
    } else {
        const sea::MeasuredError& best = outcome.measured.front();
        fmt::print("best that can be had: {} at p{:g} (maps {} rms, waves left out {} rms), {}\n"
                   "  {}\n",
                   sea::metres(best.total_m), target.percentile, sea::metres(best.rms_m),
                   sea::metres(best.waves_left_out_m), price_in_words(outcome.best.price),
                   tiles_in_words(outcome.best));
    }
    if (outcome.without_limits) {
        fmt::print("it would take {}: {}\n", price_in_words(outcome.without_limits->price),
                   tiles_in_words(*outcome.without_limits));
        return;
    }
    const bool waves = outcome.limits.waves_left_out_m > outcome.limits.maps_m;
    if (target.slope_error && !outcome.measured.empty() &&
        outcome.measured.front().total_m * margin <= target.height_error_m)
        fmt::print("what limits it: slopes, {:.3g} rms\n", outcome.measured.front().slope_rms);
    else
        fmt::print("what limits it: {}\n",
                   waves
                       ? "waves that no tile holds; it would take finer tiles than 512 points "
                         "hold, or seaway-query --exact with a scene cut off by "
                         "sea.wavenumber_max_radpm"
                       : "maps in single precision, 10 ms keyframes; it would take the exact sum, "
                         "seaway-query --exact");
}

Result<void> write_outputs(const TuneCommand& command, const Target& target, const Outcome& outcome,
                           const TuneOptions& options, sea::Scene scene, Devices& devices) {
    const Outputs outputs(command);
    SEAWAY_TRY_LET(sea::Certificate certificate,
                   certificate_of(scene, target, outcome, options, command.words, devices));
    SEAWAY_TRY_LET(certificate.beside_finer_waves_m,
                   measure_beside_finer(scene, target.percentile, options, devices));
    fmt::print("{}: {}\n  {}\n  {}\n  beside waves twice to four times shorter: {}\n",
               target_in_words(target), price_in_words(outcome.best.price),
               tiles_in_words(outcome.best), describe(certificate),
               sea::metres(*certificate.beside_finer_waves_m));
    scene.accuracy.certificate = {outputs.certificate, outputs.certificate_path().string()};
    SEAWAY_TRY(write_result(outputs.certificate_path().string(), to_json(certificate)));
    const std::string note =
        fmt::format("# {} made cheapest for {}.\n# {} says what was measured.\n\n",
                    std::filesystem::path(command.scene).filename().string(),
                    target_in_words(target), outputs.certificate);
    SEAWAY_TRY(write_result(outputs.scene.string(), note + to_toml(scene)));
    fmt::print("{}\n", outputs.scene.string());
    return {};
}

/// On seeds that the search did not see.
Result<void> check_seeds(const TuneCommand& command, const Target& target,
                         const TuneOptions& options, sea::Scene scene, Devices& devices) {
    constexpr std::uint64_t first_unseen = 1'000'000;
    double worst_m = 0;
    int above = 0;
    for (int i = 0; i < command.check_seeds; ++i) {
        scene.sea.seed = fresh_seed(options.seed, first_unseen + static_cast<std::uint64_t>(i));
        SEAWAY_TRY_LET(const sea::MeasuredError error,
                       measure_error(scene, "unseen", target.percentile, options, devices));
        worst_m = std::max(worst_m, error.total_m);
        above += error.total_m > target.height_error_m;
    }
    fmt::print("of {} unseen seeds {} are above the target; the worst is {}\n", command.check_seeds,
               above, sea::metres(worst_m));
    return {};
}

} // namespace

Result<int> run_tune(const TuneCommand& command) {
    SEAWAY_TRY(check_outputs(command));
    SEAWAY_TRY_LET(sea::Scene scene, sea::read_scene(command.scene));
    scene.accuracy.certificate = {};
    if (scene.accuracy.streams())
        scene.accuracy.preset.reset(); // it is another configuration now
    const auto asked = [](double value) { return value > 0 ? std::optional(value) : std::nullopt; };
    const Target target{command.height_error_m, command.percentile, asked(command.slope_error),
                        asked(command.budget_ms), asked(command.bytes_per_s)};
    TuneOptions options;
    options.device = command.device;
    options.folder = command.work;
    options.seed = command.seed;
    options.envelope_share = 0.01 * command.envelope_pct;
    options.progress = [start = std::chrono::steady_clock::now()](const std::string& line) {
        const std::chrono::duration<double> since = std::chrono::steady_clock::now() - start;
        tell(fmt::format("{:5.1f} s  {}\n", since.count(), line));
    };
    std::error_code failed;
    std::filesystem::create_directories(command.work, failed);
    Devices devices;
    SEAWAY_TRY_LET(const auto prices,
                   stage_prices(command.device, command.work + "/prices.json", devices));
    SEAWAY_TRY_LET(const Outcome outcome,
                   tune(scene, target, whole_space(), options, *prices, devices));
    if (!outcome.reached) {
        say_not_reached(target, outcome);
        return tune_not_reached;
    }
    const sea::Scene tuned = with_candidate(scene, outcome.best);
    SEAWAY_TRY(write_outputs(command, target, outcome, options, tuned, devices));
    if (command.check_seeds > 0)
        SEAWAY_TRY(check_seeds(command, target, options, tuned, devices));
    return tune_reached;
}

} // namespace seaway::bench
