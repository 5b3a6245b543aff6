// SPDX-License-Identifier: Apache-2.0
// Keyframe source: any keyframe of the seas of a course, from the store or from the device, with foam
// where it is wanted; and what all of that has cost. What may take long - many keyframes, a foam
// history that starts - is a job, worked on slice by slice.
//
// Where there is no memory for what is asked, that is an error of kind Refusal::busy and nothing else
// happens. The first failure of the device that rebuilding does not mend is the last word: from then on every
// call gives that same error, of kind Refusal::gone. For one thread, except store(), holding(), report() and failed().
#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "server/device/rebuilt_synthesizer.h"
#include "server/device/spare_buffers.h"
#include "server/host/memory.h"
#include "server/simulation/course_synthesis.h"
#include "server/simulation/effect_costs.h"
#include "server/simulation/foam_maps.h"
#include "server/simulation/keyframe_store.h"
#include "server/simulation/price.h"
#include "server/simulation/readback.h"
#include "server/simulation/sea_course.h"

namespace seaway::server {

/// Walks through time, each with foam histories of its own: the stream goes step by step, starts of
/// subscriptions join it near now, questions jump to where someone asks.
enum class Walk { stream, starts, questions };

/// Samples of one field that a slice makes, at most where one keyframe has not more: 32 of 256 x 256,
/// 1 ms on two native cores and 8 as splines, some ten times as much on lavapipe. A tick of foam counts as
/// foam_tick_fields.
inline constexpr std::int64_t samples_per_slice = 1 << 21;
inline constexpr std::int64_t foam_tick_fields = 4;

/// Keyframes that are being made: one a request, in order, with at least its fields. They come in
/// parts of at most samples_per_slice, or of one keyframe that has more: a job holds no more than
/// that, however much is asked for.
class KeyframeJob {
  public:
    /// With a `room` each part takes its bytes of it before it is made. Whoever holds a keyframe of
    /// the part holds its place too.
    KeyframeJob(std::vector<KeyframeRequest> wanted, Walk walk,
                std::shared_ptr<Room> room = nullptr)
        : wanted_(std::move(wanted)), walk_(walk), room_(std::move(room)) {}

    /// Whoever works on it makes no sea: a slice ends before one that nobody holds.
    void leave_seas_to_others() { leaves_seas_ = true; }
    /// The epoch of that sea, which the next slice needs. None: it may go on.
    std::optional<std::uint32_t> lacks_sea() const { return lacks_sea_; }
    void go_on() { lacks_sea_.reset(); }

    /// The next part, once KeyframeSource::work_on() has said that it is made.
    std::vector<sea::KeyframePtr> take();
    /// The last part has been taken.
    bool complete() const { return !open_ && end_ == wanted_.size(); }
    /// Nothing is under way: the next slice begins a part.
    bool between_parts() const { return !open_; }
    /// A slice would come to nothing: there is no room for the next part, or another job walks foam.
    bool waits() const {
        return !open_ && (!awaited_turn_.expired() || (room_ && !room_->fits(part_bytes_)));
    }

  private:
    friend class KeyframeSource;
    struct Missing {
        std::size_t place;
        KeyframeRequest request; ///< of the fields that are lacking
        sea::KeyframePtr held;   ///< with fields that are not, which are kept, or null
        sea::TimeUs foam_us; ///< foam_time() when it was looked up: a change may cut it meanwhile
        bool walks_foam() const { return request.fields.contains(sea::Field::foam); }
    };
    bool made() const { return open_ && missing_.empty(); }

    std::vector<KeyframeRequest> wanted_;
    Walk walk_;
    std::shared_ptr<Room> room_;
    bool open_ = false;   ///< a part is being made
    std::size_t end_ = 0; ///< of it, among `wanted_`
    std::size_t part_bytes_ = 0;
    Room::Place place_;
    std::vector<sea::KeyframePtr> found_; ///< the part
    std::deque<Missing> missing_;
    std::shared_ptr<const void> turn_;       ///< held by the one job whose foam is walked for
    std::weak_ptr<const void> awaited_turn_; ///< of another, which had it at the last slice
    bool leaves_seas_ = false;
    std::optional<std::uint32_t> lacks_sea_;
};

/// What a keyframe is one of.
inline KeyframeRequest request_of(const sea::Keyframe& keyframe) {
    return {keyframe.cascade, keyframe.time_us, keyframe.fields, keyframe.epoch};
}

class KeyframeSource : private KeyframeMaker {
  public:
    /// `readback`: of a device whose memory the CPU cannot read.
    KeyframeSource(SeaCoursePtr course, std::unique_ptr<RebuiltSynthesizer> device,
                   const Memory& memory, Readback readback = Readback::exact);
    Readback readback() const { return readback_; }

    /// One slice; true: a part is made, to be taken. Of several jobs of one walk that need foam one
    /// gets on at a time, the others wait until it is made or gone.
    Result<bool> work_on(KeyframeJob& job);

    /// Ticks that the stream's foam of a cascade is away from a time.
    int foam_ticks_to(int cascade, sea::TimeUs time_us) const;
    /// A slice of them; true: none is left.
    Result<bool> walk_streamed_foam(int cascade, sea::TimeUs time_us);
    /// The foam of starts and of questions goes on from where the stream's is.
    void share_streamed_foam(int cascade);

    /// Why there are no more keyframes.
    const std::optional<Error>& failure() const { return failure_; }
    bool failed() const { return failed_; } ///< any thread

    /// Lets go of keyframes, and of maps, that nobody has used since the call before the last one, and of memory for work
    /// that the last few calls saw no need of.
    std::size_t trim() {
        device_.trim();
        joined_->clear(); // before more comes from the store, for until the next call
        return store_.trim();
    }
    /// There is something to trim().
    bool holds_keyframes() const { return store_.counters().keyframes > 0; }
    /// Of these, some that nobody streams: a question was answered from them a moment ago. Any thread.
    bool holds_asked_keyframes() const { return store_.counters().asked > 0; }

    /// What is held, with its splines. Any thread.
    KeyframeStore& store() { return store_; }
    /// What of a keyframe is there now that points can be answered from. Any thread.
    Holding holding(const KeyframeRequest& request) const;
    /// Its maps are: a spline is of no use to who wants to have them. Any thread.
    Holding holding_of_maps(const KeyframeRequest& request) const;

    struct Report {
        std::string device;
        SynthesisCounters synthesis;
        StoreCounters store;
        EffectCosts costs;
        std::uint64_t device_rebuilds = 0;
    };
    Report report() const;

  private:
    bool open_part(KeyframeJob& job);
    /// `held`: what was held of the part as its turn was taken.
    void look_up(KeyframeJob& job, std::size_t begin, std::vector<sea::KeyframePtr> held);
    Result<bool> slice(KeyframeJob& job, std::int64_t& budget);
    bool takes_its_turn(KeyframeJob& job);
    /// True: the foam of the next keyframe that is missing is there, but for its own tick.
    Result<bool> walk_to_next(KeyframeJob& job, std::int64_t& budget);
    /// This sea can be looked at now. False: the job lacks it.
    bool is_there(KeyframeJob& job, std::uint32_t epoch) const;
    /// So can all that the keyframes that are missing are of.
    bool are_there(KeyframeJob& job) const;
    /// Some of those that are missing, which are made in one call.
    struct Together {
        std::vector<KeyframeRequest> requests;
        std::deque<FoamTurn> turns;
        std::uint32_t foam_epoch = 0; ///< of those with a turn: each epoch has histories of its own
        std::vector<int> with_turn;   ///< cascades
        struct Foam {
            std::size_t keyframe, of; ///< places among the requests
        };
        std::vector<Foam> moved;         ///< foam that is of another time than its keyframe
        std::vector<std::size_t> places; ///< of the keyframes that were missing, among the requests
    };
    /// One turn a history, and of one epoch: what follows it has to find it done.
    bool fits(const Together& together, const KeyframeJob& job, const KeyframeJob::Missing& next);
    Result<void> add_turn(Together& together, const KeyframeJob& job,
                          const KeyframeJob::Missing& next);
    Result<std::vector<NewKeyframePtr>> make(const KeyframeJob& job, std::int64_t& budget,
                                             Together& together);
    Result<std::vector<NewKeyframePtr>>
    synthesize_rounded(std::span<const KeyframeRequest> requests);
    Result<void> synthesize_some(KeyframeJob& job, std::int64_t& budget);
    /// What is held, with what has been made: one keyframe.
    NewKeyframePtr joined(const sea::Keyframe& held, const sea::Keyframe& made) const;
    void keep(KeyframeJob& job, std::size_t place, sea::KeyframePtr keyframe);
    Result<bool> walk(FoamMaps& foam, int cascade, sea::TimeUs time_us, sea::TimeUs until_us,
                      std::int64_t& budget, KeyframeJob* job = nullptr);

    // What foam is walked with: the device, and its accounts.
    Result<FoamMapPtr> open_foam(int size, const FoamMap* from) override;
    Result<std::vector<NewKeyframePtr>>
    synthesize(std::span<const KeyframeRequest> requests) override;

    /// When the foam of a keyframe is of: its time, but within the time of its sea, so that a stream never goes back
    /// where one sea follows another.
    sea::TimeUs foam_time(const KeyframeRequest& request) const;
    FoamMaps& foam_maps(const KeyframeJob& job, std::uint32_t epoch);
    FoamMaps& streamed_foam(std::uint32_t epoch);
    std::int64_t samples(int cascade) const;
    /// The first failure is the last word.
    template <class T>
    Result<T> or_fail(Result<T> result);

    const SeaCoursePtr course_;
    const Readback readback_;
    CourseSynthesis device_;
    /// Of the stream: where one sea follows another, both have keyframes at a time, each in its own order.
    struct EpochFoam {
        std::uint32_t epoch;
        FoamMaps maps;
    };
    std::vector<EpochFoam> streamed_foam_; ///< two at most, the later one last
    struct AskedFoam {
        FoamMaps maps;
        std::weak_ptr<const void> turn = {}; ///< KeyframeJob::turn_
    };
    AskedFoam& foam_of(Walk walk) { return walk == Walk::starts ? started_foam_ : asked_foam_; }
    AskedFoam started_foam_;
    AskedFoam asked_foam_;
    const std::shared_ptr<SpareBuffers> joined_ =
        std::make_shared<SpareBuffers>(); ///< for joined()
    KeyframeStore store_;
    std::optional<Error> failure_;
    std::atomic<bool> failed_ = false;

    mutable std::mutex mutex_; ///< of what follows
    std::string description_;
    SynthesisCounters synthesis_;
    EffectCosts costs_;
    std::uint64_t device_rebuilds_ = 0;
};

} // namespace seaway::server
