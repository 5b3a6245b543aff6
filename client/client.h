// SPDX-License-Identifier: Apache-2.0
// Client: what a program keeps of a sea while it is connected - the clock, the sea states, the
// keyframes - and its two ways to ask for heights: the server answers, or the client does.
//
//     Result<std::unique_ptr<Client>> client = Client::connect({.url = "ws://localhost:8080"});
//     if (!client)
//         return report(client.error());
//     const sea::QueryPoint point{10, 20, (*client)->now_us()};
//     auto asked = (*client)->ask({&point, 1}, Asking{}); // the server answers
//     (*client)->subscribe({.fields = sea::surface_fields}, 2, 10);
//     auto sampled = (*client)->sample({&point, 1}); // the client does, as often as wanted
//
// A connection that is lost comes back by itself, with waits of link/reconnect.h, and what was subscribed to is subscribed
// to again, tiles and waves each for itself (ConnectOptions::stays_lost: it does not). Meanwhile what is held is sampled, on the same clock; answers about
// times of which the server may know more are flagged answer_stale (staleness.h). Whoever is turned away for good stops. A
// server that comes back with the same sea goes on with what is held; one with another sea, or another time, makes this
// client drop all of it: ClientStatus::seas counts them. What waits for a reply when the connection ends fails with lost.
//
// Thread-safe. Functions that block say so and must not be called from an event. With ConnectOptions::threadless it makes no
// thread: work_until() and functions that block do the work of the network, events among it, for one thread at a time.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/fair_mutex.h"
#include "base/result.h"
#include "client/asking.h"
#include "client/held/keyframe_ring.h"
#include "client/held_surfaces.h"
#include "client/joining.h"
#include "client/link/clock.h"
#include "client/link/connection.h"
#include "client/link/kept.h"
#include "client/link/readiness.h"
#include "client/link/reconnect.h"
#include "client/local_surface.h"
#include "client/looks.h"
#include "client/rebuilt/waves_of.h"
#include "client/sea_motion.h"
#include "client/staleness.h"
#include "client/status.h"
#include "client/subscriptions.h"
#include "client/wave_maps.h"

namespace seaway::client {

/// On a thread of the client's, or where its work is done; must not block. Any may be left empty.
struct ClientEvents {
    std::function<void(const SeaStatePtr&)> on_sea_state{};
    std::function<void(const HeldKeyframePtr&)> on_keyframe{};
    std::function<void(const Error& reason)> on_closed{}; ///< each time
    /// It is another, but for times that pass. One after the other, the last of them is what is.
    std::function<void(const ClientStatus&)> on_status{};
};

class Waiter;
struct Again;
template <class Kind>
struct RungAgain;
enum class RungState;

class Client {
  public:
    /// Blocks until the sea is known, `options.timeout_s` at most.
    static Result<std::unique_ptr<Client>>
    connect(const ConnectOptions& options, ClientEvents events = {}, RingLimits limits = {});
    ~Client();
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;

    bool is_open() const { return link()->is_open(); }
    /// Why the connection ended, and for how long the server wants nobody to come back (link/reconnect.h); nothing
    /// while it is open.
    std::optional<Error> end() const;
    std::string closed_reason() const; ///< the same in words; empty while it is open
    Welcome welcome() const { return link()->welcome(); }
    ClientStatus status() const;
    int seas() const { return seas_; } ///< as in ClientStatus

    /// Sea time by the filtered clock: never runs backwards, and without a connection goes on. Of another sea
    /// (ClientStatus::seas) it is another time.
    sea::TimeUs now_us();
    ClockStatus clock() const;

    /// The sea that runs at this time (the first known one before it began). Never null.
    SeaStatePtr sea_state(sea::TimeUs time_us) const;

    /// Has tiles streamed from now on; an earlier subscription is replaced. Blocks until the
    /// keyframes around now are held. An error (refused) says why nothing is granted.
    Result<Grant> subscribe(const protocol::TileWish& wish, int credit, double timeout_s);
    void unsubscribe();
    /// What the last subscription gets now: a change of the sea may make its bound another.
    std::optional<Grant> grant() const;

    /// Has the waves themselves sent, of the sea that runs and of every later one: some 60 KB each, then nothing;
    /// points are answered from them at any time (of the seas that it was told of), from the first of them on with what is still missed in
    /// `error_m`. Blocks until all of the present have come and agree with the server's probes. Errors:
    /// refused, and not_held for a sea that is another than the one announced.
    Result<protocol::SpectrumGrant> subscribe_spectrum(const protocol::SpectrumWish& wish,
                                                       double timeout_s);
    /// What is held stays.
    void unsubscribe_spectrum();

    /// The server answers: any number of points, split into batches, in order. Blocks.
    Result<std::vector<sea::Answer>> ask(std::span<const sea::QueryPoint> points,
                                         const Asking& asking);

    /// The same for a batch the server takes at once; does not block (Connection::query). Where it fails the handler is not called.
    Result<void> ask_async(std::span<const sea::QueryPoint> points, const Asking& asking,
                           ReplyHandler handler);

    bool threadless() const { return options_.threadless; }
    /// Of a threadless client: what there is to do, and then what comes until `done` or until then. True: `done`.
    bool work_until(std::chrono::steady_clock::time_point until, const std::function<bool()>& done);
    /// Of a threadless client: readable while there is something to do, or while `other` is.
    Result<int> descriptor_with(int other);

    /// This client answers from what it holds; at once, never asks the server. An error (not_held): there is nothing
    /// to go by. Points of equal or near times should stand together. About 1 us a point, 3 ms more for a new keyframe; of a sea
    /// that it has rebuilt, at any time, what client/rebuilt/rebuilt_sea.h says.
    Result<std::vector<sea::Answer>> sample(std::span<const sea::QueryPoint> points) const;
    /// The same into the caller's memory, as many answers as points; of an error they are anything. From keyframes that came since
    /// somebody sampled it allocates nothing, but what a search for sheets keeps for the next one of its thread.
    Result<void> sample_into(std::span<const sea::QueryPoint> points,
                             std::span<sea::Answer> answers, const Sampling& how = {}) const;

    /// Makes the sea that runs at this time from the scene that the server sent, and holds it against the
    /// server's probes; from then on its points are answered from its waves. Of a glide: both ends. Blocks, never asks the server.
    /// Changes that come after are followed by the client, unless it is threadless or stays lost. Errors: rebuild_from_scene();
    /// not_held: what a glide begins with is not known here (hold() a time before it).
    Result<void> rebuild(sea::TimeUs time_us);

    /// Whether the sea of this time is known without asking: not before the first that it was told of, and no further ahead than a
    /// server has told of every change (an interval of keyframes and a second). Of other times hold() brings what is to be known.
    bool knows_sea_of(sea::TimeUs time_us) const;

    /// Where sample() of this time has its answers from.
    SourceNow source(sea::TimeUs time_us) const;

    /// sample() with all that is known of a point, of some of the waves (looks.h). Errors as sample().
    Result<std::vector<Water>> look(std::span<const sea::QueryPoint> points,
                                    const Looking& looking) const;

    /// The water at depths (sea/surface/below.h), up from still water, from waves that this client has. An error (not_held):
    /// it has none of that time; bad_argument: a time at which there is no sea. Some 300 us a point of a gale.
    Result<Below> below(std::span<const sea::QueryPoint> points, std::span<const double> z_m,
                        const Looking& looking) const;
    /// The same by the server, as ask(): any number of points.
    Result<Below> ask_below(std::span<const sea::QueryPoint> points, std::span<const double> z_m,
                            const Asking& asking);

    /// A whole map of a cascade from the keyframes held, at any time that they cover or come near. An error (not_held): there
    /// are none with these fields; bad_argument: the sea has no such cascade.
    Result<CascadeMap> map(int cascade, sea::TimeUs time_us,
                           std::span<const std::optional<sea::Field>> channels) const;

    /// The surface around a time from what is held: for renderers and for many points.
    Result<LocalSurface> surface(sea::TimeUs time_us) const;

    /// Fetches the keyframes around these times that are not held, with the fields that sampling needs and those of `also` that
    /// the server offers. Blocks; `timeout_s` is for each request, and within it a server that is busy is asked again. What came to
    /// the ring first makes room, never what these times need; more times than the ring has room for are an error.
    Result<void> hold(std::span<const sea::TimeUs> times_us, double timeout_s,
                      sea::FieldSet also = {});

    /// Samples any number of points at any number of times, in order: fetches what is not held and keeps it until its points are
    /// answered, whatever else comes. Blocks. Only as many keyframes are asked for at once as the ring has room for. An
    /// answer without keyframes on both sides is an error here.
    Result<std::vector<sea::Answer>> fetch_and_sample(std::span<const sea::QueryPoint> points,
                                                      double timeout_s);

    const KeyframeRing& ring() const { return ring_; }

  private:
    /// `z_m`: none, or one a point.
    Result<void> check_asked(std::span<const sea::QueryPoint> points, const Looking& looking) const;
    Result<Below> ask_all(std::span<const sea::QueryPoint> points, std::span<const double> z_m,
                          const Asking& asking);

    using ConnectionPtr = std::shared_ptr<Connection>;
    using JoiningPtr = std::shared_ptr<Joining>;

    Client(ConnectOptions options, ClientEvents events, RingLimits limits);
    /// Never null once connect() has succeeded.
    ConnectionPtr link() const;
    ConnectionEvents connection_events(const JoiningPtr& joining);
    void take_times(ConnectionEvents& events, const JoiningPtr& joining);
    void take_keyframe(const HeldKeyframePtr& keyframe);
    void take_grant(const Grant& grant);

    // client_goes_on.cpp: on the keeper's thread, but for what says otherwise.
    Result<void> open_link();
    /// The connection from now on; hands back the one before.
    ConnectionPtr adopt(ConnectionPtr opened, const JoiningPtr& joining);
    /// mutex_ held: the next attempt is after a pause, or there is none.
    void note_wait(const Error& why);
    void note_attempt(); ///< mutex_ held
    void keep();
    /// Tries until it is connected, or there is no sense in it, or the client goes. `lock` is of mutex_.
    void come_back(std::unique_lock<std::mutex>& lock, Error why);
    void say_status();
    void say_what_is_held(); ///< where that is something else than was said
    /// mutex_ held, on the connection's thread: its first sea is known.
    void join(Joining& joining, const SeaStatePtr& state);
    /// mutex_ held. Why it is not the sea that is held; empty: it is.
    std::string why_another(const Joining& joining, const SeaState& state) const;
    void hear(const Joining::Look& look, bool clock_knows = false); ///< mutex_ held
    /// mutex_ held. Why it is not the server's sea: one should run by now, or a pace hold, that this connection was not told of, and each
    /// change is told of before it begins. Empty: nothing is.
    std::string what_is_lost(const Joining& joining, std::uint32_t told_epoch_max,
                             const Joining::Look& look) const;
    void forget_sea(const Joining& joining, const SeaStatePtr& next); ///< mutex_ held
    // client_subscribes_again.cpp: what is refused is asked for again, after waits, for as long as the connection stands.
    /// mutex_ held. When there is something to do for that, if nothing comes before.
    std::chrono::steady_clock::time_point subscribes_next_held() const;
    void subscribe_again(std::unique_lock<std::mutex>& lock); ///< does it; lock is of mutex_
    /// mutex_ held. Is there something else to be told?
    bool note_subscribed();
    template <class Kind>
    void step_again(Kept<Kind>& kept, RungAgain<Kind>& rung);
    template <class Kind> ///< how it stands, where there is nothing to be asked for
    std::optional<RungState> ask_as_before(const Kept<Kind>& kept, RungAgain<Kind>& rung);
    template <class Kind>
    Result<RungState> take_again(Kept<Kind>& kept, const RungAgain<Kind>& rung,
                                 const Result<Reply>& reply);
    static void ask_for(Connection& connection, const Subscription& subscription,
                        ReplyHandler handler);
    static void ask_for(Connection& connection, const SpectrumSubscription& subscription,
                        ReplyHandler handler);
    Result<Grant> granted(const Subscription& subscription, const Result<Reply>& reply);
    Result<protocol::SpectrumGrant> granted(const SpectrumSubscription& subscription,
                                            const Result<Reply>& reply);
    /// What is kept is subscribed to again by the keeper.
    template <class Kind>
    auto subscribe_and_keep(Kept<Kind>& kept, const Kind& subscription);
    // client_threadless.cpp: of a client without threads, where the keeper's way back is taken step by step.
    struct Coming {
        ConnectionPtr connection;
        JoiningPtr joining;
    };
    enum class Turn { standing, waiting, opening, stopped };
    Result<Reply> reply_of(Waiter& waiter); ///< waits; without threads it works meanwhile
    /// Likewise; or to the end of that connection, or of the client.
    void rest_until(std::chrono::steady_clock::time_point until, const ConnectionPtr& connection);
    /// One turn of work, until then at most.
    void work(std::chrono::steady_clock::time_point until);
    void work_held(std::chrono::steady_clock::time_point until); ///< working_ held
    /// working_ held. One step on the way back, if there is one to take.
    void keep_turn();
    void lose(std::unique_lock<std::mutex>& lock, const Error& why);
    void begin_link(std::unique_lock<std::mutex>& lock);
    void open_turn(std::unique_lock<std::mutex>& lock);
    void wake() {
        if (readiness_)
            readiness_->wake();
    }

    /// mutex_ held. Is nothing heard of the server, or of it that it is not sure of its sea?
    bool silent(LocalUs now_us) const;
    KnownSea known_held(const SeaState& state) const; ///< mutex_ held
    bool is_told_held(sea::TimeUs time_us) const;
    KnownSea known_sea(sea::TimeUs time_us) const; ///< read before answers are made
    /// Flags what the server may know more about.
    void mark_stale(std::span<const sea::QueryPoint> points, std::span<sea::Answer> answers,
                    std::span<sea::ErrorTerms> terms = {},
                    std::span<double> moved_off_m = {}) const;
    /// The same of answers of a server that is not sure of its sea.
    void mark_unsure(std::span<const sea::QueryPoint> points, std::span<sea::Answer> answers) const;
    /// By the earliest beginning of those that contain it. `moved_off_m`: added to, the same of a component of the displacement.
    void mark(std::span<const Unheard> unheard, std::span<const sea::QueryPoint> points,
              std::span<sea::Answer> answers, std::span<sea::ErrorTerms> terms = {},
              std::span<double> moved_off_m = {}) const;
    sea::TimeUs now_error_us() const; ///< bound on what now_us() is off by
    SeaMotion motion_within(TimeSpan span, const Looking& looking) const; ///< of all seas of then
    Result<void> add_clock(std::span<const sea::QueryPoint> points, std::span<sea::Answer> answers,
                           const Sampling& how) const; ///< what the water may be further on by

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
    void note_seen(std::span<const std::pair<sea::TimeUs, SeaStatePtr>> sent);
    /// Is it known which sea runs at each of these? One between keyframes that were asked for may have begun since the first of them.
    bool are_known(std::span<const sea::TimeUs> times_us) const;
    /// It is not known which sea runs then, and the server can say.
    bool to_be_seen(sea::TimeUs time_us) const;
    /// Null: this client has not the waves of that sea; of a glide, not those of both of its ends.
    OwnSeaPtr own_sea(const SeaStatePtr& state) const;
    // client_rebuilds.cpp; rebuilding_ held by the first two
    Result<void> rebuild(const SeaStatePtr& state, int depth);
    Result<OwnSeaPtr> rebuild_before(const SeaStatePtr& glide, int depth);
    SeaStatePtr to_follow_held() const; ///< not looked at yet; null: none. mutex_ held
    void follow(std::unique_lock<std::mutex>& lock, const SeaState& glide);
    void keep_made(const SeaStatePtr& state, const RebuiltSeaPtr& made);
    /// All of one time, of that sea.
    Result<void> look_at(std::span<const sea::QueryPoint> points, const Looking& looking,
                         const SeaStatePtr& state, std::span<Water> water) const;
    /// Glides that begin before the one before them has ended.
    static constexpr int glides_chained_max = 16;
    /// mutex_ held; `depth` more glides may lead there.
    WavesOf waves_held(const SeaStatePtr& state, int depth = glides_chained_max) const;
    WavesOf waves_before_held(const SeaStatePtr& glide, int depth = glides_chained_max) const;
    WavesOf waves_of_epoch_held(const SeaStatePtr& state, std::uint32_t epoch) const;
    OwnSeaPtr own_sea(const WavesOf& of) const; ///< without mutex_
    /// Would there be one? Nothing is made for that.
    bool holds_waves_held(const SeaStatePtr& state, int depth = glides_chained_max) const;
    bool has_waves_held(std::uint32_t epoch) const;
    /// Of whose spectrum a steady sea is.
    std::uint32_t epoch_of_waves_held(const SeaState& steady) const;
    sea::TimeUs elapsed_held() const; ///< mutex_ held. Of now, by the estimate alone
    sea::TimeUs sea_time_held() const { return paces_.sea_time(elapsed_held()); }
    /// mutex_ held. Paces that came late may put the sea far behind what was shown: time goes back then, in another sea. Does it?
    bool show_where_it_is();
    SeaStatePtr sea_state_held(sea::TimeUs time_us) const;
    /// mutex_ held. From now, of those that are held: the first or the last.
    void forget_furthest_state();
    void take_waves(ConnectionEvents& events);
    void make_room_for_waves(const SeaState& next); ///< mutex_ held
    void forget_waves(std::uint32_t epoch);         ///< mutex_ held
    void forget_received(std::uint32_t epoch);      ///< mutex_ held
    /// The sea that runs at a time, its waves if they are here, and until when it does.
    struct SeaThen {
        SeaStatePtr state;
        WavesOf waves_of;
        OwnSeaPtr waves; ///< made of them where they answer
        TimeSpan span;
        KnownSea known;
    };
    SeaThen sea_then(sea::TimeUs time_us) const;
    /// Has what that time takes: waves, or a surface. True: of its sea nothing has come, `then` is the one before.
    Result<bool> hold_then(SeaThen& then, const KeyframeRing& ring, sea::TimeUs time_us,
                           HeldSurfaces& surfaces, HeldSurfaces::Lent& surface,
                           const Sampling& how) const;
    /// Of one cascade: of keyframes that came where they cover the time, else of waves, and what those are off by.
    Result<LocalSurface> surface_of(const SeaStatePtr& state, sea::TimeUs time_us, int cascade,
                                    sea::FieldSet needed, RebuiltError& waves_off) const;
    /// All of the sea of `then`, by sums or by maps, whichever costs less.
    void answer_from_waves(const SeaThen& then, std::span<const sea::QueryPoint> points,
                           std::span<sea::Answer> answers, const Sampling& how) const;
    Result<void> sample_from(const KeyframeRing& ring, HeldSurfaces& surfaces,
                             std::span<const sea::QueryPoint> points,
                             std::span<sea::Answer> answers, const Sampling& how) const;
    /// What `look` finds in what is held, of one sea: looked at again where another has taken its place meanwhile.
    template <class Look>
    auto of_one_sea(const Look& look) const {
        for (;;) {
            const int before = seas_, seen = times_seen_;
            auto found = look();
            if (seas_ == before && times_seen_ == seen)
                return found;
        }
    }

    ConnectOptions options_;
    const ClientEvents events_;
    KeyframeRing ring_;
    mutable HeldSurfaces surfaces_;              ///< of ring_
    mutable std::atomic<int> splines_ahead_ = 0; ///< of so many keyframes that come

    mutable std::mutex mutex_;
    ClockFilter clock_; ///< of the time since the sea's epoch
    sea::Paces paces_;
    sea::TimeUs shown_us_ = std::numeric_limits<sea::TimeUs>::min();
    std::vector<SeaStatePtr> sea_states_; ///< by start time
    // Waves by epoch, of sea_states_; of a glide: of its end.
    std::map<std::uint32_t, RebuiltSeaPtr> rebuilt_;
    std::set<std::uint32_t> followed_; ///< glides that keep() has made, or could not
    std::map<std::uint32_t, std::shared_ptr<ReceivedSpectrum>> received_;
    /// Sent anew of epochs whose waves are held: they take over once they are as good.
    std::map<std::uint32_t, std::shared_ptr<ReceivedSpectrum>> arriving_;
    mutable HeldGlides glides_;
    mutable MapsOfSeas maps_of_waves_;
    mutable std::mutex making_glides_; ///< before mutex_
    std::mutex rebuilding_;            ///< before making_glides_
    sea::FieldSet not_offered_;
    std::optional<Grant> grant_;
    std::vector<Wanted*> wanted_;
    /// What the server was found to take at once, where its tiles are larger than usual.
    std::size_t times_taken_max_ = std::numeric_limits<std::size_t>::max();
    bool cascades_apart_ = false;

    // How it goes on.
    std::condition_variable changed_; ///< the end of a connection or of the client, and seas
    std::stop_source leaving_;
    ConnectionPtr connection_;
    JoiningPtr joining_; ///< of connection_
    /// Before mutex_. What is kept is what the server was asked for last: changed and said with this held.
    std::mutex asking_;
    Kept<Subscription> subscription_;
    Kept<SpectrumSubscription> spectrum_subscription_;
    ReconnectPauses pauses_;
    ClientStatus status_; ///< what changes by events
    std::chrono::steady_clock::time_point next_attempt_{};
    std::atomic<int> seas_ = 0; ///< changed before what is held of the one before is dropped
    bool resuming_ = false;     ///< from the end of a connection until all is subscribed to again
    std::unique_ptr<Again> again_; ///< meanwhile; of the keeper's thread, or of working_
    sea::TimeUs told_from_us_ = 0; ///< the beginning of the sea that a connection began with
    std::map<std::uint32_t, sea::TimeUs> seen_until_us_; ///< by epoch: KnownSea
    std::atomic<int> times_seen_ = 0;                    ///< so often that was others
    LocalUs heard_at_us_ = 0; ///< when the server was sure of its sea, as far as it is known
    sea::TimeUs heard_us_ = std::numeric_limits<sea::TimeUs>::min(); ///< sea time then
    bool unsure_ = false;                                            ///< so it says itself
    Unheard missed_;    ///< of the last connection that ended, where the sea was changed meanwhile
    std::mutex saying_; ///< of on_status; before mutex_
    /// What was said of that which changes without an event; of saying_.
    struct Said {
        bool tiles = false, waves = false, stale = false;
        bool operator==(const Said&) const = default;
    } said_;
    std::thread keeper_;

    // Of a client without threads.
    FairMutex working_; ///< of who does its work; before saying_ and mutex_
    std::unique_ptr<Readiness> readiness_;
    bool watching_ = false; ///< readiness_ knows the socket of the connection
    Turn turn_ = Turn::standing;
    Coming coming_;
};

} // namespace seaway::client
