// SPDX-License-Identifier: Apache-2.0
// A long log: what another change takes over from before it begins keeps its numbers and costs nothing.
#include <algorithm>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "server/simulation/sea_course.h"
#include "tests/server/simulation/simulation_bench.h"

namespace seaway::server {
namespace {

constexpr TimeUs ever_us = std::numeric_limits<TimeUs>::max();

/// As the log says, row by row: each ends whatever was to come.
class NaiveCourse {
  public:
    void add(TimeUs start_us, TimeUs end_us) {
        for (const TimeUs from_us : {start_us, end_us}) {
            for (EpochWindow& earlier : epochs_)
                earlier.end_us = std::min(earlier.end_us, from_us);
            epochs_.push_back({static_cast<std::uint32_t>(epochs_.size() + 1), from_us, ever_us});
        }
    }
    const std::vector<EpochWindow>& epochs() const { return epochs_; }
    /// Of the first so many.
    std::uint32_t at(TimeUs time_us, std::size_t epochs) const {
        while (epochs > 1 && epochs_[epochs - 1].start_us > time_us)
            --epochs;
        return static_cast<std::uint32_t>(epochs);
    }
    int glides_in_row(TimeUs time_us) const {
        int glides = 0;
        for (std::uint32_t epoch = at(time_us, epochs_.size()); epoch % 2 == 0;
             epoch = at(epochs_[epoch - 1].start_us, epoch - 1))
            ++glides;
        return glides;
    }

  private:
    std::vector<EpochWindow> epochs_{{1, std::numeric_limits<TimeUs>::min(), ever_us}};
};

struct Load {
    sea::Scene scene;
    TimeUs start_us;
    TimeUs end_us;
};

/// With so many rows, an hour apart, from an hour after its start on.
Load forecast(TimeUs start_us, int rows, const std::string& sets = "systems.0.from_deg = {}") {
    std::string text;
    for (int i = 0; i < rows; ++i)
        text += fmt::format("[[weather]]\nat_s = {}\nover_s = 600\nset.{}\n",
                            start_us / second_us + 3600 * (i + 1),
                            fmt::format(fmt::runtime(sets), 200 + i % 90));
    return {small_scene(text), start_us, start_us + 60 * second_us};
}

void expect_as(const SeaCourse& course, const NaiveCourse& naive) {
    ASSERT_EQ(course.epochs(), naive.epochs().size());
    std::size_t run = 0;
    for (const EpochWindow& wanted : naive.epochs()) {
        const EpochWindow window = course.window(wanted.epoch);
        ASSERT_EQ(window.empty(), wanted.empty()) << wanted.epoch;
        if (wanted.empty())
            continue;
        ++run;
        EXPECT_EQ(window.start_us, wanted.start_us) << wanted.epoch;
        EXPECT_EQ(window.end_us, wanted.end_us) << wanted.epoch;
    }
    EXPECT_EQ(course.windows(-ever_us, ever_us).size(), run);
}

// Naive: rows that never run count, and who loads a forecast each day cannot change the sea any more after half a year.
TEST(CourseLog, a_forecast_that_comes_anew_every_day_counts_what_of_it_has_run_and_is_to_come) {
    const auto course = *SeaCourse::begin(small_scene());
    NaiveCourse naive;
    constexpr int loads = 200, rows = 64, run_of_each = 3;
    for (int day = 1; day <= loads; ++day) {
        // Takes over in the middle of the glide of a row, or behind it.
        const Load load =
            forecast(day * (3600 * run_of_each + 300 * (1 + day % 4)) * second_us, rows);
        const Result<void> added = course->add(load.scene, load.start_us, load.end_us);
        ASSERT_TRUE(added) << "load " << day << ": " << added.error().message;
        naive.add(load.start_us, load.end_us);
        for (const sea::WeatherChange& row : load.scene.weather)
            naive.add(sea::us_from_seconds(row.at_s), sea::us_from_seconds(row.at_s + row.over_s));
    }
    ASSERT_GT(naive.epochs().size(), 2 * changes_max) << "of all that was written";
    expect_as(*course, naive);
    EXPECT_LE(course->changes(), 1u + loads * (2u + run_of_each) + rows);
    std::mt19937_64 random(5);
    std::uniform_int_distribution<TimeUs> time(0, naive.epochs().back().start_us);
    for (int i = 0; i < 2000; ++i) {
        const TimeUs time_us = time(random);
        ASSERT_EQ(course->window_at(time_us).epoch, naive.at(time_us, naive.epochs().size()));
        ASSERT_EQ(course->glides_in_row(time_us), naive.glides_in_row(time_us));
    }
}

// Naive: a server that is started again realises every row that was ever written, and phases hang on depths that never were.
TEST(CourseLog, read_again_it_is_the_same_course_though_what_never_ran_is_not_looked_at) {
    std::vector<Load> log;
    for (int i = 0; i < 6; ++i)
        log.push_back(forecast((1 + i) * 4000 * second_us, 4, "sea.depth_m = {}"));
    log.insert(log.begin() + 3, forecast(60'000 * second_us, 2)); // promised, and never run
    const auto lived = *SeaCourse::begin(small_scene()), again = *SeaCourse::begin(small_scene());
    NaiveCourse naive;
    for (const Load& load : log) {
        ASSERT_TRUE(lived->add(load.scene, load.start_us, load.end_us));
        naive.add(load.start_us, load.end_us);
        for (const sea::WeatherChange& row : load.scene.weather)
            naive.add(sea::us_from_seconds(row.at_s), sea::us_from_seconds(row.at_s + row.over_s));
    }
    // Nobody could play them.
    log[3].scene.cascades[0].size = 128;
    log[0].scene.weather.back().set = {{"sea.no_such_thing", "1"}};
    TimeUs until_us = ever_us;
    std::vector<TimeUs> until(log.size());
    for (std::size_t i = log.size(); i-- > 0; until_us = std::min(until_us, log[i].start_us))
        until[i] = until_us;
    for (std::size_t i = 0; i < log.size(); ++i)
        ASSERT_TRUE(again->add(log[i].scene, log[i].start_us, log[i].end_us, until[i])) << i;
    expect_as(*lived, naive);
    expect_as(*again, naive);
    EXPECT_EQ(again->changes(), lived->changes());
    for (const TimeUs time_s : {4010, 7700, 8030, 12'050, 16'000, 26'000, 38'000}) {
        const TimeUs time_us = time_s * second_us;
        EXPECT_EQ(again->at(time_us)->truth_at(time_us)->at(1, 2, time_us).height,
                  lived->at(time_us)->truth_at(time_us)->at(1, 2, time_us).height)
            << time_s;
    }
}

// Naive: the one before is a glide that has not ended, to be made though it never runs, and a plan that is corrected every hour is
// refused from its ninth correction on.
TEST(CourseLog, what_begins_with_another_takes_its_place) {
    const auto course = *SeaCourse::begin(small_scene()), alone = *SeaCourse::begin(small_scene());
    const TimeUs start_us = 7200 * second_us, end_us = start_us + 600 * second_us;
    sea::Scene scene = small_scene("[[weather]]\nat_s = 9000\nover_s = 60\n"
                                   "set.systems.0.from_deg = 100\n");
    const int times = 3 * takeovers_max;
    for (int i = 0; i < times; ++i) {
        scene.sea.depth_m = 20 + i; // phases hang on what was before
        ASSERT_TRUE(course->add(scene, start_us, end_us)) << i;
        EXPECT_EQ(course->glides_in_row(start_us), 0) << "one more would be the first";
        EXPECT_EQ(course->glides_in_row(start_us + 1), 1);
    }
    EXPECT_EQ(course->changes(), 3u) << "the beginning, the last one and its row";
    EXPECT_EQ(course->epochs(), 1u + 4 * times);
    EXPECT_TRUE(course->window(3).empty());
    EXPECT_EQ(course->window_at(start_us - 1).epoch, 1u);
    const std::uint32_t glide = course->window_at(start_us).epoch;
    EXPECT_EQ(course->origins(glide), std::vector<std::uint32_t>{1});
    ASSERT_TRUE(alone->add(scene, start_us, end_us));
    for (const TimeUs after_s : {0, 1, 300, 599, 601, 1700, 1830, 4000}) {
        const TimeUs time_us = start_us + after_s * second_us;
        EXPECT_EQ(course->at(time_us)->truth_at(time_us)->at(1, 2, time_us).height,
                  alone->at(time_us)->truth_at(time_us)->at(1, 2, time_us).height)
            << after_s;
    }
}

// A keyframe of it may be on its way, or a question.
TEST(CourseLog, an_epoch_that_never_runs_is_itself_while_it_is_held_and_then_what_took_over) {
    const auto course = *SeaCourse::begin(small_scene());
    const Load promised = forecast(7200 * second_us, 0), sooner = forecast(3600 * second_us, 0);
    ASSERT_TRUE(course->add(promised.scene, promised.start_us, promised.end_us));
    RunningSeaPtr held = course->sea(3);
    ASSERT_TRUE(course->add(sooner.scene, sooner.start_us, sooner.end_us));
    EXPECT_EQ(course->sea(3), held);
    EXPECT_EQ(course->window(3).end_us, sooner.start_us);
    held.reset();
    for (std::uint32_t i = 0; i < seas_kept; ++i) { // others are asked for
        const TimeUs start_us = (10'000 + 100 * i) * second_us;
        ASSERT_TRUE(course->add(small_scene(), start_us, start_us + 50 * second_us));
        (void)course->sea(2 * (3 + i) + 1);
    }
    EXPECT_EQ(course->sea(3)->epoch, 5u);
    EXPECT_EQ(course->sea(2)->epoch, 4u) << "of a glide the glide";
}

TEST(CourseLog, that_is_full_says_so_and_takes_what_makes_room) {
    const auto course = *SeaCourse::begin(small_scene());
    const sea::Scene scene = small_scene();
    const auto add = [&](TimeUs at_s) {
        return course->add(scene, at_s * second_us, (at_s + 30) * second_us);
    };
    for (std::size_t i = 1; i < changes_max; ++i)
        ASSERT_TRUE(add(100 * static_cast<TimeUs>(i)));
    EXPECT_EQ(course->changes(), changes_max);
    const Result<void> more = add(100 * static_cast<TimeUs>(changes_max));
    ASSERT_FALSE(more);
    EXPECT_TRUE(more.error().is(CourseError::full));
    EXPECT_NE(more.error().message.find("the log is full: it counts 10000 changes"),
              std::string::npos)
        << more.error().message;
    EXPECT_EQ(course->epochs(), 2 * changes_max - 1);
    EXPECT_TRUE(add(50 * static_cast<TimeUs>(changes_max) + 50)) << "half of them never run";
    EXPECT_EQ(course->changes(), changes_max / 2 + 2);
}

} // namespace
} // namespace seaway::server
