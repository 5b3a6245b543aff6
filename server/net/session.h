// SPDX-License-Identifier: Apache-2.0
// Session: the protocol of one client, from Hello to the end, without sockets. Bytes of verified
// size come in through receive(), messages go out through next_message(); the connection is behind
// Link. Of the io thread alone.
//
// Bad bytes end the session with a reason; a request that cannot be granted is refused and the
// session goes on. How a session ended is logged in one line and counted, once.
#pragma once

#include <cstdint>
#include <deque>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/messages.h"
#include "server/net/core.h"
#include "server/net/gate.h"
#include "server/publish/outbox.h"

namespace seaway::server {

struct FetchedTiles;

/// The connection, as its session sees it. May be called from within receive().
class Link {
  public:
    virtual ~Link() = default;
    /// next_message() may have something.
    virtual void send_more() = 0;
    /// The same, and at once: the session ends, and answers that are to go out with others would not.
    virtual void send_held_back() {}
    /// Closes at once, without a word: there is no memory for one. Does not throw.
    virtual void drop() noexcept = 0;
    /// Sends `go_away` after the message that is being sent, then closes with `code` and `why`.
    virtual void close(protocol::SharedBytes go_away, wire::ErrorCode code,
                       const std::string& why) = 0;
};

class Session {
  public:
    /// `standing` is what the token of the upgrade was worth. Both references outlive the session.
    Session(Core& core, Link& link, Peer peer, Standing standing);
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    SessionId id() const { return id_; }
    bool ended() const { return ended_; }
    bool greeted() const { return greeted_; } ///< a Hello has been taken

    // ---- from the connection ---------------------------------------------------------------

    void receive(std::span<const std::uint8_t> bytes);
    /// False: enough replies wait; read nothing until it is true again.
    bool wants_requests() const;
    protocol::SharedBytes next_message();
    /// Is sent, too.
    void count_sent(const protocol::Bytes& message);
    /// All that next_message() has given is gone.
    void sent() { outbox_.sent(); }
    void hello_overdue();
    /// The connection is gone. `reason` is a label of Counters::sessions_closed.
    void end(std::string_view reason, std::string_view why);

    // ---- from the server -------------------------------------------------------------------

    /// Sends it if it is of this session's quality and holds all that was granted.
    void deliver(const Delivery& streamed);
    /// A sea that is near: its SeaState is sent unless it has been, and grant and spectra are for that sea, too, from now on.
    void announce(protocol::SharedBytes sea_state);
    /// Something that it asked for is not answered, or not sent.
    bool is_owed() const;
    /// Ends the session with GoAway.
    void close(wire::ErrorCode code, const std::string& why,
               std::chrono::milliseconds stays_away = {});
    /// Has those of later seas made for which there was no room, once it is worth another try.
    void make_owed_spectra();
    /// Waves go on coming by and by, whether it says something or not.
    bool awaits_waves() const { return outbox_.paces_spectra() || spectra_owed_.has_value(); }
    /// Ends it as too slow, so that what it holds is let go of: where it does not take what it is being sent, without
    /// a word, for which it would have to take that first.
    void give_up(std::string_view why);

    const Outbox& outbox() const { return outbox_; }

  private:
    void on_hello(const wire::Hello& hello);
    void on_subscribe(const wire::Subscribe& subscribe);
    void on_unsubscribe(bool spectrum = false);
    void on_subscribe_spectrum(const wire::SubscribeSpectrum& subscribe);
    void on_ack(const wire::Ack& ack);
    void on_fetch(const wire::Fetch& fetch);
    void on_query(const wire::Query& query); // session_query.cpp
    void on_ping(const wire::Ping& ping);
    // For administrators (session_admin.cpp).
    void on_change(const wire::Change& change);
    void on_administer(const wire::Administer& administer);
    void changed(std::uint32_t request_id, const Result<SeaPromise>& promise);
    /// On any thread: `take`, on the network's, of a session if it is still there.
    template <class Take>
    static void later(const std::weak_ptr<Core>& core, SessionId id, Take take);
    /// `ask`s the host where spectra are made, so that the network's thread does not wait for it; then `take`, on that thread, of
    /// this session if it is still there. Where there is no memory that is the answer. False: too much waits already.
    template <class Ask, class Take>
    bool ask_behind(Ask ask, Take take);
    using JournalText = Result<std::string> (Host::*)(std::uint64_t) const;
    void read_journal(std::uint32_t request_id, JournalText text, std::uint64_t number);
    void told(std::uint32_t request_id, const Result<std::string>& text);
    std::string sessions_json() const;
    Result<void> drop(SessionId session);

    /// Says what is granted to subscription_.
    void state_grant();
    /// Looks what of its wish can be had of the seas that there are now, and says so where that is something else.
    void renew_grant();
    /// Others of its address have as many kinds of coarser maps as they may have.
    bool shares_coarser_maps(const Demand& wish) const;
    /// After each change of what is granted.
    void count_coarser_maps();
    /// Is a keyframe of one that the session is sent?
    bool takes(const EncodedKeyframe& keyframe);
    bool fetches_too_many(std::uint32_t request_id); ///< and says so
    void fetch(std::uint32_t request_id, std::vector<sea::TimeUs> times_us, const Demand& demand);
    void fetched(std::uint32_t request_id, const Result<FetchedTiles>& encoded);
    /// A query that is under way.
    struct Asked {
        std::uint32_t request_id;
        std::size_t points;
        std::size_t bytes; ///< of its reply
        Room::Place place; ///< of these
        std::chrono::steady_clock::time_point at = std::chrono::steady_clock::now();
    };
    static Result<protocol::SharedBytes> reply_of(const Asked& asked,
                                                  const Result<QueryAnswers>& answers);
    void answered(const Asked& asked, const Result<protocol::SharedBytes>& reply);
    /// For the reply to so many points; null: there is none.
    Room::Place reply_place(std::size_t bytes) const;
    /// Has the spectra made that this session wants; what comes of it answers the request, where there is one.
    void make_spectra(std::optional<std::uint32_t> request_id);
    void spectra_made(std::optional<std::uint32_t> request_id,
                      const Result<GrantedSpectrum>& granted);
    /// Does it, or ends the session where there is no memory for it.
    template <class Work>
    void or_drop(Work work) {
        try {
            work();
        } catch (const std::bad_alloc&) {
            link_.drop();
            end(protocol::name(wire::ErrorCode::internal), "there is no memory for this session");
        }
    }
    void dispatch(std::span<const std::uint8_t> bytes);
    /// The sea of keyframes that are about to be sent, where it was not told of.
    void tell_of(std::uint32_t epoch);
    /// Sends a SeaState that it has not been sent; of a sea that is far, so that nothing follows of it.
    void tell(protocol::SharedBytes sea_state);
    bool was_told(const protocol::SharedBytes& sea_state) const;
    void reply(protocol::Bytes message);
    void refuse(std::uint32_t request_id, const Error& why);

    Core& core_;
    Link& link_;
    const SessionId id_;
    const Peer peer_;
    Standing standing_;
    protocol::MessageReader reader_{protocol::Sender::client};
    Outbox outbox_;
    std::shared_ptr<const void> here_ = std::make_shared<char>(); ///< for those who are asked
    bool greeted_ = false;
    bool closing_ = false;
    bool ended_ = false;
    int queries_in_flight_ = 0;
    std::size_t replies_in_flight_bytes_ = 0; ///< of those
    int fetches_in_flight_ = 0;               ///< at the host or at the encoder
    struct Subscription {
        std::uint32_t request_id;
        Demand wish;
        int credit;
        Demand granted;
        /// Another quality that it had before, of which keyframes of these cascades are still on their way.
        Quality former_quality = 0;
        std::uint32_t former_cascades = 0;
    };
    std::optional<Subscription> subscription_;
    std::optional<Quality> counted_coarser_; ///< at its address
    std::optional<SpectrumDemand> spectrum_wish_;
    int spectra_in_making_ = 0;
    std::vector<std::uint32_t> spectra_sent_; ///< epochs, since the wish; the newest few
    std::optional<std::chrono::steady_clock::time_point> spectra_owed_; ///< not before then
    int changes_in_flight_ = 0;
    int journal_reads_ = 0;                  ///< asked for and not told
    std::string client_;                     ///< its name, printable
    std::deque<protocol::SharedBytes> told_; ///< sea states
    std::uint64_t messages_sent_ = 0;
    std::uint64_t bytes_sent_ = 0;
    std::chrono::steady_clock::time_point opened_ = std::chrono::steady_clock::now();
};

} // namespace seaway::server
