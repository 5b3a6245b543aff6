// SPDX-License-Identifier: Apache-2.0
// Simulation: one thread that owns the synthesizer, computes the keyframes that the effect plan
// calls for ahead of time, and answers questions about any time from keyframes around it.
//
// Order of work: keyframes that are due, then one slice of what was asked. Without demand and
// without questions the thread sleeps and nothing is dispatched. A device that fails is rebuilt
// from (sea, time) a bounded number of times; after that on_failure is called and the simulation
// is over.
//
// All public functions may be called from any thread and return at once; callbacks come on the
// simulation thread and must not block.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "base/result.h"
#include "sea/surface/answer.h"
#include "sea/surface/surface.h"
#include "server/device/synthesizer.h"
#include "server/refusal.h"
#include "server/simulation/effect_costs.h"
#include "server/simulation/effect_plan.h"
#include "server/simulation/foam_maps.h"
#include "server/simulation/keyframe_store.h"
#include "server/simulation/running_sea.h"

namespace seaway::server {

using SurfacePtr = std::shared_ptr<const sea::Surface>;

using SynthesizerFactory = std::function<Result<std::unique_ptr<Synthesizer>>()>;

/// A keyframe is published this long before its interval begins, so that it is decoded in time.
inline constexpr sea::TimeUs publish_lead_us = 250'000;
/// A keyframe that is later than this is skipped for a newer one.
inline constexpr sea::TimeUs catch_up_us = 500'000;
inline constexpr int device_rebuilds_max = 3;
/// Questions that wait at most; one more is refused at once.
inline constexpr std::size_t questions_waiting_max = 1024;
/// Exact sums between two looks at what else is due.
inline constexpr std::size_t exact_points_per_slice = 8;
/// Up to 50 ms in a sea that folds often, 5 ms in others.
inline constexpr std::size_t sampled_points_per_slice = 1024;

struct SimulationEvents {
    std::function<void(const sea::KeyframePtr&)> on_keyframe; ///< a planned one, once
    std::function<void(const std::string& why)> on_warning;
    std::function<void(const std::string& why)> on_failure; ///< the simulation has ended
};

struct SimulationCounters {
    SynthesisCounters synthesis;
    StoreCounters store;
    std::uint64_t keyframes_published = 0;
    std::uint64_t keyframes_skipped = 0; ///< too late to be of use
    std::uint64_t questions = 0;
    std::uint64_t device_rebuilds = 0;
};

class Simulation {
  public:
    /// Makes the device, warms it up and starts the thread. `now` is the sea's clock.
    static Result<std::unique_ptr<Simulation>> start(RunningSeaPtr sea, SynthesizerFactory factory,
                                                     std::function<sea::TimeUs()> now,
                                                     SimulationEvents events);
    ~Simulation();
    Simulation(const Simulation&) = delete;
    Simulation& operator=(const Simulation&) = delete;

    /// Sets or replaces what `who` wants streamed; an empty demand takes it away. Takes effect with
    /// the next keyframes.
    void set_demand(std::uint64_t who, Demand demand);

    // Each question is answered once, by what was asked for or by why not, an Error of kind
    // Refusal: bad_value for a time or place out of range, busy while questions_waiting_max wait,
    // gone after the device or the simulation has ended.

    /// The two keyframes of each wanted cascade around each time.
    using Fetched = std::function<void(Result<std::vector<sea::KeyframePtr>>)>;
    void fetch(std::vector<sea::TimeUs> times_us, Demand demand, Fetched done);

    /// What a new subscriber needs: from the keyframe before now to the newest published one.
    void fetch_current(Demand demand, Fetched done);

    /// One answer a point, in order, each at its own time, past or future.
    using Answered = std::function<void(Result<std::vector<sea::Answer>>)>;
    void answer(std::vector<sea::QueryPoint> points, bool exact, Answered done);

    /// The surface around a time, for who samples much of it at once.
    using Surfaced = std::function<void(Result<SurfacePtr>)>;
    void surface(sea::TimeUs time_us, Surfaced done);

    RunningSeaPtr sea() const;
    EffectPlan plan() const;
    SimulationCounters counters() const;
    EffectCosts costs() const;
    std::string device() const;
    bool healthy() const { return !failed_; }

  private:
    /// Something asked: worked on slice by slice until it is answered, or refused.
    struct Question {
        std::function<bool()> slice; ///< true: answered
        std::function<void(const Error&)> refuse;
    };

    Simulation(RunningSeaPtr sea, SynthesizerFactory factory, std::function<sea::TimeUs()> now,
               SimulationEvents events);

    void run();
    bool publish_due();
    void ask(Question question);
    void refuse_all_questions();
    sea::TimeUs next_due_us() const;
    sea::TimeUs lead_us(std::size_t cascade) const;

    struct Wanted {
        int cascade;
        sea::TimeUs time_us;
        sea::FieldSet fields;
    };
    /// From the store, or computed. An error is the end of the simulation: the device has failed
    /// for good.
    Result<std::vector<sea::KeyframePtr>> keyframes(std::span<const Wanted> wanted, FoamMaps& foam);
    Result<std::vector<sea::KeyframePtr>> compute(std::span<const KeyframeRequest> requests,
                                                  FoamMaps& foam);
    /// `asked`: the same requests before foam was replaced by what it stands on; for the accounts.
    Result<std::vector<sea::KeyframePtr>> synthesize(std::span<const KeyframeRequest> requests,
                                                     std::span<const KeyframeRequest> asked);
    Result<sea::KeyframePtr> add_foam(const sea::KeyframePtr& keyframe, FoamMaps& foam);
    Result<void> rebuild_device();
    std::vector<Wanted> around(sea::TimeUs time_us, const Demand& demand) const;
    /// From the keyframes of every cascade around a time; valid before `end_us`.
    struct SurfaceSpan {
        SurfacePtr surface;
        sea::TimeUs end_us;
    };
    Result<SurfaceSpan> surface_around(sea::TimeUs time_us);

    struct Batch;
    Result<void> sampled_slice(Batch& batch);
    void exact_slice(Batch& batch) const;
    void count_synthesis(std::span<const KeyframeRequest> requests);

    const RunningSeaPtr sea_;
    const SynthesizerFactory factory_;
    const std::function<sea::TimeUs()> now_;
    const SimulationEvents events_;

    // Of the simulation thread alone.
    std::unique_ptr<Synthesizer> synthesizer_;
    std::vector<sea::TimeUs> next_keyframe_us_; ///< a cascade; the next to publish
    std::vector<bool> streaming_;
    FoamMaps streamed_foam_; ///< walks with the stream
    FoamMaps asked_foam_;    ///< jumps to where someone asks

    KeyframeStore store_;
    std::atomic<bool> failed_ = false;

    mutable std::mutex mutex_;
    std::condition_variable wake_;
    bool stopping_ = false;
    std::map<std::uint64_t, Demand> demands_;
    EffectPlan plan_;
    std::deque<Question> questions_;
    std::optional<Error> ended_; ///< why nothing is taken any more
    SimulationCounters counters_;
    EffectCosts costs_;
    SynthesisCounters before_rebuild_; ///< of devices that are gone
    std::string device_;

    std::thread thread_;
};

} // namespace seaway::server
