// SPDX-License-Identifier: Apache-2.0
// Client: what a program keeps of a sea while it is connected - the clock, the sea states, the
// keyframes - and its two ways to ask for heights: the server answers, or the client does.
//
//     Result<std::unique_ptr<Client>> client = Client::connect({.url = "ws://localhost:8080"});
//     if (!client)
//         return report(client.error());
//     const sea::QueryPoint point{10, 20, (*client)->now_us()};
//     // The server answers:
//     Result<std::vector<sea::Answer>> asked = (*client)->ask({&point, 1}, Asking{});
//     // The client does, once it has subscribed, as often as wanted:
//     (*client)->subscribe({.fields = sea::surface_fields}, 2, 10);
//     Result<std::vector<sea::Answer>> sampled = (*client)->sample({&point, 1});
//
// Thread-safe. Functions that block say so and must not be called from an event. A connection that
// has ended stays ended: what is held can still be sampled, and the owner may make a new client.
#pragma once

#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "client/held/keyframe_ring.h"
#include "client/link/clock.h"
#include "client/link/connection.h"
#include "client/local_surface.h"
#include "client/rebuilt/gliding_sea.h"
#include "client/rebuilt/rebuilt_sea.h"
#include "client/rebuilt/received_spectrum.h"

namespace seaway::client {

/// On the connection's thread; must not block. Any may be left empty.
struct ClientEvents {
    std::function<void(const SeaStatePtr&)> on_sea_state{};
    std::function<void(const HeldKeyframePtr&)> on_keyframe{};
    std::function<void(const Error& reason)> on_closed{};
};

struct Asking {
    bool exact = false;    ///< direct sum in double precision by the server; slow
    double timeout_s = 10; ///< for each batch that the points are split into
};

class Client {
  public:
    /// Blocks until the sea is known, `options.timeout_s` at most.
    static Result<std::unique_ptr<Client>>
    connect(const ConnectOptions& options, ClientEvents events = {}, RingLimits limits = {});
    ~Client();
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;

    bool is_open() const { return connection_->is_open(); }
    /// Why the connection ended, and for how long the server wants nobody to come back (link/reconnect.h); nothing
    /// while it is open.
    std::optional<Error> end() const;
    std::string closed_reason() const; ///< the same in words; empty while it is open
    const Welcome& welcome() const { return connection_->welcome(); }

    /// Sea time by the filtered clock: never runs backwards.
    sea::TimeUs now_us();
    ClockStatus clock() const;

    /// The sea that runs at this time (the first known one before it began). Never null.
    SeaStatePtr sea_state(sea::TimeUs time_us) const;

    /// Has tiles streamed from now on; an earlier subscription is replaced. Blocks until the
    /// keyframes around now are held. An error (refused) says why nothing is granted.
    Result<Grant> subscribe(const protocol::TileWish& wish, int credit, double timeout_s);
    void unsubscribe() { connection_->unsubscribe(); }
    /// What the last subscription gets now: a change of the sea may make its bound another.
    std::optional<Grant> grant() const;

    /// Has the waves themselves sent, of the sea that runs and of every later one: some 60 KB each, then nothing;
    /// points are answered from them at any time, from the first of them on with what is still missed in
    /// `error_m`. Blocks until all of the present have come and agree with the server's probes. Errors:
    /// refused, and not_held for a sea that is another than the one announced.
    Result<protocol::SpectrumGrant> subscribe_spectrum(const protocol::SpectrumWish& wish,
                                                       double timeout_s);
    /// What is held stays.
    void unsubscribe_spectrum() { connection_->unsubscribe_spectrum(); }

    /// The server answers: any number of points, split into batches, in order. Blocks.
    Result<std::vector<sea::Answer>> ask(std::span<const sea::QueryPoint> points,
                                         const Asking& asking);

    /// The same for a batch the server takes at once; does not block (Connection::query).
    void ask_async(std::span<const sea::QueryPoint> points, const Asking& asking,
                   ReplyHandler handler) {
        connection_->query(points, asking.exact, asking.timeout_s, std::move(handler));
    }

    /// This client answers from what it holds; at once, never asks the server. Points of equal or
    /// near times should stand together. About 1 us a point, 3 ms more for a new keyframe; of a sea
    /// that it has rebuilt, at any time, what client/rebuilt/rebuilt_sea.h says.
    Result<std::vector<sea::Answer>> sample(std::span<const sea::QueryPoint> points) const;

    /// Makes the sea that runs at this time from the scene that the server sent, and holds it against the
    /// server's probes; from then on its points are answered from its waves. Blocks, never asks the server.
    /// Errors: rebuild_from_scene().
    Result<void> rebuild(sea::TimeUs time_us);

    /// The surface around a time from what is held: for renderers and for many points.
    Result<LocalSurface> surface(sea::TimeUs time_us) const;

    /// Fetches the keyframes around these times that are not held, with the fields that sampling
    /// needs and those of `also` that the server offers. Blocks. What came to the ring first makes
    /// room, never what these times need; more times than the ring has room for are an error.
    Result<void> hold(std::span<const sea::TimeUs> times_us, double timeout_s,
                      sea::FieldSet also = {});

    /// Samples any number of points at any number of times, in order: fetches what is not held and
    /// keeps it until its points are answered, whatever else comes. Blocks. Only as many keyframes
    /// are asked for at once as the ring has room for. An answer without keyframes on both sides
    /// is an error here.
    Result<std::vector<sea::Answer>> fetch_and_sample(std::span<const sea::QueryPoint> points,
                                                      double timeout_s);

    const KeyframeRing& ring() const { return ring_; }

  private:
    Client(ClientEvents events, RingLimits limits);
    ConnectionEvents connection_events();
    sea::FieldSet sampled_fields() const { return offered(sea::surface_fields); }
    /// Without what the server is known not to offer.
    sea::FieldSet offered(sea::FieldSet fields) const;
    /// Notes what the server does not offer, so that it is not waited for.
    void note_offer(sea::FieldSet asked, sea::FieldSet granted);

    /// Keyframes that somebody waits for, kept for him whatever the ring drops.
    class Wanted;
    /// Intervals of every cascade whose keyframes the ring has room for at once.
    std::size_t cells_at_once(const SeaState& state, sea::FieldSet fields) const;
    /// The longest run of points in one sea, from `first` on in `order`, that needs no more.
    std::size_t batch_end(std::span<const sea::QueryPoint> points,
                          std::span<const std::size_t> order, std::size_t first,
                          std::vector<sea::TimeUs>& times_us) const;
    /// Fetches the keyframes around all of these times, in as many requests as the server takes.
    Result<void> fetch(std::span<const sea::TimeUs> times_us, sea::FieldSet fields,
                       double timeout_s);
    /// hold(), once. False: seas are others than was known when it began.
    Result<bool> try_hold(std::span<const sea::TimeUs> times_us, double timeout_s,
                          sea::FieldSet also);
    bool seas_are(std::span<const std::pair<sea::TimeUs, SeaStatePtr>> expected) const;
    /// Null: this client has not the waves of that sea; of a glide, not those of both of its ends.
    OwnSeaPtr own_sea(const SeaStatePtr& state) const;
    /// The same with mutex_ held; `depth` more glides may lead there.
    OwnSeaPtr own_sea_held(const SeaStatePtr& state, int depth) const;
    SeaStatePtr sea_state_held(sea::TimeUs time_us) const;
    void take_waves(ConnectionEvents& events);
    void forget_waves(std::uint32_t epoch);
    /// Answers the points from `first` on that are of one rebuilt sea; where they end, `first` if there are none.
    std::size_t answer_rebuilt(std::span<const sea::QueryPoint> points, std::size_t first,
                               std::span<sea::Answer> answers) const;
    Result<std::vector<sea::Answer>> sample_from(const KeyframeRing& ring,
                                                 std::span<const sea::QueryPoint> points) const;

    const ClientEvents events_;
    KeyframeRing ring_;

    mutable std::mutex mutex_;
    ClockFilter clock_; ///< of the time since the sea's epoch
    sea::Paces paces_;
    sea::TimeUs shown_us_ = std::numeric_limits<sea::TimeUs>::min();
    std::vector<SeaStatePtr> sea_states_;            ///< by start time
    std::map<std::uint32_t, RebuiltSeaPtr> rebuilt_; ///< by epoch, of sea_states_
    std::map<std::uint32_t, std::shared_ptr<ReceivedSpectrum>>
        received_; ///< likewise; of a glide: its end
    /// A glide with the ends that it was made of.
    struct Glide {
        OwnSeaPtr from;
        OwnSeaPtr to;
        OwnSeaPtr sea;
    };
    mutable std::map<std::uint32_t, Glide> glides_; ///< likewise
    sea::FieldSet not_offered_;
    std::optional<Grant> grant_;
    std::vector<Wanted*> wanted_;
    /// What the server was found to take at once, where its tiles are larger than usual.
    std::size_t times_taken_max_ = std::numeric_limits<std::size_t>::max();
    bool cascades_apart_ = false;
    std::optional<Error> end_;

    std::unique_ptr<Connection> connection_; ///< first to go: its events use all of the above
};

} // namespace seaway::client
