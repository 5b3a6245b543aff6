// SPDX-License-Identifier: Apache-2.0
// Core: what all connections of one NetServer share. Of the io thread alone, except where said.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>

#include "server/host/host.h"
#include "server/host/memory.h"
#include "server/net/addresses.h"
#include "server/net/counters.h"
#include "server/net/deliveries.h"
#include "server/net/disposal.h"
#include "server/net/encode_worker.h"
#include "server/net/map_places.h"
#include "server/net/options.h"
#include "server/net/origins.h"
#include "server/net/senders.h"
#include "server/net/tokens.h"
#include "server/net/turns.h"
#include "server/net/waiting_line.h"

namespace seaway::server {

class Session;

/// What is behind one listener: everything, or health alone.
struct Door {
    bool health_only = false;
    int connections = 0;
    /// Connections that make room for others: from which a whole request is awaited, TLS handshakes and pauses between requests
    /// included, and those that are sent an answer or have been told to go.
    WaitingLine awaiting_requests;
    int answered = 0; ///< these last
};

/// A connection in awaiting_requests that is not idle, for as long as this is there.
class AnsweredSlot {
  public:
    explicit AnsweredSlot(Door& door) : door_(door) { ++door_.answered; }
    ~AnsweredSlot() { --door_.answered; }
    AnsweredSlot(const AnsweredSlot&) = delete;
    AnsweredSlot& operator=(const AnsweredSlot&) = delete;

  private:
    Door& door_;
};

class Core : public std::enable_shared_from_this<Core> {
  public:
    using Work = std::function<void()>;

    Core(NetOptions net_options, Host& simulation, std::function<void(Work)> run_on_io_thread,
         Turns::Now now = Turns::Clock::now);

    const NetOptions options;
    Host& host;
    Tokens tokens;
    Origins origins;

    Counters counters;
    Addresses addresses;
    /// What is held for those who ask; the room of fetched tiles is taken of on the encode thread, that of
    /// replies on the io thread.
    const MemoryPtr memory;
    EncodeWorker encoding;
    /// Makes spectra, which may take seconds, beside keyframes.
    EncodeWorker spectra;
    Disposal disposal;
    std::map<SessionId, Session*> sessions;
    SessionId next_session = 1;
    Senders senders;
    Turns turns;
    Deliveries deliveries{*this};
    Turns::Clock::time_point tells_of_left_out; ///< a line about keyframes, from then on
    Door door;
    Door health_door;
    int upgrades = 0; ///< under way: each will be a session
    MapPlaces map_places;
    /// Connections that wait for a map of the host: nobody else holds them. Given up with the server.
    std::set<std::shared_ptr<void>> waiting_for_maps;
    /// Sessions, and upgrades under way, without a token and without a Hello.
    WaitingLine awaiting_hello;
    bool stopping = false;
    std::chrono::milliseconds retry_after{0}; ///< while it stops

    /// Runs `work` on the io thread; does nothing after detach(). Any thread.
    void post(Work work);
    void detach();

    Session* find(SessionId session) const;
    /// There is room for one more, those under way counted.
    bool takes_a_session() const {
        return sessions.size() + static_cast<std::size_t>(upgrades) <
               static_cast<std::size_t>(options.sessions_max);
    }
    Gauges gauges() const;

    /// Those who are sent away now hear when to come: to another server of the same sea.
    void begin_to_hand_over(const std::string& why);
    /// Nobody new is taken from here on, and those who are sent away hear when to come back: after
    /// options.retry_after_s, or so much later the more they are.
    void begin_to_stop();
    /// Clients wait once to twice what they are told, so in half a minute 6000 are back.
    static constexpr double comers_per_s = 200;
    static constexpr double retry_after_s_min = 2;
    /// Who is handed over comes back so soon: by then a balancer has asked for /readyz. A client holds keyframes for longer.
    static constexpr double hand_over_s_min = 0.5;

    /// One log line, at most `log_lines_per_second_max` of them: a flood of bad clients must not
    /// become a flood of log. What was left out is counted in the next line.
    void log(const std::string& line);
    /// An act of an administrator: nobody can flood it out of the log.
    void log_act(const std::string& line);
    static constexpr int log_lines_per_second_max = 200;

  private:
    std::chrono::milliseconds pause_of_all(double least_s) const;

    std::mutex post_mutex_;
    std::function<void(Work)> run_on_io_thread_;
    std::int64_t log_second_ = 0;
    int log_lines_ = 0;
    std::uint64_t log_left_out_ = 0;
};

} // namespace seaway::server
