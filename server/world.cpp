// SPDX-License-Identifier: Apache-2.0
#include "server/world.h"

#include <utility>

#include <fmt/format.h>

#include "server/map_source.h"
#include "server/process_metrics.h"
#include "server/simulation/memory_needs.h"
#include "server/world_reports.h"

namespace seaway::server {

World::World(RunningSeaPtr sea, std::vector<std::string> warnings, SeaClock& clock,
             MemoryPtr memory)
    : Host(std::move(memory)), sea_(std::move(sea)), warnings_(std::move(warnings)), clock_(clock),
      sea_state_(std::make_shared<const std::vector<std::uint8_t>>(
          protocol::sea_state(announcement(*sea_, warnings_)))) {}

Health health_of(bool healthy, Heartbeat::Clock::duration turn) {
    if (!healthy)
        return {false, "the simulation has failed"};
    if (turn < stuck_after)
        return {};
    return {false, fmt::format("the simulation has not come on for {} s",
                               std::chrono::duration_cast<std::chrono::seconds>(turn).count())};
}

void World::publish_to(Publish publish) {
    const std::scoped_lock lock(mutex_);
    publish_ = std::move(publish);
}

sea::FieldSet World::follows(std::uint8_t quality) const {
    return is_compact(quality) && sea_->budget.displacement_follows
               ? sea::following(sea_->streamed()) & sea_->streamed()
               : sea::FieldSet{};
}

KeyframeTiles World::tiles(sea::KeyframePtr keyframe, std::uint8_t quality) const {
    std::vector<float> bounds =
        sea::codec_bounds(sea_->budget, keyframe->fields, keyframe->cascade,
                          codec_error_m(sea_->budget, quality), is_compact(quality));
    const auto cascade = static_cast<std::size_t>(keyframe->cascade);
    const int size = is_compact(quality) ? sea_->budget.cascades[cascade].compact_size : 0;
    return {std::move(keyframe), std::move(bounds), quality, size, follows(quality)};
}

void World::attach(Simulation& simulation) {
    simulation_ = &simulation;
    subscriptions().on_change([&simulation] { simulation.demand_changed(); });
}

void World::on_keyframe(const sea::KeyframePtr& keyframe) {
    Publish publish;
    {
        const std::scoped_lock lock(mutex_);
        publish = publish_;
    }
    for (std::uint8_t quality = 0; quality < quality_rungs; ++quality)
        if (publish && !subscriptions().wanted(keyframe->cascade, quality).empty())
            publish(tiles(keyframe, quality));
}

Demand World::grant(const Demand& wish) const {
    Demand granted;
    granted.cascades = wish.cascades & ((1u << sea_->budget.cascades.size()) - 1u);
    granted.fields = sea::FieldSet::from_bits(wish.fields.bits() & sea_->streamed().bits());
    granted.quality = quality_for(sea_->budget, static_cast<double>(wish.error_m), wish.compact);
    granted.compact = wish.compact;
    granted.follows = granted.fields & follows(granted.quality) & sea::following(granted.fields);
    granted.fields = granted.fields.without(granted.follows);
    granted.error_m = static_cast<float>(height_error_m(sea_->budget, granted.quality));
    return granted;
}

void World::fetch(FetchRequest request, Fetched done) {
    const Demand granted = grant(request.demand);
    if (granted.empty())
        return done(
            Error{Refusal::not_offered, "this sea offers none of these fields and cascades"});
    auto made = [this, quality = granted.quality,
                 done = std::move(done)](Result<FetchedKeyframes> fetched) {
        if (!fetched)
            return done(fetched.error());
        FetchedPart part{.tiles = {}, .last = fetched->last};
        for (sea::KeyframePtr& keyframe : fetched->keyframes)
            part.tiles.push_back(tiles(std::move(keyframe), quality));
        done(std::move(part));
    };
    if (request.times_us.empty())
        simulation_->fetch_current(granted, std::move(made), request.asker);
    else
        simulation_->fetch(std::move(request.times_us), granted, std::move(made), request.asker);
}

void World::query(QueryBatch batch, Queried done) {
    simulation_->answer(
        std::move(batch.points), batch.exact,
        [epoch = sea_->epoch, done = std::move(done)](Result<std::vector<sea::Answer>> answers) {
            if (!answers)
                return done(answers.error());
            done(QueryAnswers{epoch, *std::move(answers)});
        },
        batch.asker);
}

void World::map(MapQuery query, Mapped done) {
    const Result<sea::MapRequest> request = read_map_request(query.parameters, clock_.now_us());
    if (!request)
        return done(request.error());
    const Room::Place place = memory()->room(MemoryUse::maps)->take(server::map_bytes(*sea_));
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

std::string World::state_json() const {
    return server::state_json(*sea_, warnings_, simulation_->device(), clock_.moment());
}

std::string World::plan_json() const {
    return server::plan_json(*sea_, simulation_->plan(), simulation_->counters(),
                             simulation_->costs(), simulation_->device());
}

std::string World::metrics_text() const {
    return server::metrics_text(simulation_->plan(), simulation_->counters(), simulation_->costs(),
                                clock_.moment()) +
           process_metrics_text();
}

} // namespace seaway::server
