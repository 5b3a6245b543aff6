// SPDX-License-Identifier: Apache-2.0
// Who changes the sea, over a journal that others write and for which there is no memory at times.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "protocol/messages.h"
#include "sea/scene/weather.h"
#include "server/sea_director.h"
#include "tests/server/forgetful_journal.h"
#include "tests/server/simulation/simulation_bench.h"
#include "tests/support/eventually.h"

namespace seaway::server {
namespace {

class Director : public testing::Test {
  protected:
    static std::string windy() {
        const TomlAssignment wind{"systems.0.wind_speed_10m_mps", "14.0"};
        return sea::to_toml(sea::changed(small_scene(), {&wind, 1}).value());
    }
    SeaWish wish() const {
        SeaWish wish;
        wish.scene = windy();
        wish.over_us = 20'000'000;
        return wish;
    }
    /// What comes of it.
    template <class Changes, class Wish>
    static Result<SeaPromise> asked_of(Changes& changes, Wish wish) {
        std::promise<Result<SeaPromise>> promise;
        changes.change(std::move(wish),
                       [&promise](Result<SeaPromise> made) { promise.set_value(std::move(made)); });
        return promise.get_future().get();
    }
    /// Takes longer to be made, and so begins later, than wish().
    SeaWish long_made() const {
        SeaWish made = wish();
        made.scene += "[[sea.system]]\ntype = \"sines\"\nshape = \"exponential\"\n"
                      "length_m = 43\nwavelength_m = 20\ncount = 64\nfrom_deg = 0\n"
                      "wavenumber_ratio = 1.03\namplitude_m = 0.05\n";
        return made;
    }
    Result<SeaPromise> asked(SeaWish wish) { return asked_of(*director, std::move(wish)); }
    Result<SeaPromise> through_world(Result<SeaWish> wish) {
        return asked_of(world, std::move(wish));
    }
    Following following() const { return world.following().value(); }

    const std::shared_ptr<SeaCourse> course = SeaCourse::begin(small_scene()).value();
    ForgetfulJournal journal{{1, 0, 0, sea::to_toml(small_scene())}};
    SeaClock clock{SeaClock::utc_now_us()};
    World world{course, clock};
    std::unique_ptr<SeaDirector> director =
        std::make_unique<SeaDirector>(course, &journal, 1, world, clock);
};

TEST_F(Director, a_change_of_others_for_which_there_is_no_memory_is_played_once_there_is) {
    const TimeUs start_us = clock.now_us() + 60'000'000;
    journal.reads_fail = 3;
    journal.by_another({2, start_us, start_us + 20'000'000, windy()});
    EXPECT_TRUE(tests::eventually([&] { return course->epochs() == 3u; }));
    EXPECT_EQ(journal.reads_fail, 0);
    EXPECT_TRUE(tests::eventually([&] { return following().played == 2u; }));
    EXPECT_EQ(course->window(2).start_us, start_us);
    EXPECT_EQ(following().doubt(), "");
}

TEST_F(Director, one_of_its_own_that_was_written_before_there_was_no_memory_is_played_too) {
    journal.appends_fail = 1;
    const Result<SeaPromise> made = asked(wish());
    ASSERT_FALSE(made);
    EXPECT_NE(made.error().message.find("change 2 may be in the journal"), std::string::npos)
        << made.error().message;
    ASSERT_TRUE(tests::eventually([&] { return course->epochs() == 3u; }))
        << "it stands in the journal";
    EXPECT_TRUE(tests::eventually([&] { return following().played == 2u; }));
    EXPECT_EQ(course->window(2).start_us, journal.since(1)->front().start_us);
    const Result<SeaPromise> next = asked(wish());
    ASSERT_TRUE(next) << next.error().message;
    EXPECT_EQ(journal.since(2)->front().epoch, 3u);
    EXPECT_EQ(following().played, 3u);
}

// Naive: a change begins the later the longer it takes to be made, so that one that is asked for behind it, and made sooner, begins
// before it: it would be lost.
// Naive: of what begins by itself the journal knows nothing, and a clock that is behind after a start takes over from it.
TEST_F(Director, the_journal_is_told_of_each_sea_that_begins) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1500)); // a look or two
    EXPECT_EQ(journal.begun, 0) << "the first sea has run for ever";
    const Result<SeaPromise> promise = asked(wish());
    ASSERT_TRUE(promise) << promise.error().message;
    ASSERT_TRUE(tests::eventually([&] { return journal.begun == 1; }));
    EXPECT_GE(clock.now_us(), promise->start_us);
}

TEST_F(Director, changes_begin_in_the_order_in_which_they_were_asked_for) {
    const Result<SeaPromise> first = asked(long_made()), second = asked(wish());
    ASSERT_TRUE(first) << first.error().message;
    ASSERT_TRUE(second) << second.error().message;
    EXPECT_GE(second->start_us, first->start_us);
    SeaWish later = wish();
    later.at_us = second->start_us + 100'000'001; // no keyframe lies there
    EXPECT_EQ(asked(later)->start_us, later.at_us);
    const Result<SeaPromise> at_once = asked(wish());
    ASSERT_TRUE(at_once) << at_once.error().message;
    EXPECT_LT(at_once->start_us, later.at_us) << "who names no time waits for none that was named";
}

// Naive: one whose time had not come when it was written keeps its place only if it was to have it.
TEST_F(Director, a_change_whose_time_was_too_early_begins_in_that_order_too) {
    journal.spread = 20'000'000; // as soon as can be is behind that
    SeaWish early = long_made();
    early.at_us = clock.now_us() + 15'000'000; // has not come when it is made
    const Result<SeaPromise> first = asked(early), second = asked(wish());
    ASSERT_TRUE(first && second);
    EXPECT_GT(first->start_us, early.at_us);
    EXPECT_GE(second->start_us, first->start_us);
}

// Naive: each is moved on to where keyframes of its own two seas meet: the second, for which they do not, begins before the first,
// takes over from it, and was made of a sea in which it is not in force.
TEST_F(Director, changes_for_one_time_begin_exactly_then_and_are_all_in_force) {
    const TomlAssignment values[] = {{"systems.0.from_deg", "60"},
                                     {"systems.0.wind_speed_10m_mps", "14.0"},
                                     {"sea.depth_m", "30"}};
    const TimeUs at_us = clock.now_us() + 100'000'001; // no keyframe lies there
    sea::Scene all = small_scene();
    for (const TomlAssignment& value : values) {
        SeaWish set;
        set.set = {value};
        set.over_us = 30'000'000;
        set.at_us = at_us;
        const Result<SeaPromise> made = asked(set);
        ASSERT_TRUE(made) << made.error().message;
        EXPECT_EQ(made->start_us, at_us);
        all = sea::changed(all, {&value, 1}).value();
    }
    EXPECT_EQ(sea::to_toml(course->scene_at(at_us)), sea::to_toml(all));
}

// Naive: what is to be made for it takes less time than for the one before, so that the time can be kept, and that one is lost.
TEST_F(Director, a_change_for_a_time_that_was_too_early_for_the_one_before_begins_behind_that_one) {
    journal.spread = 20'000'000;
    SeaWish early = wish();
    early.at_us = clock.now_us() + 15'000'000;
    const Result<SeaPromise> first = asked(early);
    ASSERT_TRUE(first && first->start_us > early.at_us);
    journal.spread = 0;                          // so that a change may begin after two seconds
    for (const TimeUs later_us : {0, 500'000}) { // naive: of that very time alone
        early.at_us += later_us;
        const Result<SeaPromise> behind = asked(early);
        ASSERT_TRUE(behind && behind->start_us >= first->start_us) << later_us;
    }
}

// Naive: those that were taken over from, and never begin, keep their places until their times have passed.
TEST_F(Director, changes_that_another_takes_over_from_are_promised_no_more) {
    journal.spread = 0; // so that a change may begin after two seconds
    const auto asked_at = [this](TimeUs at_us) {
        SeaWish at = wish();
        at.at_us = at_us;
        return asked(at);
    };
    for (const bool by_another : {false, true}) {
        const TimeUs later_us = clock.now_us() + 6'000'000;
        std::size_t promised = 0;
        for (TimeUs last_us = later_us;; ++promised) {
            ASSERT_LT(last_us, clock.now_us() + World::announced_ahead_us) << "all are told";
            const Result<SeaPromise> made = asked_at(last_us + 400'000);
            if (!made)
                break;
            ASSERT_GT(made->start_us, last_us);
            last_us = made->start_us;
        }
        // At least: the one that the first round ended with keeps its place until it begins, which on a busy machine it has by now.
        EXPECT_GE(promised, by_another ? changes_promised_max - 1 : changes_promised_max);
        const TimeUs start_us =
            later_us - 200'000; // a busy machine takes most of a second for each
        if (by_another) {
            const std::uint32_t number = following().played + 1;
            journal.by_another({number, start_us, start_us + 20'000'000, windy()});
            ASSERT_TRUE(tests::eventually([&] { return following().played == number; }));
        } else {
            const Result<SeaPromise> made = asked_at(start_us);
            ASSERT_TRUE(made) << made.error().message;
        }
        const Result<SeaPromise> next = asked(wish()); // takes over from that one
        EXPECT_TRUE(next) << next.error().message;
    }
}

// Naive: each correction keeps a place, and ten seconds before the plan begins nobody can change the sea.
TEST_F(Director, a_plan_that_was_corrected_often_is_one_change_when_its_time_comes_near) {
    journal.spread = 0;
    SeaWish plan = wish();
    plan.at_us = clock.now_us() + World::announced_ahead_us + 3'000'000; // nobody is told of it yet
    for (std::size_t i = 0; i < 2 * changes_promised_max; ++i)
        ASSERT_TRUE(asked(plan));
    ASSERT_TRUE(tests::eventually(
        [&] { return clock.now_us() + World::announced_ahead_us > plan.at_us + 2'000'000; }));
    const Result<SeaPromise> other = asked(wish());
    EXPECT_TRUE(other) << other.error().message;
}

// Naive: the server has run on while it was written, its clients follow what it says, and who starts it anew has an earlier sea.
TEST_F(Director, a_pace_that_was_written_too_late_is_followed_by_one_in_which_all_meet) {
    std::atomic<int> handed_over = 0;
    world.hand_over_by([&handed_over](const std::string&, const std::string&) { ++handed_over; });
    std::vector<protocol::Bytes>
        told; // on the director's thread, which has written when it answers
    world.announce_to([&told](const SharedBytes& message) { told.push_back(*message); });
    journal.spread = 0; // a pace is to hold after a second
    journal.appends_take_ms = 1500;
    SeaWish pause;
    pause.pace_permille = 0;
    const Result<SeaPromise> made = asked(pause);
    ASSERT_TRUE(made) << made.error().message;
    const std::vector<SeaChange> written = journal.since(1).value();
    ASSERT_GE(written.size(), 2u) << "and more where a busy machine took longer still";
    const sea::Pace second = written.back().pace.value();
    EXPECT_EQ(made->change, written.size() + 1);
    EXPECT_EQ(made->start_us, second.sea_us);
    ASSERT_EQ(told.size(), 1u) << "one that held already is nothing that anybody can follow";
    EXPECT_EQ(told.front(), protocol::pace(second));
    EXPECT_EQ(second.sea_us, second.from_us) << "it has run at pace 1 until then, without a jump";
    ASSERT_TRUE(
        tests::eventually([&] { return clock.moment().elapsed_us > second.from_us + 200'000; }));
    EXPECT_EQ(clock.now_us(), second.sea_us);
    sea::Paces from_journal;
    for (const SeaChange& change : written)
        from_journal.add(change.pace.value());
    SeaClock started_anew(clock.moment().epoch_utc_us, SeaClock::utc_now_us, local_now_us,
                          from_journal);
    EXPECT_EQ(started_anew.now_us(), clock.now_us());
    EXPECT_EQ(handed_over, 0);
}

// Others may follow it by then: it knows that it runs beside them.
TEST_F(Director,
       is_unsure_from_a_pace_of_its_own_that_it_passed_over_to_the_one_in_which_all_meet) {
    journal.appends_take_ms = 4000;
    SeaWish pause;
    pause.pace_permille = 0;
    const Result<SeaPromise> made = asked(pause);
    ASSERT_TRUE(made) << made.error().message;
    const sea::Pace second = journal.since(1).value().back().pace.value();
    ASSERT_LT(clock.moment().elapsed_us, second.from_us) << "all can hear of it";
    EXPECT_EQ(following().kind_of_doubt(), Doubt::writing);
    ASSERT_TRUE(tests::eventually([&] { return clock.moment().elapsed_us > second.from_us; }));
    EXPECT_EQ(following().kind_of_doubt(), Doubt::none);
}

// Naive: at a pace of 0 it is ahead of all others, and of its own clients, for as long as that lasts.
TEST_F(Director, who_hears_of_a_pause_after_it_began_goes_back_to_where_it_began) {
    const TimeUs from_us = clock.moment().elapsed_us - 1'000'000;
    journal.by_another({.epoch = 2, .scene = {}, .pace = sea::Pace{from_us, from_us, 0}});
    ASSERT_TRUE(tests::eventually([&] { return following().played == 2u; }));
    EXPECT_EQ(clock.now_us(), from_us);
    EXPECT_EQ(following().kind_of_doubt(), Doubt::none);
}

// A second is waited for, in doubt.
TEST_F(Director,
       who_hears_of_a_slower_pace_a_little_late_is_in_doubt_until_the_sea_has_come_there) {
    sea::Pace pace;
    TimeUs before_us = 0;
    Following now;
    // It lasts a second, which a busy machine may sleep through, or hear of so late that the sea goes back: of a few times once is enough.
    for (std::uint32_t n = 2; n < 7 && now.kind_of_doubt() != Doubt::ahead; ++n) {
        const TimeUs from_us = clock.moment().elapsed_us - 1'000'000;
        pace = {from_us, pace.sea_time(from_us), pace.permille / 2};
        before_us = clock.now_us();
        journal.by_another({.epoch = n, .scene = {}, .pace = pace});
        ASSERT_TRUE(tests::eventually([&] {
            now = following();
            return now.played == n && now.kind_of_doubt() != Doubt::behind;
        }));
    }
    ASSERT_EQ(now.kind_of_doubt(), Doubt::ahead);
    EXPECT_NE(now.doubt().find("heard of a pace too late"), std::string::npos);
    EXPECT_GE(clock.now_us(), before_us);
    EXPECT_TRUE(tests::eventually([&] { return following().kind_of_doubt() == Doubt::none; }));
}

// The sea has leapt under those who are here: they are to go where it has not.
TEST_F(Director, a_pace_that_held_already_when_it_came_hands_the_sessions_over) {
    std::atomic<int> handed_over = 0;
    world.hand_over_by([&handed_over](const std::string& why, const std::string&) {
        handed_over += why == "a change of the sea was missed";
    });
    const auto pace_from = [this](TimeUs ahead_us, int permille) {
        const TimeUs from_us = clock.moment().elapsed_us + ahead_us;
        return sea::Pace{from_us, from_us, permille};
    };
    journal.by_another({.epoch = 2, .scene = {}, .pace = pace_from(60'000'000, 500)});
    ASSERT_TRUE(tests::eventually([&] { return following().played == 2u; }));
    EXPECT_EQ(handed_over, 0) << "this one is still to come";
    journal.by_another({.epoch = 3, .scene = {}, .pace = pace_from(-1'000'000, 2000)});
    EXPECT_TRUE(tests::eventually([&] { return handed_over == 1; }));
}

// Naive: a disk that takes six seconds makes a change that has begun by then; nobody knew, and all looked certain.
TEST_F(Director, a_change_of_its_own_that_is_written_too_late_is_a_doubt_and_starts_sessions_anew) {
    std::atomic<int> handed_over = 0;
    world.hand_over_by([&handed_over](const std::string& why, const std::string&) {
        handed_over += why == "a change of the sea was missed";
    });
    journal.appends_take_ms = 6000; // it would begin after three, and one and an interval
    std::promise<Result<SeaPromise>> made;
    director->change(wish(), [&made](auto promise) { made.set_value(std::move(promise)); });
    EXPECT_TRUE(tests::eventually([&] { return world.sea_time().unsure_us > 1'000'000; }));
    EXPECT_EQ(following().kind_of_doubt(), Doubt::writing);
    EXPECT_TRUE(made.get_future().get());
    EXPECT_TRUE(tests::eventually([&] { return handed_over == 1; }));
}

// Naive: a log that was away for three seconds sends the sessions of all its servers from one to another when it is back.
TEST_F(Director,
       a_doubt_that_is_about_to_pass_sends_nobody_to_others_and_one_that_stays_does_once) {
    std::atomic<int> handed_over = 0;
    world.hand_over_by([&handed_over](const std::string&, const std::string&) { ++handed_over; });
    JournalStanding away{.unheard_us = 3'000'000, .current = false, .settles = true};
    away.peers.peers = 2;
    journal.stand(away);
    ASSERT_TRUE(tests::eventually([&] { return !following().doubt().empty(); }));
    std::this_thread::sleep_for(std::chrono::seconds(1)); // several looks of the director's
    EXPECT_EQ(handed_over, 0);
    away.settles = false;
    journal.stand(away);
    EXPECT_TRUE(tests::eventually([&] { return handed_over == 1; }));
    std::this_thread::sleep_for(std::chrono::seconds(1));
    EXPECT_EQ(handed_over, 1);
}

// Naive: announcements wait for a moment in which nobody wishes anything.
TEST_F(Director, seas_are_told_of_however_many_wishes_are_refused_meanwhile) {
    std::atomic<int> told = 0, refused = 0, asking = 0;
    std::atomic<bool> goes_on = true;
    world.announce_to([&told](const SharedBytes&) { ++told; });
    SeaWish wrong = wish();
    wrong.scene = "[sea]\nseed = \"x\"\n";
    std::function<void()> again = [&] {
        ++asking;
        director->change(wrong, [&](const Result<SeaPromise>& made) {
            refused += !made;
            if (goes_on)
                again();
            --asking;
        });
    };
    for (int i = 0; i < 4; ++i)
        again();
    EXPECT_TRUE(tests::eventually([&] { return refused > 8; }));
    const int before = told;
    const TimeUs start_us = clock.now_us() + 5'000'000;
    journal.by_another({2, start_us, start_us + 20'000'000, windy()});
    EXPECT_TRUE(tests::eventually([&] { return told > before; }));
    goes_on = false;
    EXPECT_TRUE(tests::eventually([&] { return asking == 0; }));
}

// Naive: so long as the sea takes, which at half its pace is half of what it will be.
TEST_F(Director, when_to_ask_again_is_told_by_the_clock_of_who_asks) {
    clock.follow(clock.next_pace(clock.moment().elapsed_us, 500));
    TimeUs first_us = 0;
    SeaWish next = wish();
    for (std::size_t i = 0; i < changes_promised_max; ++i) {
        const Result<SeaPromise> made = asked(next);
        ASSERT_TRUE(made) << made.error().message;
        first_us = i == 0 ? made->start_us : first_us;
        next.at_us = made->start_us + 1; // one that began with it would take its place
    }
    const TimeUs before_us = clock.now_us();
    const Result<SeaPromise> busy = asked(wish());
    const TimeUs after_us = clock.now_us();
    ASSERT_FALSE(busy);
    ASSERT_TRUE(busy.error().is(Refusal::busy)) << busy.error().message;
    const double wait_us = 1000.0 * busy.error().retry_after_ms;
    EXPECT_GE(wait_us, 2.0 * static_cast<double>(first_us - after_us) - 2000);
    EXPECT_LE(wait_us, 2.0 * static_cast<double>(first_us - before_us) + 2000);
    clock.follow(clock.next_pace(clock.moment().elapsed_us, 0));
    const Result<SeaPromise> never = asked(wish());
    ASSERT_FALSE(never);
    EXPECT_NE(never.error().message.find("ask again when the sea runs"), std::string::npos)
        << never.error().message;
}

// Naive: anybody who asks whether a server is ready reads where its NATS is, or where a scene lies.
TEST_F(Director, says_that_it_is_stuck_and_no_place_of_anything) {
    journal.by_another({2, clock.now_us() + 5'000'000, clock.now_us() + 25'000'000, "[sea]\nx"});
    ASSERT_TRUE(tests::eventually([&] { return !following().stuck.empty(); }));
    EXPECT_EQ(following().doubt(), "change 2 of another server cannot be played");
}

TEST_F(Director, what_it_refuses_is_counted_by_reason) {
    const auto counts = [this] { return world.changes_refused(); };
    EXPECT_EQ(counts(), (RefusedChanges::Counts{{"bad_value", 0},
                                                {"busy", 0},
                                                {"full", 0},
                                                {"gone", 0},
                                                {"not_offered", 0},
                                                {"unwritten", 0}}));
    const Result<SeaPromise> made = through_world(wish());
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ(made->change, 2u) << "its number in the journal";
    SeaWish wrong = wish();
    wrong.scene = "[sea]\nseed = \"x\"\n";
    EXPECT_FALSE(through_world(wrong));
    const Result<SeaPromise> before_it_came =
        through_world(Error{Refusal::bad_value, "over_us is 1, allowed are 10000000 to ..."});
    ASSERT_FALSE(before_it_came);
    EXPECT_EQ(before_it_came.error().message, "over_us is 1, allowed are 10000000 to ...");
    journal.refuses = JournalError::outrun;
    EXPECT_FALSE(through_world(wish()));
    EXPECT_FALSE(through_world(wish()));
    journal.refuses = JournalError::unknown;
    EXPECT_FALSE(through_world(wish()));
    EXPECT_EQ(counts(), (RefusedChanges::Counts{{"bad_value", 2},
                                                {"busy", 2},
                                                {"full", 0},
                                                {"gone", 0},
                                                {"not_offered", 0},
                                                {"unwritten", 1}}));
    world.change_by(nullptr);
    EXPECT_FALSE(through_world(wish()));
    EXPECT_EQ(counts().at("not_offered"), 1u);
    const std::string page = metrics_text(counts());
    for (const char* row : {"bad_value\"} 2\n", "busy\"} 2\n", "unwritten\"} 1\n"})
        EXPECT_NE(page.find(std::string("seaway_changes_refused_total{reason=\"") + row),
                  std::string::npos)
            << page;
    EXPECT_NE(page.find("# TYPE seaway_changes_refused_total counter\n"), std::string::npos);
}

} // namespace
} // namespace seaway::server
