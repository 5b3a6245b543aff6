// SPDX-License-Identifier: Apache-2.0
#include "client/apps/query_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "base/messages.h"
#include "base/text_file.h"
#include "client/apps/query_output.h"
#include "client/link/failure.h"

namespace seaway::client {
namespace {

using std::chrono::steady_clock;

/// Where a beat had no answer, the next is no later.
constexpr std::chrono::milliseconds ask_again{100};

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

/// Points whose sea is not known before it is asked for. Of now it always is.
bool elsewhen(const Client& client, const QueryOptions& options,
              std::span<const sea::QueryPoint> points) {
    return options.source != Source::tiles && options.has_times &&
           !std::ranges::all_of(points, [&](const sea::QueryPoint& point) {
               return client.knows_sea_of(point.time_us);
           });
}

/// Makes the seas of these points from their scenes, where that is wanted. True: some were not there.
Result<bool> make_seas(Client& client, const QueryOptions& options,
                       std::span<const sea::QueryPoint> points) {
    bool more = false;
    for (const sea::QueryPoint& point : points)
        if (options.source == Source::scene &&
            client.source(point.time_us).source != AnswersFrom::parameters) {
            SEAWAY_TRY(client.rebuild(point.time_us));
            more = true;
        }
    return more;
}

/// Has it told which seas run at these times of points, if that is not known.
Result<void> learn_seas(Client& client, const QueryOptions& options,
                        std::span<const sea::QueryPoint> points,
                        std::span<const sea::TimeUs> times_us) {
    if (!elsewhen(client, options, points))
        return {};
    SEAWAY_TRY(client.hold(times_us, options.timeout_s));
    SEAWAY_TRY(make_seas(client, options, points));
    return {};
}

/// From what is held, of the waves that count; keyframes of points that are not streamed are fetched before, those of a few
/// times after the other.
Result<std::vector<sea::Answer>> look(Client& client, const QueryOptions& options,
                                      const sea::Looking& looking,
                                      std::span<const sea::QueryPoint> points) {
    constexpr std::size_t times_at_once = 16; // the client holds those around 24
    std::vector<sea::Answer> answers;
    while (answers.size() < points.size()) {
        const auto rest = points.subspan(answers.size());
        std::vector<sea::TimeUs> times_us;
        std::size_t end = 0;
        for (; end < rest.size(); ++end)
            if (times_us.empty() || times_us.back() != rest[end].time_us) {
                if (times_us.size() == times_at_once)
                    break;
                times_us.push_back(rest[end].time_us);
            }
        if (options.source == Source::tiles)
            SEAWAY_TRY(client.hold(times_us, options.timeout_s));
        else
            SEAWAY_TRY(learn_seas(client, options, rest.first(end), times_us));
        SEAWAY_TRY_LET(const std::vector<Water> water, client.look(rest.first(end), looking));
        for (const Water& one : water)
            answers.push_back(one.answer);
    }
    return answers;
}

/// Of points whose seas were not known: what is told of with their tiles, and from the waves of a scene where that is wanted. Of far
/// seas the server sends no others.
Result<std::vector<sea::Answer>> answers_elsewhen(Client& client, const QueryOptions& options,
                                                  std::span<const sea::QueryPoint> points) {
    SEAWAY_TRY_LET(std::vector<sea::Answer> answers,
                   client.fetch_and_sample(points, options.timeout_s));
    SEAWAY_TRY_LET(const bool more, make_seas(client, options, points));
    if (more)
        return client.fetch_and_sample(points, options.timeout_s);
    const bool of_tiles = std::ranges::any_of(points, [&](const sea::QueryPoint& point) {
        const AnswersFrom from = client.source(point.time_us).source;
        return from == AnswersFrom::tiles || from == AnswersFrom::server;
    });
    if (of_tiles && options.watch_hz == 0)
        complain("seaway-query", 0,
                 "another sea runs at some of these times, whose waves the server does not send: "
                 "answered from its tiles");
    return answers;
}

Result<std::vector<sea::Answer>> answers_to(Client& client, const QueryOptions& options,
                                            std::span<const sea::QueryPoint> points) {
    const sea::Looking looking{.min_wavelength_m = options.min_wavelength_m};
    if (options.local && looking != sea::Looking{})
        return look(client, options, looking, points);
    if (options.local && options.source == Source::tiles)
        return client.fetch_and_sample(points, options.timeout_s);
    if (options.local && elsewhen(client, options, points))
        return answers_elsewhen(client, options, points);
    if (options.local)
        return client.sample(points);
    return client.ask(points, {options.exact, options.timeout_s, looking});
}

/// Answers, as they are written.
Result<std::string> rows_of(Client& client, const QueryOptions& options,
                            std::span<const sea::QueryPoint> points) {
    const bool compact = options.watch_hz > 0;
    if (!options.z_m) {
        SEAWAY_TRY_LET(const std::vector<sea::Answer> answers, answers_to(client, options, points));
        return output_rows(options.format, points, answers, compact);
    }
    if (options.local) {
        std::set<sea::TimeUs> times_us;
        for (const sea::QueryPoint& point : points)
            times_us.insert(point.time_us);
        SEAWAY_TRY(learn_seas(client, options, points,
                              std::vector<sea::TimeUs>(times_us.begin(), times_us.end())));
    }
    const sea::Looking looking{.min_wavelength_m = options.min_wavelength_m};
    const std::vector<double> z_m(points.size(), *options.z_m);
    SEAWAY_TRY_LET(
        const Below found,
        options.local ? client.below(points, z_m, looking)
                      : client.ask_below(points, z_m, {options.exact, options.timeout_s, looking}));
    return output_rows(options.format, points, *options.z_m, found, compact);
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

/// Says why the server is not there, each reason once, on a thread of the client's.
ClientEvents telling() {
    const auto said = std::make_shared<std::string>();
    return {.on_status = [said](const ClientStatus& status) {
        if (status.state == LinkState::connected)
            said->clear();
        if (status.state != LinkState::waiting || *said == status.reason)
            return;
        *said = status.reason;
        complain("seaway-query", 0,
                 fmt::format("{}; trying again in {:.1f} s", status.reason, status.next_attempt_s));
    }};
}

/// Has what the options want to be answered from; of the waves of a scene, anew for each sea.
Result<void> make_ready(Client& client, const QueryOptions& options) {
    if (options.local && options.source == Source::scene)
        return client.rebuild(client.now_us());
    if (options.local && options.source == Source::spectrum) {
        SEAWAY_TRY(client.subscribe_spectrum({}, options.timeout_s));
    } else if (options.watch_hz > 0 && options.local) {
        constexpr int credit = 2;
        protocol::TileWish wish{.fields = sea::surface_fields};
        options.limits.put_into(wish);
        SEAWAY_TRY_LET(const Grant grant, client.subscribe(wish, credit, options.timeout_s));
        if (!grant.why.empty())
            complain("seaway-query", 0, "granted less: " + grant.why);
    }
    return {};
}

/// The connection has ended, or its server hangs.
bool has_ended(const Error& error) {
    const Failure failure = failure_of(error);
    return failure == Failure::lost || failure == Failure::deadline;
}

/// Nothing where the server may still answer, or come back: the error then has been said.
std::optional<Error> for_good(const Client& client, const Error& error, std::string& said) {
    const ClientStatus status = client.status();
    if (status.state == LinkState::stopped)
        return failed(Failure::lost, status.reason);
    const bool away = status.state != LinkState::connected;
    if (!has_ended(error) && !(away && failure_of(error) == Failure::not_held))
        return error;
    if (!away && said != error.message) // else telling() has
        complain("seaway-query", 0, error.message + "; trying again");
    said = error.message;
    return std::nullopt;
}

} // namespace

double next_beat_s(double elapsed_s, double hz) {
    return (std::floor(elapsed_s * hz) + 1) / hz;
}

Result<void> run_query(const Connect& connect, const QueryOptions& asked,
                       const std::vector<Place>& places, const std::atomic<bool>& stop,
                       std::FILE* out) {
    QueryOptions options = asked;
    options.has_times = asked.time_s || std::ranges::any_of(places, [](const Place& place) {
                            return place.time_s.has_value();
                        });
    const bool watching = options.watch_hz > 0;
    SEAWAY_TRY_LET(const std::unique_ptr<Client> client,
                   connect(watching ? telling() : ClientEvents{}));
    SEAWAY_TRY(make_ready(*client, options));
    const auto start = steady_clock::now();
    sea::TimeUs start_us = client->now_us();
    std::string text = output_head(options.format, options.z_m.has_value()), said;
    int seas = client->seas();
    for (;;) {
        if (std::exchange(seas, client->seas()) != seas) {
            // Times that were given move on by the clock of the wall, whatever sea time this sea begins with.
            start_us = client->now_us() -
                       sea::us_from_seconds(seconds(steady_clock::now() - start).count());
            if (options.source == Source::scene)
                SEAWAY_TRY(make_ready(*client, options));
        }
        const sea::TimeUs now_us = client->now_us();
        const std::vector<sea::QueryPoint> points =
            points_at(places, options, now_us, watching ? now_us - start_us : 0);
        const Result<std::string> rows = rows_of(*client, options, points);
        if (!rows) {
            if (const auto error = watching ? for_good(*client, rows.error(), said) : rows.error())
                return *error;
        } else {
            said.clear();
            text += *rows;
            SEAWAY_TRY(write_out(out, text));
            text.clear();
        }
        if (!watching)
            return {};
        const seconds elapsed = steady_clock::now() - start;
        const auto beat = start + ticks(seconds(next_beat_s(elapsed.count(), options.watch_hz)));
        sleep_until(rows ? beat : std::min(beat, steady_clock::now() + ask_again), stop);
        if (stop)
            return {};
    }
}

} // namespace seaway::client
