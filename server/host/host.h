// SPDX-License-Identifier: Apache-2.0
// Host: all that server/net knows of the simulation, and all that the simulation knows of the net.
// server/net never includes server/simulation; the two meet here, in values and callbacks
// (docs/architecture.md). A gateway would be server/net with another Host.
//
// Host is called from the net thread and must return at once; its callbacks may come on any thread.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "sea/basics/dispersion.h"
#include "sea/basics/field.h"
#include "sea/basics/pace.h"
#include "sea/surface/answer.h"
#include "sea/surface/maps/keyframe.h"
#include "server/host/asker.h"
#include "server/host/encoded_spectrum.h"
#include "server/host/memory.h"
#include "server/host/refusal.h"
#include "server/host/sea_wish.h"
#include "server/host/subscriptions.h"

namespace seaway::server {

/// Immutable bytes of one complete wire message, shared by all sessions that send it.
using SharedBytes = std::shared_ptr<const std::vector<std::uint8_t>>;

/// One keyframe to be encoded and sent. `codec_error` is the bound for each contained field in
/// table order, in the field's unit; 0 is lossless. A keyframe wanted at several qualities is
/// published once for each.
struct KeyframeTiles {
    sea::KeyframePtr keyframe;
    std::vector<float> codec_error;
    Quality quality = 0;
    /// Grid points a side that its linear maps are sent with; 0: as many as they have.
    int compact_size = 0;
    /// What is not sent because it follows from what is.
    sea::FieldSet follows = {};
    /// What they miss beside what the sea says of its maps; none: nothing.
    sea::CoarserLoss coarser = {};
    /// By which its heights follow from those of the keyframe before; none: they are sent by themselves.
    std::optional<sea::WaveLaw> law = {};
    /// So many of the qualities at which it is wanted have more readers: they go first.
    std::size_t rank = 0;
};

struct QueryBatch {
    bool exact = false;
    std::vector<sea::QueryPoint> points;
    Asker asker;
    sea::Looking looking = {};    ///< which waves count
    std::vector<double> z_m = {}; ///< none, or one a point: the water there as well, by exact sums
};

struct QueryAnswers {
    std::uint32_t epoch = 0;
    std::vector<sea::Answer> answers;        ///< one a point, in order
    std::vector<sea::WaterBelow> below = {}; ///< one a depth
    /// Those that counted, a bit each, where the batch says which should; none: they all did.
    std::optional<std::uint32_t> cascades = {};
};

struct FetchRequest {
    /// The two keyframes of each cascade around each time. Empty: what a new subscriber needs, from
    /// the keyframe before now to the newest published one, so that the stream continues it without
    /// a gap (subscribe first, then fetch this).
    std::vector<sea::TimeUs> times_us;
    Demand demand;
    Asker asker;
};

/// What a fetch brings, part by part: as much of it as the server makes at a time.
struct FetchedPart {
    std::vector<KeyframeTiles> tiles;
    bool last = true;
};

struct SpectrumRequest {
    SpectrumDemand wish;
    Asker asker;
    /// False: the wish is one of before, and this is what it is sent of later seas. It costs its asker nothing.
    bool asked = true;
    /// Epochs whose waves it has: they are left out, and the sea that such a glide ends in.
    std::vector<std::uint32_t> has = {};
};

/// Bytes of a long answer, made while they are sent. For one reader.
class ByteSource {
  public:
    virtual ~ByteSource() = default;
    /// Of the whole answer.
    virtual std::uint64_t size() const = 0;
    /// The next bytes, in order. Empty: not ready, `on_ready` of the request will be called; or failed().
    virtual std::vector<std::uint8_t> next() = 0;
    /// There will be no more, though not all has come.
    virtual bool failed() const { return false; }
};

/// A bulk map wanted: the parameters as they came, by name (docs/protocol.md).
struct MapQuery {
    std::map<std::string, std::string> parameters;
    Asker asker;
    std::function<void()> on_ready; ///< any thread; must not block
};

/// Does the simulation come on, and is its sea for certain that of all servers of the same log? `why` not: one line for an
/// operator.
struct Health {
    bool live = true;
    std::string why;
    bool ready = true; ///< of one that is live
    std::string
        in_general; ///< why it is not ready, for anybody: no name, number or word of another program
};

class Host {
  public:
    explicit Host(MemoryPtr memory = std::make_shared<Memory>()) : memory_(std::move(memory)) {}
    virtual ~Host() = default;

    /// What all that is held for those who ask is taken of.
    const MemoryPtr& memory() const { return memory_; }

    virtual sea::TimeUs sea_time_us() const = 0;
    /// With the time since the epoch, of one moment.
    virtual sea::SeaTime sea_time() const { return sea_time_us(); }

    /// What a session is told first: the paces of the sea that hold and are to come, if it has any, and the wire message
    /// SeaState of the sea that runs (and of the next one, if announced).
    virtual std::vector<SharedBytes> sea_state_messages() const = 0;
    /// The same of one epoch, of which keyframes have been handed out; null: everybody knows it.
    virtual SharedBytes sea_state_message(std::uint32_t /*epoch*/) const { return nullptr; }

    /// Changes the sea that runs (server/host/sea_wish.h), once that is durable. Not every host's sea can change. An error is of a
    /// wish that was refused before it came here: `done` has it, and it is counted like others.
    using Changed = std::function<void(Result<SeaPromise>)>;
    virtual void change(Result<SeaWish> wish, Changed done) {
        done(wish ? Error{Refusal::not_offered, "this sea cannot change"} : wish.error());
    }

    /// What of a wish can be had; empty if nothing that was asked for is offered, or if it is `busy`. Of the sea that
    /// runs and of those that were announced. As if a session to whose grant it takes the place had none.
    virtual Demand grant(const Demand& wish, std::optional<SessionId> instead_of = {}) const = 0;

    /// Who was granted what: kept here once, by who grants. The keyframes of a grant come through
    /// the publisher from now on.
    Subscriptions& subscriptions() { return subscriptions_; }
    const Subscriptions& subscriptions() const { return subscriptions_; }

    // Each of these is answered once, by what was asked for or by why not: an Error of kind Refusal.
    // Who has gone meanwhile is answered gone, without any work for it.

    /// Keyframes for the caller to encode, in parts, all of which but the last one may be followed by
    /// an error. The caller lets each keyframe go as soon as it is encoded: while he holds much,
    /// nothing more is made.
    using Fetched = std::function<void(Result<FetchedPart>)>;
    virtual void fetch(FetchRequest request, Fetched done) = 0;

    using Queried = std::function<void(Result<QueryAnswers>)>;
    virtual void query(QueryBatch batch, Queried done) = 0;

    /// A whole grid at one time, in bounded chunks. Not every host makes maps.
    using Mapped = std::function<void(Result<std::unique_ptr<ByteSource>>)>;
    virtual void map(MapQuery, Mapped done) { done(Error{Refusal::not_offered, "no maps here"}); }
    /// Bytes of the map that these parameters ask for, or what is wrong with them; at once.
    virtual Result<std::uint64_t> map_bytes(const std::map<std::string, std::string>&) const {
        return Error{Refusal::not_offered, "no maps here"};
    }

    /// The waves themselves, encoded once a rung. Called on a thread of its own, which it may hold for as long as
    /// that takes: 0.05 s, of the largest seas some seconds; that is priced as questions are, and refused as busy where
    /// the asker's budget is spent or there is no memory for it. Not every host has a sea of waves.
    virtual Result<GrantedSpectrum> spectrum(const SpectrumRequest&) {
        return Error{Refusal::not_offered, "no spectra here"};
    }
    /// The same at once, from the net thread, where all of it is made already; none: it has to be asked for.
    virtual std::optional<GrantedSpectrum> held_spectrum(const SpectrumRequest&) { return {}; }

    /// The changes of the sea's journal from that number on, as JSON, some hundred at most; and the scene of one, which its timetable has
    /// led to by now, with the rows that are to come. Not every host has a journal.
    virtual Result<std::string> history(std::uint64_t /*from*/) const {
        return Error{Refusal::not_offered, "this sea has no journal"};
    }
    virtual Result<std::string> scene_of_change(std::uint64_t /*number*/) const {
        return Error{Refusal::not_offered, "this sea has no journal"};
    }

    /// Bodies of /v1/state and /v1/plan (JSON) and the simulation's part of /metrics (Prometheus).
    virtual std::string state_json() const = 0;
    virtual std::string plan_json() const = 0;
    virtual std::string metrics_text() const = 0;
    virtual Health health() const = 0;

  protected:
    MemoryPtr memory_;

  private:
    Subscriptions subscriptions_;
};

} // namespace seaway::server
