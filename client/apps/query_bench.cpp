// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <random>

#include <fmt/format.h>

#include "base/quantile.h"
#include "base/text_file.h"
#include "client/apps/query_output.h"
#include "client/apps/query_run.h"
#include "client/link/failure.h"

namespace seaway::client {
namespace {

using std::chrono::steady_clock;

constexpr std::chrono::seconds duration{2};
constexpr int in_flight_many = 8;

double milliseconds_since(steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(steady_clock::now() - start).count();
}

BenchRow finished(BenchRow row, std::vector<double> round_trips_ms, double milliseconds) {
    row.queries = static_cast<int>(round_trips_ms.size());
    row.seconds = milliseconds / 1e3;
    row.round_trip_p50_ms = quantile(round_trips_ms, 0.5);
    row.round_trip_p99_ms = quantile(round_trips_ms, 0.99);
    return row;
}

/// Keeps `in_flight` queries under way for a while.
Result<BenchRow> measure_server(Client& client, const QueryOptions& options, int in_flight,
                                const std::atomic<bool>& stop) {
    struct Progress {
        std::mutex mutex;
        std::condition_variable changed;
        int under_way = 0;
        std::vector<double> round_trips_ms;
        std::optional<Error> problem;
    };
    const auto progress = std::make_shared<Progress>();
    BenchPoints drawn(options.bench_points);
    const auto start = steady_clock::now();
    std::unique_lock lock(progress->mutex);
    while (!progress->problem) {
        progress->changed.wait(lock, [&] { return progress->under_way < in_flight; });
        if (stop || steady_clock::now() - start >= duration)
            break;
        ++progress->under_way;
        lock.unlock();
        const std::span<const sea::QueryPoint> points = drawn.next(client.now_us());
        const auto sent = steady_clock::now();
        const auto answered = [progress, sent](const Result<Reply>& reply) {
            const std::scoped_lock inner(progress->mutex);
            --progress->under_way;
            if (reply)
                progress->round_trips_ms.push_back(milliseconds_since(sent));
            else
                progress->problem = reply.error();
            progress->changed.notify_all();
        };
        SEAWAY_TRY(client.ask_async(points, {options.exact, options.timeout_s}, answered));
        lock.lock();
    }
    progress->changed.wait(lock, [&] { return progress->under_way == 0; });
    if (progress->problem)
        return *progress->problem;
    if (progress->round_trips_ms.empty())
        return failed(Failure::deadline, "stopped before the first answer");
    return finished(
        {options.exact ? "exact" : "server", options.bench_points, in_flight, 0, 0, 0, 0},
        std::move(progress->round_trips_ms), milliseconds_since(start));
}

Result<BenchRow> measure_local(Client& client, const QueryOptions& options,
                               const std::atomic<bool>& stop) {
    BenchPoints drawn(options.bench_points);
    const bool waves = options.source != Source::tiles;
    std::vector<double> round_trips_ms;
    double asked_ms = 0; // what drawing points takes is not asking
    const auto start = steady_clock::now();
    do {
        const std::span<const sea::QueryPoint> points = drawn.next(client.now_us());
        const auto sent = steady_clock::now();
        // Of tiles what is streamed too late is fetched, as a watch does.
        const Result<std::vector<sea::Answer>> answers =
            waves ? client.sample(points) : client.fetch_and_sample(points, options.timeout_s);
        if (!answers)
            return answers.error();
        asked_ms += round_trips_ms.emplace_back(milliseconds_since(sent));
    } while (!stop && steady_clock::now() - start < duration);
    return finished({waves ? "waves" : "local", options.bench_points, 1, 0, 0, 0, 0},
                    std::move(round_trips_ms), asked_ms);
}

} // namespace

BenchPoints::BenchPoints(int count) : points_(static_cast<std::size_t>(count)) {}

std::span<const sea::QueryPoint> BenchPoints::next(sea::TimeUs now_us) {
    // Both from one draw: to draw places is not what is measured, and takes this side's time.
    constexpr double reach_m = 10e3, step_m = 2 * reach_m / 0x1p32;
    for (sea::QueryPoint& point : points_) {
        const std::uint64_t drawn = random_();
        point = {step_m * static_cast<double>(drawn >> 32) - reach_m,
                 step_m * static_cast<double>(drawn & 0xffffffffu) - reach_m, now_us};
    }
    return points_;
}

Result<void> run_bench(Client& client, const QueryOptions& options, const std::atomic<bool>& stop,
                       std::FILE* out) {
    SEAWAY_TRY(make_ready(client, options, true));
    std::vector<BenchRow> rows;
    std::vector<int> ways{1, in_flight_many};
    if (options.local)
        ways = {1};
    for (const int in_flight : ways) {
        const Result<BenchRow> row = options.local
                                         ? measure_local(client, options, stop)
                                         : measure_server(client, options, in_flight, stop);
        if (!row)
            return row.error();
        rows.push_back(*row);
    }
    return write_out(out, output_bench(options.format, rows));
}

} // namespace seaway::client
