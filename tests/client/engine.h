// SPDX-License-Identifier: Apache-2.0
// A program that uses seaway_engine.h, on the real net server and a sea whose truth is known.
#pragma once

#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "client/seaway.hpp"
#include "client/seaway_engine.h"
#include "tests/client/wave_server.h"

namespace seaway::tests {

class Engine : public WaveServer {
  protected:
    static constexpr sea::TimeUs asked_us = 1'060'030'000;

    /// The waves of one cascade, summed in double precision.
    static sea::DirectSum only(std::size_t cascade) {
        auto one = std::make_shared<sea::Realization>(*few_waves());
        one->cascades = {one->cascades[cascade]};
        return sea::DirectSum(one);
    }

    /// Of cascade 1: displacements, height, nothing.
    static seaway_map_wish map_wish() {
        seaway_map_wish wish = SEAWAY_SIZED(seaway_map_wish);
        wish.cascade = 1;
        wish.time_us = asked_us;
        wish.channels = 4;
        wish.field[0] = SEAWAY_DISPLACEMENT_X;
        wish.field[1] = SEAWAY_NO_FIELD;
        wish.field[2] = SEAWAY_HEIGHT;
        wish.field[3] = SEAWAY_JACOBIAN;
        return wish;
    }

    static std::vector<seaway_point> places(int count) {
        std::mt19937_64 random(11);
        std::uniform_real_distribution<double> place(-1e4, 1e4);
        std::vector<seaway_point> made;
        for (int i = 0; i < count; ++i)
            made.push_back({place(random), place(random), asked_us + i % 3 * 10'000});
        return made;
    }

    /// The sea around `asked_us` as tiles, or its spectrum.
    static void hold_sea(Sea& client, bool tiles) {
        if (tiles)
            return client.hold({asked_us, asked_us + 10'000, asked_us + 20'000});
        seaway_subscription spectrum{};
        spectrum.rung = SEAWAY_SPECTRUM;
        client.subscribe(spectrum);
    }

    static std::vector<seaway_water> water_at(const Sea& client, const seaway_looking* looking,
                                              const std::vector<seaway_point>& points) {
        std::vector<seaway_water> water(points.size());
        EXPECT_EQ(seaway_sample_water(client.handle(), looking, points.data(), points.size(),
                                      water.data(), sizeof(seaway_water)),
                  SEAWAY_OK)
            << seaway_last_error();
        return water;
    }

    static std::string refusal(seaway_code code, seaway_code expected = SEAWAY_BAD_ARGUMENT) {
        EXPECT_EQ(code, expected) << seaway_last_error();
        return seaway_last_error();
    }
};

} // namespace seaway::tests
