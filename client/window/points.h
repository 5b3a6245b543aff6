// SPDX-License-Identifier: Apache-2.0
// What a window asks about points of the sea that it shows.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "client/client.h"
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

/// The same of a client, which knows what it may not have been told: what Client::sample() says, as long as it has an answer.
class ClientPoints final : public Points {
  public:
    ClientPoints(std::shared_ptr<const Client> client, LocalSurface held)
        : client_(std::move(client)), held_(std::move(held)) {}
    sea::Answer answer(const sea::QueryPoint& point) const override {
        const Result<std::vector<sea::Answer>> sampled = client_->sample({&point, 1});
        return sampled ? sampled->front() : held_.answer(point);
    }
    bool covers(sea::TimeUs time_us) const override { return held_.covers(time_us); }

  private:
    const std::shared_ptr<const Client> client_;
    const HeldPoints held_;
};

} // namespace seaway::client
