// SPDX-License-Identifier: Apache-2.0
#include "server/world.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "base/undo.h"
#include "sea/scene/weather.h"
#include "server/host/grant.h"
#include "server/host/metrics_text.h"
#include "server/map_source.h"
#include "server/process_metrics.h"
#include "server/resume.h"
#include "server/simulation/memory_needs.h"
#include "server/world_reports.h"

namespace seaway::server {

namespace {

/// States of seas that are held ready; one of an older sea is made again where somebody asks for its keyframes.
constexpr std::size_t sea_states_kept = 64;

/// Who got other coarser maps than were wished for looks so often, by sea time, whether there is room for those.
constexpr sea::TimeUs looks_for_room_us = 2'000'000;

SharedBytes pace_message(const sea::Pace& pace) {
    return std::make_shared<const std::vector<std::uint8_t>>(protocol::pace(pace));
}

} // namespace

World::World(SeaCoursePtr course, SeaClock& clock, MemoryPtr memory)
    : Host(std::move(memory)), course_(std::move(course)), clock_(clock),
      spectra_(this->memory()->room(MemoryUse::spectra)) {
    (void)announce_due();
}

void World::publish_to(Publish publish) {
    const std::scoped_lock lock(mutex_);
    publish_ = std::move(publish);
}

void World::announce_to(Announce announce) {
    const std::scoped_lock lock(mutex_);
    announce_ = std::move(announce);
}

void World::announce_pace(const sea::Pace& pace) {
    Announce announce;
    {
        const std::scoped_lock lock(mutex_);
        announce = announce_;
    }
    if (announce)
        announce(pace_message(pace));
    if (simulation_)
        simulation_->demand_changed(); // it looks at the clock
}

void World::change_by(Change change) {
    const std::scoped_lock lock(mutex_);
    change_ = std::move(change);
}

bool World::is_told(std::uint32_t epoch) const {
    const std::scoped_lock lock(mutex_);
    return std::ranges::find(told_, epoch, &RunningSea::epoch) != told_.end();
}

sea::TimeUs World::announce_due() {
    const sea::TimeUs now_us = clock_.now_us();
    const sea::TimeUs until_us = now_us + announced_ahead();
    const std::vector<EpochWindow> windows = course_->windows(now_us, until_us);
    std::vector<SpectrumSource> origins = origins_of(windows.front().epoch); // it is made of them
    std::vector<RunningSeaPtr> told;
    std::vector<SeaState> untold;
    for (const EpochWindow& window : windows) {
        told.push_back(course_->sea(window.epoch));
        SharedBytes message = sea_state_message(window.epoch);
        if (!is_told(window.epoch))
            untold.push_back({window.epoch, std::move(message)});
    }
    Announce announce;
    {
        const std::scoped_lock lock(mutex_);
        told_.swap(told); // what has left the windows is told anew should it come back
        origins_.swap(origins);
        announce = announce_;
    }
    // Who comes now is told of them already: of the two a session takes one. Those that could not be told, for want of
    // memory, are told next time.
    Undo again([&] {
        const std::scoped_lock lock(mutex_);
        std::erase_if(told_, [&](const RunningSeaPtr& sea) {
            return std::ranges::find(untold, sea->epoch, &SeaState::epoch) != untold.end();
        });
    });
    for (const SeaState& sea : untold)
        if (announce)
            announce(sea.message);
    again.keep();
    constexpr sea::TimeUs ever_us = std::numeric_limits<sea::TimeUs>::max();
    const auto later = course_->windows(until_us, ever_us);
    const auto next = std::ranges::find_if(
        later, [&](const EpochWindow& window) { return window.start_us >= until_us; });
    told_until_us_ = next == later.end() ? ever_us : next->start_us;
    return next == later.end() ? ever_us : next->start_us - (until_us - now_us);
}

SharedBytes World::sea_state_message(std::uint32_t epoch) const {
    {
        const std::scoped_lock lock(mutex_);
        const auto found = std::ranges::find(sea_states_, epoch, &SeaState::epoch);
        if (found != sea_states_.end()) {
            std::rotate(found, found + 1, sea_states_.end());
            return sea_states_.back().message;
        }
    }
    const RunningSeaPtr sea = course_->sea(epoch);
    if (sea->epoch != epoch) // it never runs: that is the one that took its place
        return nullptr;
    auto message = std::make_shared<const std::vector<std::uint8_t>>(
        protocol::sea_state(announcement(*sea, course_->window(epoch), warnings_of(*sea))));
    const std::scoped_lock lock(mutex_);
    sea_states_.push_back({epoch, message});
    // Those that all are told of stay, and what they glide from: the network's thread asks for them.
    const auto other = std::ranges::find_if(sea_states_, [&](const SeaState& one) {
        return std::ranges::find(told_, one.epoch, &RunningSea::epoch) == told_.end() &&
               std::ranges::find(origins_, one.epoch, &SpectrumSource::epoch) == origins_.end();
    });
    if (sea_states_.size() > sea_states_kept && other != sea_states_.end())
        sea_states_.erase(other);
    return message;
}

std::vector<SharedBytes> World::sea_state_messages() const {
    const sea::TimeUs now_us = clock_.now_us();
    std::vector<SharedBytes> messages;
    for (const sea::Pace& pace : clock_.paces())
        messages.push_back(pace_message(pace));
    // One that nobody has been told of is not made yet: all will be told when it is.
    bool runs = true;
    for (const EpochWindow& window : course_->windows(now_us, now_us + announced_ahead()))
        if (std::exchange(runs, false) || is_told(window.epoch))
            if (SharedBytes message = sea_state_message(window.epoch)) // else changed meanwhile
                messages.push_back(std::move(message));
    return messages;
}

void World::change(Result<SeaWish> wish, Changed done) {
    const Changed counted = [this, done = std::move(done)](Result<SeaPromise> promise) {
        if (!promise)
            refused_.count(promise.error());
        done(std::move(promise));
    };
    if (!wish)
        return counted(wish.error());
    Change change;
    {
        const std::scoped_lock lock(mutex_);
        change = change_;
    }
    if (!change)
        return counted(Error{Refusal::not_offered, "this sea cannot change"});
    change(*std::move(wish), counted);
}

KeyframeTiles World::tiles(sea::KeyframePtr keyframe, Quality quality) const {
    const RunningSeaPtr sea = course_->sea(keyframe->epoch);
    (void)sea_state_message(keyframe->epoch); // held ready for the sessions that it goes to
    RungMaps maps = maps_of(sea->budget, keyframe->cascade, keyframe->fields, quality);
    return {std::move(keyframe),
            std::move(maps.codec_error),
            quality,
            maps.compact_size,
            follows_of(sea->budget, sea->streamed(), quality),
            maps.coarser,
            maps.predicted ? sea->wave_law() : std::nullopt};
}

void World::attach(Simulation& simulation) {
    simulation_ = &simulation;
    subscriptions().on_change([&simulation] { simulation.demand_changed(); });
}

bool World::ever_runs(const sea::KeyframePtr& keyframe) const {
    return !course_->window(keyframe->epoch).empty();
}

namespace {

/// As by lot, but of one keyframe always the same: rungs of several rates come one after the other.
std::uint64_t turn_of(sea::TimeUs time_us) {
    return (static_cast<std::uint64_t>(time_us) * 0x9e3779b97f4a7c15u) >> 33;
}

} // namespace

void World::on_keyframe(const sea::KeyframePtr& keyframe, std::size_t rate) {
    if (!ever_runs(keyframe)) // any more: it was under way when another sea took its place
        return;
    Publish publish;
    {
        const std::scoped_lock lock(mutex_);
        publish = publish_;
    }
    const std::vector<Quality> used =
        subscriptions().most_wanted(keyframe->cascade, turn_of(keyframe->time_us));
    for (std::size_t rank = 0; rank < used.size(); ++rank)
        if (publish && rung_of(used[rank]).rate == rate) {
            KeyframeTiles one = tiles(keyframe, used[rank]);
            one.rank = rank;
            publish(std::move(one));
        }
}

std::vector<RunningSeaPtr> World::seas_told() const {
    std::vector<RunningSeaPtr> seas{sea_now()};
    const std::scoped_lock lock(mutex_);
    const sea::TimeUs now_us = clock_.now_us();
    std::ranges::copy_if(told_, std::back_inserter(seas), [&](const RunningSeaPtr& sea) {
        return sea != seas.front() && course_->window(sea->epoch).end_us > now_us;
    });
    return seas;
}

Demand World::grant(const Demand& wish, std::optional<SessionId> instead_of) const {
    const std::vector<RunningSeaPtr> seas = seas_told();
    std::vector<const sea::ErrorBudget*> budgets;
    for (const RunningSeaPtr& sea : seas)
        budgets.push_back(&sea->budget);
    Demand granted = grant_of(wish, budgets, seas.front()->streamed(),
                              subscriptions().qualities_but(instead_of));
    granted.until_us = course_->window(seas.front()->epoch).end_us;
    if (granted.crowded)
        granted.until_us = std::min(granted.until_us, clock_.now_us() + looks_for_room_us);
    return granted;
}

void World::fetch(FetchRequest request, Fetched done) {
    // What a subscription begins with is what it was granted.
    const bool starts = request.times_us.empty();
    Demand granted = starts ? request.demand : grant(request.demand);
    if (starts)
        granted.fields = granted.fields.without(granted.follows);
    if (granted.empty())
        return done(
            Error{Refusal::not_offered, "this sea offers none of these fields and cascades"});
    auto made = [this, quality = granted.quality,
                 done = std::move(done)](Result<FetchedKeyframes> fetched) {
        if (!fetched)
            return done(fetched.error());
        if (!std::ranges::all_of(fetched->keyframes,
                                 [this](const auto& one) { return ever_runs(one); }))
            return done(Error{Refusal::busy, "the sea of these times was changed meanwhile"});
        FetchedPart part{.tiles = {}, .last = fetched->last};
        for (sea::KeyframePtr& keyframe : fetched->keyframes)
            part.tiles.push_back(tiles(std::move(keyframe), quality));
        done(std::move(part));
    };
    if (starts)
        simulation_->fetch_current(granted, std::move(made), request.asker);
    else
        simulation_->fetch(std::move(request.times_us), granted, std::move(made), request.asker);
}

void World::query(QueryBatch batch, Queried done) {
    const sea::TimeUs time_us =
        batch.points.empty() ? clock_.now_us() : batch.points.front().time_us;
    PointsAsked asked(std::move(batch.points));
    asked.exact = batch.exact;
    asked.looking = batch.looking;
    asked.z_m = std::move(batch.z_m);
    std::optional<std::uint32_t> counted;
    if (asked.looking != sea::Looking{})
        counted = felt_cascades(*course_, asked.points, asked.looking);
    simulation_->answer(
        std::move(asked),
        [epoch = course_->window_at(time_us).epoch, counted,
         done = std::move(done)](Result<PointsAnswered> answered) {
            if (!answered)
                return done(answered.error());
            done(QueryAnswers{epoch, std::move(answered->answers), std::move(answered->below),
                              counted});
        },
        batch.asker);
}

void World::map(MapQuery query, Mapped done) {
    const Result<sea::MapRequest> request = read_map_request(query.parameters, clock_.now_us());
    if (!request)
        return done(request.error());
    const Room::Place place =
        memory()->room(MemoryUse::maps)->take(server::map_bytes(*course_->first()));
    if (!place)
        return done(Error{Refusal::busy, "maps under way fill the memory there is for them, try "
                                         "again later"});
    simulation_->surface(
        request->time_us,
        [request = *request, place, on_ready = query.on_ready,
         done = std::move(done)](const Result<SurfacePtr>& surface) {
            if (!surface)
                return done(surface.error());
            done(start_map(request, **surface, place, on_ready));
        },
        query.asker);
}

Result<std::uint64_t> World::map_bytes(const std::map<std::string, std::string>& parameters) const {
    SEAWAY_TRY_LET(const sea::MapRequest request, read_map_request(parameters, clock_.now_us()));
    return bytes_of_map(request);
}

void World::read_by(Since since) {
    const std::scoped_lock lock(mutex_);
    since_ = std::move(since);
}

Result<std::vector<SeaChange>> World::changes_from(std::uint64_t number, std::size_t most) const {
    Since since;
    {
        const std::scoped_lock lock(mutex_);
        since = since_;
    }
    if (!since)
        return Error{Refusal::not_offered, "this sea has no journal"};
    constexpr std::uint64_t number_max = std::numeric_limits<std::uint32_t>::max();
    if (number > number_max)
        return Error{Refusal::bad_value,
                     fmt::format("change is {}; their numbers are 1 .. {}", number, number_max)};
    return since(static_cast<std::uint32_t>(number > 0 ? number - 1 : 0), most);
}

Result<std::string> World::history(std::uint64_t from) const {
    const std::uint64_t begin = std::max<std::uint64_t>(from, 1);
    SEAWAY_TRY_LET(std::vector<SeaChange> changes, changes_from(begin, history_max));
    if (changes.empty()) // nothing differs from anything, however far back that is
        return history_json(changes, static_cast<std::uint32_t>(from));
    // With those before that the listed ones differ from, back to one that had begun before all of them. Between are paces, what lapsed,
    // and what was taken over from.
    sea::TimeUs first_us = std::numeric_limits<sea::TimeUs>::max();
    for (const SeaChange& change : changes)
        if (!change.pace)
            first_us = std::min(first_us, change.start_us);
    for (std::uint64_t first = begin, step = 1; first > 1; step = std::min(2 * step, history_max)) {
        const std::uint64_t count = std::min(step, first - 1);
        first -= count;
        SEAWAY_TRY_LET(std::vector<SeaChange> before, changes_from(first, count));
        const bool last = std::ranges::any_of(
            before, [first_us](const SeaChange& change) { return runs_before(change, first_us); });
        std::erase_if(before, std::not_fn(changes_the_scene));
        changes.insert(changes.begin(), std::make_move_iterator(before.begin()),
                       std::make_move_iterator(before.end()));
        if (last)
            break;
    }
    return history_json(changes, static_cast<std::uint32_t>(from));
}

Result<std::string> World::scene_of_change(std::uint64_t number) const {
    SEAWAY_TRY_LET(const std::vector<SeaChange> changes, changes_from(number, 1));
    if (number == 0 || changes.empty())
        return Error{Refusal::bad_value, fmt::format("change is {}; there is none", number)};
    const SeaChange& change = changes.front();
    if (change.pace)
        return Error{Refusal::bad_value,
                     fmt::format("change is {}, which is one of pace: it has no scene", number)};
    if (change.lapsed)
        return Error{Refusal::bad_value,
                     fmt::format("change is {}, which came to the journal too late and has lapsed: "
                                 "its sea has never run",
                                 number)};
    SEAWAY_TRY_LET(const sea::Scene scene,
                   scene_of(change, "the journal", course_->first()->scene));
    if (scene.weather.empty())
        return change.scene;
    SEAWAY_TRY_LET(const sea::Scene by_now, sea::weather_by(scene, clock_.now_us()));
    return sea::to_toml(by_now);
}

std::string World::state_json() const {
    const RunningSeaPtr sea = sea_now();
    return server::state_json(*sea, warnings_of(*sea), simulation_->device(), clock_.moment(),
                              following(), refused_.counts());
}

std::string World::plan_json() const {
    return server::plan_json(*sea_now(), simulation_->plan(), simulation_->counters(),
                             simulation_->costs(), simulation_->device(), clock_.moment());
}

std::string World::metrics_text() const {
    const std::optional<Following> now = following();
    MetricsText spectra;
    spectra.one("spectra_made_total", "counter",
                "Waves of a sea that were encoded at one accuracy.", spectra_.made_so_far());
    return server::metrics_text(simulation_->plan(), simulation_->counters(), simulation_->costs(),
                                clock_.moment()) +
           (now ? now->metrics() : "") + server::metrics_text(refused_.counts()) + spectra.take() +
           process_metrics_text();
}

} // namespace seaway::server
