// SPDX-License-Identifier: Apache-2.0
// Simulation: the thread that publishes the keyframes that the effect plan calls for, ahead of time
// (Schedule), and makes those that are asked for about any time (Questions), all from one KeyframeSource; and the
// threads that answer points from what is held (AnswerThreads).
//
// Order of work of the simulation thread, over and over: the keyframes that are due, stream_slices_ahead slices of
// them at most, a slice of foam that starts (StreamedFoam), a slice of what was asked. None of them waits for the end
// of another, however far the stream is behind. Without demand and without questions all threads sleep and nothing is
// dispatched. When the device has failed for good, on_failure is called and the simulation is over.
//
// All public functions may be called from any thread and return at once; callbacks come on the
// simulation thread or, of points and surfaces, on one of those that answer, and must not block.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <concepts>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/result.h"
#include "sea/surface/answer.h"
#include "server/host/refusal.h"
#include "server/host/stream_ahead.h"
#include "server/host/subscriptions.h"
#include "server/simulation/answer_threads.h"
#include "server/simulation/effect_plan.h"
#include "server/simulation/foresight.h"
#include "server/simulation/heartbeat.h"
#include "server/simulation/keyframe_source.h"
#include "server/simulation/point_question.h"
#include "server/simulation/questions.h"
#include "server/simulation/schedule.h"
#include "server/simulation/sea_course.h"
#include "server/simulation/streamed_foam.h"
#include "server/simulation/surfaces.h"

namespace seaway::server {

struct SimulationEvents {
    /// A planned one, once for those who take every keyframe (0) and once for each rate at most of which some take them
    /// (rate_rungs_hz).
    std::function<void(const sea::KeyframePtr&, std::size_t rate)> on_keyframe;
    std::function<void(const std::string& why)> on_warning;
    std::function<void(const std::string& why)> on_failure; ///< the simulation has ended
    std::function<void()> on_trim;                          ///< what nobody uses has been let go
};

struct SimulationCounters {
    SynthesisCounters synthesis;
    StoreCounters store;
    std::uint64_t keyframes_published = 0;
    std::uint64_t keyframes_skipped = 0; ///< too late to be of use
    std::uint64_t stream_slices = 0;     ///< of keyframes for the stream and of its foam
    std::uint64_t questions = 0;
    std::uint64_t questions_over_budget = 0; ///< refused: their askers had asked for too much
    std::size_t question_bytes = 0;          ///< points that wait, and room for their answers
    std::size_t fetch_bytes = 0;             ///< raw, of fetches that are under way
    std::size_t fetch_bytes_most = 0;        ///< so far
    std::uint64_t device_rebuilds = 0;
};

/// So many times after the last question, and the last keyframe that was held, what is unused is let go (Memory::trims_every): what was
/// made for them is still on its way out. Longer than an encoder keeps what was streamed.
inline constexpr int trims_after_work = 80;
/// Of so many one gives back to the system what is free: it looks through all that malloc has.
inline constexpr int trims_a_give_back = 2;

/// Points of no higher price are answered by who asks: with fewer threads to be woken they take half as long. So much of
/// the time of those who ask, so that what else they do, which is to send keyframes, waits for little.
inline constexpr double at_once_us = 50;
inline constexpr WorkBudget at_once_budget{.rate = 0.2, .burst_s = 0.002};

/// The sea's clock. All from any thread.
struct SimulationClock {
    std::function<sea::TimeUs()> now;
    /// How long it is until that sea time by the machine's clock; none: as long as the sea stands.
    std::function<std::optional<sea::TimeUs>(sea::TimeUs)> wait_us;
    /// As often as clocks do the sea runs, now or soon; 1 at least.
    std::function<double()> hurry;

    /// Of a sea that runs as clocks do.
    template <std::invocable Now>
    SimulationClock(Now now_) // NOLINT(google-explicit-constructor): a clock is mostly that
        : now(std::move(now_)), wait_us([this_now = now](sea::TimeUs time_us) {
              return std::optional(time_us - this_now());
          }),
          hurry([] { return 1.0; }) {}
    SimulationClock(std::function<sea::TimeUs()> now_,
                    std::function<std::optional<sea::TimeUs>(sea::TimeUs)> wait_us_,
                    std::function<double()> hurry_)
        : now(std::move(now_)), wait_us(std::move(wait_us_)), hurry(std::move(hurry_)) {}
};

/// What a fetch brings, part by part.
struct FetchedKeyframes {
    std::vector<sea::KeyframePtr> keyframes;
    bool last = true;
};

class Simulation {
  public:
    /// Makes the device, warms it up and starts the threads, of which those who answer are 1 to answer_threads_max;
    /// the rate of `budget` is a share of the time of all of them. `readback`: what maps may lose on the way from a device. The course may be added to at any time. Streams what
    /// `subscriptions` say, which outlive the simulation; whoever changes them calls
    /// demand_changed().
    static Result<std::unique_ptr<Simulation>>
    start(SeaCoursePtr course, const SynthesizerFactory& factory,
          const Subscriptions& subscriptions, SimulationClock clock, SimulationEvents events,
          WorkBudget budget = {}, MemoryPtr memory = std::make_shared<Memory>(),
          int answer_threads = answer_threads_default(), Readback readback = Readback::exact);
    ~Simulation();
    Simulation(const Simulation&) = delete;
    Simulation& operator=(const Simulation&) = delete;

    /// Takes effect with the next keyframes.
    void demand_changed() { questions_.wake(); }

    // Each question is answered once, by what was asked for or by why not, an Error of kind
    // Refusal: bad_value for a time or place out of range, busy while questions_waiting_max wait, there
    // is no memory for it or the budget of its asker is spent (price.h, account.h), gone after the
    // device or the simulation has ended, or the asker is gone.

    /// The two keyframes of each wanted cascade around each time, in parts, all of which but the
    /// last one may be followed by an error. Parts that are held keep others from being made.
    using Fetched = std::function<void(Result<FetchedKeyframes>)>;
    void fetch(std::vector<sea::TimeUs> times_us, const Demand& demand, Fetched done,
               const Asker& asker);

    /// What a new subscriber needs: from the keyframe before now to the newest published one.
    void fetch_current(const Demand& demand, Fetched done, const Asker& asker);

    /// One answer a point, in order, each at its own time, past or future. Few points of what is held are answered before
    /// this returns, where it is their turn and the calling thread has not answered much of late (at_once_us).
    using Answered = std::function<void(Result<PointsAnswered>)>;
    void answer(PointsAsked asked, Answered done, const Asker& asker);
    void answer(std::vector<sea::QueryPoint> points, bool exact,
                const std::function<void(Result<std::vector<sea::Answer>>)>& done,
                const Asker& asker) {
        PointsAsked asked(std::move(points));
        asked.exact = exact;
        answer(
            std::move(asked),
            [done](Result<PointsAnswered> answered) {
                if (!answered)
                    return done(answered.error());
                done(std::move(answered->answers));
            },
            asker);
    }

    /// The surface around a time, for who samples much of it at once.
    using Surfaced = std::function<void(Result<SurfacePtr>)>;
    void surface(sea::TimeUs time_us, Surfaced done, const Asker& asker);

    /// Of who asks for what other threads make: out of the same budget as questions; Refusal::busy where it is spent.
    Result<void> charge(const Asker& asker, double price_us) {
        return questions_.charge(asker, price_us);
    }
    void settle(const Asker& asker, double left_us) { questions_.settle(asker, left_us); }

    EffectPlan plan() const;
    SimulationCounters counters() const;
    EffectCosts costs() const { return source_.report().costs; }
    std::string device() const { return source_.report().device; }
    bool healthy() const { return !source_.failed(); }
    /// For how long the slice that has been under way for longest has lasted: some 50 ms, one large keyframe or one
    /// exact answer where all is well.
    Heartbeat::Clock::duration turn() const {
        return std::max(heartbeat_.turn(), answer_threads_.turn());
    }

  private:
    Simulation(SeaCoursePtr course, std::unique_ptr<RebuiltSynthesizer> device,
               const Subscriptions& subscriptions, SimulationClock clock, SimulationEvents events,
               WorkBudget budget, MemoryPtr memory, Readback readback);

    EffectPlan plan(sea::TimeUs now_us) const;
    void run();
    /// False: nothing was due.
    bool work_on_stream();
    void publish(const std::vector<sea::KeyframePtr>& keyframes);
    /// The stream's slices before a question's. False: there was nothing to do.
    bool work_ahead();
    void trim_now_and_then();
    /// `more`: there is other work, no question is waited for.
    void work_on_a_question(bool more);
    HoldingOf holding() const;
    void woken_for_work();
    void ask(Question question);
    /// Asks, or does the first slice of it here.
    void answer_at_once(Question question, const std::function<bool()>& slice);
    /// Splines, and keyframes that nobody streams, of a time that somebody is going to ask about.
    void make_ready(sea::TimeUs time_us);
    Question surface_question(std::shared_ptr<SurfaceJob> job, Surfaced done, const Asker& asker);
    /// A slice of a job, whose parts, which `parts` has, go to `done` as they are made; true: it is over.
    template <class Parts>
    bool work_on(KeyframeJob& job, Parts& parts, const Fetched& done);

    const SeaCoursePtr course_;
    const Subscriptions& subscriptions_;
    const SimulationClock clock_;
    const SimulationEvents events_;
    const MemoryPtr memory_;
    SumsRoom sums_{memory_->room(MemoryUse::sums)};

    // Used by the simulation thread alone, but for reports.
    KeyframeSource source_;
    Surfaces surfaces_; ///< any thread
    const Prices prices_;
    Schedule schedule_;
    StreamedFoam streamed_foam_;
    std::optional<EffectPlan> streamed_plan_; ///< what the streams were made by last
    std::optional<KeyframeJob> streaming_;    ///< due keyframes that are being made
    std::vector<RateSet> streaming_rates_;    ///< of them, in order
    std::size_t streaming_published_ = 0;     ///< of them
    const std::shared_ptr<Room>
        fetch_room_; ///< raw, from before they are made until they are encoded
    std::chrono::steady_clock::time_point trimmed_ = std::chrono::steady_clock::now();
    int trims_ = 0;
    std::atomic<int> trims_left_ = 0;
    std::mutex at_once_mutex_;
    Account at_once_{at_once_budget, steady_seconds()}; ///< of those who call answer()
    Foresight foresight_;
    const std::shared_ptr<const void> foreseer_ = std::make_shared<char>(); ///< asks for it
    Questions questions_;

    Heartbeat heartbeat_;
    std::atomic<bool> stopping_ = false;
    std::atomic<std::uint64_t> keyframes_published_ = 0;
    std::atomic<std::uint64_t> keyframes_skipped_ = 0;
    std::atomic<std::uint64_t> stream_slices_ = 0;
    AnswerThreads answer_threads_{questions_};
    std::thread thread_;
};

} // namespace seaway::server
