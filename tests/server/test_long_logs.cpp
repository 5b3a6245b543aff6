// SPDX-License-Identifier: Apache-2.0
// A server that lives long: its clock is wrong for a while, and its log comes to its end.
#include <atomic>
#include <future>
#include <memory>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "sea/scene/weather.h"
#include "server/resume.h"
#include "server/sea_director.h"
#include "tests/server/net/net_fixture.h"
#include "tests/server/simulation/simulation_bench.h"
#include "tests/support/folder.h"

namespace seaway::server {
namespace {

/// A machine whose clocks are moved by hand.
struct Machine {
    std::atomic<std::int64_t> utc_us = 1'800'000'000 * second_us;
    std::atomic<std::int64_t> steady_us = 77;

    void pass(std::int64_t us) {
        steady_us += us;
        utc_us += us;
    }
};

/// One of its starts, over a journal in a folder.
class Start {
  public:
    Start(const std::string& folder, Machine& machine)
        : machine_(machine),
          resumed_(begin_or_resume({.where = folder}, *course, machine.utc_us).value()),
          clock_(
              resumed_.epoch_utc_us, [this] { return machine_.utc_us.load(); },
              [this] { return machine_.steady_us.load(); }, resumed_.paces),
          director_(course, resumed_.journal.get(), resumed_.changes, world, clock_) {}

    Result<SeaPromise> set_wind(const std::string& mps) {
        SeaWish wish;
        wish.set = {{"systems.0.wind_speed_10m_mps", mps}};
        wish.over_us = 20 * second_us;
        std::promise<Result<SeaPromise>> promise;
        world.change(std::move(wish),
                     [&promise](Result<SeaPromise> made) { promise.set_value(std::move(made)); });
        return promise.get_future().get();
    }
    std::size_t changes() const { return resumed_.journal->since(0).value().size(); }

  private:
    Machine& machine_;

  public:
    const std::shared_ptr<SeaCourse> course = SeaCourse::begin(small_scene()).value();

  private:
    Resumed resumed_;
    SeaClock clock_;

  public:
    World world{course, clock_};

  private:
    SeaDirector director_;
};

// As a machine without a clock of its own, that serves before it has heard of the time.
TEST(LongLog, a_clock_that_is_behind_for_a_while_undoes_no_change) {
    const tests::LogCapture log;
    const std::string folder = tests::folder().fresh("behind");
    Machine machine;
    {
        Start server(folder, machine);
        const Result<SeaPromise> made = server.set_wind("14.0");
        ASSERT_TRUE(made) << made.error().message;
        machine.pass(600 * second_us);
        EXPECT_GT(server.world.sea_time_us(), made->end_us) << "it has run";
    }
    machine.utc_us -= 3600 * second_us;
    Start server(folder, machine);
    // Of when the change was made, or, where the first server had a second for that, of when its sea began.
    EXPECT_EQ(log.lines_with("event=sea_clock_behind by_s=3000.0").size() +
                  log.lines_with("event=sea_clock_behind by_s=3600.0").size(),
              1u)
        << log.text();
    const Result<SeaPromise> refused = server.set_wind("3.0");
    ASSERT_FALSE(refused) << "it would take over from the one that has run";
    EXPECT_TRUE(refused.error().is(Refusal::busy));
    EXPECT_NE(refused.error().message.find("its last change was made, or its sea begun, at"),
              std::string::npos)
        << refused.error().message;
    EXPECT_EQ(server.changes(), 2u);
    EXPECT_EQ(log.lines_with("event=sea_clock_leapt").size(), 0u);
    machine.utc_us += 3600 * second_us;
    const Result<SeaPromise> made = server.set_wind("3.0");
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ(log.lines_with("event=sea_clock_leapt by_s=3600.0").size(), 1u) << log.text();
    EXPECT_FALSE(server.course->window(2).empty());
    EXPECT_FALSE(server.course->window(3).empty()) << "the change before has been";
    EXPECT_EQ(server.course->window(3).end_us, made->start_us);
}

// Naive: whoever asks is told that his value is wrong, from one day to the next, while the status says 154 changes.
TEST(LongLog, its_end_is_warned_of_and_has_a_name) {
    const tests::LogCapture log;
    Machine machine;
    Start server(tests::folder().fresh("full"), machine);
    const sea::Scene scene = small_scene();
    const auto fill = [&](std::size_t upto) { // before now: they have run
        for (std::size_t i = server.course->changes(); i < upto; ++i) {
            const auto at_us = (static_cast<TimeUs>(i) - 3'000'000) * 30 * second_us;
            ASSERT_TRUE(server.course->add(scene, at_us, at_us + 20 * second_us));
        }
    };
    fill(changes_warned_of - 2);
    ASSERT_TRUE(server.set_wind("10.0"));
    EXPECT_EQ(log.lines_with("event=sea_log_fills").size(), 0u);
    machine.pass(600 * second_us);
    ASSERT_TRUE(server.set_wind("11.0"));
    EXPECT_EQ(log.lines_with("event=sea_log_fills counted=9000 of=10000").size(), 1u) << log.text();
    const Following now = server.world.following().value();
    EXPECT_NE(now.json().find("\"counted\":9000,\"counted_max\":10000"), std::string::npos)
        << now.json();
    EXPECT_NE(now.metrics().find("seaway_journal_changes_counted 9000\n"), std::string::npos)
        << now.metrics();
    EXPECT_NE(now.metrics().find("seaway_journal_changes_counted_max 10000\n"), std::string::npos);
    for (std::size_t i = 0; server.course->changes() < changes_max; ++i) {
        const auto at_us = 10'000 * second_us + static_cast<TimeUs>(i) * 30 * second_us;
        ASSERT_TRUE(server.course->add(scene, at_us, at_us + 20 * second_us));
    }
    machine.pass(100'000 * second_us);
    const Result<SeaPromise> refused = server.set_wind("12.0");
    ASSERT_FALSE(refused);
    EXPECT_TRUE(refused.error().is(CourseError::full)) << refused.error().message;
    EXPECT_EQ(refused.error().message.find("the log is full: "), 0u) << refused.error().message;
    EXPECT_EQ(server.world.changes_refused().at("full"), 1u);
    EXPECT_EQ(server.world.changes_refused().at("bad_value"), 0u);
    EXPECT_EQ(server.changes(), 3u);
}

} // namespace
} // namespace seaway::server
