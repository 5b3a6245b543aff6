// SPDX-License-Identifier: Apache-2.0
// Surfaces made of what is held, by any thread: who shares one, who waits for room, and what is made by whom.
#include <deque>

#include "sea/scene/weather.h"
#include "server/simulation/memory_needs.h"
#include "server/simulation/point_question.h"
#include "tests/server/simulation/simulation_bench.h"

namespace seaway::server {
namespace {

/// A source and its surfaces without threads.
struct SurfaceBench {
    explicit SurfaceBench(std::size_t memory_bytes = Memory::bytes_default)
        : memory(memory_bytes, needs_of(*course->first())) {}

    std::shared_ptr<SeaCourse> course = std::make_shared<SeaCourse>(running_sea());
    Memory memory;
    KeyframeSource source{course, native_synthesizer(*course), memory};
    Surfaces surfaces{course, source, memory};

    void change(TimeUs start_us, TimeUs end_us) {
        const TomlAssignment wind{"systems.0.wind_speed_10m_mps", "12.0"};
        const Result<sea::Scene> stormier = sea::changed(course->first()->scene, {&wind, 1});
        ASSERT_TRUE(stormier);
        ASSERT_TRUE(course->add(*stormier, start_us, end_us));
    }

    /// All slices.
    void finish(SurfaceJob& job) {
        while (!surfaces.work_on(job)) {
            ASSERT_FALSE(surfaces.waits(job));
            if (job.lacks_keyframes()) {
                ASSERT_TRUE(surfaces.make_keyframes(job));
            }
        }
    }
};

TEST(Surfaces, keyframes_that_are_not_held_are_asked_of_the_device_and_nothing_else_is) {
    SurfaceBench bench;
    SurfaceJob first(100'000);
    EXPECT_FALSE(bench.surfaces.work_on(first));
    EXPECT_TRUE(first.lacks_keyframes());
    bench.finish(first);
    const std::uint64_t made = bench.source.report().synthesis.keyframes;
    EXPECT_EQ(made, 4u);
    SurfaceJob second(100'001);
    bench.finish(second);
    EXPECT_FALSE(second.lacks_keyframes());
    EXPECT_EQ(bench.source.report().synthesis.keyframes, made);
}

/// Of some places at its time.
std::vector<double> heights_m(const sea::Surface& surface, TimeUs time_us) {
    std::vector<double> heights;
    for (int i = 0; i < 20; ++i)
        heights.push_back(surface.answer({17.0 * i, -3.0 * i, time_us}).height_m);
    return heights;
}

// Naive: of keyframes of which the splines alone are held, the maps are made again.
TEST(Surfaces, stand_on_splines_alone_and_of_a_pair_that_goes_on_the_later_keyframe_alone_is_made) {
    SurfaceBench bench, fresh;
    std::optional<SurfaceJob> first(std::in_place, 100'000);
    bench.finish(*first);
    const TimeUs next_us = first->end_us();
    const std::vector<double> before = heights_m(*first->surface(), 100'000);
    first.reset();
    EXPECT_EQ(bench.source.report().store.bytes, 4 * sea::SplineMap::bytes_of(64));
    SurfaceJob again(100'000);
    bench.finish(again);
    EXPECT_EQ(bench.source.report().synthesis.keyframes, 4u);
    EXPECT_EQ(heights_m(*again.surface(), 100'000), before);
    SurfaceJob next(next_us), of_its_own(next_us);
    bench.finish(next);
    fresh.finish(of_its_own);
    EXPECT_LE(bench.source.report().synthesis.keyframes, 6u);
    EXPECT_EQ(heights_m(*next.surface(), next_us), heights_m(*of_its_own.surface(), next_us));
    const KeyframeRequest before_now{0, again.surface()->pairs()[0].before->time_us(),
                                     sea::surface_fields, bench.course->first()->epoch};
    EXPECT_EQ(bench.source.holding(before_now), Holding::spline);
    EXPECT_EQ(bench.source.holding_of_maps(before_now), Holding::nothing)
        << "a fetch of it has its full price";
    KeyframeJob maps({before_now}, Walk::questions);
    ASSERT_TRUE(bench.source.work_on(maps));
    EXPECT_EQ(maps.take().front()->fields, sea::surface_fields);
    EXPECT_LE(bench.source.report().synthesis.keyframes, 7u);
    EXPECT_EQ(bench.source.holding(before_now), Holding::spline);
    EXPECT_EQ(bench.source.holding_of_maps(before_now), Holding::keyframe);
}

TEST(Surfaces, a_slice_makes_one_spline_at_most) {
    SurfaceBench bench;
    SurfaceJob job(100'000);
    (void)bench.surfaces.work_on(job);
    while (job.lacks_keyframes())
        ASSERT_TRUE(bench.surfaces.make_keyframes(job));
    const auto bytes = [&] { return bench.source.report().store.bytes; };
    const std::size_t maps = bytes() / 4, spline = sea::SplineMap::bytes_of(64);
    for (std::size_t slice = 1; slice <= 4; ++slice) {
        EXPECT_EQ(bench.surfaces.work_on(job), slice == 4);
        EXPECT_EQ(bytes(), slice * spline + (4 - slice) * maps) << "instead of its maps";
    }
}

TEST(Surfaces, who_wants_nothing_made_has_what_is_there_or_nothing) {
    SurfaceBench bench;
    SurfaceJob far(100'000, SurfaceUse::few);
    EXPECT_FALSE(bench.surfaces.work_on(far, Make::nothing));
    while (far.lacks_keyframes())
        ASSERT_TRUE(bench.surfaces.make_keyframes(far));
    const std::size_t before = bench.source.report().store.bytes;
    EXPECT_FALSE(bench.surfaces.work_on(far, Make::nothing));
    EXPECT_EQ(bench.source.report().store.bytes, before) << "no spline";
    bench.finish(far);
    SurfaceJob held(100'001, SurfaceUse::few);
    EXPECT_TRUE(bench.surfaces.work_on(held, Make::nothing));
}

TEST(Surfaces, of_all_threads_one_makes_a_spline_and_who_needs_none_goes_on) {
    SurfaceBench bench;
    SurfaceJob held(100'000);
    bench.finish(held);
    const TimeUs next_us = held.end_us();
    SurfaceJob made(next_us);
    (void)bench.surfaces.work_on(made);
    while (made.lacks_keyframes())
        ASSERT_TRUE(bench.surfaces.make_keyframes(made));
    std::shared_ptr<const void> turn = bench.surfaces.spline_turn();
    ASSERT_TRUE(turn);
    EXPECT_FALSE(bench.surfaces.work_on(made));
    EXPECT_TRUE(bench.surfaces.waits(made)) << "another thread makes one";
    EXPECT_FALSE(bench.surfaces.spline_turn());
    SurfaceJob point(100'001, SurfaceUse::few);
    EXPECT_TRUE(bench.surfaces.work_on(point));
    turn.reset();
    EXPECT_FALSE(bench.surfaces.waits(made));
    bench.finish(made);
}

// Naive: as many surfaces as questions; those about now, who come while batches are under way, wait for room.
TEST(Surfaces, who_asks_about_times_of_a_surface_that_is_used_shares_it_and_takes_no_room) {
    SurfaceBench bench;
    const auto room = bench.memory.room(MemoryUse::prompt_surfaces);
    std::optional<SurfaceJob> first(std::in_place, 100'000, SurfaceUse::prompt);
    bench.finish(*first);
    const std::size_t held = room->held_bytes();
    EXPECT_GT(held, 0u);
    SurfaceJob second(first->end_us() - 1, SurfaceUse::prompt);
    bench.finish(second);
    EXPECT_EQ(second.surface(), first->surface());
    EXPECT_EQ(second.end_us(), first->end_us());
    EXPECT_EQ(room->held_bytes(), held);
    SurfaceJob later(first->end_us(), SurfaceUse::prompt);
    bench.finish(later);
    EXPECT_NE(later.surface(), first->surface()) << "it ends there";
    first.reset();
    EXPECT_EQ(room->held_bytes(), 2 * held) << "somebody still has it";
}

// A change takes over while somebody uses the surface that was to be.
TEST(Surfaces, of_a_sea_that_another_took_over_from_is_not_shared_with_who_asks_later) {
    SurfaceBench bench;
    const TimeUs time_us = 20 * second_us;
    SurfaceJob before(time_us);
    bench.finish(before);
    bench.change(5 * second_us, 15 * second_us);
    SurfaceJob after(time_us);
    bench.finish(after);
    EXPECT_NE(after.surface(), before.surface());
    EXPECT_NE(after.surface()->pairs()[0].before->epoch(),
              before.surface()->pairs()[0].before->epoch());
}

// Naive: a surface that ends before its own time, and a question that comes no nearer to its end.
TEST(Surfaces, of_a_sea_that_another_takes_over_from_while_it_is_made_is_made_of_the_other) {
    const std::vector<sea::QueryPoint> later{{3, 4, 20 * second_us}};
    const auto answered = [&](SurfaceBench& bench, const std::function<void()>& meanwhile) {
        PointQuestion question(later);
        const auto slice = [&] {
            if (question.hand() == Hand::simulation)
                EXPECT_TRUE(question.make_keyframes(bench.surfaces));
            else
                question.sample(bench.surfaces, [] { return true; });
        };
        slice();
        EXPECT_EQ(question.hand(), Hand::simulation);
        slice();
        meanwhile();
        for (int slices = 0; slices < 100 && !question.complete(); ++slices)
            slice();
        EXPECT_TRUE(question.complete());
        return question.take_answers().answers.front().height_m;
    };
    SurfaceBench cut, known;
    known.change(5 * second_us, 15 * second_us);
    const double height_m = answered(cut, [&] { cut.change(5 * second_us, 15 * second_us); });
    EXPECT_EQ(height_m, answered(known, [] {}));
    SurfaceBench steady;
    EXPECT_NE(height_m, answered(steady, [] {}));
}

TEST(Surfaces, batches_wait_for_room_and_a_few_points_of_what_is_held_do_not) {
    const std::size_t least = Memory::least_bytes(needs_of(*running_sea()));
    SurfaceBench bench(least);
    // Held, with splines, as keyframes of the stream are; then others fill the room.
    std::optional<SurfaceJob> streamed(std::in_place, 888 * second_us, SurfaceUse::prompt);
    bench.finish(*streamed);
    const TimeUs held_us = streamed->end_us() - 1;
    streamed.reset();
    std::deque<SurfaceJob> others;
    do {
        SurfaceJob& job =
            others.emplace_back(static_cast<TimeUs>(others.size()) * second_us, SurfaceUse::prompt);
        for (bool there = false; !there && !bench.surfaces.waits(job);) {
            there = bench.surfaces.work_on(job);
            if (job.lacks_keyframes()) {
                ASSERT_TRUE(bench.surfaces.make_keyframes(job));
            }
        }
    } while (!bench.surfaces.waits(others.back()) && others.size() < 100);
    ASSERT_LT(others.size(), 100u) << "the room is full";
    SurfaceJob made(999 * second_us, SurfaceUse::few);
    EXPECT_FALSE(bench.surfaces.work_on(made));
    EXPECT_TRUE(bench.surfaces.waits(made)) << "there is something to be made";
    SurfaceJob few(held_us, SurfaceUse::few);
    EXPECT_TRUE(bench.surfaces.work_on(few));
    SurfaceJob batch(held_us + 1, SurfaceUse::prompt);
    EXPECT_FALSE(bench.surfaces.work_on(batch));
    while (others.size() > 1)
        others.pop_front();
    EXPECT_FALSE(bench.surfaces.waits(others.back())) << "others have let go";
}

TEST(Rooms, never_give_more_than_they_have_to_several_threads) {
    const auto room = Room::of(10);
    std::atomic<bool> overfull = false;
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; ++i)
        threads.emplace_back([&] {
            for (int k = 0; k < 20'000; ++k) {
                const Room::Place place = room->take(4);
                overfull = overfull || room->held_bytes() > 10;
            }
        });
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_FALSE(overfull);
    EXPECT_EQ(room->held_bytes(), 0u);
    EXPECT_LE(room->held_bytes_most(), 10u);
}

} // namespace
} // namespace seaway::server
