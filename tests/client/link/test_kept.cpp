// SPDX-License-Identifier: Apache-2.0
// What is wanted of a server, whatever the order of its replies.
#include "client/link/kept.h"

#include <array>

#include <gtest/gtest.h>

namespace seaway::client {
namespace {

const Error refused = failed(Failure::refused, "no");

TEST(Kept, is_the_last_wish_and_where_that_is_refused_the_last_that_was_granted) {
    Kept<int> kept;
    EXPECT_FALSE(kept.wanted());
    const auto first = kept.ask(1);
    EXPECT_EQ(kept.wanted(), 1) << "before it is granted, for a connection that ends meanwhile";
    kept.granted(first, 1);
    kept.failed(kept.ask(2), 2, refused);
    EXPECT_EQ(kept.wanted(), 1);
    kept.failed(kept.ask(3), 3, failed(Failure::lost, "gone"));
    EXPECT_EQ(kept.wanted(), 1);
}

// Naive: each remembers what was wanted before it, and who fails last puts back what was never granted.
TEST(Kept, of_two_that_are_both_refused_neither_stays) {
    for (const bool older_first : {false, true}) {
        Kept<int> kept;
        kept.granted(kept.ask(1), 1);
        const auto two = kept.ask(2), three = kept.ask(3);
        for (const int one : older_first ? std::array{2, 3} : std::array{3, 2})
            kept.failed(one == 2 ? two : three, one, refused);
        EXPECT_EQ(kept.wanted(), 1) << older_first;
    }
}

TEST(Kept, who_comes_after_one_that_is_refused_is_wanted_whichever_reply_is_first) {
    for (const bool refusal_first : {false, true}) {
        Kept<int> kept;
        kept.granted(kept.ask(1), 1);
        const auto two = kept.ask(2), three = kept.ask(3);
        if (refusal_first)
            kept.failed(three, 3, refused);
        kept.granted(two, 2);
        EXPECT_EQ(kept.wanted(), refusal_first ? 2 : 3) << "the last one, while it is not refused";
        if (!refusal_first)
            kept.failed(three, 3, refused);
        EXPECT_EQ(kept.wanted(), 2) << refusal_first;
    }
}

TEST(Kept, knows_who_has_come_since_and_whether_there_was_an_end) {
    Kept<int> kept;
    const auto one = kept.ask(1);
    EXPECT_FALSE(kept.is_past(one) || kept.is_over(one));
    const auto two = kept.ask(2);
    EXPECT_TRUE(kept.is_past(one) && !kept.is_past(two));
    kept.end();
    EXPECT_TRUE(kept.is_past(two) && kept.is_over(one) && kept.is_over(two));
    const auto three = kept.ask(3);
    EXPECT_FALSE(kept.is_past(three) || kept.is_over(three));
}

// Naive: no reply is a refusal. The server may have granted it, and streams.
TEST(Kept, what_was_not_answered_in_time_stays_wanted) {
    Kept<int> kept;
    kept.granted(kept.ask(1), 1);
    const auto two = kept.ask(2);
    kept.failed(two, 2, failed(Failure::deadline, "late"));
    EXPECT_EQ(kept.wanted(), 2);
    kept.failed(kept.ask(3), 3, refused);
    EXPECT_EQ(kept.wanted(), 2) << "which the server may stream";
    // It is asked for again on the way back.
    EXPECT_EQ(kept.wanted_one().serial, two);
    kept.failed(two, 2, refused);
    EXPECT_EQ(kept.wanted(), 1);
}

// Naive: one place for what was not answered in time, and the older one, that the server streams, is forgotten.
TEST(Kept, of_two_that_were_not_answered_in_time_the_older_stays_where_the_other_is_refused) {
    Kept<int> kept;
    kept.granted(kept.ask(1), 1);
    const auto two = kept.ask(2), three = kept.ask(3);
    const Error late = failed(Failure::deadline, "late");
    kept.failed(two, 2, late);
    kept.failed(three, 3, late);
    EXPECT_EQ(kept.wanted(), 3);
    kept.failed(kept.ask(4), 4, refused);
    EXPECT_EQ(kept.wanted(), 3) << "the last of them";
    kept.failed(three, 3, refused);
    EXPECT_EQ(kept.wanted(), 2);
    kept.granted(two, 2);
    kept.failed(kept.ask(5), 5, refused);
    EXPECT_EQ(kept.wanted(), 2);
    EXPECT_EQ(kept.wanted_one().serial, two);
}

TEST(Kept, what_was_granted_is_wanted_though_it_is_refused_on_the_way_back) {
    Kept<int> kept;
    const auto one = kept.ask(1);
    kept.failed(one, 1, failed(Failure::deadline, "late"));
    kept.granted(one, 1);
    kept.failed(one, 1, refused);
    EXPECT_EQ(kept.wanted(), 1);
}

TEST(Kept, after_an_end_nothing_is_wanted_that_was_asked_for_before) {
    Kept<int> kept;
    const auto one = kept.ask(1);
    kept.end();
    kept.granted(one, 1);
    EXPECT_FALSE(kept.wanted());
    kept.failed(kept.ask(2), 2, refused);
    EXPECT_FALSE(kept.wanted());
}

} // namespace
} // namespace seaway::client
