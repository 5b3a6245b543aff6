// SPDX-License-Identifier: Apache-2.0
// Histories by lot of servers that follow one log: lines are cut and lose what goes over them, answers are lost, what was sent comes
// late, the engine and the servers are killed, clocks are off. Each history follows from a seed; a failure names it, and
//     SEAWAY_SEED=N test_journal --gtest_filter=SharedJournal.*histories*
// lives through it alone.
#include <algorithm>
#include <cstdlib>
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "server/journal/shared_journal.h"
#include "tests/server/journal/lot_network.h"

namespace seaway::server {
namespace {
namespace histories {

using namespace tests_of_journals;

constexpr std::int64_t second_us = 1'000'000;
/// From when a change has to be known to when it begins, at least (server/sea_director.cpp: spare_us).
constexpr std::int64_t lead_us = second_us;
/// A server's clock is off by no more; each drains itself before (server/journal/peer_clocks.h).
constexpr std::int64_t clock_off_us_max = 20'000;

struct Server {
    LotLine::State line;
    std::unique_ptr<SharedJournal> journal; ///< none while it is dead
    std::int64_t clock_off_us = 0;
    std::int64_t next_poll_us = 0;
    std::int64_t listens_us = 0; ///< nobody asks it before
    std::uint32_t held = 0;      ///< of which it was seen that they are the log's
};

class History {
  public:
    explicit History(std::uint64_t seed) : lots_(seed), servers_(3) {
        for (Server& server : servers_)
            server.clock_off_us = lots_.between(-clock_off_us_max, clock_off_us_max);
        engine_.refuses_repeats = lots_.chance(0.5);
        engine_.clock_off_us = lots_.between(-clock_off_us_max, clock_off_us_max);
    }

    /// Empty: all promises were kept.
    std::string live() {
        while (wrong_.empty() && now_us_ < 40 * second_us)
            step();
        heal();
        return wrong_;
    }
    std::size_t acknowledged() const { return acknowledged_.size(); }
    int unknown() const { return unknown_; }
    int refused() const { return refused_; }
    int lapsed() const { return lapsed_; }
    int stale() const { return stale_; }
    int joins() const { return joins_; }

  private:
    void step() {
        now_us_ += lots_.between(1'000, 60'000);
        for (std::size_t i = 0; i < servers_.size() && wrong_.empty(); ++i) {
            Server& server = servers_[i];
            trouble(server);
            if (!server.journal)
                start(server, i);
            else if (now_us_ >= server.next_poll_us) {
                server.journal->poll();
                server.next_poll_us = now_us_ + SharedJournal::poll_us;
            }
            if (server.journal && lots_.chance(0.02))
                change(server);
            if (server.journal)
                look_at(server);
        }
        if (lots_.chance(engine_.down ? 0.03 : 0.002))
            engine_.down = !engine_.down;
        trouble_of_nodes();
        agree();
    }

    void trouble(Server& server) {
        if (lots_.chance(server.line.cut ? 0.02 : 0.004))
            server.line.cut = !server.line.cut;
        if (lots_.chance(0.01))
            server.line.loss = lots_.chance(0.5) ? 0 : 0.4;
        if (lots_.chance(0.05))
            LotLine::let_come(engine_, server.line, lots_, now_us_);
        if (lots_.chance(0.002)) // kill -9: what it was told of is the log's
            server.journal.reset();
    }

    /// Others choose a leader after 4 to 9 s without the one they had (nats-server: minElectionTimeout, maxElectionTimeout).
    void trouble_of_nodes() {
        if (!engine_.parted_us && lots_.chance(0.002)) {
            engine_.settle();
            engine_.part(now_us_);
            for (Server& server : servers_)
                server.line.at_leader = lots_.chance(0.5);
        } else if (engine_.parted_us) {
            const std::int64_t parted_us = now_us_ - *engine_.parted_us;
            const bool chosen = parted_us > lots_.between(4 * second_us, 9 * second_us);
            if (chosen || lots_.chance(0.01)) {
                joins_ += !chosen && !engine_.kept.empty();
                engine_.join(chosen);
                settles_us_ = now_us_ + lots_.between(0, SharedJournal::settles_us / 2);
            }
        } else if (now_us_ >= settles_us_) {
            engine_.settle();
        }
    }

    void start(Server& server, std::size_t number) {
        auto opened = SharedJournal::open(
            std::make_unique<LotLine>(engine_, server.line, lots_, now_us_),
            {now_us_, fmt::format("of server {}", number)},
            {"log", fmt::format("writer {}", ++writers_), [this] { return now_us_; },
             [this, &server] { return now_us_ + server.clock_off_us; }});
        if (opened)
            server.journal = *std::move(opened);
        else if (!opened.error().is(JournalError::unreachable) &&
                 !opened.error().is(JournalError::unknown))
            wrong_ = "a start fails: " + opened.error().message;
        server.held = 0;
        server.listens_us = now_us_ + SharedJournal::settles_us;
    }

    void change(Server& server) {
        const std::vector<SeaChange> held = server.journal->since(0).value();
        SeaChange mine{static_cast<std::uint32_t>(held.size()) + 1};
        mine.start_us = now_us_ + server.clock_off_us + server.journal->spread_us() + lead_us +
                        lots_.between(0, 5 * second_us);
        mine.end_us = mine.start_us + 10 * second_us;
        mine.scene = fmt::format("change {} of {}", ++changes_, server.clock_off_us);
        const Result<void> taken = server.journal->append(mine);
        if (taken) {
            acknowledged_.push_back(mine);
            return;
        }
        if (taken.error().is(JournalError::unknown)) {
            ++unknown_;
            return;
        }
        if (taken.error().is(JournalError::lapsed)) {
            ++lapsed_;
            return;
        }
        ++refused_;
        refused_scenes_.push_back(mine.scene);
    }

    /// What it holds is the beginning of the log, whatever happened.
    void look_at(Server& server) {
        const std::uint32_t last = server.journal->standing().last_epoch;
        stale_ += !server.journal->standing().current;
        if (last > engine_.messages.size())
            return (void)(wrong_ = "a server holds a change that the log does not");
        for (; server.held < last; ++server.held) {
            const LoggedChange logged = read_message(engine_.messages[server.held].message).value();
            SeaChange here = server.journal->since(server.held).value().front();
            here.lapsed = false;
            if (!(here == logged.change))
                return (void)(wrong_ =
                                  fmt::format("change {} is another one here", server.held + 1));
        }
    }

    /// Of two servers that call themselves current, at one time of the sea: the same change runs.
    void agree() {
        std::optional<std::size_t> runs;
        // As far ahead as keyframes are published.
        const std::int64_t at_us = now_us_ + lead_us / 2;
        for (const Server& server : servers_) {
            if (!server.journal || !server.journal->standing().current ||
                now_us_ < server.listens_us)
                continue;
            const std::vector<SeaChange> held = server.journal->since(0).value();
            std::size_t here = 0;
            for (std::size_t i = 0; i < held.size(); ++i)
                if (held[i].start_us <= at_us && !held[i].lapsed)
                    here = i;
            if (runs && *runs != here)
                wrong_ = fmt::format("at {} us two servers that are current have changes {} and {}",
                                     at_us, *runs + 1, here + 1);
            runs = here;
        }
    }

    /// All is well again: every server has the same log, with all that was acknowledged and nothing that was refused.
    void heal() {
        engine_.down = false;
        engine_.parted_us.reset();
        engine_.settle();
        for (std::size_t i = 0; i < servers_.size() && wrong_.empty(); ++i) {
            LotLine::let_come(engine_, servers_[i].line, lots_, now_us_);
            servers_[i].line = {};
        }
        for (std::size_t i = 0; i < servers_.size() && wrong_.empty(); ++i) {
            if (!servers_[i].journal)
                start(servers_[i], i);
            servers_[i].journal->poll();
            now_us_ += SharedJournal::settles_us; // it may have been stale
            servers_[i].journal->poll();
            look_at(servers_[i]);
            const JournalStanding standing = servers_[i].journal->standing();
            if (!standing.current || !standing.trouble.empty() ||
                standing.last_epoch != engine_.messages.size())
                wrong_ = "a server does not follow after all has healed: " + standing.trouble;
        }
        std::vector<std::string> scenes;
        for (const SharedLog::Stored& stored : engine_.messages)
            scenes.push_back(read_message(stored.message)->change.scene);
        for (const SeaChange& change : acknowledged_)
            if (change.epoch > scenes.size() || scenes[change.epoch - 1] != change.scene)
                wrong_ = fmt::format("change {} was acknowledged and is lost", change.epoch);
        for (const std::string& scene : refused_scenes_)
            if (std::ranges::find(scenes, scene) != scenes.end())
                wrong_ = "a change that was refused is in the log: " + scene;
        std::ranges::sort(scenes);
        if (std::ranges::adjacent_find(scenes) != scenes.end())
            wrong_ = "a change is in the log twice";
    }

    Lots lots_;
    std::int64_t now_us_ = 0, settles_us_ = 0;
    LotEngine engine_;
    std::vector<Server> servers_;
    std::vector<SeaChange> acknowledged_;
    std::vector<std::string> refused_scenes_;
    int lapsed_ = 0, writers_ = 0, changes_ = 0, unknown_ = 0, refused_ = 0, stale_ = 0, joins_ = 0;
    std::string wrong_;
};

} // namespace histories

TEST(SharedJournal, a_thousand_histories_keep_every_promise) {
    const char* one = std::getenv("SEAWAY_SEED");
    const std::uint64_t first = one ? std::strtoull(one, nullptr, 10) : 1;
    const std::uint64_t count = one ? 1 : 1000;
    std::size_t acknowledged = 0;
    int unknown = 0, refused = 0, stale = 0, joins = 0;
    for (std::uint64_t seed = first; seed < first + count; ++seed) {
        histories::History history(seed);
        const std::string wrong = history.live();
        ASSERT_EQ(wrong, "") << "SEAWAY_SEED=" << seed;
        acknowledged += history.acknowledged();
        unknown += history.unknown();
        refused += history.refused();
        stale += history.stale();
        joins += history.joins();
    }
    // Of a thousand there is a good deal of each.
    if (!one) {
        EXPECT_GT(acknowledged, 10'000u);
        EXPECT_GT(unknown, 500);
        EXPECT_GT(refused, 1'000);
        EXPECT_GT(stale, 10'000);
        EXPECT_GT(joins, 30) << "leaders that came back with what they had kept";
    }
}

} // namespace
} // namespace seaway::server
