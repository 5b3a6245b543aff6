// SPDX-License-Identifier: Apache-2.0
// The grids that compact maps are sent on, and what they may cost.
#include <cmath>
#include <complex>

#include <gtest/gtest.h>

#include "sea/basics/cascade.h"
#include "sea/scene/scene.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/surface/maps/regrid.h"
#include "sea/waves/realize.h"
#include "tests/sea/scene_of.h"

namespace seaway::sea {
namespace {

struct Planned {
    Realization sea;
    ErrorBudget budget;
};

Planned planned(const Scene& scene, double height_error_m) {
    Planned made{*realize(scene), {}};
    made.budget = plan_budget(made.sea, height_error_m);
    return made;
}

Planned of_file(const std::string& name, double height_error_m) {
    const auto scene = read_scene(std::string(SEAWAY_SOURCE_DIR) + "/scenes/" + name + ".toml");
    EXPECT_TRUE(scene) << name;
    return planned(*scene, height_error_m);
}

TEST(CompactBudget, the_grid_of_every_cascade_carries_its_finest_wave_and_is_far_below_its_own) {
    for (const char* name : {"north_sea_gale", "calm", "hurricane", "trade_wind_swell"}) {
        const Planned made = of_file(name, 0.01);
        for (std::size_t c = 0; c < made.sea.cascades.size(); ++c) {
            const CascadeModes& modes = made.sea.cascades[c];
            const CascadeBudget& own = made.budget.cascades[c];
            const int size = modes.spec.size;
            double reach = 0;
            for (int i = 0; i < size * size; ++i)
                if (modes.h0[static_cast<std::size_t>(i)] != std::complex<double>{})
                    reach = std::max(reach, std::hypot(signed_index(i % size, size),
                                                       signed_index(i / size, size)));
            EXPECT_GT(own.compact_size, 2.0 * reach) << name << " " << c;
            EXPECT_LE(own.compact_size, 2.0 * reach + 12) << name << " " << c;
            EXPECT_LE(own.compact_size, 0.7 * size) << name << " " << c;
            EXPECT_NEAR(own.compact_share, 0.785, 0.01) << name << " " << c;
        }
        EXPECT_TRUE(made.budget.displacement_follows) << name;
    }
}

// Noise in waves beyond the disc is lost on the way to the client's own grid: so much coarser may be coded.
TEST(CompactBudget, bounds_of_compact_values_are_wider_by_what_is_lost_of_their_noise) {
    const Planned made = of_file("north_sea_gale", 0.01);
    const FieldSet fields = surface_fields | FieldSet{Field::slope_x, Field::foam};
    for (int c = 0; c < 3; ++c) {
        const auto whole = codec_bounds(made.budget, fields, c, made.budget.codec_error_m);
        const auto compact = codec_bounds(made.budget, fields, c, made.budget.codec_error_m, true);
        const double share =
            disc_share(made.budget.cascades[static_cast<std::size_t>(c)].compact_size);
        for (std::size_t i = 0; i < whole.size(); ++i)
            EXPECT_NEAR(static_cast<double>(compact[i] / whole[i]),
                        i < 6 ? 1.0 / std::sqrt(share) : 1.0, 1e-5);
    }
    EXPECT_DOUBLE_EQ(compact_error_m(made.budget), 2.0 * made.budget.single_precision_m);
}

// The way there and back costs single precision again, which is nothing beside a centimetre; beside a hundredth of a
// millimetre it is.
TEST(CompactBudget, whoever_asks_for_what_single_precision_costs_is_sent_whole_maps) {
    const Planned made = of_file("north_sea_gale", 2e-4);
    for (const CascadeBudget& own : made.budget.cascades) {
        EXPECT_EQ(own.compact_size, own.size);
        EXPECT_EQ(own.compact_share, 1.0);
    }
    EXPECT_FALSE(made.budget.displacement_follows);
}

TEST(CompactBudget, displacements_are_sent_where_they_do_not_follow_or_would_be_noisier) {
    EXPECT_FALSE(of_file("gerstner_toy", 0.02).budget.displacement_follows)
        << "sines move nothing sideways";
    const std::string depths[] = {"200.0", "0.5"};
    for (const std::string& depth_m : depths) {
        const Scene scene = testing::scene_of("[sea]\ndepth_m = " + depth_m + R"(
[[sea.system]]
type = "swell"
significant_height_m = 0.05
peak_period_s = 6.0
from_deg = 0
[[cascade]]
length_m = 800.0
size = 128
[accuracy]
height_error_m = 0.01
)");
        EXPECT_EQ(planned(scene, 0.01).budget.displacement_follows, depth_m == "200.0") << depth_m;
    }
}

} // namespace
} // namespace seaway::sea
