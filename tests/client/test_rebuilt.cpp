// SPDX-License-Identifier: Apache-2.0
// A sea that the client makes of what the server announced is the server's, or is refused.
#include <random>

#include <gtest/gtest.h>

#include "client/link/failure.h"
#include "client/rebuilt/rebuilt_sea.h"
#include "sea/scene/scene.h"
#include "tests/client/announced_scene.h"

namespace seaway::client {
namespace {

using protocol::SeaStateValues;
using tests::announced;

std::string refusal_of(const SeaStateValues& state) {
    const Result<RebuiltSeaPtr> made = rebuild_from_scene(state);
    if (made)
        return "";
    EXPECT_EQ(failure_of(made.error()), Failure::not_held);
    return made.error().message;
}

TEST(Rebuilt, from_the_scene_is_the_exact_sum_of_the_sea_at_any_time) {
    const SeaStateValues state = announced();
    const Result<RebuiltSeaPtr> made = rebuild_from_scene(state);
    ASSERT_TRUE(made) << made.error().message;
    const auto waves = tests::announced_waves();
    const sea::DirectSum truth(waves);
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> place(-1e6, 1e6);
    std::uniform_int_distribution<sea::TimeUs> time(-1'000'000'000'000, 1'000'000'000'000'000);
    for (int i = 0; i < 100; ++i) {
        const sea::QueryPoint point{place(random), place(random), time(random)};
        sea::Answer answer;
        (*made)->answer({&point, 1}, {&answer, 1});
        const sea::Answer exact = sea::surface_at(
            point, {waves->choppiness, 1e-9, sea::FoldSearch{}}, truth.at_time(point.time_us));
        EXPECT_LE(std::abs(answer.height_m - exact.height_m), answer.error_m);
        EXPECT_LE(answer.error_m, 1e-5) << "what probes allow, and slopes";
    }
}

TEST(Rebuilt, a_sea_of_another_seed_or_tile_is_refused_by_name) {
    SeaStateValues state = announced();
    const auto at = state.scene.find("seed = 7");
    ASSERT_NE(at, std::string::npos) << state.scene;
    state.scene.replace(at, 8, "seed = 8");
    EXPECT_NE(refusal_of(state).find("probes differ by"), std::string::npos) << refusal_of(state);
    state = announced();
    state.cascades[1].length_m += 1;
    EXPECT_NE(refusal_of(state).find("other tiles"), std::string::npos);
}

TEST(Rebuilt, without_scene_or_probes_nothing_is_believed) {
    SeaStateValues state = announced();
    state.probes.clear();
    EXPECT_NE(refusal_of(state).find("no probes"), std::string::npos);
    state = announced();
    state.scene.clear();
    EXPECT_NE(refusal_of(state).find("no scene"), std::string::npos);
    state.scene = "[sea";
    EXPECT_NE(refusal_of(state).find("the server's scene"), std::string::npos);
}

// A server may be anybody's: its scene opens no file of whoever reads it.
TEST(Rebuilt, a_scene_from_a_server_names_no_files) {
    SeaStateValues state = announced();
    state.scene = "[sea]\nseed = 1\n[[sea.system]]\ntype = \"measured\"\nfile = \"/etc/hostname\"\n"
                  "[[cascade]]\nlength_m = 100\nsize = 64\n";
    EXPECT_NE(refusal_of(state).find("may name no file"), std::string::npos) << refusal_of(state);
}

} // namespace
} // namespace seaway::client
