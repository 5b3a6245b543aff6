// SPDX-License-Identifier: Apache-2.0
// Who changes the sea, over a journal that others write and for which there is no memory at times.
#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "sea/scene/weather.h"
#include "server/sea_director.h"
#include "tests/server/simulation/simulation_bench.h"

namespace seaway::server {
namespace {

template <class Condition>
bool comes_true(const Condition& condition) {
    for (int i = 0; i < 12'000 && !condition(); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return condition();
}

/// Shared with nobody that there is; calls may find no memory so many times.
class ForgetfulJournal final : public Journal {
  public:
    explicit ForgetfulJournal(SeaChange first) : changes_{std::move(first)} {}

    std::atomic<int> reads_fail = 0;   ///< since()
    std::atomic<int> appends_fail = 0; ///< behind the write
    std::atomic<bool> outrun = false;  ///< each append

    const std::string& name() const override { return name_; }
    std::int64_t epoch_utc_us() const override { return 0; }
    Result<std::vector<SeaChange>> since(std::uint32_t epoch) const override {
        if (auto& fails = const_cast<std::atomic<int>&>(reads_fail); fails > 0 && fails-- > 0)
            throw std::bad_alloc();
        const std::scoped_lock lock(mutex_);
        if (epoch >= changes_.size())
            return std::vector<SeaChange>{};
        return std::vector<SeaChange>(changes_.begin() + epoch, changes_.end());
    }
    Result<void> append(const SeaChange& change) override {
        if (outrun)
            return Error{JournalError::outrun, "another change was appended first"};
        by_another(change, false);
        if (appends_fail > 0 && appends_fail-- > 0)
            throw std::bad_alloc();
        return {};
    }
    JournalStanding standing() const override {
        const std::scoped_lock lock(mutex_);
        return {.last_epoch = static_cast<std::uint32_t>(changes_.size())};
    }
    std::int64_t spread_us() const override { return 3'000'000; }
    void compare_clocks(std::function<std::int64_t()>) override {}
    void connect_no_more() override {}
    void call_on_change(std::function<void()> call) override {
        const std::scoped_lock lock(mutex_);
        call_ = std::move(call);
    }

    void by_another(const SeaChange& change, bool tells = true) {
        std::function<void()> call;
        {
            const std::scoped_lock lock(mutex_);
            changes_.push_back(change);
            call = call_;
        }
        if (tells && call)
            call();
    }

  private:
    const std::string name_ = "nats://nowhere/forgetful";
    mutable std::mutex mutex_;
    std::vector<SeaChange> changes_;
    std::function<void()> call_;
};

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
    Result<SeaPromise> asked(SeaWish wish) {
        std::promise<Result<SeaPromise>> promise;
        director->change(std::move(wish), [&promise](Result<SeaPromise> made) {
            promise.set_value(std::move(made));
        });
        return promise.get_future().get();
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
    EXPECT_TRUE(comes_true([&] { return course->epochs() == 3u; }));
    EXPECT_EQ(journal.reads_fail, 0);
    EXPECT_TRUE(comes_true([&] { return following().played == 2u; }));
    EXPECT_EQ(course->window(2).start_us, start_us);
    EXPECT_EQ(following().doubt(), "");
}

TEST_F(Director, one_of_its_own_that_was_written_before_there_was_no_memory_is_played_too) {
    journal.appends_fail = 1;
    const Result<SeaPromise> made = asked(wish());
    ASSERT_FALSE(made);
    EXPECT_NE(made.error().message.find("change 2 may be in the journal"), std::string::npos)
        << made.error().message;
    ASSERT_TRUE(comes_true([&] { return course->epochs() == 3u; })) << "it stands in the journal";
    EXPECT_TRUE(comes_true([&] { return following().played == 2u; }));
    EXPECT_EQ(course->window(2).start_us, journal.since(1)->front().start_us);
    const Result<SeaPromise> next = asked(wish());
    ASSERT_TRUE(next) << next.error().message;
    EXPECT_EQ(journal.since(2)->front().epoch, 3u);
    EXPECT_EQ(following().played, 3u);
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
    ASSERT_TRUE(comes_true([&] { return following().played == 2u; }));
    EXPECT_EQ(handed_over, 0) << "this one is still to come";
    journal.by_another({.epoch = 3, .scene = {}, .pace = pace_from(-1'000'000, 2000)});
    EXPECT_TRUE(comes_true([&] { return handed_over == 1; }));
}

} // namespace
} // namespace seaway::server
