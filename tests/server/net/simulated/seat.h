// SPDX-License-Identifier: Apache-2.0
// Seat: one client, its connection and its session, without sockets: a link of some bytes a second, a
// buffer and a delay, that stalls, is cut and has the deadlines of a real connection; and a peer that
// asks for this and that, in a temper of its own.
#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <string>

#include "server/net/session.h"
#include "tests/server/net/simulated/late_sea.h"
#include "tests/server/net/simulated/ledger.h"

namespace seaway::tests::simulated {

enum class Temper {
    honest,
    slow,    ///< its link is
    stuck,   ///< reads nothing after a while
    miser,   ///< acknowledges late or never; others sometimes several keyframes together
    hostile, ///< bytes that are no message, and messages that are no client's
    mute,    ///< says no Hello
};

class Seat final : public server::Link {
  public:
    /// `settle` waits for what the session has given to threads of its own.
    Seat(server::Core& core, Judge& judge, Draw& draw, const Publications& publications,
         const std::string& name, std::string token, std::function<void()> settle);

    // ---- what the crowd does with it ---------------------------------------------------------

    /// Time has come to `now_us`: bytes travel, deadlines pass, what has arrived is read.
    void come_to(sea::TimeUs now_us);
    /// The peer does something, or nothing.
    void act();
    void cut();     ///< without a word
    void say_bye(); ///< with a closing handshake
    void set_rate(double bytes_per_s) { bytes_per_s_ = bytes_per_s; }
    /// From now on it reads, acknowledges and asks nothing new.
    void calm_down();
    void is_owed(const protocol::SharedBytes& state);

    bool lost() const { return lost_; }
    Temper temper() const { return temper_; }
    const server::Session& session() const { return *session_; }
    const Ledger& ledger() const { return ledger_; }
    const std::string& name() const { return name_; }

    // ---- Link ------------------------------------------------------------------------------

    void drop() noexcept override { lost_ = true; }
    void send_more() override;
    void close(protocol::SharedBytes go_away, wire::ErrorCode code,
               const std::string& why) override;

  private:
    struct Travelling {
        protocol::SharedBytes message;
        std::size_t left = 0;
        std::optional<std::uint64_t> completes;
        sea::TimeUs arrives_us = 0; ///< once nothing is left
    };

    void give_to_session();
    void drain(sea::TimeUs passed_us);
    void arrived(const Travelling& message);
    void pass_deadlines();
    void written();
    protocol::Bytes something();
    protocol::Bytes nonsense();
    protocol::TileWish wish();
    /// Acknowledges this keyframe, and all that were hoarded with it.
    void say_ack(std::uint64_t keyframe);
    void say(protocol::Bytes bytes) { asking_.push_back(std::move(bytes)); }
    std::uint32_t new_id() { return next_id_++; }
    void tell(const std::string& what);

    server::Core& core_;
    Judge& judge_;
    Draw& draw_;
    const Publications& publications_;
    const std::string name_;
    const std::string token_;
    const std::function<void()> settle_;
    const Temper temper_;
    const std::uint64_t pause_; ///< a request in so many steps
    Ledger ledger_;
    sea::TimeUs now_us_ = 0;
    sea::TimeUs opened_us_ = -1;
    sea::TimeUs writing_since_us_ = 0;
    double bytes_per_s_ = 1e6;
    sea::TimeUs delay_us_ = 0;
    std::size_t buffer_bytes_ = 0;
    double allowance_ = 0; ///< bytes that the link may still carry
    std::uint32_t next_id_ = 1;
    bool said_hello_ = false;
    bool calm_ = false;
    bool closing_ = false;
    sea::TimeUs closing_since_us_ = 0;
    bool lost_ = false;
    std::deque<protocol::Bytes> asking_; ///< on their way to the session
    protocol::SharedBytes writing_;      ///< not yet in the buffer
    std::deque<Travelling> travelling_;
    std::size_t travelling_bytes_ = 0;
    protocol::SharedBytes go_away_;
    std::vector<std::uint64_t> hoarded_; ///< keyframes that were not acknowledged
    std::optional<server::Session> session_;
};

} // namespace seaway::tests::simulated
