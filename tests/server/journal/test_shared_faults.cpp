// SPDX-License-Identifier: Apache-2.0
// A shared journal whose engine loses what it acknowledged, lags, hangs, or is cut off from its others.
#include <atomic>
#include <new>
#include <thread>

#include <gtest/gtest.h>

#include "server/journal/sea_clock.h"
#include "server/journal/shared_journal.h"
#include "tests/server/journal/journals.h"
#include "tests/server/journal/lot_network.h"
#include "tests/support/allocations.h"
#include "tests/support/eventually.h"

namespace seaway::server {
namespace {

using namespace tests_of_journals;

constexpr std::int64_t one_second_us = 1'000'000;

class SharedFaults : public testing::Test {
  protected:
    struct Server {
        LotLine::State line;
        std::unique_ptr<SharedJournal> journal;
    };
    void open(Server& server) {
        server.line.takes_us = 0;
        auto opened = SharedJournal::open(
            std::make_unique<LotLine>(engine, server.line, lots, now_us), beginning,
            {"log", "writer" + std::to_string(next_number()), [this] { return now_us; },
             [this] { return now_us; }});
        ASSERT_TRUE(opened) << opened.error().message;
        server.journal = *std::move(opened);
    }
    SeaChange next(const Server& server) {
        return change(server.journal->standing().last_epoch + 1);
    }
    /// A second later, so that each message has a moment of its own.
    Result<void> append(Server& server) {
        now_us += one_second_us;
        return server.journal->append(next(server));
    }

    LotEngine engine;
    Lots lots{15};
    std::int64_t now_us = 1'700'000'000'000'000;
    Server first, second;
};

// A node without its newest message: a loss of power, or a backup that was put back.
TEST_F(SharedFaults, a_log_whose_end_was_lost_and_written_anew_is_not_the_one_that_was_followed) {
    open(first);
    ASSERT_TRUE(append(first));
    ASSERT_TRUE(append(first));
    engine.messages.pop_back();
    first.journal->poll();
    EXPECT_NE(first.journal->standing().trouble.find("its end was lost"), std::string::npos);
    open(second);
    for (int more = 0; more < 3; ++more) { // as long as the one that was followed, and longer
        ASSERT_TRUE(append(second)) << more;
        now_us += 3 * one_second_us;
        first.journal->poll();
        EXPECT_FALSE(first.journal->standing().current) << more;
        EXPECT_NE(first.journal->standing().trouble.find("another change 3 than was followed"),
                  std::string::npos)
            << first.journal->standing().trouble;
        EXPECT_FALSE(append(first)) << "it would be written to another sea's log";
        EXPECT_EQ(first.journal->standing().last_epoch, 3u);
    }
    EXPECT_EQ(engine.messages.size(), 5u);
    Server third;
    open(third); // the log is whole for who reads it now
    EXPECT_EQ(third.journal->standing().last_epoch, 5u);
}

// As nodes of a cluster that were parted and joined again have been seen to give it.
TEST_F(SharedFaults,
       a_change_that_is_read_again_at_another_time_is_still_the_one_that_was_followed) {
    open(first);
    ASSERT_TRUE(append(first));
    for (const std::int64_t off_us : {-300'000, 300'000}) {
        engine.messages.back().at_utc_us += off_us;
        first.journal->poll();
        EXPECT_EQ(first.journal->standing().trouble, "") << off_us;
        const Result<void> taken =
            append(first); // which reads it once more, with the one behind it
        ASSERT_TRUE(taken) << taken.error().message;
    }
    engine.messages.back().at_utc_us += 5 * one_second_us; // for who reads it now it has lapsed
    first.journal->poll();
    EXPECT_NE(first.journal->standing().trouble.find("another change 4 than was followed"),
              std::string::npos)
        << first.journal->standing().trouble;
}

TEST_F(SharedFaults, who_leads_alone_does_not_know_whether_the_log_goes_on_elsewhere) {
    open(first);
    first.journal->poll();
    EXPECT_TRUE(first.journal->standing().current);
    first.line.unsure_us = SharedJournal::current_us + 1;
    first.journal->poll();
    EXPECT_FALSE(first.journal->standing().current);
    EXPECT_EQ(first.journal->standing().unheard_us, SharedJournal::current_us + 1);
    EXPECT_FALSE(first.journal->standing().settles);
    const Result<void> taken = append(first);
    ASSERT_FALSE(taken);
    EXPECT_TRUE(taken.error().is(JournalError::unreachable)) << taken.error().message;
    EXPECT_NE(taken.error().message.find("has not heard of a majority for 2.0 s"),
              std::string::npos)
        << taken.error().message;
    EXPECT_EQ(engine.messages.size(), 1u);
    // Joined to the others again it may bring what it was told before.
    first.line.unsure_us = 0;
    first.journal->poll();
    EXPECT_FALSE(first.journal->standing().current);
    EXPECT_TRUE(first.journal->standing().settles);
    now_us += SharedJournal::settles_us;
    first.journal->poll();
    EXPECT_TRUE(first.journal->standing().current);
    EXPECT_FALSE(first.journal->standing().settles);
}

TEST_F(SharedFaults, after_a_silence_a_log_has_to_answer_for_a_while_without_a_gap) {
    open(first);
    now_us += SharedJournal::current_us + 1;
    EXPECT_FALSE(first.journal->standing().current);
    for (int i = 0; i < 3; ++i) { // a gap each time
        first.journal->poll();
        EXPECT_FALSE(first.journal->standing().current) << i;
        now_us += SharedJournal::settles_us - 1;
        EXPECT_TRUE(first.journal->standing().settles) << i;
        first.line.cut = true;
        first.journal->poll();
        EXPECT_FALSE(first.journal->standing().settles) << i;
        first.line.cut = false;
        now_us += 1;
    }
    first.journal->poll();
    now_us += SharedJournal::settles_us;
    first.journal->poll();
    EXPECT_TRUE(first.journal->standing().current);
    EXPECT_EQ(first.journal->standing().unheard_us, 0);
}

// A message that nodes give at two times, before and behind the moment by which it had to be stored.
TEST_F(SharedFaults, who_took_another_verdict_on_a_change_follows_no_other_sea_silently) {
    open(first);
    ASSERT_TRUE(append(first));
    second.line.other_copy_of = 2;
    second.line.other_copy_off_us = 5 * one_second_us;
    open(second);
    ASSERT_TRUE(second.journal->since(1)->front().lapsed);
    ASSERT_FALSE(first.journal->since(1)->front().lapsed);
    for (Server* writes : {&first, &second}) {
        Server& reads = writes == &first ? second : first;
        ASSERT_TRUE(append(*writes));
        reads.journal->poll();
        EXPECT_EQ(reads.journal->standing().last_epoch, 2u);
        EXPECT_NE(reads.journal->standing().trouble.find(writes == &first
                                                             ? "has not lapsed as it has here"
                                                             : "has lapsed as it has not here"),
                  std::string::npos)
            << reads.journal->standing().trouble;
        EXPECT_FALSE(append(reads));
        engine.messages.pop_back(); // and the other way round
        engine.ids.clear();
        for (Server* server : {&first, &second})
            open(*server);
    }
}

TEST_F(SharedFaults, a_change_that_was_taken_and_does_not_show_yet_is_unknown_and_comes) {
    open(first);
    ASSERT_TRUE(append(first));
    const SeaChange mine = next(first);
    first.line.lags_after_writes = 1;
    const Result<void> taken = first.journal->append(mine);
    ASSERT_FALSE(taken);
    EXPECT_TRUE(taken.error().is(JournalError::unknown)) << taken.error().message;
    first.line.lags = 0;
    first.journal->poll();
    EXPECT_EQ(first.journal->standing().last_epoch, mine.epoch);
}

// The end of the log is looked at before ids are, as who leads a cluster may do.
TEST_F(SharedFaults, a_repeat_that_was_outrun_by_its_own_first_attempt_is_taken) {
    engine.refuses_repeats = true;
    open(first);
    for (int lost = 1; lost < SharedJournal::writes_max; ++lost) {
        now_us += one_second_us;
        const SeaChange mine = next(first);
        first.line.answers_lost = lost;
        const Result<void> taken = first.journal->append(mine);
        EXPECT_TRUE(taken) << taken.error().message;
        EXPECT_EQ(first.journal->since(mine.epoch - 1).value(), std::vector<SeaChange>{mine});
    }
}

TEST_F(SharedFaults, a_repeat_that_was_refused_and_cannot_see_what_stands_there_is_unknown) {
    engine.refuses_repeats = true;
    open(first);
    first.line.answers_lost = 1;
    first.line.reads_behind = SharedJournal::writes_max - 2;
    EXPECT_TRUE(first.journal->append(next(first))) << "the last repeat sees it";
    now_us += one_second_us;
    const SeaChange mine = next(first);
    first.line.answers_lost = 1;
    first.line.reads_behind = SharedJournal::writes_max - 1;
    const Result<void> taken = first.journal->append(mine);
    ASSERT_FALSE(taken);
    EXPECT_TRUE(taken.error().is(JournalError::unknown)) << taken.error().message;
    first.journal->poll();
    EXPECT_EQ(first.journal->since(mine.epoch - 1).value(), std::vector<SeaChange>{mine});
}

TEST_F(SharedFaults, of_who_was_outrun_by_another_nothing_is_taken) {
    engine.refuses_repeats = true;
    open(first);
    open(second);
    first.line.comes_first = [&] {
        now_us += one_second_us;
        ASSERT_TRUE(second.journal->append(next(second)));
    };
    SeaChange mine = next(first);
    mine.scene = "of the first";
    const Result<void> taken = first.journal->append(mine);
    ASSERT_FALSE(taken);
    EXPECT_TRUE(taken.error().is(JournalError::outrun)) << taken.error().message;
    first.journal->poll();
    EXPECT_EQ(first.journal->since(1).value(), std::vector<SeaChange>{change(2)});
    EXPECT_EQ(engine.messages.size(), 2u);
}

// Its start was planned when it was asked for: what waits longer than it may would begin before all know of it.
TEST_F(SharedFaults, a_change_that_waits_for_a_slow_log_is_refused_and_not_written) {
    open(first);
    first.line.takes_us = 0;
    first.line.hangs_us = SharedJournal::stored_within_us + 1;
    const Result<void> taken = first.journal->append(next(first));
    ASSERT_FALSE(taken);
    EXPECT_TRUE(taken.error().is(JournalError::unreachable)) << taken.error().message;
    EXPECT_EQ(engine.messages.size(), 1u);
    first.line.hangs_us = 0;
    EXPECT_TRUE(append(first));
}

// The machine's clock was set, by an hour and by less than the sea follows at once. The sea's runs on as those of the others do.
TEST_F(SharedFaults, a_change_is_made_by_the_clock_of_the_sea_and_not_by_the_machines) {
    for (const std::int64_t set_by_us : {-3600 * one_second_us, -5 * one_second_us}) {
        auto opened = SharedJournal::open(
            std::make_unique<LotLine>(engine, first.line, lots, now_us), beginning,
            {"log", "writer" + std::to_string(next_number()), [this] { return now_us; },
             [&, this] { return now_us + set_by_us; }});
        ASSERT_TRUE(opened) << opened.error().message;
        first.journal = *std::move(opened);
        const Result<void> by_the_machine = append(first);
        ASSERT_FALSE(by_the_machine);
        EXPECT_TRUE(by_the_machine.error().is(JournalError::clock_behind));
        first.journal->compare_clocks([this] { return now_us - beginning.epoch_utc_us; });
        const Result<void> by_the_sea = append(first);
        EXPECT_TRUE(by_the_sea) << by_the_sea.error().message;
    }
    // The sea behind the machine, which is right: one change shows it, and those after it are not written.
    auto behind = SharedJournal::open(
        std::make_unique<LotLine>(engine, first.line, lots, now_us), beginning,
        {"log", "behind", [this] { return now_us; }, [this] { return now_us; }});
    ASSERT_TRUE(behind);
    first.journal = *std::move(behind);
    first.journal->compare_clocks(
        [this] { return now_us - beginning.epoch_utc_us - 5 * one_second_us; });
    const Result<void> shown = first.journal->append(next(first));
    ASSERT_FALSE(shown);
    EXPECT_TRUE(shown.error().is(JournalError::clock_behind));
    const std::size_t written = engine.messages.size();
    first.journal->poll();
    const Result<void> known = first.journal->append(next(first));
    ASSERT_FALSE(known);
    EXPECT_NE(known.error().message.find("is 5.0 s behind UTC"), std::string::npos)
        << known.error().message;
    EXPECT_EQ(engine.messages.size(), written);
    // Ahead: stored a second late it would begin before all know of it, and has lapsed all the same.
    auto opened = SharedJournal::open(
        std::make_unique<LotLine>(engine, first.line, lots, now_us), beginning,
        {"log", "ahead", [this] { return now_us; }, [this] { return now_us + 9 * one_second_us; }});
    ASSERT_TRUE(opened);
    first.journal = *std::move(opened);
    first.journal->compare_clocks([this] { return now_us - beginning.epoch_utc_us; });
    first.line.comes_first = [this] { now_us += 2 * SharedJournal::stored_within_us; };
    const Result<void> late = first.journal->append(next(first));
    ASSERT_FALSE(late);
    EXPECT_TRUE(late.error().is(JournalError::lapsed)) << late.error().message;
}

/// Says and hears without a pause until it ends.
class BusyLine final : public PeerLine {
  public:
    ~BusyLine() override {
        stops_ = true;
        if (thread_.joinable())
            thread_.join();
    }
    void begin(std::function<std::string()> say,
               std::function<void(const std::string&)> hear) override {
        thread_ = std::thread([this, say = std::move(say), hear = std::move(hear)] {
            while (!stops_)
                hear(say());
        });
    }

  private:
    std::atomic<bool> stops_ = false;
    std::thread thread_;
};

TEST_F(SharedFaults, clocks_are_compared_no_more_once_that_was_ended) {
    for (int round = 0; round < 50; ++round) {
        open(first);
        first.journal->talk_over(std::make_unique<BusyLine>());
        std::atomic<bool> ended = false, called_after = false;
        first.journal->compare_clocks([&] {
            called_after = called_after || ended;
            return std::int64_t{5};
        });
        first.journal->compare_clocks({});
        ended = true;
        EXPECT_FALSE(called_after);
        first.journal.reset();
        EXPECT_FALSE(called_after);
    }
}

// Wherever it finds none while it holds three changes, the next look has the whole log.
TEST_F(SharedFaults, a_look_for_which_there_is_no_memory_is_made_up_for_by_the_next) {
    open(first);
    for (int i = 0; i < 3; ++i)
        ASSERT_TRUE(append(first));
    const std::vector<SeaChange> all = first.journal->since(0).value();
    const std::vector<SharedLog::Stored> whole = engine.messages;
    std::size_t failed = 0;
    for (bool fails = true; fails; ++failed) {
        Server late;
        engine.messages.resize(1);
        open(late); // before the three are there
        for (std::size_t i = 1; i < whole.size(); ++i)
            engine.messages.push_back(whole[i]);
        try {
            const tests::NoMemoryOnce none(failed);
            late.journal->poll();
            fails = false;
        } catch (const std::bad_alloc&) {
        }
        late.journal->poll();
        ASSERT_EQ(late.journal->since(0).value(), all) << failed;
        ASSERT_TRUE(late.journal->standing().current);
        ASSERT_EQ(late.journal->standing().trouble, "");
    }
    EXPECT_GT(failed, all.size()) << "it asks for some memory on the way";
}

/// Of one message, and for some looks of no memory.
class ForgetfulLog : public SharedLog {
  public:
    explicit ForgetfulLog(std::atomic<int>& fails) : fails_(fails) {}
    Result<Tail> tail() override {
        if (fails_ > 0 && fails_-- > 0)
            throw std::bad_alloc();
        return Tail{.last = message_.empty() ? 0u : 1u, .identity = "one", .last_at_utc_us = 5};
    }
    Result<std::vector<Stored>> read(std::uint64_t, std::uint64_t) override {
        return std::vector<Stored>{{message_, 5, "first"}};
    }
    Result<std::uint64_t> write(const std::string& message, const std::string&,
                                std::uint64_t) override {
        message_ = message;
        return 1;
    }
    void connect_no_more() override {}

  protected:
    std::string message_;

  private:
    std::atomic<int>& fails_;
};

/// Who leads it has not come to what was written when it is asked first.
class SlowLog final : public ForgetfulLog {
  public:
    using ForgetfulLog::ForgetfulLog;
    Result<Tail> tail() override {
        if (!message_.empty() && !asked_) {
            asked_ = true;
            return Tail{};
        }
        return ForgetfulLog::tail();
    }

  private:
    bool asked_ = false;
};

// Naive: an error without a kind ends the server for good, and its service manager does not start it again.
TEST(SharedJournal, a_beginning_that_is_not_shown_yet_is_asked_for_again) {
    std::atomic<int> fails = 0;
    const auto journal = SharedJournal::open(std::make_unique<SlowLog>(fails), beginning,
                                             {"log", "writer", local_now_us, SeaClock::utc_now_us});
    ASSERT_FALSE(journal);
    EXPECT_TRUE(journal.error().is(JournalError::unknown)) << journal.error().message;
}

TEST(SharedJournalThread, goes_on_after_looks_for_which_there_was_no_memory) {
    std::atomic<int> fails = 0;
    auto journal = SharedJournal::open(std::make_unique<ForgetfulLog>(fails), beginning,
                                       {"log", "writer", local_now_us, SeaClock::utc_now_us});
    ASSERT_TRUE(journal);
    (*journal)->follow();
    fails = 3;
    ASSERT_TRUE(tests::eventually([&] { return fails == 0; }));
    const std::int64_t then_us = local_now_us();
    EXPECT_TRUE(tests::eventually([&] {
        return (*journal)->standing().unheard_us < local_now_us() - then_us;
    })) << "it has looked since";
}

} // namespace
} // namespace seaway::server
