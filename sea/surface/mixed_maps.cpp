// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/mixed_maps.h"

#include <new>

#include "sea/surface/surface.h"

namespace seaway::sea {

MixedMaps::Lent::~Lent() {
    if (of_ == nullptr)
        return;
    const std::scoped_lock lock(of_->mutex_);
    --of_->users_;
}

bool MixedMaps::has_room_for(const Surface& surface) {
    for (std::size_t c = 0; c < surface.pairs().size(); ++c) {
        const std::size_t texels = surface.pairs()[c].before->texels();
        if (texels <= texels_[c])
            continue;
        texels_[c] = 0;
        try {
            maps_[c] = allocate_floats(texels * spline_channel::mixed);
        } catch (const std::bad_alloc&) {
            return false;
        }
        texels_[c] = texels;
    }
    return true;
}

void MixedMaps::lend(const Surface& surface, TimeUs time_us, std::size_t points,
                     const PointKernel& kernel, Lent& lent) {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock)
        return;
    if (surface_ != surface.number() || time_us_ != time_us) {
        if (users_ > 0)
            return;
        surface_ = surface.number();
        time_us_ = time_us;
        points_ = 0;
        mixed_ = false;
    }
    points_ += points;
    if (!mixed_ && points_ < pays_from_points)
        return;
    if (!mixed_) {
        if (!has_room_for(surface))
            return;
        surface.mix(time_us, kernel, maps_);
        mixed_ = true;
    }
    ++users_;
    lent.of_ = this;
}

} // namespace seaway::sea
