// SPDX-License-Identifier: Apache-2.0
// When a server of a fleet doubts its sea (server/following.h).
#include <gtest/gtest.h>

#include "server/following.h"

namespace seaway::server {
namespace {

Following certain() {
    Following following{};
    following.shared = true;
    following.journal.current = true;
    following.vertical_mps = 1;
    following.height_error_m = 0.01;
    return following;
}

TEST(Following, who_follows_and_knows_the_end_of_the_log_has_no_doubt) {
    EXPECT_EQ(certain().doubt(), "");
    Following alone = certain();
    alone.shared = false;
    alone.late = true;
    EXPECT_EQ(alone.doubt(), "") << "a log of one's own is never late";
}

TEST(Following, what_it_has_not_heard_or_not_played_makes_it_doubt) {
    Following late = certain();
    late.late = true;
    EXPECT_NE(late.doubt().find("changes are played"), std::string::npos) << late.doubt();
    Following behind = certain();
    behind.behind_us = behind_us_max;
    EXPECT_EQ(behind.doubt(), "");
    ++behind.behind_us;
    EXPECT_NE(behind.doubt().find("changes are played"), std::string::npos) << behind.doubt();
    Following unheard = certain();
    unheard.journal.current = false;
    EXPECT_NE(unheard.doubt().find("not been heard of"), std::string::npos) << unheard.doubt();
    Following stuck = certain();
    stuck.stuck = "change 3 cannot be read";
    EXPECT_EQ(stuck.doubt(), stuck.stuck);
}

TEST(Following, what_it_doubts_is_told_to_anybody_without_names_and_numbers) {
    for (const Doubt doubt : {Doubt::stuck, Doubt::unheard, Doubt::clock, Doubt::ahead,
                              Doubt::writing, Doubt::behind}) {
        const std::string told = in_general(doubt);
        EXPECT_FALSE(told.empty());
        EXPECT_EQ(told.find_first_of("0123456789()\"$"), std::string::npos) << told;
    }
    EXPECT_EQ(in_general(Doubt::none), "");
}

TEST(Following, names_the_world_or_the_file_and_not_where_it_lies) {
    Following following = certain();
    following.name = "nats://10.1.2.3:4222,10.1.2.4:4222/north-sea";
    EXPECT_NE(following.json().find("\"name\":\"north-sea\""), std::string::npos)
        << following.json();
    following.name = "/srv/secret place/journal.sqlite";
    EXPECT_NE(following.json().find("\"name\":\"journal.sqlite\""), std::string::npos)
        << following.json();
}

// Naive: a log of one server's own fills in silence.
TEST(Following, how_full_the_log_is_can_be_seen_of_any) {
    Following alone = certain();
    alone.shared = false;
    alone.counted = 154;
    EXPECT_NE(alone.metrics().find("seaway_journal_changes_counted 154\n"), std::string::npos)
        << alone.metrics();
    EXPECT_EQ(alone.metrics().find("seaway_peers"), std::string::npos) << "it has none";
    EXPECT_NE(alone.json().find("\"counted\":154,\"counted_max\":10000"), std::string::npos)
        << alone.json();
}

// Of what passes by itself a change may be asked for again; of the others another server.
TEST(Following, each_doubt_has_its_kind) {
    EXPECT_EQ(certain().kind_of_doubt(), Doubt::none);
    Following following = certain();
    following.late = true;
    EXPECT_EQ(following.kind_of_doubt(), Doubt::behind);
    following.ahead_us = ahead_us_max;
    EXPECT_EQ(following.kind_of_doubt(), Doubt::behind);
    ++following.ahead_us;
    EXPECT_EQ(following.kind_of_doubt(), Doubt::ahead);
    following.ahead_us = 0;
    following.journal.peers = {.peers = 2, .judges = 2, .ahead_us = 11'000, .error_us = 500};
    EXPECT_EQ(following.kind_of_doubt(), Doubt::clock) << "11 ms at 1 m/s, of 10 mm";
    following.journal.peers.judges = 1;
    EXPECT_EQ(following.kind_of_doubt(), Doubt::behind) << "of two nobody knows which is off";
    following.journal.current = false;
    EXPECT_EQ(following.kind_of_doubt(), Doubt::unheard);
    following.stuck = "change 3 cannot be read";
    EXPECT_EQ(following.kind_of_doubt(), Doubt::stuck);
}

// Others should have been told of it by then, also where nobody shares the log.
TEST(Following, a_change_that_is_long_under_way_to_the_journal_makes_it_doubt) {
    for (const bool shared : {false, true}) {
        Following following = certain();
        following.shared = shared;
        following.writing_us = writing_us_max;
        EXPECT_EQ(following.kind_of_doubt(), Doubt::none);
        following.writing_us = 3'200'000;
        EXPECT_EQ(following.kind_of_doubt(), Doubt::writing);
        EXPECT_EQ(following.doubt(), "a change has been under way to the journal for 3.2 s");
    }
}

} // namespace
} // namespace seaway::server
