// SPDX-License-Identifier: Apache-2.0
#include "client/rebuilt/received_spectrum.h"

#include <algorithm>
#include <limits>

#include "sea/basics/deviations.h"

namespace seaway::client {
namespace {

sea::SpectrumFrame frame_of(const SeaState& state, const protocol::SpectrumHead& head) {
    sea::SpectrumFrame frame;
    for (const protocol::CascadeInfo& cascade : state.cascades)
        frame.tiles.push_back({{cascade.length_m, cascade.size},
                               {cascade.k_lo_radpm, cascade.k_hi_radpm},
                               !cascade.placed_alone});
    frame.choppiness = {state.choppiness_x, state.choppiness_y};
    frame.dispersion = head.dispersion;
    frame.loop_period_us = head.loop_period_us;
    return frame;
}

} // namespace

ReceivedSpectrum::ReceivedSpectrum(SeaStatePtr state, const protocol::SpectrumHead& head)
    : state_(std::move(state)),
      builder_(sea::SpectrumBuilder::create(frame_of(*state_, head), head.steps)),
      chunks_to_come_(head.chunks) {
    if (head.chunks == 0 && builder_) // nothing is missed
        left_ = sea::SpectrumLeft{};
}

Result<void> ReceivedSpectrum::add(const sea::SpectrumLeft& left,
                                   std::span<const sea::WaveBlock> blocks) {
    const std::scoped_lock making(making_);
    if (!builder_)
        return builder_.error();
    if (chunks_to_come_ == 0)
        return Error{"more waves come than the server said"};
    --chunks_to_come_;
    for (const sea::WaveBlock& block : blocks)
        SEAWAY_TRY(builder_->add(block));
    sea_ = nullptr;
    const std::scoped_lock lock(mutex_);
    left_ = left;
    return {};
}

namespace {

/// Strain is slope, wider by what shallow water makes of displacements.
RebuiltError error_of(const sea::SpectrumLeft& left) {
    const double wider =
        left.height_m > 0 ? std::max(left.displacement_m / left.height_m, 1.0) : 1.0;
    return {sea::bound_sigmas * left.height_m, sea::bound_sigmas * left.displacement_m,
            sea::fold_sigmas * left.slope * wider};
}

} // namespace

RebuiltSeaPtr ReceivedSpectrum::sea() const {
    const std::scoped_lock making(making_);
    if (!sea_ && left_) // which adding alone changes
        sea_ = std::make_shared<const RebuiltSea>(waves(), *state_, error_of(*left_));
    return sea_;
}

sea::RealizationPtr ReceivedSpectrum::waves() const {
    if (chunks_to_come_ > 0)
        return std::make_shared<const sea::Realization>(builder_->sea());
    if (!all_) {
        auto all = std::make_shared<sea::Realization>(); // memory first, and nothing is lost
        *all = std::move(*builder_).sea();
        all_ = std::move(all);
    }
    return all_;
}

bool ReceivedSpectrum::has_come() const {
    const std::scoped_lock lock(mutex_);
    return left_.has_value();
}

double ReceivedSpectrum::left_m() const {
    const std::scoped_lock lock(mutex_);
    return left_ ? left_->height_m : std::numeric_limits<double>::infinity();
}

} // namespace seaway::client
