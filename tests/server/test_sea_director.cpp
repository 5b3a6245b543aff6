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

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sea/scene/weather.h"
#include "server/sea_director.h"
#include "tests/server/forgetful_journal.h"
#include "tests/server/simulation/simulation_bench.h"
#include "tests/support/eventually.h"

namespace seaway::server {
namespace {

class Director : public testing::Test {
  protected:
    static sea::Scene calm() {
        Result<sea::Scene> scene = sea::parse_scene(small_sea, "small_sea", ".");
        EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
        return *std::move(scene);
    }
    static std::string windy() {
        const TomlAssignment wind{"systems.0.wind_speed_10m_mps", "14.0"};
        return sea::to_toml(sea::changed(calm(), {&wind, 1}).value());
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
    Result<SeaPromise> asked(SeaWish wish) { return asked_of(*director, std::move(wish)); }
    Result<SeaPromise> through_world(Result<SeaWish> wish) {
        return asked_of(world, std::move(wish));
    }
    Following following() const { return world.following().value(); }

    const std::shared_ptr<SeaCourse> course = SeaCourse::begin(calm()).value();
    ForgetfulJournal journal{{1, 0, 0, sea::to_toml(calm())}};
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
TEST_F(Director, changes_begin_in_the_order_in_which_they_were_asked_for) {
    SeaWish long_made = wish();
    long_made.scene = windy();
    long_made.scene += "[[sea.system]]\ntype = \"sines\"\nshape = \"exponential\"\n"
                       "length_m = 43\nwavelength_m = 20\ncount = 64\nfrom_deg = 0\n"
                       "wavenumber_ratio = 1.03\namplitude_m = 0.05\n";
    const Result<SeaPromise> first = asked(long_made), second = asked(wish());
    ASSERT_TRUE(first) << first.error().message;
    ASSERT_TRUE(second) << second.error().message;
    EXPECT_GE(second->start_us, first->start_us);
    SeaWish later = wish();
    later.at_us = second->start_us + 100'000'001; // no keyframe lies there
    EXPECT_GT(asked(later)->start_us, later.at_us);
    const Result<SeaPromise> at_once = asked(wish());
    ASSERT_TRUE(at_once) << at_once.error().message;
    EXPECT_LT(at_once->start_us, later.at_us) << "who names no time waits for none that was named";
}

// The sea has leapt under those who are here: they are to go where it has not.
TEST_F(Director, a_pace_that_held_already_when_it_came_hands_the_sessions_over) {
    std::atomic<int> handed_over = 0;
    world.hand_over_by([&handed_over](const std::string& why) {
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
    world.hand_over_by([&handed_over](const std::string& why) {
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
    world.hand_over_by([&handed_over](const std::string&) { ++handed_over; });
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
    for (std::size_t i = 0; i < changes_promised_max; ++i) {
        const Result<SeaPromise> made = asked(wish());
        ASSERT_TRUE(made) << made.error().message;
        first_us = i == 0 ? made->start_us : first_us;
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
    EXPECT_EQ(
        counts(),
        (RefusedChanges::Counts{
            {"bad_value", 0}, {"busy", 0}, {"gone", 0}, {"not_offered", 0}, {"unwritten", 0}}));
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
    EXPECT_EQ(
        counts(),
        (RefusedChanges::Counts{
            {"bad_value", 2}, {"busy", 2}, {"gone", 0}, {"not_offered", 0}, {"unwritten", 1}}));
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

/// What administrators read of a journal that nobody plays.
class ReadJournal : public testing::Test {
  protected:
    ReadJournal() {
        world.read_by([this](std::uint32_t epoch, std::size_t most) {
            Result<std::vector<SeaChange>> those = some(changes, epoch, most);
            read += those->size();
            ++asked;
            return those;
        });
    }
    static sea::Scene scene(const std::string& more = {}) {
        return sea::parse_scene(small_sea + more, "small_sea", ".").value();
    }
    void add(const std::string& toml, bool lapsed = false) {
        changes.push_back({.epoch = static_cast<std::uint32_t>(changes.size()) + 1,
                           .scene = toml,
                           .lapsed = lapsed});
    }
    void add_pace() {
        changes.push_back({.epoch = static_cast<std::uint32_t>(changes.size()) + 1,
                           .scene = {},
                           .pace = sea::Pace{1, 1, 500}});
    }
    static std::string with(const std::string& path, const std::string& value) {
        const TomlAssignment one{path, value};
        return sea::to_toml(sea::changed(scene(), {&one, 1}).value());
    }

    std::vector<SeaChange> changes{{1, 0, 0, sea::to_toml(scene())}};
    std::size_t read = 0; ///< changes that were handed over
    int asked = 0;
    const std::shared_ptr<SeaCourse> course = SeaCourse::begin(scene()).value();
    SeaClock clock{0, [] { return std::int64_t{5'000'000'000}; }, [] { return std::int64_t{0}; }};
    World world{course, clock};
};

TEST_F(ReadJournal, each_change_differs_from_the_last_scene_that_ran_wherever_a_list_begins) {
    add(with("systems.0.wind_speed_10m_mps", "14.0"));
    for (int i = 0; i < 5; ++i) {
        add_pace();
        add(with("systems.0.wind_speed_10m_mps", fmt::format("{}.5", 20 + i)), true);
    }
    add(with("systems.0.wind_speed_10m_mps", "15.0")); // 13
    const auto whole = nlohmann::json::parse(world.history(1).value())["changes"];
    ASSERT_EQ(whole.size(), 13u);
    for (std::uint64_t from = 1; from <= 13; ++from) {
        const auto listed = nlohmann::json::parse(world.history(from).value())["changes"];
        ASSERT_EQ(listed.size(), 14 - from);
        for (std::size_t i = 0; i < listed.size(); ++i)
            EXPECT_EQ(listed[i], whole[from - 1 + i]) << from;
    }
    ASSERT_EQ(whole[12]["differs"].size(), 1u) << whole[12].dump();
    EXPECT_NE(whole[12]["differs"].dump().find("15"), std::string::npos);
    EXPECT_TRUE(nlohmann::json::parse(world.history(14).value())["changes"].empty());
}

// A scene may hold a table of 100 KB, a journal 10 000 of them, and who asks is the network's thread.
TEST_F(ReadJournal, no_more_is_read_than_is_told_however_long_it_is) {
    for (int i = 0; i < 3000; ++i)
        add_pace();
    add(with("systems.0.wind_speed_10m_mps", "14.0"));
    (void)world.history(3002).value();
    EXPECT_LE(read, 1u + 3001u) << "one that runs has to be looked for behind paces, once";
    read = 0;
    for (int i = 0; i < 500; ++i)
        add(with("systems.0.wind_speed_10m_mps", fmt::format("{}.25", 10 + i % 10)));
    EXPECT_EQ(nlohmann::json::parse(world.history(3002).value())["changes"].size(), 200u);
    read = 0;
    EXPECT_EQ(nlohmann::json::parse(world.history(3100).value())["changes"].size(), 200u);
    EXPECT_EQ(read, 201u);
    read = 0;
    (void)world.scene_of_change(3100).value();
    EXPECT_EQ(read, 1u);
}

// Naive: the scene before the first that is told of is looked for, number by number from where nothing has ever been: minutes.
TEST_F(ReadJournal, a_history_of_what_has_no_number_yet_is_empty_at_once) {
    for (const std::uint64_t from : {std::uint64_t{2}, std::uint64_t{4'294'967'295}}) {
        asked = 0;
        EXPECT_TRUE(nlohmann::json::parse(world.history(from).value())["changes"].empty());
        EXPECT_EQ(asked, 1) << from;
    }
}

// Four lines a change, two hundred changes: a table's line would fill the answer alone.
TEST_F(ReadJournal, of_a_long_line_a_history_tells_the_beginning) {
    changes.push_back({.epoch = 2, .scene = "table = \"" + std::string(110'000, '1') + "\"\n"});
    const auto listed = nlohmann::json::parse(world.history(2).value())["changes"];
    ASSERT_EQ(listed[0]["differs"].size(), 5u)
        << "it has nothing else, and not all of that is told";
    const std::string line = listed[0]["differs"][0];
    EXPECT_LT(line.size(), 256u);
    EXPECT_TRUE(line.starts_with("table = \"111")) << line;
    EXPECT_TRUE(line.ends_with("1...")) << line;
}

TEST_F(ReadJournal, there_is_no_way_back_to_what_has_no_sea) {
    add(with("sea.depth_m", "50.0"), true);
    add_pace();
    const auto why = [this](std::uint64_t number) {
        const Result<std::string> scene = world.scene_of_change(number);
        EXPECT_FALSE(scene) << number;
        EXPECT_TRUE(scene || scene.error().is(Refusal::bad_value));
        return scene ? "" : scene.error().message;
    };
    EXPECT_NE(why(2).find("change is 2, which came to the journal too late and has lapsed"),
              std::string::npos)
        << why(2);
    EXPECT_NE(why(3).find("change is 3, which is one of pace"), std::string::npos) << why(3);
    EXPECT_NE(why(4).find("change is 4; there is none"), std::string::npos) << why(4);
    EXPECT_NE(why(1ull << 32).find("numbers are 1 .. 4294967295"), std::string::npos);
    for (int i = 0; i < 10'000; ++i) // one a minute for a week
        add_pace();
    EXPECT_NE(why(10'002).find("which is one of pace"), std::string::npos) << why(10'002);
    EXPECT_NE(why(0).find("there is none"), std::string::npos) << why(0);
    EXPECT_EQ(world.scene_of_change(1).value(), changes[0].scene) << "to the letter";
}

// At 5000 s: what its rows have led to by then, and those to come at their own times.
TEST_F(ReadJournal, the_way_back_to_a_scene_with_a_timetable_is_to_where_that_is_now) {
    add(sea::to_toml(
        scene("[[weather]]\nat_s = 1000\nover_s = 20\n"
              "set.systems.0.wind_speed_10m_mps = 14.0\n"
              "[[weather]]\nat_s = 9000\nover_s = 20\nset.systems.0.from_deg = 123\n")));
    const std::string now = world.scene_of_change(2).value();
    const Result<sea::Scene> read = sea::parse_scene(now, "now", ".");
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(read->weather.size(), 1u);
    EXPECT_EQ(read->weather[0].at_s, 9000);
    sea::Scene bare = *read;
    bare.weather.clear();
    EXPECT_EQ(sea::to_toml(bare), with("systems.0.wind_speed_10m_mps", "14.0"));
    const Result<void> added = course->add(*read, 5'010'000'000, 5'030'000'000);
    EXPECT_TRUE(added) << added.error().message << " it can be gone back to";
}

} // namespace
} // namespace seaway::server
