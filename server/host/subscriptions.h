// SPDX-License-Identifier: Apache-2.0
// Subscriptions: who was granted what, kept once for the whole server. The simulation computes the
// union, the world publishes and the encoder encodes the qualities that someone has, each session
// is sent its own.
//
// Thread-safe.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "sea/basics/field.h"
#include "sea/basics/time.h"
#include "server/host/quality.h"

namespace seaway::server {

using SessionId = std::uint64_t;

/// What someone wants of the sea, and what is granted: the same shape, two different values.
struct Demand {
    std::uint32_t cascades = 0; ///< bit c
    sea::FieldSet fields;
    float error_m = 0; ///< bound on height, all parts together; 0: the server chooses
    /// Granted only: the quality rung of the session. It is sent the published KeyframeTiles of the
    /// same rung, of its cascades, and of those the fields that it was granted.
    Quality quality = 0;
    /// Takes linear maps at the smallest grid that carries their waves. Of a wish: the rung says it of a grant.
    bool compact = false;
    /// And differences to what follows from earlier ones. Likewise.
    bool predicted = false;
    /// The highest rate of keyframes of a cascade, Hz, and the largest side of a map; 0: any. Granted: what it will be,
    /// where that is less than all there is.
    float rate_hz_max = 0;
    int size_max = 0;
    /// Granted only: fields that are the session's, too, but are not sent: they follow from those that are.
    sea::FieldSet follows = {};
    /// Granted only: in what it is less than the wish; empty: in nothing. An empty grant: why.
    std::string why = {};
    bool busy = false; ///< Granted only, and empty: asking again later may help.
    /// Of a wish: of coarser maps such as somebody has, since its address has as many kinds as it may have.
    bool shared_only = false;
    /// Granted only: other coarser maps than were wished for, as long as others have so many kinds.
    bool crowded = false;
    /// Granted only: the sea time from which on it is worth looking whether the same wish would get something else.
    sea::TimeUs until_us = std::numeric_limits<sea::TimeUs>::max();
    /// Of a wish: it is a grant's of this quality, and stays at its rate, where seas have changed.
    bool renewed = false;

    bool grants_as(const Demand& other) const {
        return cascades == other.cascades && fields == other.fields && follows == other.follows &&
               quality == other.quality;
    }

    /// The same with the limits of another.
    Demand limited_as(const Demand& other) const {
        Demand limited = *this;
        limited.rate_hz_max = other.rate_hz_max;
        limited.size_max = other.size_max;
        return limited;
    }
    bool wants(int cascade) const { return ((cascades >> cascade) & 1u) != 0; }
    bool empty() const { return cascades == 0 || fields.empty(); }
};

class Subscriptions {
  public:
    /// Called after every change, on the thread that made it; before any change is made.
    void on_change(std::function<void()> changed) { changed_ = std::move(changed); }

    /// Sets or replaces what a session was granted; an empty grant takes it away.
    void set(SessionId session, const Demand& grant);
    /// Takes no memory: a session may end because there is none.
    void erase(SessionId session);

    std::optional<Demand> find(SessionId session) const;
    std::size_t size() const;

    /// Union of what is wanted of a cascade, at any quality and at one; there without what of each grant follows from the rest of it,
    /// of fields that may follow.
    sea::FieldSet wanted(int cascade) const;
    sea::FieldSet wanted(int cascade, Quality quality, sea::FieldSet may_follow = {}) const;
    /// The same of those who take keyframes at most at a rate, one a rung of rates.
    std::array<sea::FieldSet, rate_rungs_hz.size()> wanted_by_rate(int cascade) const;
    /// Rungs at which somebody wants a cascade, those with most readers first; of those with as many each in turn, by a number that is
    /// another one each time: where not all can be served none of them is the one that never is.
    std::vector<Quality> most_wanted(int cascade, std::uint64_t turn = 0) const;
    /// Rungs at which anybody (`but` one) wants any, without a look at each session, as each session asks for it when grants are renewed.
    std::bitset<quality_rungs> qualities() const { return qualities_but({}); }
    std::bitset<quality_rungs> qualities_but(std::optional<SessionId> session) const;
    /// The same of those who do not want a field.
    sea::FieldSet wanted_without(int cascade, sea::Field field) const;

  private:
    template <class Includes>
    sea::FieldSet union_of(const Includes& includes) const;

    std::function<void()> changed_;
    mutable std::mutex mutex_;
    std::map<SessionId, Demand> grants_;
    std::array<std::size_t, quality_rungs> of_quality_{}; ///< how many have each
};

} // namespace seaway::server
