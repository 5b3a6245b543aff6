// SPDX-License-Identifier: Apache-2.0
// A fetch, sea by sea: whose turn it is, who makes what it lacks, and what comes of no times.
#include "server/simulation/fetched_parts.h"

#include "sea/scene/weather.h"
#include "tests/server/simulation/simulation_bench.h"

namespace seaway::server {
namespace {

const Demand some{sea::all_cascades, FieldSet{Field::height}};

/// So many changes of ten seconds, a minute apart, the first after a minute.
std::shared_ptr<SeaCourse> course_with(int changes) {
    const RunningSeaPtr sea = running_sea();
    auto course = std::make_shared<SeaCourse>(sea);
    for (int i = 1; i <= changes; ++i) {
        const TomlAssignment wind{"systems.0.wind_speed_10m_mps", i % 2 == 0 ? "8.0" : "11.0"};
        EXPECT_TRUE(course->add(*sea::changed(sea->scene, {&wind, 1}), i * 60 * second_us,
                                (i * 60 + 10) * second_us));
    }
    return course;
}

TEST(FetchedParts, of_a_sea_that_is_there_need_nobody_else_and_of_another_it_is_made_first) {
    const auto course = course_with(1);
    FetchedParts first(*course, {0, 30 * second_us}, some, nullptr);
    EXPECT_EQ(first.hand(), Hand::simulation);
    FetchedParts glide(*course, {65 * second_us}, some, nullptr);
    EXPECT_EQ(glide.hand(), Hand::answers);
    glide.make_some_sea();
    EXPECT_EQ(glide.hand(), Hand::simulation);
    EXPECT_FALSE(glide.complete());
}

// Naive: made is made. Whoever waits long finds it gone, and the thread of the stream makes it anew.
TEST(FetchedParts, a_sea_that_was_let_go_before_its_turn_is_made_again_by_others) {
    const auto course = course_with(static_cast<int>(seas_kept) + 2);
    FetchedParts parts(*course, {65 * second_us}, some, nullptr);
    parts.make_some_sea();
    ASSERT_EQ(parts.hand(), Hand::simulation);
    ASSERT_TRUE(parts.may_work());
    for (int i = 2; i <= static_cast<int>(seas_kept) + 2; ++i)
        (void)course->at((60 * i + 30) * second_us);
    ASSERT_EQ(course->sea_if_held(course->window_at(65 * second_us).epoch), nullptr);
    EXPECT_FALSE(parts.may_work());
    EXPECT_EQ(parts.hand(), Hand::answers);
    parts.make_some_sea();
    EXPECT_EQ(parts.hand(), Hand::simulation);
    EXPECT_TRUE(parts.may_work());
}

TEST(FetchedParts, times_in_any_order_and_twice_are_each_seas_keyframes_once) {
    Bench bench;
    const auto all =
        bench.fetch({5 * second_us, 0, 5 * second_us, 1}, {1u, {Field::height}}).value();
    const auto once = bench.fetch({0, 5 * second_us}, {1u, {Field::height}}).value();
    ASSERT_EQ(all.size(), once.size());
    for (std::size_t i = 0; i < all.size(); ++i)
        EXPECT_EQ(all[i]->time_us, once[i]->time_us);
    EXPECT_TRUE(bench.fetch({}, {1u, {Field::height}}).value().empty());
}

// Naive: the course calls under its own lock. Questions are woken under theirs: whoever asks the course under that one and
// whoever is told would wait for each other.
TEST(FetchedParts, whoever_hears_that_a_sea_was_made_may_ask_the_course) {
    const auto course = course_with(1);
    FetchedParts parts(*course, {65 * second_us}, some, nullptr);
    int told = 0;
    course->when_made([&] {
        ++told;
        EXPECT_EQ(course->window_at(65 * second_us).epoch, 2u);
        EXPECT_EQ(parts.hand(), Hand::answers) << "it is counted when this returns";
    });
    parts.make_some_sea();
    course->when_made(nullptr);
    EXPECT_EQ(told, 1);
    EXPECT_EQ(parts.hand(), Hand::simulation);
}

} // namespace
} // namespace seaway::server
