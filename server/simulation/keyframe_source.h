// SPDX-License-Identifier: Apache-2.0
// Keyframe source: any keyframe of the running sea, from the store or from the device, with foam
// where it is wanted; and what all of that has cost. What may take long - many keyframes, and a foam
// history that starts - is a KeyframeJob, worked on slice by slice.
//
// The first failure of the device that rebuilding does not mend is the last word: from then on every
// call gives that same error, of kind Refusal::gone. For one thread, except report() and failed().
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
#include "sea/surface/surface.h"
#include "server/device/rebuilt_synthesizer.h"
#include "server/simulation/effect_costs.h"
#include "server/simulation/foam_maps.h"
#include "server/simulation/keyframe_store.h"
#include "server/simulation/running_sea.h"

namespace seaway::server {

using SurfacePtr = std::shared_ptr<const sea::Surface>;

/// Two walks through time, each with foam histories of its own: the stream goes step by step,
/// questions jump to where someone asks.
enum class Walk { stream, questions };

/// Samples of one field that a slice makes, at most where one keyframe has not more: 32 of 256 x 256,
/// some 50 ms on two cores. A tick of foam counts as foam_tick_fields.
inline constexpr std::int64_t samples_per_slice = 1 << 21;
inline constexpr std::int64_t foam_tick_fields = 4;

/// Keyframes that are being made: one a request, in order, with at least its fields.
class KeyframeJob {
  public:
    KeyframeJob(std::vector<KeyframeRequest> wanted, Walk walk)
        : wanted_(std::move(wanted)), walk_(walk), found_(wanted_.size()) {}

    /// All of them, once KeyframeSource::work_on() has said that they are made.
    std::vector<sea::KeyframePtr> take() { return std::move(found_); }

  private:
    friend class KeyframeSource;
    struct Missing {
        std::size_t place;
        KeyframeRequest request;  ///< with the fields that are held, so that none is lost
        sea::KeyframePtr foam_of; ///< a keyframe whose map of foam is taken over, or null
        bool walks_foam() const {
            return request.fields.contains(sea::Field::foam) && foam_of == nullptr;
        }
    };
    struct WithoutFoam {
        std::size_t place;
        NewKeyframePtr keyframe;
    };

    std::vector<KeyframeRequest> wanted_;
    Walk walk_;
    std::vector<sea::KeyframePtr> found_;
    bool begun_ = false;
    std::deque<Missing> missing_;
    std::deque<WithoutFoam> without_foam_; ///< made but for their foam, in order
    std::shared_ptr<const void> turn_;     ///< held by the one job whose foam is walked for
};

class KeyframeSource {
  public:
    KeyframeSource(RunningSeaPtr sea, std::unique_ptr<RebuiltSynthesizer> device);

    /// One slice; true: all are made. Of several jobs of Walk::questions that need foam one gets on
    /// at a time, the others wait until it is made or gone.
    Result<bool> work_on(KeyframeJob& job);

    /// All at once, for what needs no foam.
    Result<std::vector<sea::KeyframePtr>> keyframes(std::vector<KeyframeRequest> wanted);

    /// Ticks that the stream's foam of a cascade is away from a time.
    int foam_ticks_to(int cascade, sea::TimeUs time_us) const;
    /// A slice of them; true: none is left.
    Result<bool> walk_streamed_foam(int cascade, sea::TimeUs time_us);
    /// The questions' foam goes on from where the stream's is.
    void share_streamed_foam(int cascade);

    /// From the keyframes of every cascade around a time; holds its times up to, without, `end_us`.
    struct SurfaceSpan {
        SurfacePtr surface;
        sea::TimeUs end_us;
    };
    Result<SurfaceSpan> surface_around(sea::TimeUs time_us);

    /// Why there are no more keyframes.
    const std::optional<Error>& failure() const { return failure_; }
    bool failed() const { return failed_; } ///< any thread

    struct Report {
        std::string device;
        SynthesisCounters synthesis;
        StoreCounters store;
        EffectCosts costs;
        std::uint64_t device_rebuilds = 0;
    };
    Report report() const;

  private:
    void look_up(KeyframeJob& job);
    Result<bool> slice(KeyframeJob& job);
    bool takes_its_turn(KeyframeJob& job);
    Result<void> synthesize_some(KeyframeJob& job, std::int64_t& budget);
    Result<void> add_foam(KeyframeJob& job, std::int64_t& budget);
    void keep(KeyframeJob& job, std::size_t place, sea::KeyframePtr keyframe);
    Result<bool> walk(FoamMaps& foam, int cascade, sea::TimeUs time_us, std::int64_t& budget,
                      const sea::FoamHistory::StrainsAt& strains_at);

    /// `asked`: the same requests without what foam stands on; for the accounts.
    Result<std::vector<NewKeyframePtr>> synthesize(std::span<const KeyframeRequest> requests,
                                                   std::span<const KeyframeRequest> asked);
    Result<sea::KeyframePtr> strains(int cascade, sea::TimeUs time_us);
    /// Puts the time that `work` on foam takes, but for its transforms, on the accounts.
    template <class Work>
    auto timed(int cascade, const Work& work);
    std::int64_t samples(int cascade) const;
    /// The first failure is the last word.
    template <class T>
    Result<T> or_fail(Result<T> result);

    const RunningSeaPtr sea_;
    const std::unique_ptr<RebuiltSynthesizer> device_;
    FoamMaps streamed_foam_;
    FoamMaps asked_foam_;
    std::weak_ptr<const void> asked_foam_turn_; ///< KeyframeJob::turn_
    double synthesis_s_ = 0;                    ///< spent waiting for the device
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
