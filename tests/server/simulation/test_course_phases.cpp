// SPDX-License-Identifier: Apache-2.0
// Phases of seas whose waves run otherwise than at the beginning: found again, kept within a bound.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sea/scene/weather.h"
#include "sea/waves/reference.h"
#include "server/simulation/sea_course.h"
#include "tests/server/simulation/simulation_bench.h"

namespace seaway::server {
namespace {

sea::Scene of_depth(double depth_m, const std::string& more = {}) {
    sea::Scene scene = small_scene(more);
    scene.sea.depth_m = depth_m;
    return scene;
}

struct Row {
    sea::Scene scene;
    TimeUs start_us;
    TimeUs end_us;
};

/// A change of depth every 40 s; every third begins while the one before is under way.
std::vector<Row> depths(int count, const std::string& more = {}) {
    std::vector<Row> rows;
    for (int i = 0; i < count; ++i)
        rows.push_back({of_depth(12.0 + 7.0 * (i % 4), more), (100 + 40 * i) * second_us,
                        (100 + 40 * i + (i % 3 == 1 ? 55 : 20)) * second_us});
    return rows;
}

std::shared_ptr<SeaCourse> course_of(const sea::Scene& first, const std::vector<Row>& rows) {
    auto course = *SeaCourse::begin(first);
    for (const Row& row : rows)
        EXPECT_TRUE(course->add(row.scene, row.start_us, row.end_us));
    return course;
}

/// All changes one after the other, each from the whole sea before it.
sea::RealizationPtr walked(const sea::Scene& first, const std::vector<Row>& rows) {
    const auto realized = [](const sea::Scene& scene) {
        return std::make_shared<const sea::Realization>(*sea::realize(scene));
    };
    sea::RealizationPtr sea = realized(first);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const auto change = *sea::SeaTransition::create(sea, realized(rows[i].scene),
                                                        rows[i].start_us, rows[i].end_us);
        const bool taken_over = i + 1 < rows.size() && rows[i + 1].start_us < rows[i].end_us;
        sea = taken_over ? change.gliding(rows[i + 1].start_us) : change.after();
    }
    return sea;
}

void expect_same_waves(const sea::Realization& a, const sea::Realization& b) {
    ASSERT_EQ(a.cascades.size(), b.cascades.size());
    for (std::size_t c = 0; c < a.cascades.size(); ++c) {
        EXPECT_EQ(a.cascades[c].h0, b.cascades[c].h0);
        EXPECT_EQ(a.cascades[c].rate, b.cascades[c].rate);
        EXPECT_EQ(a.cascades[c].phase_offset_turns, b.cascades[c].phase_offset_turns);
        ASSERT_EQ(a.cascades[c].sines.size(), b.cascades[c].sines.size());
        for (std::size_t f = 0; f < a.cascades[c].sines.size(); ++f)
            for (std::size_t w = 0; w < a.cascades[c].sines[f].waves.size(); ++w)
                EXPECT_EQ(a.cascades[c].sines[f].waves[w].phase_offset_turns,
                          b.cascades[c].sines[f].waves[w].phase_offset_turns);
    }
}

// Found from clocks without amplitudes, from the nearest that are kept; the walk has whole seas.
TEST(CoursePhases, a_sea_late_in_the_log_is_that_of_all_its_changes_one_after_the_other) {
    const std::vector<Row> rows = depths(20);
    const auto course = course_of(of_depth(30.0), rows);
    for (const std::size_t upto : {20u, 1u, 11u, 19u, 6u, 14u}) {
        const std::vector<Row> some(rows.begin(), rows.begin() + static_cast<long>(upto));
        const auto epoch = static_cast<std::uint32_t>(2 * upto + 1);
        expect_same_waves(*course->sea(epoch)->realization, *walked(of_depth(30.0), some));
    }
}

TEST(CoursePhases, stylised_waves_keep_their_clocks_through_a_log) {
    const std::string sines = R"(
[[sea.system]]
type = "sines"
shape = "exponential"
length_m = 43.0
count = 4
amplitude_m = 0.1
wavelength_m = 14.0
from_deg = 230
)";
    const std::vector<Row> rows = depths(5, sines);
    const auto course = course_of(of_depth(30.0, sines), rows);
    expect_same_waves(*course->sea(11)->realization, *walked(of_depth(30.0, sines), rows));
}

// Naive: clocks know what grows alone, the glide what fades, too, and the wave in the second place jumps at its end.
TEST(CoursePhases,
     what_takes_over_from_a_glide_of_stylised_waves_ends_in_the_sea_that_it_leads_to) {
    const auto waves = [](double wavelength_m) {
        return fmt::format(
            "[[sea.system]]\ntype = \"sines\"\nshape = \"exponential\"\nlength_m = 43.0\n"
            "count = 1\namplitude_m = 0.1\nwavelength_m = {}\nfrom_deg = 230\n"
            "direction_spread_deg = 0\n",
            wavelength_m);
    };
    const std::string x = waves(20), y = waves(9);
    const std::vector<Row> rows{{of_depth(12.0, y), 100 * second_us, 700 * second_us},
                                {of_depth(12.0, y + x), 300 * second_us, 360 * second_us}};
    const auto course = course_of(of_depth(30.0, x), rows);
    expect_same_waves(*course->sea(5)->realization, *walked(of_depth(30.0, x), rows));
    const auto height = [&](std::uint32_t epoch, TimeUs time_us) {
        const RunningSeaPtr sea = course->sea(epoch);
        const sea::RealizationPtr waves_then =
            sea->glide ? sea->glide->change.gliding(time_us) : sea->realization;
        return sea::DirectSum(waves_then).at(3.0, 4.0, time_us).height;
    };
    EXPECT_NEAR(height(4, 360 * second_us), height(5, 360 * second_us), 1e-6);
}

TEST(CoursePhases, those_of_some_changes_all_over_the_log_are_kept_and_the_newest) {
    CoursePhases phases;
    const sea::Scene scene = of_depth(30.0);
    std::vector<PhaseStep> steps;
    for (std::size_t i = 1; i <= 101; ++i)
        steps.push_back({i, &scene, static_cast<TimeUs>(i) * second_us,
                         static_cast<TimeUs>(i) * second_us + 1, false});
    ASSERT_TRUE(phases.before(*own_clocks(scene), steps));
    std::vector<std::size_t> kept;
    for (std::size_t i = 1; i <= 101; ++i)
        if (phases.of(i))
            kept.push_back(i);
    ASSERT_EQ(kept.size(), phases_kept);
    EXPECT_EQ(kept.back(), 100u) << "the sea behind the last one is what was asked for";
    std::size_t before = 0;
    for (const std::size_t change : kept) {
        EXPECT_LE(change - before, 3 * 100 / phases_kept) << "the walk from " << before;
        before = change;
    }
}

TEST(CoursePhases, a_sea_that_somebody_holds_is_not_made_again) {
    const auto course = course_of(of_depth(30.0), depths(12));
    const RunningSeaPtr held = course->sea(3);
    for (std::uint32_t epoch = 4; epoch <= 25; ++epoch)
        (void)course->sea(epoch);
    EXPECT_EQ(course->sea(3), held);
    EXPECT_EQ(course->sea_if_held(5), nullptr) << "nobody holds it, and it was long ago";
    EXPECT_NE(course->sea_if_held(25), nullptr);
}

} // namespace
} // namespace seaway::server
