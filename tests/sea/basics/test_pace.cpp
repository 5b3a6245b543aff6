// SPDX-License-Identifier: Apache-2.0
#include <random>

#include <gtest/gtest.h>

#include "sea/basics/pace.h"

namespace seaway::sea {
namespace {

TEST(Paces, none_is_the_time_itself) {
    const Paces paces;
    for (const TimeUs us : {-5'000'001L, 0L, 77L, 1'000'000'000'000L}) {
        EXPECT_EQ(paces.sea_time(us), us);
        EXPECT_EQ(paces.moment_of(us + 9, us), us + 9);
        EXPECT_EQ(paces.moment_of(us - 9, us), us);
    }
}

TEST(Paces, a_pace_goes_on_from_where_the_sea_was) {
    Paces paces;
    paces.add(paces.next(1'000'000, 0)); // paused
    EXPECT_EQ(paces.sea_time(999'999), 999'999);
    EXPECT_EQ(paces.sea_time(9'000'000), 1'000'000);
    EXPECT_EQ(paces.moment_of(1'000'001, 2'000'000), std::nullopt) << "never";
    paces.add(paces.next(11'000'000, 2'500));
    EXPECT_EQ(paces.sea_time(13'000'000), 6'000'000);
    EXPECT_EQ(paces.moment_of(6'000'000, 2'000'000), 13'000'000) << "over the pause";
    EXPECT_EQ(paces.fastest_permille(2'000'000), 2'500);
    // One that begins before takes over.
    paces.add(paces.next(5'000'000, 1'000));
    EXPECT_EQ(paces.sea_time(13'000'000), 9'000'000);
    EXPECT_EQ(paces.all().size(), 2u);
    paces.forget_before(6'000'000);
    EXPECT_EQ(paces.all().size(), 1u);
    EXPECT_EQ(paces.sea_time(13'000'000), 9'000'000);
}

// Naive: 64 bits do not hold a time times a pace.
TEST(Paces, at_the_ends_of_all_times_the_sea_stands) {
    Paces paces;
    paces.add({-time_us_max, 0, pace_permille_max});
    for (const TimeUs us : {0L, time_us_max / 2, time_us_max})
        EXPECT_EQ(paces.sea_time(us), time_us_max);
    paces.add({0, time_us_max, 900});
    EXPECT_EQ(paces.sea_time(time_us_max), time_us_max);

    Paces slow;
    slow.add({0, 0, 1});
    EXPECT_EQ(slow.sea_time(time_us_max), time_us_max / pace_unit);
    EXPECT_EQ(slow.moment_of(time_us_max / pace_unit, 0), time_us_max);
    EXPECT_EQ(slow.moment_of(time_us_max, 0), std::nullopt) << "later than all times";
    EXPECT_EQ(slow.moment_of(time_us_max + 1, 0), std::nullopt);
    slow.add({1'000'000, 1'000, pace_permille_max});
    EXPECT_EQ(slow.moment_of(time_us_max, 0), 1'000'000 + (time_us_max - 1'000) / 10);
}

// Naive: a server that promises paces without end fills the memory of its clients.
TEST(Paces, of_many_to_come_the_last_ones_are_held) {
    Paces paces;
    for (TimeUs second = 1; second <= 100'000; ++second)
        paces.add({second * 1'000'000, 7, 1});
    EXPECT_EQ(paces.all().size(), paces_max);
    EXPECT_EQ(paces.all().back().from_us, 100'000'000'000);
}

// Naive: a double loses microseconds after a month, and two readers round otherwise.
TEST(Paces, time_never_jumps_or_goes_back_and_the_moment_of_a_time_is_the_first_one) {
    std::mt19937_64 random(4);
    for (int round = 0; round < 200; ++round) {
        Paces paces;
        TimeUs at_us = static_cast<TimeUs>(random() % 4'000'000'000'000'000ull);
        for (int i = 0; i < 5; ++i) {
            const int permille = static_cast<int>(random() % (pace_permille_max + 1));
            paces.add(paces.next(at_us, random() % 4 == 0 ? 0 : permille));
            at_us += static_cast<TimeUs>(random() % 3'000'000);
        }
        TimeUs last_us = paces.sea_time(paces.all().front().from_us - 1);
        for (TimeUs us = paces.all().front().from_us; us < at_us; us += 997) {
            const TimeUs now_us = paces.sea_time(us);
            ASSERT_GE(now_us, last_us);
            ASSERT_LE(now_us - last_us, 997 * pace_permille_max / pace_unit + 1);
            last_us = now_us;
            const TimeUs wanted_us = now_us + static_cast<TimeUs>(random() % 2'000'000);
            if (const auto moment_us = paces.moment_of(wanted_us, us)) {
                ASSERT_GE(paces.sea_time(*moment_us), wanted_us);
                ASSERT_TRUE(*moment_us == us || paces.sea_time(*moment_us - 1) < wanted_us);
            } else {
                ASSERT_EQ(paces.all().back().permille, 0);
            }
        }
    }
}

} // namespace
} // namespace seaway::sea
