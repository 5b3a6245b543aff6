// SPDX-License-Identifier: Apache-2.0
// What a window asks about points of the sea that it shows.
#pragma once

#include <memory>
#include <utility>

#include "client/local_surface.h"

namespace seaway::client {

/// Immutable; thread-safe.
class Points {
  public:
    virtual ~Points() = default;
    virtual sea::Answer answer(const sea::QueryPoint& point) const = 0;
    /// Answers about this time have a bound.
    virtual bool covers(sea::TimeUs time_us) const = 0;
};
using PointsPtr = std::shared_ptr<const Points>;

/// Of keyframes that are held.
class HeldPoints final : public Points {
  public:
    explicit HeldPoints(LocalSurface held) : held_(std::move(held)) {}
    sea::Answer answer(const sea::QueryPoint& point) const override {
        return held_.surface.answer(point);
    }
    bool covers(sea::TimeUs time_us) const override {
        return held_.covers && held_.surface.covers(time_us);
    }

  private:
    LocalSurface held_;
};

} // namespace seaway::client
