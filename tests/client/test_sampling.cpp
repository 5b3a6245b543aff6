// SPDX-License-Identifier: Apache-2.0
// What sampling promises to who calls it in every frame: no allocation, and surfaces that are kept are those of the keyframes held.
#include <memory>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "client/held_surfaces.h"
#include "tests/client/engine.h"
#include "tests/support/allocations.h"

namespace seaway {
namespace {

using client::HeldSurfaces;

class Sampling : public tests::Engine {
  protected:
    static std::vector<seaway_point> points_at(int count, sea::TimeUs time_us) {
        std::vector<seaway_point> points = places(count);
        for (seaway_point& point : points)
            point.time_us = time_us;
        return points;
    }
};

// The first calls may: they make the splines of what was held before anybody sampled, and what batches need.
TEST_F(Sampling, allocates_nothing_also_when_keyframes_went_on) {
    const Sea client("ws://127.0.0.1:" + std::to_string(net->port()));
    constexpr int batches[] = {1, 64, 1024};
    for (int round = 0; round < 4; ++round) {
        const sea::TimeUs from_us = asked_us + round * 5'000'000;
        ASSERT_EQ(seaway_hold(client.handle(), &from_us, 1, 30), SEAWAY_OK) << seaway_last_error();
        for (const int count : batches)
            for (int call = 0; call < 20; ++call) {
                // Within one interval of both cascades, so that what was held is enough.
                const auto points = points_at(count, from_us + call * 100);
                std::vector<seaway_answer> answers(points.size());
                const tests::Allocations asked;
                const seaway_code code =
                    seaway_sample(client.handle(), points.data(), points.size(), answers.data());
                const std::size_t times = asked.count();
                ASSERT_EQ(code, SEAWAY_OK) << seaway_last_error();
                if (round > 0) {
                    EXPECT_EQ(times, 0u) << "round " << round << ", " << count << " points";
                }
                EXPECT_EQ(answers[0].flags, 0u);
            }
    }
}

class Surfaces : public ::testing::Test {
  protected:
    static constexpr sea::TimeUs interval_us = 250'000;
    client::SeaStatePtr state = [] {
        client::SeaState one;
        one.epoch = 1;
        one.cascades = {{.length_m = 100, .size = 32, .interval_us = interval_us}};
        one.choppiness_x = one.choppiness_y = 1;
        one.height_error_m = 0.01;
        one.displacement_reach_m = 1;
        return std::make_shared<const client::SeaState>(one);
    }();
    client::KeyframeRing ring{{.look_back_us = 0}};
    HeldSurfaces surfaces;

    /// Flat water, so high.
    static client::HeldKeyframePtr level(std::int64_t n, float height_m) {
        sea::Keyframe map{1, 0, n * interval_us, 32, 100, sea::surface_fields, {}};
        map.values.resize(map.plane_size() * static_cast<std::size_t>(map.fields.size()));
        for (float& value : map.plane(sea::Field::height))
            value = height_m;
        return std::make_shared<const client::HeldKeyframe>(std::move(map),
                                                            client::HeldKeyframe::FieldErrors{});
    }
    double height_m(sea::TimeUs time_us) {
        HeldSurfaces::Lent lent;
        const Result<void> found = surfaces.lend(state, ring, time_us, sea::surface_fields, lent);
        EXPECT_TRUE(found) << found.error().message;
        return found ? lent->surface.answer({1, 2, time_us}).height_m : 0;
    }
};

TEST_F(Surfaces, that_are_kept_are_of_the_keyframes_that_are_held) {
    ring.insert(level(0, 1));
    EXPECT_NEAR(height_m(interval_us / 2), 1, 1e-6); // single precision
    ring.insert(level(1, 3));
    EXPECT_NEAR(height_m(interval_us / 2), 2, 1e-6) << "the one after has come";
    ring.insert(level(1, 5));
    EXPECT_NEAR(height_m(interval_us / 2), 3, 1e-6) << "another took its place";
    ring.insert(level(7, 9));
    EXPECT_NEAR(height_m(interval_us / 2), 3, 1e-6) << "one of another time came";
    ring.clear();
    HeldSurfaces::Lent lent;
    EXPECT_FALSE(surfaces.lend(state, ring, interval_us / 2, sea::surface_fields, lent));
}

TEST_F(Surfaces, keep_no_keyframe_that_the_ring_has_let_go) {
    ring.insert(level(0, 1));
    ring.insert(level(1, 1));
    const std::weak_ptr<const sea::SplineMap> spline =
        ring.around(0, 1, 0, interval_us, sea::surface_fields)->before->spline();
    height_m(interval_us / 2);
    ring.clear();
    EXPECT_FALSE(spline.expired()) << "nothing is kept: the test sees nothing";
    surfaces.follow(ring);
    EXPECT_TRUE(spline.expired());
}

TEST_F(Surfaces, that_are_lent_stay_whoever_asks_for_others) {
    for (int n = 0; n < 12; ++n)
        ring.insert(level(n, static_cast<float>(n)));
    std::vector<std::unique_ptr<HeldSurfaces::Lent>> lent;
    for (int n = 0; n < 10; ++n) { // more than there are places
        lent.push_back(std::make_unique<HeldSurfaces::Lent>());
        ASSERT_TRUE(surfaces.lend(state, ring, n * interval_us, sea::surface_fields, *lent.back()));
    }
    surfaces.follow(client::KeyframeRing{});
    for (int n = 0; n < 10; ++n)
        EXPECT_NEAR(
            (*lent[static_cast<std::size_t>(n)])->surface.answer({1, 2, n * interval_us}).height_m,
            n, 1e-5); // single precision of 10 m
}

} // namespace
} // namespace seaway
