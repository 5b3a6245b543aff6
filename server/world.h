// SPDX-License-Identifier: Apache-2.0
// World: the Host that server/net talks to, made of a Simulation. Translates between what the wire
// knows (sessions, bounds, messages) and what the simulation knows (fields, keyframes).
//
// Thread-safe.
#pragma once

#include <atomic>
#include <chrono>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/following.h"
#include "server/host/host.h"
#include "server/host/quality.h"
#include "server/journal/sea_clock.h"
#include "server/publish/spectrum_store.h"
#include "server/refused_changes.h"
#include "server/simulation/simulation.h"

namespace seaway::server {

/// A slice that has lasted as long has not come on: ten times what the largest keyframe takes on two crowded cores.
inline constexpr std::chrono::seconds stuck_after{30};

/// Five standard deviations of the water's vertical velocity: by so much a height is off, at most, for each second that its
/// time is.
double vertical_mps(const sea::SeaStatistics& sea);

/// Of a simulation that is healthy or has failed, and of how long its slice has lasted.
Health health_of(bool healthy, Heartbeat::Clock::duration turn);

class World final : public Host {
  public:
    using Publish = std::function<void(KeyframeTiles)>;
    using Announce = std::function<void(SharedBytes)>;
    using Change = std::function<void(SeaWish, Changed)>;

    /// A sea is told of this long before it begins, by the clocks of who hears it.
    static constexpr sea::TimeUs announced_ahead_us = 10'000'000;
    /// The same in sea time.
    sea::TimeUs announced_ahead() const { return clock_.hurried(announced_ahead_us); }

    /// `clock` outlives the world.
    World(SeaCoursePtr course, SeaClock& clock, MemoryPtr memory = std::make_shared<Memory>());

    /// Before anything is asked; the simulation must outlive every later call.
    void attach(Simulation& simulation);
    /// Where keyframes go from now on.
    void publish_to(Publish publish);
    /// Where the states of seas to come go from now on, and who changes the sea.
    void announce_to(Announce announce);
    void change_by(Change change);
    /// Who knows how it stands with the log, from now on; empty: there is none.
    void follow_by(std::function<Following()> follow);
    /// Changes after that of a number, so many at most, as Journal::since(), from now on; empty: there is no journal.
    using Since = std::function<Result<std::vector<SeaChange>>(std::uint32_t, std::size_t)>;
    void read_by(Since since);
    /// Who sends all sessions to other servers, from now on; and that it is to.
    using HandOver = std::function<void(const std::string& why, const std::string& why_in_general)>;
    void hand_over_by(HandOver hand_over);
    void hand_over(const std::string& why, const std::string& why_in_general);
    /// How it stands with the log, if it follows one.
    std::optional<Following> following() const;
    /// A keyframe that the plan called for, for those who take keyframes at a rate (of rate_rungs_hz): published once a
    /// quality in use.
    void on_keyframe(const sea::KeyframePtr& keyframe, std::size_t rate = 0);
    /// Makes the seas that begin within announced_ahead_us and tells everybody who has not been told. Says until when
    /// there is nothing more to tell. Slow.
    sea::TimeUs announce_due();

    /// Told to everybody, before it holds.
    void announce_pace(const sea::Pace& pace);

    sea::TimeUs sea_time_us() const override { return clock_.now_us(); }
    sea::SeaTime sea_time() const override;
    std::vector<SharedBytes> sea_state_messages() const override;
    /// Null: of an epoch that never runs, since another took its place.
    SharedBytes sea_state_message(std::uint32_t epoch) const override;
    Demand grant(const Demand& wish, std::optional<SessionId> instead_of = {}) const override;
    void fetch(FetchRequest request, Fetched done) override;
    void query(QueryBatch batch, Queried done) override;
    void map(MapQuery query, Mapped done) override;
    /// Of the sea that runs, of those that it glides from, and of those announced.
    Result<GrantedSpectrum> spectrum(const SpectrumRequest& request) override;
    std::optional<GrantedSpectrum> held_spectrum(const SpectrumRequest& request) override;
    Result<std::uint64_t>
    map_bytes(const std::map<std::string, std::string>& parameters) const override;
    void change(Result<SeaWish> wish, Changed done) override;
    Result<std::string> history(std::uint64_t from) const override;
    Result<std::string> scene_of_change(std::uint64_t number) const override;
    std::string state_json() const override;
    std::string plan_json() const override;
    std::string metrics_text() const override;
    Health health() const override;
    /// Of change().
    RefusedChanges::Counts changes_refused() const { return refused_.counts(); }

  private:
    Result<std::vector<SeaChange>> changes_from(std::uint64_t number, std::size_t most) const;
    KeyframeTiles tiles(sea::KeyframePtr keyframe, Quality quality) const;
    bool ever_runs(const sea::KeyframePtr& keyframe) const;
    /// The one that runs; made here only where the clock has leapt to a sea that nobody was told of.
    RunningSeaPtr sea_now() const { return course_->at(clock_.now_us()); }
    SpectrumSource source_of(const RunningSea& sea) const;
    /// The waves that a sea glides from, and those that led there: the nearest first. Slow where they are not held.
    std::vector<SpectrumSource> origins_of(std::uint32_t epoch) const;
    /// Of whose waves a request is: the sea that runs first, if it is among them.
    std::vector<SpectrumSource> spectrum_sources(const SpectrumRequest& request) const;
    bool is_told(std::uint32_t epoch) const;
    /// The one that runs, first, and those that were announced.
    std::vector<RunningSeaPtr> seas_told() const;

    const SeaCoursePtr course_;
    SeaClock& clock_;
    SpectrumStore spectra_;
    RefusedChanges refused_;
    Simulation* simulation_ = nullptr;

    mutable std::atomic<std::int64_t> unsure_since_us_ = 0, unsure_looked_us_ = 0;
    std::atomic<sea::TimeUs> told_until_us_ = 0; ///< a sea that nobody was told of begins then
    mutable std::mutex mutex_;                   ///< of what follows
    Publish publish_;
    Announce announce_;
    Change change_;
    std::function<Following()> follow_;
    HandOver hand_over_;
    Since since_;
    /// The sea that runs and those that announce_due() has told of, in order of time; and what the first of them glides from.
    /// Held, so that nobody on the network's thread has to make one.
    std::vector<RunningSeaPtr> told_;
    std::vector<SpectrumSource> origins_;
    struct SeaState {
        std::uint32_t epoch;
        SharedBytes message;
    };
    /// Of seas that are told of, or of which keyframes went out; asked for last: at the back.
    mutable std::deque<SeaState> sea_states_;
};

} // namespace seaway::server
