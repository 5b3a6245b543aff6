// SPDX-License-Identifier: Apache-2.0
// Subscriptions: who was granted what, kept once for the whole server. The simulation computes the
// union, the world publishes and the encoder encodes the qualities that someone has, each session
// is sent its own.
//
// Thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>

#include "sea/basics/field.h"

namespace seaway::server {

using SessionId = std::uint64_t;

/// What someone wants of the sea, and what is granted: the same shape, two different values.
struct Demand {
    std::uint32_t cascades = 0; ///< bit c
    sea::FieldSet fields;
    float error_m = 0; ///< bound on height, all parts together; 0: the server chooses
    /// Granted only: the quality rung of the session. It is sent the published KeyframeTiles of the
    /// same rung, of its cascades, and of those the fields that it was granted.
    std::uint8_t quality = 0;
    /// Takes linear maps at the smallest grid that carries their waves. Of a wish: the rung says it of a grant.
    bool compact = false;
    /// Granted only: fields that are the session's, too, but are not sent: they follow from those that are.
    sea::FieldSet follows = {};

    bool wants(int cascade) const { return ((cascades >> cascade) & 1u) != 0; }
    bool empty() const { return cascades == 0 || fields.empty(); }
};

class Subscriptions {
  public:
    /// Called after every change, on the thread that made it; before any change is made.
    void on_change(std::function<void()> changed) { changed_ = std::move(changed); }

    /// Sets or replaces what a session was granted; an empty grant takes it away.
    void set(SessionId session, const Demand& grant);
    void erase(SessionId session) { set(session, {}); }

    std::optional<Demand> find(SessionId session) const;
    std::size_t size() const;

    /// Union of what is wanted of a cascade, at any quality and at one.
    sea::FieldSet wanted(int cascade) const;
    sea::FieldSet wanted(int cascade, std::uint8_t quality) const;
    /// The same of those who do not want a field.
    sea::FieldSet wanted_without(int cascade, sea::Field field) const;

  private:
    template <class Includes>
    sea::FieldSet union_of(const Includes& includes) const;

    std::function<void()> changed_;
    mutable std::mutex mutex_;
    std::map<SessionId, Demand> grants_;
};

} // namespace seaway::server
