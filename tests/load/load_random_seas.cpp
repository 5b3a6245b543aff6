// SPDX-License-Identifier: Apache-2.0
// Does every answer keep its bound? All scenes of scenes/ and forty drawn by lot, odd on purpose, are
// served by the real server on each device; points far out, from years back to decades ahead, are
// answered by the server, by a client from streamed tiles and by the direct sum in double precision.
//
//     load_random_seas                        one round: a minute on two cores
//     load_random_seas --seconds 3600         rounds with new scenes for an hour
//     load_random_seas --samples 1000000      as many rounds as that needs
//
// An answer further from the sum than the two bounds together is a miss, unless it is flagged folded,
// not converged or extrapolated. Prints a table, one row a kind of scene, device and way: samples,
// share flagged, misses, how many times the bound is the 99th percentile of the error, and the worst
// error over its bound. A miss is printed with what shows it, and its scene is kept.
// Exit code 1: more than one miss in 100 000 samples, or a program that failed.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>

#include <fmt/format.h>

#include "base/command_line.h"
#include "client/client.h"
#include "tests/load/draw.h"
#include "tests/load/random_scenes.h"
#include "tests/support/server_process.h"

using namespace seaway;
using Clock = std::chrono::steady_clock;

namespace {

struct Options {
    std::uint64_t seed = 1;
    int generated = 40;
    int times = 4;
    int points = 30; ///< a time
    double seconds = 0;
    std::uint64_t samples = 0;
    std::vector<std::string> devices{"native", "lavapipe"};
    std::string keep = "."; ///< folder for scenes that show a miss
};

struct Tally {
    std::uint64_t samples = 0, flagged = 0, misses = 0;
    // Of what is not flagged:
    std::vector<double> share{}; ///< error over bound
    std::vector<double> error_m{};
    std::vector<double> bound_m{};
};

double quantile(std::vector<double>& values, double q) {
    if (values.empty())
        return 0;
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

struct Scene {
    std::string kind;
    std::string path;
};

constexpr std::uint32_t no_promise =
    sea::answer_folded | sea::answer_not_converged | sea::answer_extrapolated;

std::vector<sea::QueryPoint> random_points(tests::Draw& draw, const Options& options) {
    std::vector<sea::QueryPoint> points;
    for (int t = 0; t < options.times; ++t) {
        const double t_s =
            draw.one_of({0.0, 0.37, draw.uniform(0, 100), 1e5, -5e7, draw.uniform(0, 1e9)});
        const double reach_m = draw.one_of({100.0, 1e4, 1e6});
        for (int i = 0; i < options.points; ++i)
            points.push_back({draw.uniform(-reach_m, reach_m), draw.uniform(-reach_m, reach_m),
                              sea::us_from_seconds(t_s)});
    }
    return points;
}

class Soak {
  public:
    explicit Soak(Options options) : options_(std::move(options)) {}

    int run() {
        const auto start = Clock::now();
        const auto over = [&] {
            return (options_.samples == 0 || samples_ >= options_.samples) &&
                   std::chrono::duration<double>(Clock::now() - start).count() >= options_.seconds;
        };
        for (std::uint64_t round = 0; round == 0 || !over(); ++round)
            this->round(round);
        print();
        return failures_ || misses_ * 100'000 > samples_ ? 1 : 0;
    }

  private:
    void round(std::uint64_t round) {
        std::vector<Scene> scenes;
        for (const auto& entry : std::filesystem::directory_iterator(SEAWAY_SOURCE_DIR "/scenes"))
            if (entry.path().extension() == ".toml")
                scenes.push_back({entry.path().stem(), entry.path()});
        std::sort(scenes.begin(), scenes.end(),
                  [](const Scene& a, const Scene& b) { return a.path < b.path; });
        for (int i = 0; i < options_.generated; ++i) {
            const tests::RandomScene drawn = tests::random_scene(options_.seed + round, i);
            const auto path = std::filesystem::absolute(options_.keep) /
                              fmt::format("random_sea_{}_{}.toml", options_.seed + round, i);
            std::ofstream(path) << drawn.toml;
            scenes.push_back({name(drawn.oddity), path});
        }
        tests::Draw draw(options_.seed + round);
        for (std::size_t i = 0; i < scenes.size(); ++i) {
            const std::uint64_t before = misses_ + failures_;
            // In a round each scene meets one device, each kind of scene all; then it is the other's turn.
            serve(scenes[i], options_.devices[(i + i / 8 + round) % options_.devices.size()], draw);
            if (before == misses_ + failures_ &&
                scenes[i].path.find("random_sea_") != std::string::npos)
                std::filesystem::remove(scenes[i].path);
        }
    }

    void fail(const Scene& scene, const std::string& why) {
        ++failures_;
        fmt::print("{}: {}\n", scene.path, why);
    }

    void serve(const Scene& scene, const std::string& device, tests::Draw& draw) {
        const std::vector<sea::QueryPoint> points = random_points(draw, options_);
        tests::ServerProcess server({scene.path, "--listen", "127.0.0.1:0", "--device", device});
        client::ConnectOptions connect;
        connect.url = server.wait_until_ready();
        connect.timeout_s = 60;
        if (connect.url.empty())
            return fail(scene, server.log());
        auto client = client::Client::connect(connect);
        if (!client)
            return fail(scene, client.error().message);
        const auto exact = (*client)->ask(points, {.exact = true, .timeout_s = 300});
        const auto served = (*client)->ask(points, {.timeout_s = 300});
        const auto local = (*client)->fetch_and_sample(points, 300);
        for (const auto* answers : {&exact, &served, &local})
            if (!*answers)
                return fail(scene, answers->error().message);
        judge(scene, device, "served", points, *exact, *served);
        judge(scene, device, "local", points, *exact, *local);
        client->reset();
        server.send(SIGTERM);
        if (const auto code = server.wait_for_exit(std::chrono::seconds(60)); code != 0)
            fail(scene, fmt::format("exit code {}", code.value_or(-1)));
    }

    void judge(const Scene& scene, const std::string& device, const std::string& way,
               std::span<const sea::QueryPoint> points, std::span<const sea::Answer> truths,
               std::span<const sea::Answer> answers) {
        Tally& tally = tallies_[scene.kind + "," + device + "," + way];
        for (std::size_t i = 0; i < points.size(); ++i) {
            ++tally.samples;
            ++samples_;
            if (answers[i].flags & no_promise) {
                ++tally.flagged;
                continue;
            }
            const double apart = std::abs(answers[i].height_m - truths[i].height_m);
            const double bound = answers[i].error_m + truths[i].error_m;
            tally.share.push_back(bound > 0 ? apart / bound : apart > 0 ? INFINITY : 0);
            tally.error_m.push_back(apart);
            tally.bound_m.push_back(bound);
            if (apart <= bound)
                continue;
            ++tally.misses;
            ++misses_;
            fmt::print("{}, {}, {}: {:.4g} m from the sum {:.4f}{}, stated {:.4g} m, at "
                       "{:.4f},{:.4f} t = {} us\n",
                       scene.path, device, way, apart, truths[i].height_m,
                       truths[i].flags & sea::answer_folded ? " (folded)" : "", bound,
                       points[i].x_m, points[i].y_m, points[i].time_us);
        }
    }

    void print() {
        fmt::print("scene,device,way,samples,flagged,misses,bound_p50_m,error_p99_m,bound_over_p99,"
                   "worst_over_bound\n");
        for (auto& [name, of_name] : tallies_) {
            const std::string& key = name; // clang 14 lets no lambda see a structured binding
            Tally& tally = of_name;
            const double bound_m = quantile(tally.bound_m, 0.5);
            const double error_m = quantile(tally.error_m, 0.99);
            fmt::print("{},{},{:.4f},{},{:.3g},{:.3g},{:.2f},{:.3f}\n", key, tally.samples,
                       static_cast<double>(tally.flagged) / static_cast<double>(tally.samples),
                       tally.misses, bound_m, error_m, error_m > 0 ? bound_m / error_m : 0.0,
                       quantile(tally.share, 1.0));
        }
        fmt::print("{} samples, {} misses, {} failures\n", samples_, misses_, failures_);
    }

    const Options options_;
    std::map<std::string, Tally> tallies_;
    std::uint64_t samples_ = 0, misses_ = 0, failures_ = 0;
};

} // namespace

int main(int argc, char** argv) {
    CommandLine line("load_random_seas", "Random seas: does every answer keep its bound?");
    Options options;
    line.option("--seed", options.seed);
    line.option("--generated", options.generated).between(0, 10'000);
    line.option("--times", options.times).between(1, 1000);
    line.option("--points", options.points, "a time").between(1, 10'000);
    line.option("--seconds", options.seconds).between(0.0, 1e9);
    line.option("--samples", options.samples);
    line.option("--devices", options.devices).separated_by(',');
    line.option("--keep", options.keep, "folder for scenes that show a miss");
    const Result<CommandLine::Next> next = line.read(argc, argv);
    if (!next) {
        fmt::print(stderr, "load_random_seas: {}\n", next.error().message);
        return 2;
    }
    if (*next == CommandLine::Next::leave)
        return 0;
    if (!std::filesystem::is_directory(options.keep)) {
        fmt::print(stderr, "load_random_seas: --keep {}: no such folder\n", options.keep);
        return 2;
    }
    return Soak(options).run();
}
