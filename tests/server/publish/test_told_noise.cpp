// SPDX-License-Identifier: Apache-2.0
// What tiles tell of the rounding of heights that are predicted.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "client/local_surface.h"
#include "tests/server/publish/predicted_tiles.h"

namespace seaway::server {
namespace {

using sea::Field;

/// Mean square of heights that are off, `share` of the way from one keyframe to another.
double off_m2(const client::HeldKeyframe& a, int n_a, const client::HeldKeyframe& b, int n_b,
              double share) {
    const sea::Keyframe truth_a = running_keyframe(n_a), truth_b = running_keyframe(n_b);
    const sea::HermiteWeights w =
        sea::hermite_weights(0, predicted_interval_us, std::llround(share * predicted_interval_us));
    const auto off = [](const client::HeldKeyframe& held, const sea::Keyframe& truth, Field field,
                        std::size_t i) {
        return static_cast<double>(held.keyframe().plane(field)[i]) -
               static_cast<double>(truth.plane(field)[i]);
    };
    double m2 = 0;
    for (std::size_t i = 0; i < truth_a.plane_size(); ++i)
        m2 += std::pow(w.value[0] * off(a, truth_a, Field::height, i) +
                           w.value[1] * off(a, truth_a, Field::height_rate, i) +
                           w.value[2] * off(b, truth_b, Field::height, i) +
                           w.value[3] * off(b, truth_b, Field::height_rate, i),
                       2);
    return m2 / static_cast<double>(truth_a.plane_size());
}

// On its own grid, corners and all; on smaller ones: PredictedNoise.*. Naive: of even noise, error / sqrt(3).
TEST(ToldNoise, is_what_rounding_left_of_heights_and_between_them_and_the_keyframe_before) {
    Encoder encoder;
    client::TileAssembly follows, joins;
    client::HeldKeyframePtr before;
    for (int n = 0; n < 50; ++n) {
        const EncodedKeyframePtr made = encode(encoder, running_keyframe(n));
        const auto now = take(follows, messages_of(*made, n > 0));
        const auto whole = take(joins, messages_of(*made, false));
        ASSERT_TRUE(now && whole);
        EXPECT_EQ(whole->noise(), now->noise()) << "whichever form it came in";
        EXPECT_NEAR(now->noise().at_m / std::sqrt(off_m2(*now, n, *now, n, 1)), 1.0, 1e-4);
        EXPECT_LE(now->noise().at_m, static_cast<double>(bounds[0]));
        if (n == 0) {
            EXPECT_EQ(now->noise().between_m, 0.0) << "it follows none";
        } else {
            EXPECT_EQ(now->noise().before, before->noise().number);
            EXPECT_EQ(now->noise().before_us, before->keyframe().time_us);
            sea::CascadeLoss loss;
            client::add_codec(loss, {before, now});
            double most = 0;
            for (const double share : {0.25, 0.5, 0.75})
                most = std::max(most, off_m2(*before, n - 1, *now, n, share) /
                                          loss.height.at(share, {}).coded_m2);
            EXPECT_NEAR(most, 1.0, 1e-3) << "no less than there is, and as much somewhere";
        }
        before = now;
    }
}

// What the device rounded is off before it is coded: of both keyframes, or of the earlier one alone where the later did not fit.
TEST(ToldNoise, has_in_it_what_samples_of_either_keyframe_were_rounded_by_before) {
    const auto told = [](bool earlier, bool later) {
        Encoder encoder;
        client::TileAssembly assembly;
        client::HeldKeyframePtr last;
        for (int n = 0; n < 3; ++n) {
            sea::Keyframe keyframe = running_keyframe(n);
            if (n < 2 ? earlier : later)
                keyframe.rounded = {{Field::height, 1.8e-3f, 0.9e-3f, {}},
                                    {Field::height_rate, 7.2e-3f, 3.6e-3f, {}}};
            last = take(assembly, messages_of(*encode(encoder, keyframe), n > 0));
        }
        return last->noise();
    };
    // A tenth of the bound is left to code by. Half way both count a quarter, in the square; of one alone it is stated for both.
    const double rounded_m2 = 0.81e-6 / 3;
    EXPECT_GT(std::pow(told(true, true).at_m, 2), rounded_m2);
    EXPECT_GT(std::pow(told(true, true).between_m, 2), rounded_m2 / 2);
    EXPECT_GT(std::pow(told(true, false).between_m, 2), rounded_m2 / 2);
}

} // namespace
} // namespace seaway::server
