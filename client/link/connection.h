// SPDX-License-Identifier: Apache-2.0
// Connection: one session with a server, in terms of values. Speaks the protocol, assembles tiles,
// acknowledges keyframes, pings, and reports what comes. It ends once and does not come back:
// whether to connect again is for whoever owns it (client/client.h holds what outlives messages).
//
// Thread-safe. Events come on the connection's own thread, or in work() of one without (ConnectOptions::threadless), one after
// the other; they must not block, and the connection must not be destroyed from one.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "base/local_clock.h"
#include "base/result.h"
#include "client/held/acknowledgements.h"
#include "client/held/tile_assembly.h"
#include "client/link/kept.h"
#include "client/link/message_stream.h"
#include "client/link/requests.h"
#include "protocol/messages.h"

namespace seaway::client {

using SeaState = protocol::SeaStateValues;
using SeaStatePtr = std::shared_ptr<const SeaState>;
/// Keyframes of both may be sampled together.
bool same_tiles(const SeaState& a, const SeaState& b);
/// As far as both say: by probes, and of a glide by its end and by those of where it leads.
bool same_waves(const SeaState& a, const SeaState& b);

struct ConnectOptions {
    std::string url{};                                  ///< ws://HOST:PORT or wss://HOST:PORT
    std::string name = "seaway-client/" SEAWAY_VERSION; ///< for the server's log
    std::string token{};                                ///< if the server asks for one
    std::string ca_file{};                              ///< PEM, besides the system's certificates
    double timeout_s = 5; ///< for connecting until the first sea state
    /// Of a Client: once its connection has ended it is not connected again.
    bool stays_lost = false;
    std::stop_token stop{}; ///< connecting is given up soon after
    /// No thread is made: work() does everything, on the thread of who calls it. Of a Client: seaway.h says what that asks.
    bool threadless = false;
};

/// What the server said about itself and its limits.
struct Welcome {
    std::uint64_t session = 0;
    std::string server;
    std::uint32_t points_per_query_max = 0;
    std::uint32_t exact_points_per_query_max = 0;
    std::uint32_t times_per_fetch_max = 0;
};

/// Any may be left empty.
struct ConnectionEvents {
    std::function<void(const SeaStatePtr&)> on_sea_state{};
    std::function<void(const HeldKeyframePtr&)> on_keyframe{};
    /// The waves of this sea begin: those that are held of it are over.
    std::function<void(const SeaStatePtr&, const protocol::SpectrumHead&)> on_spectrum{};
    /// Some of them, and what is missed once they are there. An error ends the connection: the server is broken.
    std::function<Result<void>(std::uint32_t epoch, const sea::SpectrumLeft& left,
                               std::span<const sea::WaveBlock> blocks)>
        on_waves{};
    /// What the subscription gets: at its start, and again whenever a change of the sea makes that something else.
    std::function<void(const Grant&)> on_grant{};
    /// One look at the server's clock: local times as local_now_us().
    std::function<void(std::int64_t sent_us, std::int64_t received_us, const sea::SeaTime& said)>
        on_clock{};
    /// Some twenty times a second for as long as it stands.
    std::function<void()> on_tick{};
    /// How sea time follows from that, from a moment on.
    std::function<void(const sea::Pace& pace)> on_pace{};
    /// Once, and last; not after a failed open(). One line, and for how long the server wants nobody to come
    /// (retry_after_ms), which ReconnectPauses keeps. lost, or for_good where coming again would meet the same.
    std::function<void(const Error& reason)> on_closed{};
};

using seaway::local_now_us; // the clock of this room
/// So much later than now.
std::int64_t deadline_us(double timeout_s);
/// The same maps, on as small grids as carry them.
protocol::TileWish compact(protocol::TileWish wish);

class Connection {
  public:
    /// Carries messages to the server at the address; open_websocket unless a test brings another.
    using OpenStream =
        std::function<Result<std::unique_ptr<MessageStream>>(const Url&, const WebSocketOptions&)>;

    /// Connects, says hello and waits for the first sea state. Blocks `timeout_s`, and a second more at most; a threadless one
    /// for as long as the system looks a name up. Errors: cannot_connect; for_good where coming again would meet the same.
    static Result<std::unique_ptr<Connection>> open(const ConnectOptions& options,
                                                    ConnectionEvents events,
                                                    const OpenStream& open_stream = open_websocket);
    /// open() of a threadless connection without waiting: opened() says how it stands, which work() brings on.
    static Result<std::unique_ptr<Connection>>
    begin(const ConnectOptions& options, ConnectionEvents events,
          const OpenStream& open_stream = open_websocket);
    /// Nothing: it is under way. After that it is open, or why it is not.
    std::optional<Result<void>> opened();
    /// As MessageStream's.
    void work(std::chrono::steady_clock::time_point until) { stream_->work(until); }
    int descriptor() const { return stream_->descriptor(); }
    ~Connection();
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;

    const Welcome& welcome() const { return welcome_; }
    bool is_open() const { return open_; }
    /// Ends it: on_closed gets the reason, and with it everything that waits. Does not block.
    void close(std::string why = "closed by this client") { stream_->close(std::move(why)); }
    /// Likewise, and waits for its thread: none of its events comes, or is under way, any more. Not from one of them.
    void end() { stream_->end(); }

    // Each hands its handler the reply, a refusal, a passed deadline or the end of the connection:
    // exactly once, on the connection's thread or at once. `timeout_s` is from now on.

    /// At most welcome().points_per_query_max points, or exact_points_per_query_max.
    /// `looking`: which waves count. `z_m`: none, or of each point the water there as well, as exact points. Of a server
    /// that is older than one of them, Failure::not_understood.
    void query(std::span<const sea::QueryPoint> points, bool exact, double timeout_s,
               ReplyHandler handler, const sea::Looking& looking = {},
               std::span<const double> z_m = {});

    /// Keyframes come through on_keyframe. Replies when those around now have come.
    void subscribe(const protocol::TileWish& wish, int credit, double timeout_s,
                   ReplyHandler handler);

    /// Keyframes around these times (at most times_per_fetch_max), through on_keyframe, once.
    /// Replies when all have come.
    void fetch(std::span<const sea::TimeUs> times_us, const protocol::TileWish& wish,
               double timeout_s, ReplyHandler handler);

    void unsubscribe();

    /// Waves come through on_spectrum and on_waves. Replies when all of those that run now, and of a sea that is
    /// announced, have come.
    void subscribe_spectrum(const protocol::SpectrumWish& wish, double timeout_s,
                            ReplyHandler handler);
    void unsubscribe_spectrum();
    // For administrators: others are refused.

    /// Changes the sea. Replies once that is durable, before it begins.
    void change(const protocol::ChangeWish& wish, double timeout_s, ReplyHandler handler);
    /// `session`: that act drop ends.
    void administer(wire::Act act, std::uint64_t session, double timeout_s, ReplyHandler handler);

    /// Keyframes that made room for others before they were whole.
    std::uint64_t keyframes_dropped() const { return assembly_.dropped(); }
    /// Those that were differences to what is not here. It then asks for a stream of whole ones.
    std::uint64_t keyframes_unpredicted() const { return unpredicted_; }

  private:
    explicit Connection(ConnectionEvents events);

    Result<void> begin_opening(const ConnectOptions& options, const OpenStream& open_stream);
    void say_hello();
    Result<void> wait_for_sea();
    /// opening_mutex_ held.
    std::optional<Result<void>> opened_held();
    void on_opened(const Result<void>& opened);
    void on_message(std::span<const std::uint8_t> bytes);
    void on_tick();
    void on_closed(const std::string& reason);
    Result<void> dispatch(const wire::Message& message);
    Result<void> take(const wire::Welcome& welcome);
    Result<void> take(const wire::SeaState& state);
    Result<void> take(const wire::Subscribed& subscribed);
    Result<void> take(const wire::Tile& tile);
    Result<void> take(const wire::QueryReply& reply);
    Result<void> take(const wire::FetchDone& done);
    Result<void> take(const wire::SpectrumSubscribed& subscribed);
    Result<void> take(const wire::Spectrum& spectrum);
    Result<void> take(const wire::SpectrumChunk& chunk);
    void one_spectrum_less();
    Result<void> take(const wire::Changed& changed);
    Result<void> take(const wire::Administered& administered);
    Result<void> take(const wire::Pace& pace);
    Result<void> take(const wire::Pong& pong);
    void take(const wire::Refused& refused);
    Result<void> take(const wire::GoAway& go_away);
    bool send(protocol::Bytes message);
    void end_with(const Error& why, bool& was_open);
    struct Stream {
        protocol::TileWish wish;
        int credit = 0;
    };
    /// What comes is predicted from what is not here: the same subscription without predictions.
    void subscribe_unpredicted();
    /// Ends the connection where it cannot be sent.
    void send_ack(std::optional<protocol::Bytes> ack);
    SeaStatePtr sea_state(std::uint32_t epoch);

    const ConnectionEvents events_;
    std::atomic<bool> open_ = false;

    // Of open() and the connection's thread.
    ConnectOptions options_;
    std::chrono::steady_clock::time_point opening_until_{};
    std::optional<Error> not_opened_; ///< there is no stream
    std::mutex opening_mutex_;
    std::condition_variable opening_;
    bool welcomed_ = false;
    bool sea_known_ = false;
    std::optional<Error> end_; ///< why the connection is over
    Welcome welcome_;

    std::recursive_mutex stream_mutex_; ///< what is refused at once is answered at once
    Kept<Stream> streaming_;
    std::atomic<bool> predicts_ = true;
    std::atomic<std::uint64_t> unpredicted_ = 0;

    // Of the connection's thread alone, but for assembly_.dropped().
    protocol::MessageReader reader_{protocol::Sender::server};
    std::vector<SeaStatePtr> sea_states_; ///< used last: at the back
    std::int64_t next_ping_us_ = 0;
    std::uint32_t pings_ = 0;
    std::int64_t hello_sent_us_ = 0;
    std::optional<Error> going_away_;
    sea::FieldSet streamed_fields_;
    TileAssembly assembly_;
    bool subscribes_again_ = false; ///< because of what was not predicted
    std::uint64_t last_unpredicted_ = 0;
    Acknowledgements acknowledgements_;
    std::atomic<bool> spectra_wanted_ = false;
    bool spectrum_taken_ = false;      ///< the one that is being sent
    std::uint32_t spectrum_epoch_ = 0; ///< of it
    std::uint32_t next_chunk_ = 0;
    std::uint32_t chunks_ = 0;
    std::uint32_t spectra_awaited_ = 0; ///< by spectrum_request_
    std::uint32_t spectrum_request_ = 0;
    protocol::SpectrumGrant spectrum_grant_;

    Requests requests_;

    /// Last, so that it goes first: until its thread has ended, that uses all of the above.
    std::unique_ptr<MessageStream> stream_;
};

} // namespace seaway::client
