// SPDX-License-Identifier: Apache-2.0
// The sea director over a journal in memory.
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <future>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "server/sea_director.h"
#include "tests/server/simulation/simulation_bench.h"
#include "tests/support/allocations.h"

namespace seaway::server {
namespace {

/// With `reads_without`: once something has been appended there is no memory for a sea, for whoever did it, until the
/// log has been read so many times.
class JournalInMemory final : public Journal {
  public:
    explicit JournalInMemory(std::int64_t spread_us, int reads_without = 0)
        : spread_us_(spread_us), reads_without_(reads_without) {}

    void others_append(SeaChange change) {
        const std::scoped_lock lock(mutex_);
        changes_.push_back(std::move(change));
    }

    const std::string& name() const override { return name_; }
    std::int64_t epoch_utc_us() const override { return 0; }
    Result<std::vector<SeaChange>> since(std::uint32_t epoch) const override {
        const std::scoped_lock lock(mutex_);
        if (scarce_ && reads_++ == reads_without_)
            tests::refuse_larger_allocations(SIZE_MAX);
        return std::vector<SeaChange>(changes_.begin() + epoch, changes_.end());
    }
    Result<void> append(const SeaChange& change) override {
        const std::scoped_lock lock(mutex_);
        changes_.push_back(change);
        if (!scarce_ && reads_without_ > 0)
            tests::refuse_larger_allocations(20'000); // the waves of a tile of 64 x 64 are more
        scarce_ = true;
        return {};
    }
    JournalStanding standing() const override {
        const std::scoped_lock lock(mutex_);
        return {
            .last_epoch = static_cast<std::uint32_t>(changes_.size()), .peers = {}, .trouble = {}};
    }
    std::int64_t spread_us() const override { return spread_us_; }
    void compare_clocks(std::function<std::int64_t()>) override {}
    void call_on_change(std::function<void()>) override {}

  private:
    const std::string name_ = "a journal in memory";
    const std::int64_t spread_us_;
    const int reads_without_;
    mutable std::mutex mutex_;
    std::vector<SeaChange> changes_{{.epoch = 1, .scene = small_sea}};
    bool scarce_ = false;
    mutable int reads_ = 0;
};

/// A busy machine takes as long as it takes: a minute at most.
template <class Condition>
bool comes_true(const Condition& condition) {
    for (int i = 0; i < 12'000 && !condition(); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return condition();
}

struct Directed {
    explicit Directed(Journal* journal)
        : course(SeaCourse::begin(sea::parse_scene(small_sea, "small_sea", ".").value()).value()),
          clock(
              0, [] { return 10 * second_us; }, [] { return 0; }),
          world(course, clock), director(course, journal, 1, world, clock) {}

    Result<SeaPromise> wind(const std::string& mps) {
        std::promise<Result<SeaPromise>> promise;
        SeaWish wish;
        wish.set = {{"systems.0.wind_speed_10m_mps", mps}};
        wish.over_us = 60 * second_us;
        director.change(wish, [&promise](Result<SeaPromise> made) { promise.set_value(made); });
        return promise.get_future().get();
    }

    std::shared_ptr<SeaCourse> course;
    SeaClock clock;
    World world;
    SeaDirector director;
};

// Otherwise it would stand in the log and never in this sea, while all others who read the log have it: until a restart.
TEST(SeaDirector, a_change_for_which_there_is_no_memory_once_it_is_logged_comes_when_there_is) {
    JournalInMemory journal(0, 2);
    Directed sea(&journal);
    const Result<SeaPromise> first = sea.wind("12");
    ASSERT_FALSE(first);
    EXPECT_NE(first.error().message.find("change 2 is in the journal"), std::string::npos)
        << first.error().message;
    EXPECT_EQ(sea.course->epochs(), 1u);
    ASSERT_TRUE(comes_true([&] { return sea.course->epochs() == 3; }));
    EXPECT_TRUE(comes_true([&] { return sea.world.following()->played == 2; }));
    const Result<SeaPromise> second = sea.wind("13");
    ASSERT_TRUE(second) << second.error().message;
    EXPECT_EQ(second->epoch, 4u);
    EXPECT_EQ(journal.since(0)->size(), 3u);
    EXPECT_EQ(sea.course->epochs(), 5u) << "each is in the sea once";
}

// The sea has leapt under those who are here: they are to go where it has not.
TEST(SeaDirector, a_pace_that_held_already_when_it_came_hands_the_sessions_over) {
    JournalInMemory journal(3 * second_us);
    Directed sea(&journal);
    std::atomic<int> handed_over = 0;
    sea.world.hand_over_by([&handed_over](const std::string& why) {
        handed_over += why == "a change of the sea was missed";
    });
    journal.others_append(
        {.epoch = 2, .scene = {}, .pace = sea::Pace{11 * second_us, 11 * second_us, 500}});
    ASSERT_TRUE(comes_true([&] { return sea.world.following()->played == 2; }));
    EXPECT_EQ(handed_over, 0) << "this one is still to come";
    journal.others_append(
        {.epoch = 3, .scene = {}, .pace = sea::Pace{9 * second_us, 9 * second_us, 2000}});
    EXPECT_TRUE(comes_true([&] { return handed_over == 1; }));
}

} // namespace
} // namespace seaway::server
