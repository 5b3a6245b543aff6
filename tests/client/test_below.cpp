// SPDX-License-Identifier: Apache-2.0
// Water below the surface by the C interface: of the server, of waves, of some of them.
#include <cmath>
#include <limits>

#include "tests/client/engine.h"

namespace seaway::tests {
namespace {

class BelowEngine : public Engine {
  protected:
    struct Call {
        seaway_code code;
        std::vector<seaway_below> below;
    };
    static Call sample(const Sea& client, const std::vector<seaway_point>& points,
                       const std::vector<double>& z_m, const seaway_looking* looking = nullptr) {
        Call call{SEAWAY_OK, std::vector<seaway_below>(points.size())};
        call.code = seaway_sample_below(client.handle(), looking, points.data(), z_m.data(),
                                        points.size(), call.below.data(), sizeof(seaway_below));
        return call;
    }
    static Call query(const Sea& client, const std::vector<seaway_point>& points,
                      const std::vector<double>& z_m, const seaway_looking* looking = nullptr) {
        Call call{SEAWAY_OK, std::vector<seaway_below>(points.size())};
        call.code = seaway_query_below(client.handle(), looking, points.data(), z_m.data(),
                                       points.size(), 0, call.below.data(), sizeof(seaway_below));
        return call;
    }
    static std::vector<double> depths(std::size_t count) {
        std::vector<double> made;
        for (std::size_t i = 0; i < count; ++i)
            made.push_back(-0.2 * static_cast<double>(i));
        return made;
    }
};

// 600 points: more than three batches of exact ones. On the wire velocities and pressures are floats.
TEST_F(BelowEngine, the_server_answers_any_number_of_depths_in_order) {
    Sea client(net->url());
    const std::vector<seaway_point> points = places(600);
    const std::vector<double> z_m = depths(points.size());
    const Call call = query(client, points, z_m);
    ASSERT_EQ(call.code, SEAWAY_OK) << seaway_last_error();
    for (std::size_t i = 0; i < points.size(); ++i) {
        sea::WaterBelow water;
        const sea::Answer truth = sea.truth({points[i].x_m, points[i].y_m, points[i].time_us},
                                            sea::all_cascades, z_m[i], water);
        EXPECT_EQ(call.below[i].surface.height_m, truth.height_m);
        EXPECT_EQ(call.below[i].surface.flags, truth.flags | SEAWAY_EXACT);
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(call.below[i].velocity_mps[axis], water.velocity_mps[axis], 1e-6);
        EXPECT_NEAR(call.below[i].pressure_m2ps2, water.pressure_m2ps2, 1e-5);
    }
    EXPECT_EQ(call.below[0].surface.flags & SEAWAY_DRY,
              call.below[0].surface.height_m < 0 ? unsigned{SEAWAY_DRY} : 0u);
}

TEST_F(BelowEngine, a_server_that_knows_nothing_of_depths_is_not_believed) {
    sea.knows_below = false;
    Sea client(net->url());
    EXPECT_EQ(query(client, places(3), depths(3)).code, SEAWAY_NOT_UNDERSTOOD);
    EXPECT_NE(std::string(seaway_last_error()).find("knows nothing of the water below"),
              std::string::npos)
        << seaway_last_error();
}

// Naive: it skips what it does not know, and its answers of all waves are taken for those of some.
TEST_F(BelowEngine, a_server_that_knows_of_no_choice_of_waves_is_not_believed) {
    sea.knows_choice = false;
    Sea client(net->url());
    const std::vector<seaway_point> points = places(3);
    seaway_looking long_ones = SEAWAY_SIZED(seaway_looking), all = long_ones;
    long_ones.min_wavelength_m = 25;
    std::vector<seaway_answer> answers(points.size(), seaway_answer{.height_m = 77});
    const auto ask = [&](const seaway_looking* looking) {
        return seaway_query_some(client.handle(), looking, points.data(), points.size(), 0, 0,
                                 answers.data());
    };
    EXPECT_EQ(ask(&long_ones), SEAWAY_NOT_UNDERSTOOD);
    EXPECT_NE(std::string(seaway_last_error()).find("has answered for all waves"),
              std::string::npos)
        << seaway_last_error();
    EXPECT_EQ(answers[0].height_m, 77) << "nothing wrong is handed out";
    EXPECT_EQ(query(client, points, depths(3), &long_ones).code, SEAWAY_NOT_UNDERSTOOD);
    EXPECT_EQ(ask(&all), SEAWAY_OK) << "all waves are what it answers for";
    EXPECT_EQ(ask(nullptr), SEAWAY_OK);
    sea.knows_choice = true;
    EXPECT_EQ(ask(&long_ones), SEAWAY_OK);
}

// The waves that came are off by 1 mm; these have periods above 1 s.
TEST_F(BelowEngine, waves_answer_here_and_maps_say_that_they_cannot) {
    Sea client(net->url());
    const std::vector<seaway_point> points = places(40);
    const std::vector<double> z_m = depths(points.size());
    hold_sea(client, true);
    EXPECT_EQ(sample(client, points, z_m).code, SEAWAY_NOT_HELD);
    EXPECT_NE(std::string(seaway_last_error()).find("subscribe to the spectrum"),
              std::string::npos);
    hold_sea(client, false);
    const Call call = sample(client, points, z_m);
    ASSERT_EQ(call.code, SEAWAY_OK) << seaway_last_error();
    const Call served = query(client, points, z_m);
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (std::abs(served.below[i].surface.height_m - z_m[i]) < 0.01)
            continue; // wet by one, dry by the other
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(call.below[i].velocity_mps[axis], served.below[i].velocity_mps[axis], 0.02);
        EXPECT_NEAR(call.below[i].pressure_m2ps2, served.below[i].pressure_m2ps2, 0.05);
    }
}

// Naive: what is answered here is refused by the server, and one such depth loses the answers to all.
TEST_F(BelowEngine, depths_beyond_the_range_are_refused_alike_here_and_by_the_server) {
    Sea client(net->url());
    hold_sea(client, false);
    const std::vector<seaway_point> points = places(3);
    for (const bool served : {false, true}) {
        const auto answer = [&](double z_m) {
            const std::vector<double> depths_m{-1.0, z_m, -2.0};
            return served ? query(client, points, depths_m) : sample(client, points, depths_m);
        };
        EXPECT_EQ(answer(-1e9).code, SEAWAY_OK) << seaway_last_error();
        const Call highest = answer(1e9);
        ASSERT_EQ(highest.code, SEAWAY_OK) << seaway_last_error();
        EXPECT_TRUE(highest.below[1].surface.flags & SEAWAY_DRY);
        for (const double z_m : {-1.001e9, 1.001e9, -1e300}) {
            EXPECT_EQ(answer(z_m).code, SEAWAY_BAD_ARGUMENT) << z_m;
            EXPECT_NE(std::string(seaway_last_error()).find("z_m[1] is"), std::string::npos);
        }
    }
}

TEST_F(BelowEngine, short_waves_are_left_out_of_answers_below_and_of_the_servers_above) {
    Sea client(net->url());
    hold_sea(client, false);
    const std::vector<seaway_point> points = places(20);
    const std::vector<double> z_m(points.size(), -1.0);
    seaway_looking first = SEAWAY_SIZED(seaway_looking), second = first;
    first.cascades = 1;
    second.cascades = 2;
    const Call all = query(client, points, z_m);
    const Call one = query(client, points, z_m, &first),
               other = query(client, points, z_m, &second);
    const Call here = sample(client, points, z_m, &first);
    std::vector<seaway_answer> some(points.size());
    ASSERT_EQ(
        seaway_query_some(client.handle(), &first, points.data(), points.size(), 0, 0, some.data()),
        SEAWAY_OK);
    double apart = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_NEAR(here.below[i].pressure_m2ps2, one.below[i].pressure_m2ps2, 0.05);
        EXPECT_EQ(some[i].height_m, one.below[i].surface.height_m);
        apart += std::abs(all.below[i].pressure_m2ps2 - one.below[i].pressure_m2ps2);
    }
    EXPECT_GT(apart, 0.01) << "nothing was left out";
    EXPECT_EQ(other.code, SEAWAY_OK);
}

TEST_F(BelowEngine, what_cannot_be_asked_is_refused_by_name) {
    Sea client(net->url());
    hold_sea(client, false);
    const seaway_point point{0, 0, asked_us};
    const double z_m = -1;
    seaway_below below{};
    const auto with = [&](const seaway_looking* looking, const double* depth, std::size_t stride,
                          double timeout_s = 0) {
        return refusal(seaway_query_below(client.handle(), looking, &point, depth, 1, timeout_s,
                                          &below, stride));
    };
    EXPECT_NE(with(nullptr, nullptr, sizeof(below)).find("z_m"), std::string::npos);
    EXPECT_NE(with(nullptr, &z_m, 8).find("stride is 8"), std::string::npos);
    EXPECT_NE(with(nullptr, &z_m, sizeof(below), -1).find("timeout_s"), std::string::npos);
    seaway_looking looking = SEAWAY_SIZED(seaway_looking);
    looking.min_wavelength_m = std::numeric_limits<double>::infinity();
    EXPECT_NE(with(&looking, &z_m, sizeof(below)).find("min_wavelength_m is inf"),
              std::string::npos);
    const seaway_point late{0, 0, std::numeric_limits<int64_t>::max()};
    EXPECT_EQ(seaway_sample_below(client.handle(), nullptr, &late, &z_m, 1, &below, sizeof(below)),
              SEAWAY_BAD_ARGUMENT);
    for (const double nowhere : {std::nan(""), std::numeric_limits<double>::infinity()}) {
        EXPECT_EQ(query(client, {point}, {nowhere}).below[0].surface.flags & SEAWAY_INVALID,
                  unsigned{SEAWAY_INVALID});
        EXPECT_TRUE(std::isnan(sample(client, {point}, {nowhere}).below[0].pressure_m2ps2));
    }
    EXPECT_EQ(query(client, {}, {}).code, SEAWAY_OK) << "nothing is nothing";
}

} // namespace
} // namespace seaway::tests
