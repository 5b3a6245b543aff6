// SPDX-License-Identifier: Apache-2.0
// Skies for frames that do not wait.
#include <algorithm>
#include <span>

#include "client/view/sky/sky_feed.h"
#include "tests/client/view/sky/air_fixture.h"

namespace seaway::client {
namespace {

Sky shown(SkyFeed& feed, const Look& look, double hour, const Eye& eye = {}) {
    return feed.at(look, heavens_at_hour(hour), eye);
}
Sky exact(const Look& look, double hour, const Eye& eye = {}) {
    return *SkyMaker().make(look, heavens_at_hour(hour), eye);
}
bool same_values(const Sky& a, const Sky& b) {
    const shaders::SkyValues one = a.values(), two = b.values();
    return std::ranges::equal(std::as_bytes(std::span(&one, 1)), std::as_bytes(std::span(&two, 1)));
}

TEST(SkyFeed, frames_go_on_with_the_last_tables_while_new_ones_are_made) {
    SkyFeed feed;
    const Look look;
    const Sky noon = shown(feed, look, 12);
    EXPECT_EQ(feed.counts().frames_meanwhile, 0);
    EXPECT_TRUE(feed.settled());
    const Sky meanwhile = shown(feed, look, 17); // nobody has made its tables yet
    EXPECT_EQ(meanwhile.texels(), noon.texels());
    EXPECT_TRUE(same_values(meanwhile, noon)) << "sun and sky are of one moment";
    EXPECT_EQ(feed.counts().frames_meanwhile, 1);
    EXPECT_FALSE(feed.settled());
    feed.wait();
    const Sky evening = shown(feed, look, 17); // a sun so far away is not mixed
    EXPECT_EQ(*evening.texels(), *exact(look, 17, eye_on_steps(look, {})).texels());
    EXPECT_TRUE(feed.settled());
    EXPECT_EQ(feed.counts().made, 2);
}

TEST(SkyFeed, of_what_is_asked_for_meanwhile_the_last_alone_is_made) {
    SkyFeed feed;
    const Look look;
    shown(feed, look, 12);
    // While no table is finished one that was asked for may be begun and one waits, so that the others have been passed over.
    constexpr int enough = 200;
    int asked = 1, passed_over = 0, made = 1, since_made = 0;
    for (; passed_over < enough && asked < 100 * enough; ++asked) {
        shown(feed, look, 9 + 0.01 * (asked % 300));
        const int made_now = feed.counts().made;
        since_made = made_now == made ? since_made + 1 : 0;
        passed_over += since_made > 2;
        made = made_now;
    }
    ASSERT_EQ(passed_over, enough) << "tables take longer than asking";
    shown(feed, look, 16);
    feed.wait();
    const Sky last = shown(feed, look, 16); // a sun so far away is not mixed
    EXPECT_EQ(*last.texels(), *exact(look, 16, eye_on_steps(look, {})).texels());
    EXPECT_LE(feed.counts().made, asked + 1 - passed_over);
}

// An eye that climbs by a rung: tables go over within eight frames, each by an eighth.
TEST(SkyFeed, near_tables_are_mixed_over_a_few_frames) {
    SkyFeed feed;
    const Look look;
    const Sky before = shown(feed, look, 15, {.height_m = 3000});
    shown(feed, look, 15, {.height_m = 3300});
    feed.wait();
    const Sky after = exact(look, 15, eye_on_steps(look, {.height_m = 3300}));
    const std::size_t texels = before.texels()->size();
    for (int frame = 1; frame <= SkyFeed::mixed_frames; ++frame) {
        EXPECT_EQ(feed.settled(), false) << frame;
        const Sky mix = shown(feed, look, 15, {.height_m = 3300});
        const float share = static_cast<float>(frame) / SkyFeed::mixed_frames;
        for (std::size_t i = 0; i < texels; i += 1001) {
            const float a = (*before.texels())[i], b = (*after.texels())[i];
            ASSERT_NEAR((*mix.texels())[i], a + share * (b - a), 1e-6f + 1e-5f * std::abs(a));
        }
    }
    EXPECT_TRUE(feed.settled());
    EXPECT_EQ(*shown(feed, look, 15, {.height_m = 3300}).texels(), *after.texels());
}

TEST(SkyFeed, a_camera_that_moves_on_the_spot_asks_for_nothing) {
    SkyFeed feed;
    Look look;
    look.clouds.coverage = 0.4;
    const Sky first = shown(feed, look, 15, {.height_m = 12});
    for (int frame = 0; frame < 100; ++frame) {
        const Eye eye{.height_m = 12 + 0.03 * std::sin(frame), .east_m = 1.2 * frame};
        const Sky next = shown(feed, look, 15, eye);
        EXPECT_EQ(next.texels(), first.texels());
        // All but the tables is of this frame: clouds pass over the eye.
        EXPECT_TRUE(same_values(next, first.seen_from(look, eye)));
    }
    EXPECT_EQ(feed.counts().made, 1);
    EXPECT_EQ(feed.counts().frames_meanwhile, 0);
}

TEST(SkyFeed, a_sky_seen_from_elsewhere_is_the_sky_that_is_made_there) {
    SkyMaker maker;
    Look look;
    look.clouds.coverage = 0.6;
    const Eye one{.height_m = 50, .east_m = 990, .north_m = 20},
        other{.height_m = 50.4, .east_m = 1040, .north_m = -60, .cloud_drift_m = {15, -5}};
    ASSERT_EQ(eye_on_steps(look, one), eye_on_steps(look, other));
    const Sky there = *maker.make(look, heavens_at_hour(10), other);
    const Sky here = *maker.make(look, heavens_at_hour(10), one);
    EXPECT_TRUE(same_values(here.seen_from(look, other), there));
    EXPECT_FALSE(same_values(here, there));
    // Between steps clouds pass by the metre: 35 m of a period of 12 clouds.
    EXPECT_NEAR(there.values().cloud_origin.x - here.values().cloud_origin.x,
                35 / (12 * look.clouds.size_m), 1e-6);
    EXPECT_EQ(here.texels(), there.texels());
}

TEST(SkyFeed, ends_while_tables_are_being_made) {
    for (int i = 0; i < 3; ++i) {
        SkyFeed feed;
        const Look look;
        shown(feed, look, 12);
        shown(feed, look, 9);
    }
}

} // namespace
} // namespace seaway::client
