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
#include "protocol/limits.h"

namespace seaway::client {
namespace {

using std::chrono::steady_clock;

/// Where a beat had no answer, the next is no later.
constexpr std::chrono::milliseconds ask_again{100};

/// The connection has ended, or its server hangs.
bool has_ended(const Error& error) {
    const Failure failure = failure_of(error);
    return failure == Failure::lost || failure == Failure::deadline;
}

/// What is asked about at once.
struct Asked {
    std::vector<sea::QueryPoint> points;
    std::set<sea::TimeUs> given_us; ///< times that are not now
    bool now = false;               ///< some are
};

/// Points at their times. `elapsed_us`: since the first answer; times that were given move with it.
Asked asked_about(const std::vector<Place>& places, const QueryOptions& options, sea::TimeUs now_us,
                  sea::TimeUs elapsed_us) {
    Asked asked;
    asked.points.reserve(places.size());
    for (const Place& place : places) {
        const std::optional<double> time_s = place.time_s ? place.time_s : options.time_s;
        const sea::TimeUs time_us = time_s ? sea::us_from_seconds(*time_s) + elapsed_us : now_us;
        asked.points.push_back({place.x_m, place.y_m, time_us});
        if (time_s)
            asked.given_us.insert(time_us);
        else
            asked.now = true;
    }
    return asked;
}

/// Has it told which seas run at times that were given. Of now it is known, and where nobody is there to say it stays as it is.
Result<void> learn_seas(Client& client, const QueryOptions& options, const Asked& asked) {
    // A sea that runs at a time has run since it began, so the last time tells of all of them.
    for (auto time_us = asked.given_us.rbegin(); time_us != asked.given_us.rend(); ++time_us) {
        const ClientStatus status = client.status();
        if (status.state != LinkState::connected || status.stale_s > 0)
            return {};
        if (client.knows_sea_of(*time_us))
            continue;
        const Result<void> held = client.hold({&*time_us, 1}, options.timeout_s);
        if (!held && !(options.watch_hz > 0 && has_ended(held.error())))
            return held.error();
    }
    return {};
}

bool has_waves(const Client& client, sea::TimeUs time_us) {
    const AnswersFrom from = client.source(time_us).source;
    return from == AnswersFrom::parameters || from == AnswersFrom::spectrum;
}

/// The sea of a time from its scene; of a glide that had begun before this client came, what it began with is asked for.
Result<void> rebuild(Client& client, const QueryOptions& options, sea::TimeUs time_us) {
    const Result<void> made = client.rebuild(time_us);
    const SeaStatePtr state = client.sea_state(time_us);
    const sea::TimeUs before_us = state->start_time_us - 1;
    if (made || !state->glide || client.knows_sea_of(before_us))
        return made;
    return client.hold({&before_us, 1}, options.timeout_s) ? client.rebuild(time_us) : made;
}

/// Has the waves of all times here, as far as there are any to be had: seas of scenes are made. Why there are not of all of them.
Result<std::optional<std::string>> why_no_waves(Client& client, const QueryOptions& options,
                                                const Asked& asked) {
    SEAWAY_TRY(learn_seas(client, options, asked));
    std::set<sea::TimeUs> times_us;
    for (const sea::QueryPoint& point : asked.points)
        times_us.insert(point.time_us);
    std::optional<std::string> why;
    for (const sea::TimeUs time_us : times_us) {
        if (options.source == Source::scene &&
            client.source(time_us).source != AnswersFrom::parameters) {
            const Result<void> made = rebuild(client, options, time_us);
            if (!made && failure_of(made.error()) != Failure::not_held)
                return made.error();
            if (!made && !has_waves(client, time_us))
                why = made.error().message;
        } else if (!has_waves(client, time_us))
            why = "the server sends none of far seas";
    }
    return why;
}

/// From what is held, of the waves that count; keyframes of points that have no waves here and are not streamed are fetched
/// before, those of a few times after the other.
Result<std::vector<sea::Answer>> look(Client& client, const QueryOptions& options,
                                      const sea::Looking& looking,
                                      std::span<const sea::QueryPoint> points) {
    std::size_t times_at_once = 16; // of maps of 256 the client holds those around 24
    std::vector<sea::Answer> answers;
    while (answers.size() < points.size()) {
        const auto rest = points.subspan(answers.size());
        std::vector<sea::TimeUs> times_us;
        std::size_t end = 0;
        for (; end < rest.size(); ++end) {
            const sea::TimeUs time_us = rest[end].time_us;
            if (has_waves(client, time_us) || (!times_us.empty() && times_us.back() == time_us))
                continue;
            if (times_us.size() == times_at_once)
                break;
            times_us.push_back(time_us);
        }
        if (!times_us.empty()) {
            const Result<void> held = client.hold(times_us, options.timeout_s);
            if (!held && failure_of(held.error()) == Failure::bad_argument &&
                times_us.size() > 1) { // larger maps
                times_at_once = times_us.size() / 2;
                continue;
            }
            SEAWAY_TRY(held);
        }
        SEAWAY_TRY_LET(const std::vector<Water> water, client.look(rest.first(end), looking));
        for (const Water& one : water)
            answers.push_back(one.answer);
    }
    return answers;
}

/// `told`: why tiles answered last in the place of waves.
Result<std::vector<sea::Answer>> answers_to(Client& client, const QueryOptions& options,
                                            const Asked& asked, std::string& told) {
    const sea::Looking looking{.min_wavelength_m = options.min_wavelength_m};
    if (!options.local)
        return client.ask(asked.points, {options.exact, options.timeout_s, looking});
    bool waves = false;
    if (options.source != Source::tiles) {
        SEAWAY_TRY_LET(const std::optional<std::string> why, why_no_waves(client, options, asked));
        waves = !why;
        if (why && *why != told) // a watch says it once
            complain("seaway-query", 0,
                     "of some of these times there are no waves: answered from tiles (" + *why +
                         ")");
        told = why.value_or("");
    }
    if (looking != sea::Looking{})
        return look(client, options, looking, asked.points);
    return waves ? client.sample(asked.points)
                 : client.fetch_and_sample(asked.points, options.timeout_s);
}

/// Answers, as they are written.
Result<std::string> rows_of(Client& client, const QueryOptions& options, const Asked& asked,
                            std::string& told) {
    const bool compact = options.watch_hz > 0;
    if (!options.z_m) {
        SEAWAY_TRY_LET(const std::vector<sea::Answer> answers,
                       answers_to(client, options, asked, told));
        return output_rows(options.format, asked.points, answers, compact);
    }
    if (options.local && options.source != Source::tiles) {
        SEAWAY_TRY_LET(const std::optional<std::string> why, why_no_waves(client, options, asked));
        if (why)
            return failed(Failure::not_held, *why);
    }
    const sea::Looking looking{.min_wavelength_m = options.min_wavelength_m};
    const std::vector<double> z_m(asked.points.size(), *options.z_m);
    SEAWAY_TRY_LET(const Below found,
                   options.local ? client.below(asked.points, z_m, looking)
                                 : client.ask_below(asked.points, z_m,
                                                    {options.exact, options.timeout_s, looking}));
    return output_rows(options.format, asked.points, *options.z_m, found, compact);
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

/// Nothing where the server may still answer, or come back: the error then has been said.
std::optional<Error> for_good(const Client& client, const Error& error, std::string& said) {
    const ClientStatus status = client.status();
    if (status.state == LinkState::stopped)
        return failed(Failure::for_good, status.reason);
    const bool away = status.state != LinkState::connected;
    if (!has_ended(error) && !(away && failure_of(error) == Failure::not_held))
        return error;
    if (!away && said != error.message) // else telling() has
        complain("seaway-query", 0, error.message + "; trying again");
    said = error.message;
    return std::nullopt;
}

} // namespace

Result<void> make_ready(Client& client, const QueryOptions& options, bool now) {
    if (options.local && options.source == Source::scene) {
        const Result<void> made = now ? client.rebuild(client.now_us()) : Result<void>{};
        // Of what cannot be had why_no_waves() tells, and the rest answers.
        return !made && failure_of(made.error()) != Failure::not_held ? made : Result<void>{};
    }
    if (options.local && options.source == Source::spectrum) {
        SEAWAY_TRY(client.subscribe_spectrum({}, options.timeout_s));
    } else if ((options.watch_hz > 0 || options.bench_points > 0) && options.local) {
        protocol::TileWish wish{.fields = sea::surface_fields};
        options.limits.put_into(wish);
        SEAWAY_TRY_LET(const Grant grant,
                       client.subscribe(wish, protocol::limits::credit_default, options.timeout_s));
        if (!grant.why.empty())
            complain("seaway-query", 0, "granted less: " + grant.why);
    }
    return {};
}

double next_beat_s(double elapsed_s, double hz) {
    return (std::floor(elapsed_s * hz) + 1) / hz;
}

Result<void> run_query(const Connect& connect, const QueryOptions& options,
                       const std::vector<Place>& places, const std::atomic<bool>& stop,
                       std::FILE* out) {
    const bool watching = options.watch_hz > 0;
    SEAWAY_TRY_LET(const std::unique_ptr<Client> client,
                   connect(watching ? telling() : ClientEvents{}));
    const bool now = asked_about(places, options, 0, 0).now;
    SEAWAY_TRY(make_ready(*client, options, now));
    const auto start = steady_clock::now();
    sea::TimeUs start_us = client->now_us();
    std::string text = output_head(options.format, options.z_m.has_value()), said, told;
    int seas = client->seas();
    for (;;) {
        if (std::exchange(seas, client->seas()) != seas) {
            // Times that were given move on by the clock of the wall, whatever sea time this sea begins with.
            start_us = client->now_us() -
                       sea::us_from_seconds(seconds(steady_clock::now() - start).count());
            if (options.source == Source::scene)
                SEAWAY_TRY(make_ready(*client, options, now));
        }
        const sea::TimeUs now_us = client->now_us();
        const Result<std::string> rows =
            rows_of(*client, options,
                    asked_about(places, options, now_us, watching ? now_us - start_us : 0), told);
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
