// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/accuracy/measure/batches.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <optional>
#include <random>
#include <span>

#include "base/thread_pool.h"
#include "base/worse.h"
#include "client/client.h"
#include "tools/bench/accuracy/truth/points.h"

namespace seaway::bench {

namespace {

constexpr double reach_m = 4000.0;
constexpr int rounds = 5;
/// A round asks for so many answers at least, in as many batches.
constexpr int round_points_min = 2048;
constexpr int round_points_min_summed = 16;
constexpr int round_messages_max = 64;
/// A batch is cut into so many parts a thread, so that one slow point holds up little.
constexpr int parts_a_thread = 4;

using Answers = std::vector<sea::Answer>;
using Ask = std::function<Result<void>(std::span<const sea::QueryPoint>, std::span<sea::Answer>)>;

std::vector<sea::QueryPoint> scattered(std::size_t count, sea::TimeUs time_us) {
    std::mt19937_64 engine(1);
    std::uniform_real_distribution<double> place(-reach_m, reach_m);
    std::vector<sea::QueryPoint> points;
    for (std::size_t i = 0; i < count; ++i) {
        const double x_m = place(engine);
        points.push_back({x_m, place(engine), time_us});
    }
    return points;
}

double largest_difference(const Answers& together, const Answers& alone) {
    double largest = 0;
    for (std::size_t i = 0; i < together.size(); ++i)
        largest = worse(largest, std::abs(together[i].height_m - alone[i].height_m));
    return largest;
}

/// All points in batches of so many, once; each batch by itself.
Result<void> ask_all(const std::vector<sea::QueryPoint>& points, std::size_t batch, const Ask& ask,
                     Answers& answers) {
    for (std::size_t first = 0; first < points.size(); first += batch)
        SEAWAY_TRY(
            ask(std::span(points).subspan(first, batch), std::span(answers).subspan(first, batch)));
    return {};
}

Result<std::vector<Figure>> timed(const std::vector<sea::QueryPoint>& points, std::size_t batch,
                                  const Ask& ask, const Ask& ask_alone) {
    Answers answers(points.size());
    std::vector<double> each_ns;
    for (int round = -1; round < rounds; ++round) { // the first one warms up
        const auto start = std::chrono::steady_clock::now();
        SEAWAY_TRY(ask_all(points, batch, ask, answers));
        const std::chrono::duration<double, std::nano> spent =
            std::chrono::steady_clock::now() - start;
        if (round >= 0)
            each_ns.push_back(spent.count() / static_cast<double>(points.size()));
    }
    // Alone a summed answer takes milliseconds: some of many will do.
    constexpr std::size_t compared_max = 256;
    const std::size_t compared = std::min(points.size(), compared_max);
    Answers alone(compared);
    SEAWAY_TRY(ask_all({points.begin(), points.begin() + static_cast<std::ptrdiff_t>(compared)}, 1,
                       ask_alone, alone));
    answers.resize(compared);
    std::sort(each_ns.begin(), each_ns.end());
    const double median_ns = each_ns[rounds / 2];
    const double batch_ms = 1e-6 * static_cast<double>(batch);
    return std::vector<Figure>{
        {"batch_ns", median_ns, each_ns.front(), each_ns.back()},
        {"batch_ms", median_ns * batch_ms, each_ns.front() * batch_ms, each_ns.back() * batch_ms},
        exact("batch_difference_m", largest_difference(answers, alone))};
}

/// Answers from part to part of the batch.
struct Parts {
    const ConfiguredSea* sea;
    std::span<const sea::QueryPoint> points;
    std::span<sea::Answer> answers;
    std::size_t count;

    static void run(const void* context, int part, int) {
        const Parts& all = *static_cast<const Parts*>(context);
        const auto number = static_cast<std::size_t>(part);
        const std::size_t begin = number * all.points.size() / all.count;
        const std::size_t size = (number + 1) * all.points.size() / all.count - begin;
        all.sea->answer(all.points.subspan(begin, size), all.answers.subspan(begin, size));
    }
};

Result<std::vector<Figure>> in_process(const sea::Scene& scene, const Configuration& configuration,
                                       const Batch& batch, Devices& devices) {
    SEAWAY_TRY_LET(const auto sea, ConfiguredSea::create(scene, configuration, devices));
    const bool summed = configuration.evaluator == Evaluator::direct_sum;
    const sea::TimeUs time_us = sample_time_us(1);
    SEAWAY_TRY(sea->go_to(time_us));
    const auto size = static_cast<std::size_t>(batch.points);
    const std::size_t least = summed ? round_points_min_summed : round_points_min;
    const auto points = scattered(size * std::max<std::size_t>(1, least / size), time_us);
    const Ask one = [&](std::span<const sea::QueryPoint> asked,
                        std::span<sea::Answer> answers) -> Result<void> {
        if (summed)
            SEAWAY_TRY(sea->go_to(time_us));
        sea->answer(asked, answers);
        return {};
    };
    if (batch.asked == Asked::one_thread)
        return timed(points, size, one, one);
    ThreadPool pool;
    const Ask all = [&](std::span<const sea::QueryPoint> asked,
                        std::span<sea::Answer> answers) -> Result<void> {
        if (summed)
            SEAWAY_TRY(sea->go_to(time_us));
        const std::size_t count = std::min<std::size_t>(
            asked.size(), static_cast<std::size_t>(parts_a_thread * pool.threads()));
        const Parts parts{sea.get(), asked, answers, count};
        const Phase phase{&Parts::run, &parts, static_cast<int>(count)};
        pool.run({&phase, 1});
        return {};
    };
    return timed(points, size, all, one);
}

Result<std::vector<Figure>> over_a_socket(const Batch& batch, const std::string& server) {
    SEAWAY_TRY_LET(const auto client, client::Client::connect({.url = server}));
    const auto size = static_cast<std::size_t>(batch.points);
    const std::size_t messages =
        std::clamp<std::size_t>(round_points_min / size, 1, round_messages_max);
    const auto points = scattered(size * messages, client->now_us());
    const Ask ask = [&](std::span<const sea::QueryPoint> asked,
                        std::span<sea::Answer> answers) -> Result<void> {
        SEAWAY_TRY_LET(const Answers got, client->ask(asked, client::Asking{}));
        std::copy(got.begin(), got.end(), answers.begin());
        return {};
    };
    return timed(points, size, ask, ask);
}

} // namespace

Result<std::vector<Figure>> measure_batch(const sea::Scene& scene,
                                          const Configuration& configuration, const Batch& batch,
                                          const std::string& server, Devices& devices) {
    return batch.asked == Asked::socket ? over_a_socket(batch, server)
                                        : in_process(scene, configuration, batch, devices);
}

} // namespace seaway::bench
