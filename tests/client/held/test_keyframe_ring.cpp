// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "client/link/failure.h"
#include "client/local_surface.h"
#include "sea/surface/budget/error_budget.h"

namespace seaway::client {
namespace {

using sea::Field;
using sea::FieldSet;
using sea::TimeUs;

constexpr TimeUs interval_us = 100'000;
constexpr FieldSet height_fields{Field::height, Field::height_rate};

/// A keyframe that is its own time everywhere, so that a torn one would show.
HeldKeyframePtr keyframe(TimeUs time_us, int cascade = 0, std::uint32_t epoch = 1,
                         FieldSet fields = height_fields, int size = 16, double length_m = 50) {
    sea::Keyframe made;
    made.epoch = epoch;
    made.cascade = cascade;
    made.time_us = time_us;
    made.size = size;
    made.length_m = length_m;
    made.fields = fields;
    made.values.assign(made.plane_size() * static_cast<std::size_t>(fields.size()),
                       static_cast<float>(time_us));
    HeldKeyframe::FieldErrors errors{};
    errors.fill(0.001f);
    return std::make_shared<const HeldKeyframe>(std::move(made), errors);
}

std::optional<KeyframePair> around(const KeyframeRing& ring, TimeUs time_us) {
    return ring.around(0, 1, time_us, interval_us, height_fields);
}

TEST(Ring, gives_the_two_keyframes_around_a_time_in_whatever_order_they_came) {
    KeyframeRing ring;
    for (const TimeUs time_us : {300'000, 100'000, 400'000, 200'000})
        ring.insert(keyframe(time_us));
    const auto pair = around(ring, 250'000);
    ASSERT_TRUE(pair);
    EXPECT_EQ(pair->before->keyframe().time_us, 200'000);
    EXPECT_EQ(pair->after->keyframe().time_us, 300'000);
    EXPECT_TRUE(pair->covers);
}

TEST(Ring, keyframes_of_different_sizes_or_lengths_make_no_pair) {
    for (const auto& [size, length_m] : {std::pair(32, 50.0), {16, 51.0}}) {
        KeyframeRing ring;
        ring.insert(keyframe(200'000));
        const HeldKeyframePtr other = keyframe(300'000, 0, 1, height_fields, size, length_m);
        ring.insert(other);
        const auto pair = around(ring, 250'000);
        ASSERT_TRUE(pair);
        EXPECT_EQ(pair->before, pair->after) << "what came last counts";
        EXPECT_EQ(pair->after, other);
        EXPECT_FALSE(pair->covers);
    }
}

TEST(Ring, a_keyframe_covers_its_very_time_alone_and_begins_the_pair_after_it) {
    KeyframeRing ring;
    ring.insert(keyframe(200'000));
    const auto alone = around(ring, 200'000);
    ASSERT_TRUE(alone);
    EXPECT_EQ(alone->before, alone->after);
    EXPECT_TRUE(alone->covers);
    ring.insert(keyframe(100'000));
    ring.insert(keyframe(300'000));
    const auto pair = around(ring, 200'000);
    EXPECT_EQ(pair->before->keyframe().time_us, 200'000);
    EXPECT_EQ(pair->after->keyframe().time_us, 300'000);
    EXPECT_TRUE(pair->covers);
}

TEST(Ring, g4_does_not_cover_times_beyond_what_is_held) {
    KeyframeRing ring;
    EXPECT_FALSE(around(ring, 0));
    ring.insert(keyframe(100'000));
    ring.insert(keyframe(200'000));
    ring.insert(keyframe(300'000));
    // The last two, or the first two: their cubic knows how the sea runs on for a moment.
    for (const auto& [time_us, before_us] : {std::pair<TimeUs, TimeUs>{350'000, 200'000},
                                             std::pair<TimeUs, TimeUs>{3'000'000'000, 200'000},
                                             std::pair<TimeUs, TimeUs>{-50'000, 100'000}}) {
        const auto pair = around(ring, time_us);
        ASSERT_TRUE(pair);
        EXPECT_FALSE(pair->covers);
        EXPECT_EQ(pair->before->keyframe().time_us, before_us);
        EXPECT_EQ(pair->after->keyframe().time_us, before_us + 100'000);
    }
    EXPECT_TRUE(around(ring, 300'000)->covers) << "the very last moment";
}

TEST(Ring, h4_does_not_cover_a_gap_that_is_wider_than_the_interval) {
    KeyframeRing ring;
    ring.insert(keyframe(100'000));
    ring.insert(keyframe(300'000));
    EXPECT_TRUE(around(ring, 100'000)->covers);
    // Naive: the cubic through both, which swells between them: 16 s apart to 2.6 times a gale.
    const auto expect_alone = [&](TimeUs time_us, TimeUs nearer_us) {
        const auto pair = around(ring, time_us);
        ASSERT_TRUE(pair);
        EXPECT_FALSE(pair->covers);
        EXPECT_EQ(pair->before, pair->after);
        EXPECT_EQ(pair->before->keyframe().time_us, nearer_us);
    };
    expect_alone(150'000, 100'000);
    expect_alone(250'000, 300'000);
    ring.insert(keyframe(0));
    ring.insert(keyframe(400'000));
    const auto runs_on = around(ring, 150'000), runs_back = around(ring, 250'000);
    EXPECT_EQ(runs_on->before->keyframe().time_us, 0);
    EXPECT_EQ(runs_on->after->keyframe().time_us, 100'000);
    EXPECT_EQ(runs_back->before->keyframe().time_us, 300'000);
    EXPECT_EQ(runs_back->after->keyframe().time_us, 400'000);
    EXPECT_FALSE(runs_on->covers || runs_back->covers);
}

TEST(Ring, never_mixes_epochs_cascades_or_keyframes_that_lack_a_field) {
    KeyframeRing ring;
    ring.insert(keyframe(100'000, 0, 2));
    ring.insert(keyframe(100'000, 1, 1));
    ring.insert(keyframe(200'000, 0, 1, {Field::foam}));
    EXPECT_FALSE(around(ring, 150'000));
    ring.insert(keyframe(300'000));
    EXPECT_EQ(around(ring, 150'000)->before->keyframe().time_us, 300'000);
}

TEST(Ring, the_newest_is_the_latest_of_its_cascade_in_whatever_order_they_came) {
    KeyframeRing ring;
    EXPECT_EQ(ring.newest(0), nullptr);
    for (const TimeUs time_us : {200'000, 400'000, -100'000, 300'000})
        ring.insert(keyframe(time_us));
    ring.insert(keyframe(900'000, 1));
    EXPECT_EQ(ring.newest(0)->keyframe().time_us, 400'000);
    EXPECT_EQ(ring.newest(1)->keyframe().time_us, 900'000);
    EXPECT_EQ(ring.newest(2), nullptr);
}

TEST(Ring, one_time_of_two_epochs_is_two_keyframes) {
    KeyframeRing ring;
    for (const std::uint32_t epoch : {1u, 2u})
        for (const TimeUs time_us : {100'000, 200'000})
            ring.insert(keyframe(time_us, 0, epoch));
    EXPECT_EQ(ring.size(0), 4u);
    for (const std::uint32_t epoch : {1u, 2u}) {
        const auto pair = ring.around(0, epoch, 150'000, interval_us, height_fields);
        ASSERT_TRUE(pair) << epoch;
        EXPECT_TRUE(pair->covers);
        EXPECT_EQ(pair->before->keyframe().epoch, epoch);
        EXPECT_EQ(pair->after->keyframe().epoch, epoch);
    }
}

TEST(Ring, h2_a_duplicate_replaces_unless_it_holds_less) {
    KeyframeRing ring;
    const FieldSet rich = height_fields | FieldSet{Field::foam};
    ring.insert(keyframe(100'000));
    ring.insert(keyframe(100'000, 0, 1, rich));
    EXPECT_EQ(ring.newest(0)->keyframe().fields, rich);
    ring.insert(keyframe(100'000));
    EXPECT_EQ(ring.newest(0)->keyframe().fields, rich);
    EXPECT_EQ(ring.size(0), 1u);
}

// What comes again is the newest: it goes last when there is no room.
TEST(Ring, an_equal_copy_takes_the_place_of_the_first_and_counts_as_having_come_last) {
    KeyframeRing ring({.keyframes_per_cascade = 4});
    for (const TimeUs n : {1, 2, 3, 4})
        ring.insert(keyframe(n * interval_us));
    const HeldKeyframePtr again = keyframe(interval_us);
    ring.insert(again);
    EXPECT_EQ(around(ring, interval_us)->before, again);
    for (const TimeUs n : {5, 6, 7})
        ring.insert(keyframe(n * interval_us));
    EXPECT_EQ(around(ring, interval_us)->before, again) << "the fourth and last to go";
    EXPECT_TRUE(around(ring, interval_us)->covers);
    ring.insert(keyframe(8 * interval_us));
    EXPECT_FALSE(around(ring, interval_us)->covers);
}

TEST(Ring, is_bounded_by_count_and_the_first_to_come_goes_first) {
    KeyframeRing ring({.keyframes_per_cascade = 5});
    for (TimeUs n = 0; n < 100; ++n)
        ring.insert(keyframe(n * interval_us));
    EXPECT_EQ(ring.size(0), 5u);
    EXPECT_EQ(ring.newest(0)->keyframe().time_us, 99 * interval_us);
    EXPECT_FALSE(around(ring, 90 * interval_us + 1)->covers);
    EXPECT_TRUE(around(ring, 96 * interval_us + 1)->covers);
}

TEST(Ring, is_bounded_by_bytes_but_keeps_what_sampling_needs) {
    KeyframeRing ring({.bytes_per_cascade = 1});
    for (TimeUs n = 0; n < 10; ++n)
        ring.insert(keyframe(n * interval_us));
    EXPECT_EQ(ring.size(0), RingLimits::keyframes_per_cascade_min);
}

/// What a keyframe takes, counted from what it has made.
std::size_t bytes_held(const HeldKeyframe& held) {
    return held.keyframe().values.size() * sizeof(float) +
           (held.can_be_sampled() ? held.spline()->bytes() : 0);
}

TEST(Ring, counts_the_bytes_that_it_holds_whatever_is_inserted_replaced_and_dropped) {
    std::mt19937_64 random(16);
    const FieldSet kinds[] = {
        height_fields, height_fields | FieldSet{Field::foam}, {Field::foam}, sea::surface_fields};
    const RingLimits limits{.keyframes_per_cascade = 12, .bytes_per_cascade = 120'000};
    KeyframeRing ring(limits);
    std::vector<std::weak_ptr<const HeldKeyframe>> all;
    int full = 0, replaced = 0;
    for (int round = 0; round < 3000; ++round) {
        sea::Keyframe made;
        made.epoch = 1 + static_cast<std::uint32_t>(random() % 2);
        made.time_us = static_cast<TimeUs>(random() % 20) * interval_us;
        made.size = 16 << random() % 2;
        made.length_m = 50;
        made.fields = kinds[random() % 4];
        made.values.resize(made.plane_size() * static_cast<std::size_t>(made.fields.size()));
        HeldKeyframePtr held =
            std::make_shared<const HeldKeyframe>(std::move(made), HeldKeyframe::FieldErrors{});
        all.push_back(held);
        const std::size_t before = ring.size(0);
        ring.insert(std::move(held));
        replaced += ring.size(0) == before && before < limits.keyframes_per_cascade;
        // Nobody else keeps one: those that are alive are those held.
        std::erase_if(all, [](const auto& one) { return one.expired(); });
        std::size_t bytes = 0;
        for (const auto& one : all)
            bytes += bytes_held(*one.lock());
        ASSERT_EQ(ring.size(0), all.size());
        ASSERT_EQ(ring.bytes(0), bytes) << "round " << round;
        ASSERT_LE(ring.size(0), limits.keyframes_per_cascade);
        if (ring.size(0) > RingLimits::keyframes_per_cascade_min) {
            ASSERT_LE(bytes, limits.bytes_per_cascade);
        }
        full += ring.size(0) < limits.keyframes_per_cascade && bytes > 90'000;
    }
    EXPECT_GT(full, 100) << "the limit on bytes was hardly met";
    EXPECT_GT(replaced, 100);
}

TEST(Ring, says_how_many_keyframes_of_a_size_it_has_room_for) {
    for (const std::size_t bytes_max : {1u, 40'000u, 100'000u, 1'000'000u}) {
        const RingLimits limits{.keyframes_per_cascade = 12, .bytes_per_cascade = bytes_max};
        KeyframeRing ring(limits);
        for (TimeUs n = 0; n < 50; ++n)
            ring.insert(keyframe(n * interval_us));
        EXPECT_EQ(limits.room(HeldKeyframe::bytes_of(height_fields, 16)), ring.size(0));
    }
}

// A naive ring hands out a keyframe that is overwritten while it is read.
TEST(Ring, g10_readers_see_whole_keyframes_while_it_moves_on) {
    KeyframeRing ring({.keyframes_per_cascade = 4});
    ring.insert(keyframe(0));
    std::atomic<bool> stop = false;
    std::atomic<int> torn = 0, reads = 0, moved = 0;
    std::thread reader([&] {
        for (TimeUs last_us = 0; !stop; ++reads) {
            const HeldKeyframePtr newest = ring.newest(0);
            const TimeUs time_us = newest->keyframe().time_us;
            const auto expected = static_cast<float>(time_us);
            for (const float value : newest->keyframe().values)
                torn += value != expected;
            torn += newest->spline()->time_us() != time_us;
            moved += time_us != last_us;
            last_us = time_us;
        }
    });
    // Fifty reads after each: who takes the lock again at once would keep readers out.
    constexpr int inserted = 200;
    for (int n = 1; n <= inserted; ++n) {
        ring.insert(keyframe(n));
        for (const int before = reads; reads <= before + 50;)
            std::this_thread::yield();
    }
    stop = true;
    reader.join();
    EXPECT_GT(reads, 10'000);
    EXPECT_EQ(moved, inserted);
    EXPECT_EQ(torn, 0);
}

SeaState one_cascade_sea() {
    SeaState state;
    state.epoch = 1;
    state.cascades.push_back({.length_m = 50, .size = 16, .interval_us = interval_us});
    state.interpolation_error_m = 0.002;
    state.interpolation_strain = 0.003;
    return state;
}

TEST(LocalAnswer, names_the_cascade_of_which_nothing_is_held) {
    KeyframeRing ring;
    SeaState state = one_cascade_sea();
    state.cascades.push_back(state.cascades.front());
    ring.insert(keyframe(0));
    const auto surface = local_surface(state, ring, 0, height_fields);
    ASSERT_FALSE(surface);
    EXPECT_EQ(failure_of(surface.error()), Failure::not_held);
    EXPECT_NE(surface.error().message.find("cascade 1"), std::string::npos);
}

// A server that says no more has these errors everywhere, whatever the time and place.
TEST(LocalAnswer, a_stated_error_holds_interpolation_and_codec) {
    KeyframeRing ring;
    ring.insert(keyframe(0));
    ring.insert(keyframe(interval_us));
    SeaState state = one_cascade_sea();
    state.interpolation_displacement_m = 0.004;
    const auto pair = ring.around(0, 1, 50'000, interval_us, height_fields);
    ASSERT_TRUE(pair);
    const sea::MapError error = local_map_error(state, {&*pair, 1});
    EXPECT_DOUBLE_EQ(error.height_bound_m, 0.002);
    EXPECT_DOUBLE_EQ(error.displacement_bound_m, 0.004);
    EXPECT_DOUBLE_EQ(error.strain_bound, 0.003);
    // Values of 1 mm at most, evenly spread.
    ASSERT_EQ(error.cascades.size(), 1u);
    EXPECT_NEAR(error.cascades[0].height.value_m, 0.001 / std::sqrt(3.0), 1e-9);
    EXPECT_EQ(error.cascades[0].height.time_m, 0);
}

// bound = formula, not only error <= bound: a bound that is too wide, or that forgets a keyframe, a
// component or an axis, holds every comparison of heights. Each of the four is the worst one in turn.
TEST(LocalAnswer, a_codec_error_is_that_of_the_worst_keyframe_component_and_axis_of_every_cascade) {
    SeaState state = one_cascade_sea();
    state.cascades.push_back({.length_m = 10, .size = 16, .interval_us = 40'000});
    state.losses = {{{0.1, 0.2, 0.3}, {0.4, 0.5, 0.6}}, {{0.7, 0.8, 0.9}, {1.0, 1.1, 1.2}}};
    state.single_precision_m = 0.01;
    state.single_precision_displacement_m = 0.02;
    using Errors = HeldKeyframe::FieldErrors;
    const auto of = [](Errors& errors, Field field) -> float& {
        return errors[static_cast<std::size_t>(field)];
    };
    const auto held = [](int cascade, TimeUs time_us, const Errors& errors) {
        sea::Keyframe made = keyframe(time_us, cascade, 1, sea::surface_fields)->keyframe();
        return std::make_shared<const HeldKeyframe>(std::move(made), errors);
    };
    const double root3 = std::sqrt(3.0);
    for (const bool worst_is_first : {true, false})
        for (const bool worst_is_x : {true, false})
            for (const bool wide_is_x : {true, false}) {
                state.choppiness_x = wide_is_x ? 1.5 : 0.5;
                state.choppiness_y = wide_is_x ? 0.5 : 1.5;
                Errors fine{}, coarse{};
                for (const Field field : sea::surface_fields)
                    of(fine, field) = 1e-4f;
                of(coarse, Field::height) = 0.003f;
                of(coarse, Field::height_rate) = 0.005f;
                of(coarse, worst_is_x ? Field::displacement_x : Field::displacement_y) = 0.007f;
                of(coarse, worst_is_x ? Field::displacement_x_rate : Field::displacement_y_rate) =
                    0.011f;
                const Errors &first = worst_is_first ? coarse : fine,
                             &second = worst_is_first ? fine : coarse;
                const KeyframePair pairs[] = {
                    {held(0, 0, first), held(0, interval_us, second), true},
                    {held(1, 0, second), held(1, 40'000, first), true}};
                const sea::MapError error = local_map_error(state, pairs);
                ASSERT_EQ(error.cascades.size(), 2u);
                double strain = 0;
                for (std::size_t c = 0; c < 2; ++c) {
                    const sea::CascadeLoss &loss = error.cascades[c], &told = state.losses[c];
                    for (const auto& [got, wanted] : {std::pair(loss.height, told.height),
                                                      {loss.displacement, told.displacement}}) {
                        EXPECT_EQ(got.time_m, wanted.time_m);
                        EXPECT_EQ(got.east_m, wanted.east_m);
                        EXPECT_EQ(got.north_m, wanted.north_m);
                    }
                    EXPECT_NEAR(loss.height.value_m, 0.003 / root3, 1e-9);
                    EXPECT_NEAR(loss.height.rate_mps, 0.005 / root3, 1e-9);
                    EXPECT_NEAR(loss.displacement.value_m, 0.007 / root3, 1e-9);
                    EXPECT_NEAR(loss.displacement.rate_mps, 0.011 / root3, 1e-9);
                    const sea::Keyframe& map = pairs[c].before->keyframe();
                    strain += sea::coded_strain_variance(loss.displacement, c == 0 ? 0.1 : 0.04,
                                                         map.length_m / map.size);
                }
                EXPECT_EQ(error.height_bound_m, 0.01);
                EXPECT_EQ(error.displacement_bound_m, 0.02);
                EXPECT_NEAR(error.codec_strain_bound, sea::coded_strain_bound({1.5, 1.5}, strain),
                            1e-12);
            }
}

TEST(LocalAnswer, folds_are_looked_for_as_far_as_points_move_sideways) {
    KeyframeRing ring;
    ring.insert(keyframe(0));
    SeaState state = one_cascade_sea();
    state.realised.hs_m = 4; // says nothing of it on shallow water
    state.displacement_reach_m = 17.25;
    state.choppiness_x = 0.5;
    state.choppiness_y = 1.2;
    const auto local = local_surface(state, ring, 0, height_fields);
    ASSERT_TRUE(local);
    EXPECT_DOUBLE_EQ(local->surface.folds().reach_m, 17.25);
}

TEST(LocalAnswer, a_time_is_covered_only_with_all_that_follows_it_in_its_cell) {
    KeyframeRing ring;
    ring.insert(keyframe(0));
    const SeaState state = one_cascade_sea();
    EXPECT_FALSE(covers(state, ring, 0, height_fields));
    ring.insert(keyframe(interval_us));
    EXPECT_TRUE(covers(state, ring, 0, height_fields));
    EXPECT_TRUE(covers(state, ring, interval_us - 1, height_fields));
    EXPECT_FALSE(covers(state, ring, interval_us, height_fields));
}

TEST(TimeCells, are_the_intervals_of_all_cascades_also_before_the_epoch) {
    SeaState state = one_cascade_sea();
    state.cascades.push_back({.length_m = 10, .size = 16, .interval_us = 40'000});
    EXPECT_EQ(time_cell(state, 0), time_cell(state, 39'999));
    EXPECT_NE(time_cell(state, 39'999), time_cell(state, 40'000));
    EXPECT_EQ(time_cell(state, -1), (TimeCell{-1, -1}));
    EXPECT_EQ(time_cell(state, -40'000), (TimeCell{-1, -1}));
    EXPECT_EQ(time_cell(state, -40'001), (TimeCell{-1, -2}));
}

} // namespace
} // namespace seaway::client
