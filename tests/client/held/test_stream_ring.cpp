// SPDX-License-Identifier: Apache-2.0
// What a ring holds of a stream.
#include <gtest/gtest.h>

#include "client/held/keyframe_ring.h"
#include "sea/surface/budget/spending.h"

namespace seaway::client {
namespace {

using sea::Field;
using sea::FieldSet;
using sea::TimeUs;

constexpr TimeUs step_us = 100'000;
constexpr FieldSet streamed_fields{Field::height, Field::height_rate};

HeldKeyframePtr streamed(TimeUs time_us, int cascade = 0, FieldSet fields = streamed_fields) {
    sea::Keyframe made{1, cascade, time_us, 16, 50, fields, {}};
    made.values.assign(static_cast<std::size_t>(fields.size()) * made.plane_size(), 0.5f);
    return std::make_shared<const HeldKeyframe>(std::move(made), HeldKeyframe::FieldErrors{});
}

std::optional<KeyframePair> held_around(const KeyframeRing& ring, TimeUs time_us) {
    return ring.around(0, 1, time_us, step_us, streamed_fields);
}

// A server sends each keyframe an interval and more before its time; the present has then reached the one before.
TEST(Ring, of_a_stream_keeps_what_is_ahead_and_what_the_look_back_needs) {
    KeyframeRing ring({.look_back_us = 5 * step_us});
    for (TimeUs n = 0; n < 40; ++n) {
        ring.insert_passing(streamed((n + 2) * step_us), n * step_us + 1, step_us);
        ASSERT_LE(ring.size(0), 8u) << n;
    }
    const TimeUs now_us = 39 * step_us + 1;
    for (TimeUs back_us = -step_us; back_us <= 5 * step_us; back_us += step_us / 3)
        EXPECT_TRUE(held_around(ring, now_us - back_us)->covers) << back_us;
    EXPECT_FALSE(held_around(ring, now_us - 7 * step_us)->covers);
    EXPECT_EQ(ring.size(0), 8u) << "two ahead, the one before now, and five for the look-back";
}

TEST(Ring, what_was_asked_for_stays_when_the_present_has_gone_by) {
    KeyframeRing ring({.look_back_us = 0});
    ring.insert(streamed(3 * step_us));
    ring.insert_passing(streamed(4 * step_us), 3 * step_us, step_us);
    ring.insert(streamed(4 * step_us)); // it came by, and is asked for
    for (TimeUs n = 5; n < 50; ++n) {
        ring.insert_passing(streamed(n * step_us), (n - 1) * step_us, step_us);
        ring.insert_passing(streamed(4 * step_us), (n - 1) * step_us, step_us);
    }
    EXPECT_TRUE(held_around(ring, 3 * step_us + 1)->covers);
    EXPECT_FALSE(held_around(ring, 7 * step_us)->covers);
    EXPECT_LE(ring.size(0), 5u);
}

// Naive: as many keyframes as a usual look-back needs, whatever was asked for, and the first to come makes room.
TEST(Ring, a_long_look_back_has_room_and_takes_none_of_what_was_asked_for) {
    constexpr TimeUs back_us = 60'000'000, apart_us = 400'000;
    KeyframeRing ring({.look_back_us = back_us});
    ring.insert(streamed(-2 * apart_us));
    ring.insert(streamed(-apart_us));
    const TimeUs end = 200;
    for (TimeUs n = 0; n <= end; ++n)
        ring.insert_passing(streamed((n + 2) * apart_us), n * apart_us, apart_us);
    for (TimeUs ago_us = 0; ago_us <= back_us; ago_us += apart_us / 3)
        ASSERT_TRUE(ring.around(0, 1, end * apart_us - ago_us, apart_us, streamed_fields)->covers)
            << ago_us;
    EXPECT_TRUE(ring.around(0, 1, -apart_us - 1, apart_us, streamed_fields)->covers);
    EXPECT_LE(ring.size(0), 150u + 4u + 2u) << "and what is over has gone";
}

// Naive: as many intervals as the look-back has, from its end on: the keyframe before it has gone.
TEST(Ring, a_look_back_of_any_length_is_held_to_its_beginning_however_few_bytes_there_are) {
    for (const TimeUs apart_us : {160'000, 320'000, 500'000, 800'000})
        for (const TimeUs back_us : {300'000, 5'000'000, 20'000'000, 60'000'000}) {
            KeyframeRing ring({.bytes_per_cascade = 1, .look_back_us = back_us});
            constexpr TimeUs end = 400, ahead = 3;
            for (TimeUs n = 0; n <= end; ++n)
                ring.insert_passing(streamed(n * apart_us), (n - ahead) * apart_us - 1, apart_us);
            const TimeUs now_us = (end - ahead) * apart_us - 1;
            for (const TimeUs ago_us : {TimeUs{0}, back_us}) {
                ASSERT_TRUE(ring.around(0, 1, now_us - ago_us, apart_us, streamed_fields)->covers)
                    << apart_us << ' ' << back_us << ' ' << ago_us;
            }
        }
}

// A hostile stream is of any interval, and its keyframes of any time.
TEST(Ring, what_passes_by_is_bounded_by_count_and_bytes) {
    for (const TimeUs back_us : {RingLimits::look_back_usual_us, TimeUs{60'000'000}}) {
        RingLimits limits{.look_back_us = back_us};
        EXPECT_EQ(limits.more_passing(1), back_us > 1'000'000 ? 6002u : 0u) << "10 ms apart";
        KeyframeRing many(limits);
        limits.bytes_per_cascade = 1;
        KeyframeRing large(limits);
        const std::size_t more = limits.more_passing(1'000'000);
        for (TimeUs n = 0; n < 300; ++n) {
            many.insert_passing(streamed(n), 0, 1'000'000);
            large.insert_passing(streamed(n), 0, 1'000'000);
        }
        EXPECT_EQ(many.size(0), limits.keyframes_per_cascade + more);
        EXPECT_EQ(large.size(0), RingLimits::keyframes_per_cascade_min + more);
    }
}

// Naive: room for the bytes of a usual stream. What is sent ahead of a sea ten times as fast as clocks, of maps of 512 x 512, has
// no place then, is dropped as it comes, and never comes again.
TEST(Ring, of_a_hurried_stream_every_time_is_covered_however_large_its_maps_are) {
    constexpr TimeUs lead_us = sea::publish_lead_us, line_us = 20'000; // of clocks
    for (const TimeUs apart_us : {20'000, 125'000, 250'000, 800'000})
        for (const int hurry : {1, 4, 10})
            for (const std::size_t bytes_max : {std::size_t{1}, RingLimits{}.bytes_per_cascade}) {
                KeyframeRing ring({.bytes_per_cascade = bytes_max});
                TimeUs next_us = 0;
                for (TimeUs now_us = 0; now_us < 8'000'000; now_us += 5'000 * hurry) {
                    for (; next_us - apart_us - hurry * (lead_us - line_us) <= now_us;
                         next_us += apart_us)
                        ring.insert_passing(streamed(next_us), now_us, apart_us, hurry);
                    ASSERT_TRUE(ring.around(0, 1, now_us, apart_us, streamed_fields)->covers)
                        << apart_us << ' ' << hurry << ' ' << bytes_max << ' ' << now_us;
                }
            }
}

// Naive: the first to come makes room. A stream that is sent further ahead than there is room for, as at a high pace, then
// never leaves what is now.
TEST(Ring, of_a_stream_that_comes_too_far_ahead_what_is_now_stays) {
    KeyframeRing ring({.keyframes_per_cascade = 12, .look_back_us = step_us});
    constexpr TimeUs ahead = 30; // intervals
    int covered = 0;
    for (TimeUs n = 0; n < 300; ++n) {
        ring.insert_passing(streamed((n + ahead) * step_us), n * step_us + 1, step_us);
        ASSERT_LE(ring.size(0), 12u);
        const auto now = held_around(ring, n * step_us + 1);
        covered += now && now->covers;
    }
    EXPECT_GT(covered, 70) << "a third of the time, as there is room for a third";
}

HeldKeyframePtr of_epoch(std::uint32_t epoch, TimeUs time_us) {
    sea::Keyframe made{epoch, 0, time_us, 16, 50, streamed_fields, {}};
    made.values.assign(2 * made.plane_size(), 0.5f);
    return std::make_shared<const HeldKeyframe>(std::move(made), HeldKeyframe::FieldErrors{});
}

// Naive: the last keyframe of every sea that has been stays, and in the end there is room for nothing else.
TEST(Ring, of_a_sea_that_is_over_nothing_stays) {
    KeyframeRing ring({.keyframes_per_cascade = 12, .look_back_us = 2 * step_us});
    constexpr TimeUs of_each = 15; // keyframes of an epoch, and one of the next at its end
    for (TimeUs n = 0; n < 80 * of_each; ++n) {
        const auto epoch = static_cast<std::uint32_t>(1 + n / of_each);
        for (const TimeUs at : {n, n + 1})
            ring.insert_passing(of_epoch(epoch, (at + 1) * step_us), n * step_us + 1, step_us);
        ASSERT_LE(ring.size(0), 8u) << n;
        const TimeUs now_us = n * step_us + 1;
        if (n % of_each > 1) {
            ASSERT_TRUE(ring.around(0, epoch, now_us, step_us, streamed_fields)->covers) << n;
        }
        if (n % of_each > 3) {
            ASSERT_TRUE(
                ring.around(0, epoch, now_us - 2 * step_us, step_us, streamed_fields)->covers)
                << n;
        }
    }
}

// Naive: the room follows the interval of what has just come: keyframes further apart leave room for fewer, and what is now
// is left out for what was a minute ago.
TEST(Ring, when_keyframes_come_further_apart_what_is_now_stays) {
    constexpr TimeUs back_us = 60'000'000, later_us = 4 * step_us;
    KeyframeRing ring({.look_back_us = back_us});
    TimeUs now_us = 0;
    for (; now_us < 2 * back_us; now_us += step_us)
        ring.insert_passing(of_epoch(1, now_us + 2 * step_us), now_us, step_us);
    const TimeUs change_us = now_us;
    for (; now_us < change_us + back_us; now_us += later_us) {
        ring.insert_passing(of_epoch(2, now_us + 2 * later_us), now_us, later_us);
        if (now_us > change_us + 3 * later_us) {
            ASSERT_TRUE(ring.around(0, 2, now_us, later_us, streamed_fields)->covers) << now_us;
        }
        if (now_us < change_us + 10'000'000) {
            ASSERT_TRUE(ring.around(0, 1, change_us - 5'000'000, step_us, streamed_fields)->covers)
                << now_us;
        }
    }
}

// Who has subscribed to less holds what he asked for of the surface besides.
TEST(Ring, keyframes_of_which_each_has_what_the_other_lacks_are_both_held) {
    const FieldSet less = streamed_fields | FieldSet{Field::foam};
    for (const bool asked_first : {true, false}) {
        KeyframeRing ring;
        for (const bool asked : {asked_first, !asked_first}) {
            if (asked)
                ring.insert(streamed(0, 0, sea::surface_fields));
            else
                ring.insert_passing(streamed(0, 0, less), 0, step_us);
        }
        for (const FieldSet& fields : {sea::surface_fields, less})
            EXPECT_TRUE(ring.around(0, 1, 0, step_us, fields)) << asked_first;
        ring.insert(streamed(0, 0, sea::surface_fields | less));
        EXPECT_EQ(ring.size(0), 1u) << "in place of both";
    }
}

// They came with a fetch whose asker has them.
TEST(Ring, keyframes_far_ahead_that_nobody_asked_for_do_not_stay) {
    KeyframeRing ring;
    for (TimeUs n = 0; n < 20; ++n)
        ring.insert_passing(streamed(n * step_us), (n - 2) * step_us, step_us);
    const std::size_t before = ring.size(0);
    for (TimeUs n = 0; n < 40; ++n)
        ring.insert_passing(streamed(RingLimits::ahead_max_us + (20 + n) * step_us), 18 * step_us,
                            step_us);
    EXPECT_LE(ring.size(0), before);
    EXPECT_TRUE(held_around(ring, 18 * step_us)->covers);
}

// Of a server that was started anew its time begins again; and one second of a sea with long intervals is none of them.
TEST(Ring, holds_two_whatever_their_times_are) {
    KeyframeRing ring({.look_back_us = 0});
    for (TimeUs n = 0; n < 10; ++n)
        ring.insert_passing(streamed(n * step_us), 100 * step_us, step_us);
    EXPECT_EQ(ring.size(0), RingLimits::passing_per_cascade_min);
}

// Naive: from the first to the last, whatever is missing between.
TEST(Ring, says_from_when_to_when_every_time_is_covered) {
    KeyframeRing ring;
    const auto held = [&](TimeUs time_us) {
        return ring.held(0, 1, time_us, step_us, streamed_fields);
    };
    EXPECT_FALSE(held(0));
    for (const TimeUs n : {1, 2, 3, 6, 7, 8})
        ring.insert(streamed(n * step_us));
    for (const TimeUs n : {4, 5})
        ring.insert(streamed(n * step_us, 0, {Field::foam}));
    const std::pair<TimeUs, TimeUs> first{step_us, 3 * step_us}, second{6 * step_us, 8 * step_us};
    EXPECT_EQ(held(2 * step_us + 1), first);
    EXPECT_EQ(held(4 * step_us), first) << "what was held last";
    EXPECT_EQ(held(0), first) << "what is held next";
    EXPECT_EQ(held(6 * step_us), second);
    EXPECT_EQ(held(20 * step_us), second);
    EXPECT_FALSE(ring.held(0, 2, 0, step_us, streamed_fields)) << "of another epoch";
    ring.insert(streamed(4 * step_us));
    ring.insert(streamed(5 * step_us));
    EXPECT_EQ(held(0), std::pair(first.first, second.second));
}

TEST(Ring, of_what_has_been_sampled_the_spline_alone_is_held) {
    KeyframeRing ring;
    const HeldKeyframePtr sampled = streamed(0, 1);
    ring.insert_passing(sampled, 0, step_us);
    const sea::SplineMapPtr spline = sampled->spline();
    const std::size_t before = ring.bytes(1);
    ring.insert_passing(streamed(0, 0), 0, step_us); // of another cascade, too
    const HeldKeyframePtr held = ring.newest(1);
    EXPECT_EQ(held->spline(), spline);
    EXPECT_TRUE(held->keyframe().values.empty());
    EXPECT_EQ(held->fields(), streamed_fields);
    EXPECT_EQ(ring.bytes(1), before - 2 * 16 * 16 * sizeof(float));
    EXPECT_TRUE(ring.around(1, 1, 0, step_us, streamed_fields)->covers);
}

} // namespace
} // namespace seaway::client
