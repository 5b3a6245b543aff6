// SPDX-License-Identifier: Apache-2.0
// GlidingSea: a sea on its way from one whose waves this client has to another: amplitudes glide, phases go on without a
// jump (sea/waves/transition.h).
//
// Thread-safe. The waves of each new time are mixed and laid out anew: some 20 ms at three cascades of 256 x 256, so ask
// about many points of a time at once.
#pragma once

#include <mutex>

#include "client/rebuilt/rebuilt_sea.h"
#include "sea/waves/transition.h"

namespace seaway::client {

class GlidingSea final : public OwnSea {
  public:
    /// From the waves of `from` at `start_us` to those of `to` at `end_us`, whose phases are those at which the glide ends:
    /// what a server sends of a sea that has been changed to, or what goes on from `from` as `noted` in it
    /// (rebuild_from_scene()). `state` is of the glide. An error (not_held): they have other tiles.
    enum class Phases { as_sent, noted };
    static Result<std::shared_ptr<const GlidingSea>>
    create(const protocol::SeaStateValues& state, const OwnSea& from, const OwnSea& to,
           sea::TimeUs start_us, sea::TimeUs end_us, Phases phases = Phases::as_sent);

    double answer(std::span<const sea::QueryPoint> points, std::span<sea::Answer> answers,
                  std::span<sea::ErrorTerms> terms,
                  std::uint32_t cascades = sea::all_cascades) const override;
    sea::RealizationPtr waves_at(sea::TimeUs time_us) const override { return change_.at(time_us); }
    RebuiltError error() const override { return error_; }
    const sea::SeaTransition* change() const override { return &change_; }
    void at(sea::TimeUs time_us,
            const std::function<void(const RebuiltSea&)>& look) const override {
        look(*at(time_us));
    }

  private:
    GlidingSea(sea::SeaTransition change, const protocol::SeaStateValues& state,
               const RebuiltError& error)
        : change_(std::move(change)), state_(state), error_(error) {}
    std::shared_ptr<const RebuiltSea> at(sea::TimeUs time_us) const;

    const sea::SeaTransition change_;
    const protocol::SeaStateValues state_;
    const RebuiltError error_;
    struct Moment {
        sea::TimeUs time_us = 0;
        std::shared_ptr<const RebuiltSea> sea;
    };
    mutable std::mutex mutex_; ///< of what follows
    /// Those that were asked about last: a time with what the clock may be off by either way is three.
    mutable std::array<Moment, 3> moments_;
    mutable std::size_t oldest_ = 0;
};

} // namespace seaway::client
