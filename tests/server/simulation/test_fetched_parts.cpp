// SPDX-License-Identifier: Apache-2.0
// A fetch, sea by sea: whose turn it is, who makes what it lacks, and what comes of no times.
#include "server/simulation/fetched_parts.h"

#include <algorithm>
#include <iterator>

#include "sea/scene/weather.h"
#include "server/simulation/memory_needs.h"
#include "tests/server/simulation/simulation_bench.h"

namespace seaway::server {
namespace {

const Demand some{sea::all_cascades, FieldSet{Field::height}};

/// So many changes of ten seconds, a minute apart, the first after a minute.
std::shared_ptr<SeaCourse> course_with(int changes, TimeUs apart_us = 60 * second_us,
                                       const std::string& more = {}) {
    const RunningSeaPtr sea = running_sea(more);
    auto course = std::make_shared<SeaCourse>(sea);
    for (int i = 1; i <= changes; ++i) {
        const TomlAssignment wind{"systems.0.wind_speed_10m_mps", i % 2 == 0 ? "8.0" : "11.0"};
        EXPECT_TRUE(course->add(*sea::changed(sea->scene, {&wind, 1}), i * apart_us,
                                i * apart_us + 10 * second_us));
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

/// Foam that remembers 100 s, in which the sea changes five times, and what makes keyframes of it, without threads.
struct ChangingFoam {
    std::shared_ptr<SeaCourse> course =
        course_with(16, 20 * second_us, "[foam]\nthreshold = 0.9\ndecay_s = 10\n");
    Memory memory{Memory::bytes_default, needs_of(*course->first())};
    KeyframeSource source{course, native_synthesizer(*course), memory};

    /// By one thread that makes all seas, too.
    std::vector<sea::KeyframePtr> fetch(TimeUs time_us, const Demand& demand) {
        KeyframeJob job(keyframes_around(*course, {&time_us, 1}, demand), Walk::questions);
        std::vector<sea::KeyframePtr> all;
        while (!job.complete()) {
            const Result<bool> made = source.work_on(job);
            EXPECT_TRUE(made);
            if (!made)
                break;
            if (*made)
                std::ranges::copy(job.take(), std::back_inserter(all));
        }
        return all;
    }
};

// Naive: they are made first, the oldest first, and nobody holds them: each is gone when the walk comes to it, and so is the next
// one, once that is made for it.
TEST(FetchedParts,
     foam_that_remembers_more_seas_than_are_kept_has_none_made_by_the_thread_of_the_stream) {
    const Demand foam{3u, FieldSet{Field::foam}};
    // In the middle of a sea, and where the last keyframe has the foam of the next one.
    for (const TimeUs time_us : {175 * second_us, 160 * second_us - 1}) {
        ChangingFoam bench, alone;
        ASSERT_GT(fetched_epochs(*bench.course, {&time_us, 1}, foam.fields).size(), seas_kept);
        FetchedParts parts(*bench.course, {time_us}, foam, nullptr);
        std::vector<sea::KeyframePtr> all;
        std::uint64_t made_by_the_stream = 0;
        for (int slices = 0; slices < 1000 && !parts.complete(); ++slices) {
            if (parts.hand() == Hand::answers) {
                parts.make_some_sea();
                for (int i = 9; slices > 0 && i <= 16; ++i) // meanwhile others are asked about
                    (void)bench.course->at((20 * i + 15) * second_us);
                continue;
            }
            const std::uint64_t before = bench.course->seas_made();
            ASSERT_TRUE(parts.may_work());
            const Result<bool> made = bench.source.work_on(parts.job());
            ASSERT_TRUE(made);
            if (*made)
                std::ranges::copy(parts.take(), std::back_inserter(all));
            made_by_the_stream += bench.course->seas_made() - before;
        }
        EXPECT_TRUE(parts.complete());
        EXPECT_EQ(made_by_the_stream, 0u);
        const std::vector<sea::KeyframePtr> expected = alone.fetch(time_us, foam);
        ASSERT_EQ(all.size(), expected.size());
        for (std::size_t i = 0; i < all.size(); ++i)
            EXPECT_EQ(all[i]->values, expected[i]->values) << i;
    }
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
