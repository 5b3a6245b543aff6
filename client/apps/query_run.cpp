// SPDX-License-Identifier: Apache-2.0
#include "client/apps/query_run.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include <fmt/format.h>

#include "base/messages.h"
#include "base/text_file.h"
#include "client/apps/query_output.h"
#include "client/link/failure.h"
#include "client/link/reconnect.h"

namespace seaway::client {
namespace {

using std::chrono::steady_clock;

/// Points at their times. `elapsed_us`: since the first answer; times that were given move with it.
std::vector<sea::QueryPoint> points_at(const std::vector<Place>& places,
                                       const QueryOptions& options, sea::TimeUs now_us,
                                       sea::TimeUs elapsed_us) {
    std::vector<sea::QueryPoint> points;
    points.reserve(places.size());
    for (const Place& place : places) {
        const std::optional<double> time_s = place.time_s ? place.time_s : options.time_s;
        points.push_back(
            {place.x_m, place.y_m, time_s ? sea::us_from_seconds(*time_s) + elapsed_us : now_us});
    }
    return points;
}

Result<std::vector<sea::Answer>> answers_to(Client& client, const QueryOptions& options,
                                            std::span<const sea::QueryPoint> points) {
    if (options.local && options.source == Source::tiles)
        return client.fetch_and_sample(points, options.timeout_s);
    if (options.local)
        return client.sample(points);
    return client.ask(points, {options.exact, options.timeout_s});
}

using seconds = std::chrono::duration<double>;

steady_clock::duration ticks(seconds time) {
    return std::chrono::duration_cast<steady_clock::duration>(time);
}

/// Sleeps in slices, so that a signal ends it soon.
void sleep_until(steady_clock::time_point then, const std::atomic<bool>& stop) {
    constexpr std::chrono::milliseconds slice{20};
    while (!stop && steady_clock::now() < then)
        std::this_thread::sleep_for(
            std::min<steady_clock::duration>(slice, then - steady_clock::now()));
}

/// A connection that is ready to be asked.
Result<std::unique_ptr<Client>> connected(const Connect& connect, const QueryOptions& options) {
    SEAWAY_TRY_LET(std::unique_ptr<Client> client, connect());
    if (options.local && options.source == Source::scene) {
        SEAWAY_TRY(client->rebuild(client->now_us()));
    } else if (options.local && options.source == Source::spectrum) {
        SEAWAY_TRY(client->subscribe_spectrum({}, options.timeout_s));
    } else if (options.watch_hz > 0 && options.local) {
        constexpr int credit = 2;
        protocol::TileWish wish{.fields = sea::surface_fields};
        options.limits.put_into(wish);
        SEAWAY_TRY_LET(const Grant grant, client->subscribe(wish, credit, options.timeout_s));
        if (!grant.why.empty())
            complain("seaway-query", 0, "granted less: " + grant.why);
    }
    return client;
}

/// Tries until it succeeds; null once `stop` is set. Each reason is said once.
std::unique_ptr<Client> connected_again(const Connect& connect, const QueryOptions& options,
                                        Error why, const std::atomic<bool>& stop) {
    std::string said;
    for (ReconnectPauses pauses; !stop;) {
        const seconds pause = pauses.next(why);
        if (said != why.message)
            complain("seaway-query", 0,
                     why.retry_after_ms == 0
                         ? why.message + "; trying again"
                         : fmt::format("{}; trying again in {:.1f} s", why.message, pause.count()));
        said = why.message;
        sleep_until(steady_clock::now() + std::chrono::ceil<steady_clock::duration>(pause), stop);
        Result<std::unique_ptr<Client>> client = stop ? why : connected(connect, options);
        if (client)
            return std::move(*client);
        why = client.error();
    }
    return nullptr;
}

/// The connection has ended, or its server hangs.
bool has_ended(const Error& error) {
    const Failure failure = failure_of(error);
    return failure == Failure::lost || failure == Failure::deadline;
}

} // namespace

Result<void> run_query(const Connect& connect, const QueryOptions& options,
                       const std::vector<Place>& places, const std::atomic<bool>& stop,
                       std::FILE* out) {
    SEAWAY_TRY_LET(std::unique_ptr<Client> client, connected(connect, options));
    const bool watching = options.watch_hz > 0;
    const auto start = steady_clock::now();
    sea::TimeUs start_us = client->now_us();
    std::string text = output_head(options.format);
    for (std::int64_t tick = 0;; ++tick) {
        const sea::TimeUs now_us = client->now_us();
        const std::vector<sea::QueryPoint> points =
            points_at(places, options, now_us, watching ? now_us - start_us : 0);
        // Who samples for himself could go on with what he holds, of a sea that is perhaps another one now.
        const std::optional<Error> end = watching ? client->end() : std::nullopt;
        const Result<std::vector<sea::Answer>> answers =
            end ? *end : answers_to(*client, options, points);
        if (!answers && watching && has_ended(answers.error())) {
            client = connected_again(connect, options, answers.error(), stop);
            if (!client)
                return {};
            // Times that were given move on by the clock of the wall, whatever sea time the server begins with.
            start_us = client->now_us() -
                       sea::us_from_seconds(seconds(steady_clock::now() - start).count());
            continue;
        }
        if (!answers)
            return answers.error();
        text += output_rows(options.format, points, *answers, watching);
        SEAWAY_TRY(write_out(out, text));
        text.clear();
        if (!watching)
            return {};
        // The next beat that is not over yet: a slow answer costs beats, it never piles them up.
        const seconds elapsed = steady_clock::now() - start;
        tick = std::max(tick, static_cast<std::int64_t>(elapsed.count() * options.watch_hz));
        sleep_until(start + ticks(seconds(static_cast<double>(tick + 1) / options.watch_hz)), stop);
        if (stop)
            return {};
    }
}

} // namespace seaway::client
