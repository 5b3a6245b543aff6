// SPDX-License-Identifier: Apache-2.0
// Requests: numbers requests, holds back those beyond what the server takes at once, matches
// replies, and watches deadlines. Bookkeeping alone: no sockets, no clock of its own.
//
// Three lanes, because a server answers queries, sends bulk (fetches, starts of subscriptions) and sends spectra
// with different limits. A request whose deadline has passed is reported to whoever asked; its
// place stays taken until the server has answered, because there it is still being worked on.
//
// Thread-safe. Handlers are called without the lock held, each exactly once, by the thread that
// brings the reply, the deadline or the end.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "base/result.h"
#include "protocol/messages.h"

namespace seaway::client {

/// What a subscription will get.
struct Grant {
    std::uint32_t cascades = 0;
    sea::FieldSet fields;
    float error_m = 0; ///< bound on height that these tiles give, all parts together
    int credit = 0;
    std::string why = {};  ///< in what it is less than the wish; empty: in nothing
    float rate_hz_max = 0; ///< keyframes of a cascade a second, at most; 0: all there are
    int size_max = 0;      ///< side of a map, at most; 0: maps are not cut
};

/// What came back; each kind of request fills its own part.
struct Reply {
    std::uint32_t epoch = 0;            ///< query
    std::vector<sea::Answer> answers;   ///< query: one a point, in order
    std::vector<sea::WaterBelow> below; ///< query: one a depth
    bool chose_waves = false;           ///< query: the server says which cascades counted
    Grant grant;                        ///< subscribe
    std::uint32_t keyframes = 0;        ///< subscribe, fetch: how many were sent at once
    sea::FieldSet fields;               ///< subscribe, fetch: fields of those
    protocol::SpectrumGrant spectrum;   ///< subscribe_spectrum
    sea::TimeUs start_us = 0;           ///< change: the sea glides (epoch) from here on
    sea::TimeUs end_us = 0;             ///< change: and is there (epoch + 1)
    std::uint32_t change = 0;           ///< change: its number in the journal; 0: there is none
    std::string text;                   ///< administer: JSON
};

using ReplyHandler = std::function<void(Result<Reply>)>;

enum class Lane { query, bulk, spectrum };

class Requests {
  public:
    /// Below the server's own limits (protocol/limits.h), so that none is refused for its number.
    static constexpr int queries_in_flight_max = 8;
    static constexpr int bulk_in_flight_max = 1;
    static constexpr int spectra_in_flight_max = 1;
    static constexpr std::size_t waiting_max = 4096;

    using TimeUs = std::int64_t; ///< local, monotonic
    using Encode = std::function<protocol::Bytes(std::uint32_t request_id)>;
    using Send = std::function<bool(std::uint32_t request_id, protocol::Bytes)>;

    /// `send` is called from start() and release(), without the lock held.
    explicit Requests(Send send) : send_(std::move(send)) {}
    /// What is still open fails.
    ~Requests();
    Requests(const Requests&) = delete;
    Requests& operator=(const Requests&) = delete;

    /// Sends it, or keeps it until a place is free. `fields`: of bulk, what it waits for.
    void start(Lane lane, const Encode& encode, TimeUs deadline_us, ReplyHandler handler,
               sea::FieldSet fields = {});

    /// The grant of a subscription: kept for its reply, and its fields are what it waits for.
    void note_grant(std::uint32_t request_id, const Grant& grant);

    /// The reply of the server: calls the handler, frees the place. False if nothing with this
    /// number is open in this lane.
    bool finish(Lane lane, std::uint32_t request_id, Result<Reply> reply);

    /// A Refused: of whichever lane. A subscription that has its grant is not lost with the
    /// keyframes that it would have begun with: it succeeds without them.
    bool refuse(std::uint32_t request_id, const Error& error);

    /// The fields that each open request of the bulk lane waits for.
    std::vector<sea::FieldSet> bulk_fields() const;

    /// Nobody will answer those of this lane, which fail with this, open ones and waiting ones; it takes new ones.
    void abandon(Lane lane, const Error& error);

    void expire(TimeUs now_us);

    /// Everything open fails with this, and everything that is started from now on.
    void fail_all(const Error& error);

  private:
    struct Open {
        Lane lane;
        TimeUs deadline_us;
        ReplyHandler handler; ///< empty once its deadline has passed
        sea::FieldSet fields;
        Grant grant;
    };
    struct Waiting {
        std::uint32_t request_id;
        protocol::Bytes message;
        TimeUs deadline_us;
        ReplyHandler handler;
        sea::FieldSet fields;
    };
    struct LaneState {
        int in_flight = 0;
        std::deque<Waiting> waiting;
    };

    std::size_t handlers_held() const; ///< mutex_ held; no more than that
    LaneState& state(Lane lane) { return lanes_[static_cast<std::size_t>(lane)]; }
    static int places(Lane lane) {
        switch (lane) {
        case Lane::query:
            return queries_in_flight_max;
        case Lane::bulk:
            return bulk_in_flight_max;
        case Lane::spectrum:
            break;
        }
        return spectra_in_flight_max;
    }
    void send_waiting(Lane lane);
    /// Calls the handler and frees the place, which is not given to another. False: see finish().
    bool settle(Lane lane, std::uint32_t request_id, Result<Reply> reply);

    const Send send_;
    mutable std::mutex mutex_;
    std::uint32_t last_id_ = 0;
    std::map<std::uint32_t, Open> open_;
    LaneState lanes_[3];
    std::optional<Error> end_; ///< why nothing is taken any more
};

} // namespace seaway::client
