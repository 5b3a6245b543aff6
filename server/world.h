// SPDX-License-Identifier: Apache-2.0
// World: the Host that server/net talks to, made of a Simulation. Translates between what the wire
// knows (sessions, bounds, messages) and what the simulation knows (fields, keyframes).
//
// Thread-safe.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "server/host/host.h"
#include "server/host/quality.h"
#include "server/journal/sea_clock.h"
#include "server/publish/spectrum_store.h"
#include "server/simulation/simulation.h"

namespace seaway::server {

/// A slice that has lasted as long has not come on: ten times what the largest keyframe takes on two crowded cores.
inline constexpr std::chrono::seconds stuck_after{30};

/// Of a simulation that is healthy or has failed, and of how long its slice has lasted.
Health health_of(bool healthy, Heartbeat::Clock::duration turn);

class World final : public Host {
  public:
    using Publish = std::function<void(KeyframeTiles)>;

    /// `clock` outlives the world.
    World(RunningSeaPtr sea, std::vector<std::string> warnings, SeaClock& clock,
          MemoryPtr memory = std::make_shared<Memory>());

    /// Before anything is asked; the simulation must outlive every later call.
    void attach(Simulation& simulation);
    /// Where keyframes go from now on.
    void publish_to(Publish publish);
    /// A keyframe that the plan called for: published once a quality in use.
    void on_keyframe(const sea::KeyframePtr& keyframe);

    sea::TimeUs sea_time_us() const override { return clock_.now_us(); }
    std::vector<SharedBytes> sea_state_messages() const override { return {sea_state_}; }
    Demand grant(const Demand& wish) const override;
    void fetch(FetchRequest request, Fetched done) override;
    void query(QueryBatch batch, Queried done) override;
    void map(MapQuery query, Mapped done) override;
    Result<GrantedSpectrum> spectrum(const SpectrumDemand& wish) override {
        return spectra_.grant({sea_->epoch, sea_->realization, sea_->scene.sea.dispersion(),
                               sea_->budget.height_error_m},
                              wish);
    }
    Result<std::uint64_t>
    map_bytes(const std::map<std::string, std::string>& parameters) const override;
    std::string state_json() const override;
    std::string plan_json() const override;
    std::string metrics_text() const override;
    Health health() const override {
        return health_of(simulation_->healthy(), simulation_->turn());
    }

  private:
    /// What tiles of this rung leave out because it follows from what they hold.
    sea::FieldSet follows(std::uint8_t quality) const;
    KeyframeTiles tiles(sea::KeyframePtr keyframe, std::uint8_t quality) const;

    const RunningSeaPtr sea_;
    const std::vector<std::string> warnings_;
    SeaClock& clock_;
    const SharedBytes sea_state_;
    SpectrumStore spectra_;
    Simulation* simulation_ = nullptr;
    Publish publish_;

    std::mutex mutex_; ///< of publish_
};

} // namespace seaway::server
