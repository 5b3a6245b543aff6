// SPDX-License-Identifier: Apache-2.0
// NetServer: one port for HTTP and WebSocket in front of a Host. One io thread serves every
// connection, one encode thread turns keyframes into shared bytes; neither waits for a client.
//
//     Result<void> fine = NetServer::check(options);    // exit code 2, before a device is chosen
//     Result<std::unique_ptr<NetServer>> net = NetServer::start(options, host);
//     if (!net) ...                       // exit code 4: (*net).error().message says what to do
//     fmt::print("ready {}\n", (*net)->url());
//     (*net)->publish(keyframe_tiles);    // from the simulation, any thread
//     (*net)->stop();                     // at most options.drain_s + options.stop_deadline
//
// HTTP (GET, HEAD): /healthz, /readyz, /metrics, /v1/state, /v1/plan, / ; WebSocket: /v1/stream with the
// subprotocol seaway.v1 (docs/protocol.md). Every session ends with one log line and one count, by
// reason. A slow, stalled or hostile client changes nothing for anyone else.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "protocol/messages.h"
#include "server/host/host.h"
#include "server/net/file_read_again.h"
#include "server/net/options.h"

namespace seaway::server {

class NetServer {
  public:
    /// What can be known of these options before there is anything to serve: an address that is not
    /// understood, or the same twice; a certificate, key or token file that cannot be read or is none.
    static Result<void> check(const NetOptions& options);
    /// An address that this machine does not have, now. Of options that check() takes.
    static Result<void> check_addresses(const NetOptions& options);

    /// Listens, then starts its threads. `host` must outlive the NetServer; it is called from the
    /// io thread. Errors: those of check(), and an address in use or not allowed.
    static Result<std::unique_ptr<NetServer>> start(const NetOptions& options, Host& host);

    /// Stops.
    ~NetServer();
    NetServer(const NetServer&) = delete;
    NetServer& operator=(const NetServer&) = delete;

    /// Reads tokens, certificate and key again, all of them or, with an error, none: then it goes on
    /// with those it has. For connections and requests from now on; sessions that are open stay. Says of each file
    /// what became of it. Any thread.
    struct Reloaded {
        Result<void> all;
        std::vector<FileReadAgain> files;
    };
    Reloaded reload();

    /// The port that was taken.
    int port() const;
    int health_port() const; ///< of options.health_listen; 0: there is none
    /// "ws://127.0.0.1:9430", or "wss://...".
    std::string url() const;

    /// For how long the io thread has not come to what it was given; asks it anew. To be called now and then, by
    /// one thread.
    std::chrono::steady_clock::duration silence();

    /// Sends a keyframe to the sessions of its quality that were granted its cascade and whose
    /// granted fields it holds. Encodes once, only what somebody wants, on the encode thread; if
    /// that is too far behind, the keyframe is dropped and counted. Any thread; returns at once.
    void publish(KeyframeTiles tiles);

    /// Sends a SeaState message to every session. Durable: a session that cannot take it is closed.
    /// They are told in turns, each before what is published later. Any thread; returns at once.
    void announce(protocol::SharedBytes sea_state);

    /// Sends every session away (GoAway.retry_after_ms), to come back to whatever server a balancer leads it to; who comes from
    /// then on is taken. They hear why in general words, and the log has all. Any thread; returns at once.
    void hand_over(const std::string& why, const std::string& why_in_general);

    /// From the first moment /readyz is 503 and nobody new is taken. Who is owed nothing is sent away at once, with a
    /// time to stay away (GoAway.retry_after_ms); what is under way is finished before, for options.drain_s at
    /// most. Then closes, joins; maps that are being let go have ended then. Idempotent. Host callbacks that come
    /// later do nothing.
    void stop();

  private:
    class Impl;
    explicit NetServer(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

} // namespace seaway::server
