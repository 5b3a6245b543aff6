// SPDX-License-Identifier: Apache-2.0
// A log, several servers and the network between them, all by lot: what is asked, delayed, lost, answered twice or not at all follows
// from a seed. Time is a number that the history moves on; nothing waits and nothing runs beside it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "server/journal/shared_log.h"

namespace seaway::server::tests_of_journals {

/// What a leader was told to write.
struct LotProposal {
    std::string message, id;
    std::uint64_t expected_last = 0;
    std::int64_t at_us = 0;
};

/// What is kept: acknowledged messages, and under which id each came.
struct LotEngine {
    std::vector<SharedLog::Stored> messages;
    std::map<std::string, std::uint64_t> ids;
    bool down = false;
    /// Who leads is cut off from the other nodes, since then. What it is told to write it keeps, and brings to the log by that time
    /// when it is joined to them again; if they have chosen another leader meanwhile, never.
    std::optional<std::int64_t> parted_us;
    std::vector<LotProposal> kept;
    /// As in a cluster: a repeat of what was stored is refused for the number that it has taken itself.
    bool refuses_repeats = false;
    std::int64_t clock_off_us = 0;

    Result<std::uint64_t> write(const std::string& message, const std::string& id,
                                std::uint64_t expected_last, std::int64_t now_us) {
        if (const auto found = ids.find(id); found != ids.end() && !refuses_repeats)
            return found->second;
        if (expected_last != messages.size())
            return Error{LogFailure::outrun, "another change was appended first"};
        messages.push_back({message, now_us + clock_off_us, id});
        ids[id] = messages.size();
        return messages.size();
    }
    void part(std::int64_t now_us) { parted_us = now_us; }
    void join(bool others_have_chosen) {
        parted_us.reset();
        if (others_have_chosen)
            kept.clear();
    }
    /// What was kept comes to the log in order.
    void settle() {
        for (const LotProposal& kept_one : std::exchange(kept, {}))
            (void)write(kept_one.message, kept_one.id, kept_one.expected_last, kept_one.at_us);
    }
};

struct Lots {
    explicit Lots(std::uint64_t seed) : engine(seed) {}
    bool chance(double probability) {
        return std::uniform_real_distribution<double>(0, 1)(engine) < probability;
    }
    std::int64_t between(std::int64_t least, std::int64_t most) {
        return std::uniform_int_distribution<std::int64_t>(least, most)(engine);
    }
    std::mt19937_64 engine;
};

/// One server's line to the engine. Each call takes some time, and may end before or behind the engine.
class LotLine final : public SharedLog {
  public:
    struct State {
        bool cut = false;                    ///< nothing comes through
        bool at_leader = true;               ///< its node is the one that leads
        double loss = 0;                     ///< of each way
        std::int64_t takes_us = 1000;        ///< up to
        std::uint64_t lags = 0;              ///< messages that who answers has not come to yet
        std::uint64_t lags_after_writes = 0; ///< it will, from the next one on
        int answers_lost = 0;                ///< of so many writes that come to the engine
        std::function<void()> comes_first;   ///< before the next write
        int reads_behind = 0; ///< of so many who answers has not come to what is asked for
        std::uint64_t other_copy_of = 0;    ///< who answers has this message at another time,
        std::int64_t other_copy_off_us = 0; ///< later by so much
        std::int64_t hangs_us = 0;          ///< each time that it is asked where it ends
        std::int64_t unsure_us = 0;         ///< for how long it has not heard of a majority
        /// Writes that were sent over a connection which was given up, and come to the engine later or never.
        std::vector<std::pair<std::string, std::pair<std::string, std::uint64_t>>> late;
    };

    LotLine(LotEngine& engine, State& state, Lots& lots, std::int64_t& now_us)
        : engine_(engine), state_(state), lots_(lots), now_us_(now_us) {}

    Result<Tail> tail() override {
        now_us_ += state_.hangs_us;
        if (!passes())
            return Error{LogFailure::unreachable, "cut"};
        if (engine_.parted_us && !state_.at_leader)
            return Error{LogFailure::unanswered, "nobody leads here"};
        const std::int64_t parted_us = engine_.parted_us ? now_us_ - *engine_.parted_us : 0;
        const std::size_t last =
            engine_.messages.size() - std::min<std::size_t>(state_.lags, engine_.messages.size());
        const Tail tail{last, "one",
                        last == 0 ? 0 : engine_.messages[last - 1].at_utc_us + off_us(last),
                        std::max(state_.unsure_us, parted_us)};
        return passes() ? Result<Tail>(tail) : Error{LogFailure::unanswered, "cut"};
    }
    Result<std::vector<Stored>> read(std::uint64_t first, std::uint64_t last) override {
        if (!passes() || !passes())
            return Error{LogFailure::unanswered, "cut"};
        if (state_.reads_behind > 0 && state_.reads_behind-- > 0)
            return Error{LogFailure::unanswered, "a copy that is behind"};
        std::vector<Stored> messages(engine_.messages.begin() +
                                         static_cast<std::ptrdiff_t>(first - 1),
                                     engine_.messages.begin() + static_cast<std::ptrdiff_t>(last));
        for (Stored& message : messages)
            message.at_utc_us += off_us(first++);
        return messages;
    }
    Result<std::uint64_t> write(const std::string& message, const std::string& id,
                                std::uint64_t expected_last) override {
        if (const auto first = std::exchange(state_.comes_first, {}))
            first();
        if (!passes()) {
            if (lots_.chance(0.5)) // it is under way all the same
                state_.late.push_back({message, {id, expected_last}});
            return Error{LogFailure::unanswered, "cut"};
        }
        if (engine_.parted_us) {
            if (state_.at_leader)
                engine_.kept.push_back({message, id, expected_last, now_us_});
            return Error{LogFailure::unanswered, "no majority"};
        }
        engine_.settle(); // in order
        Result<std::uint64_t> written = engine_.write(message, id, expected_last, now_us_);
        state_.lags = std::max(state_.lags, state_.lags_after_writes);
        if (state_.answers_lost > 0)
            --state_.answers_lost;
        else if (passes())
            return written;
        return Error{LogFailure::unanswered, "cut"};
    }

    void connect_no_more() override { ended_ = true; }

    /// What was under way comes, in any order.
    static void let_come(LotEngine& engine, State& state, Lots& lots, std::int64_t now_us) {
        while (!state.late.empty() && !engine.down && !engine.parted_us) {
            const auto at = static_cast<std::size_t>(
                lots.between(0, static_cast<std::int64_t>(state.late.size()) - 1));
            const auto [message, what] = state.late[at];
            state.late.erase(state.late.begin() + static_cast<std::ptrdiff_t>(at));
            (void)engine.write(message, what.first, what.second, now_us);
        }
    }

  private:
    std::int64_t off_us(std::uint64_t number) const {
        return number == state_.other_copy_of ? state_.other_copy_off_us : 0;
    }
    bool passes() {
        now_us_ += lots_.between(0, state_.takes_us);
        return !engine_.down && !state_.cut && !ended_ && !lots_.chance(state_.loss);
    }

    LotEngine& engine_;
    State& state_;
    Lots& lots_;
    std::int64_t& now_us_;
    bool ended_ = false;
};

} // namespace seaway::server::tests_of_journals
