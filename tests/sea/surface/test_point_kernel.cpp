// SPDX-License-Identifier: Apache-2.0
// Answers that kernels solve some at a time, held to those that are looked for one by one with all care.
#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "sea/native/native_runner.h"
#include "sea/scene/accuracy_presets.h"
#include "sea/scene/scene.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/surface/surface.h"
#include "sea/surface/surface_sheets.h"
#include "sea/waves/reference.h"

namespace seaway::sea {
namespace {

/// It folds on one place of ten thousand.
constexpr const char* young = R"(
[sea]
seed = 1
choppiness = 2.0
[[sea.system]]
type = "wind"
spectrum = "jonswap"
from_deg = 20
wind_speed_10m_mps = 15
fetch_m = 5e3
spreading = "cos2"
)";

/// A scene between two keyframes of each cascade, and its truth.
struct HeldScene {
    RealizationPtr sea;
    ErrorBudget budget;
    Surface surface;
    TimeUs end_us; ///< the first time after 0 at which a cascade has its next keyframe

    static HeldScene of(const Result<Scene>& scene) {
        EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
        auto sea = std::make_shared<const Realization>(*realize(*scene));
        const ErrorBudget budget = plan_budget(*sea, 0.01);
        NativeRunner runner(1);
        std::vector<SplinePair> pairs;
        TimeUs end_us = time_us_max;
        for (std::size_t c = 0; c < sea->cascades.size(); ++c) {
            const auto transform = NativeTransform::create(sea->cascades[c], sea->choppiness);
            const TimeUs interval_us = budget.cascades[c].interval_us;
            const auto map = [&](TimeUs time_us) {
                const CascadeSpec& spec = sea->cascades[c].spec;
                Keyframe keyframe{
                    0, static_cast<int>(c), time_us, spec.size, spec.length_m, surface_fields, {}};
                keyframe.values.resize(6 * keyframe.plane_size());
                const NativeTask task{&*transform, sea->phase_time(time_us), surface_fields,
                                      keyframe.values};
                runner.run({&task, 1});
                return std::make_shared<const SplineMap>(keyframe);
            };
            pairs.push_back({map(0), map(interval_us)});
            end_us = std::min(end_us, interval_us);
        }
        Surface surface(std::move(pairs), sea->choppiness, fold_search(budget),
                        map_error(budget, 0.0), inverse_tolerance_m(budget.height_error_m));
        return {sea, budget, std::move(surface), end_us};
    }
    static const HeldScene& file(std::string_view called) {
        static std::map<std::string, HeldScene> held;
        const std::string name(called);
        const auto known = held.find(name);
        if (known != held.end())
            return known->second;
        const std::string path = SEAWAY_SOURCE_DIR "/scenes/" + name + ".toml";
        return held
            .emplace(name, of(name == "young" ? parse_scene(young, name, ".") : read_scene(path)))
            .first->second;
    }

    std::vector<QueryPoint> places(int count, double reach_m, bool one_time = false) const {
        std::mt19937_64 random(3);
        std::uniform_real_distribution<double> place(-reach_m, reach_m);
        std::uniform_int_distribution<TimeUs> time(0, end_us);
        std::vector<QueryPoint> points;
        const TimeUs same_us = time(random);
        for (int i = 0; i < count; ++i) {
            const double x_m = place(random), y_m = place(random);
            // Both ends of the interval are times like all others.
            const TimeUs own_us = i % 16 == 0 ? 0 : i % 16 == 1 ? end_us : time(random);
            points.push_back({x_m, y_m, one_time ? same_us : own_us});
        }
        return points;
    }
};

std::vector<Answer> answered(const Surface& surface, std::span<const QueryPoint> points,
                             Instructions instructions = best_instructions(),
                             AnswerParts parts = AnswerParts::all) {
    std::vector<Answer> answers(points.size());
    surface.answer(points, answers, {parts}, point_kernel(instructions));
    return answers;
}

bool same_bits(const Answer& a, const Answer& b) {
    const auto same = [](double x, double y) {
        return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
    };
    bool all = same(a.height_m, b.height_m) && same(a.error_m, b.error_m) && a.flags == b.flags;
    for (int i = 0; i < 3; ++i)
        all = all && same(a.normal[i], b.normal[i]) && same(a.velocity_mps[i], b.velocity_mps[i]);
    return all;
}

class PointKernelOf : public ::testing::TestWithParam<const char*> {};

// Newton ends within the tolerance either way, so two answers differ by what two residuals may leave of a height, which
// both say in error_m, and by single precision: sums of some ten terms of a few metres, 5e-6 m. A kernel that stops
// early, wraps wrongly or takes the weights of another time is wrong by centimetres.
TEST_P(PointKernelOf, a_gentle_answer_is_the_careful_one) {
    const HeldScene& scene = HeldScene::file(GetParam());
    const double tolerance_m = inverse_tolerance_m(scene.budget.height_error_m);
    for (const double reach_m : {10e3, 1e7}) {
        const std::vector<QueryPoint> points = scene.places(20'000, reach_m);
        const std::vector<Answer> answers = answered(scene.surface, points);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Answer careful = scene.surface.answer_carefully(points[i]);
            ASSERT_EQ(answers[i].flags, careful.flags) << points[i].x_m << " " << points[i].y_m;
            if (careful.flags & answer_folded)
                continue; // one by one in any case
            const double slope = surface_slope(careful);
            ASSERT_NEAR(answers[i].height_m, careful.height_m, 2 * tolerance_m * slope + 5e-6)
                << points[i].x_m << " " << points[i].y_m << " " << points[i].time_us;
            // A bound moves with the place by the residual; a tenth of it would be a mistake.
            ASSERT_NEAR(answers[i].error_m, careful.error_m,
                        2 * tolerance_m * slope + 0.02 * careful.error_m);
            for (int axis = 0; axis < 3; ++axis) {
                // Residuals of 0.2 mm bend by strains of 1 in a decimetre: 2e-3 at most.
                ASSERT_NEAR(answers[i].normal[axis], careful.normal[axis], 4e-3);
                ASSERT_NEAR(answers[i].velocity_mps[axis], careful.velocity_mps[axis], 1e-2);
            }
        }
    }
}

TEST_P(PointKernelOf, an_answer_lies_within_its_bound_of_the_exact_sum) {
    const HeldScene& scene = HeldScene::file(GetParam());
    std::vector<QueryPoint> points = scene.places(400, 10e3);
    const DirectSum sum(scene.sea);
    for (const TimeUs time_us : {TimeUs{0}, scene.end_us / 2, scene.end_us}) {
        for (QueryPoint& point : points)
            point.time_us = time_us;
        const DirectSum::Moment moment = sum.at_time(time_us);
        const std::vector<Answer> answers = answered(scene.surface, points);
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (answers[i].flags & answer_folded)
                continue;
            const Answer exact = surface_at(
                points[i], {scene.sea->choppiness, 1e-9, fold_search(scene.budget)}, moment);
            ASSERT_LE(std::abs(answers[i].height_m - exact.height_m), answers[i].error_m)
                << points[i].x_m << " " << points[i].y_m << " " << time_us;
        }
    }
}

// Neighbours in a batch, how it is cut and what the machine can do leave no trace.
TEST_P(PointKernelOf, a_point_alone_in_a_batch_and_by_every_kernel_has_the_same_bits) {
    const HeldScene& scene = HeldScene::file(GetParam());
    for (const bool one_time : {true, false}) {
        const std::vector<QueryPoint> points = scene.places(1001, 10e3, one_time);
        const std::vector<Answer> answers = answered(scene.surface, points);
        for (const Instructions instructions : supported_instructions()) {
            const std::vector<Answer> others = answered(scene.surface, points, instructions);
            for (std::size_t i = 0; i < points.size(); ++i)
                ASSERT_TRUE(same_bits(answers[i], others[i])) << i << " " << name(instructions);
        }
        for (std::size_t i = 0; i < points.size(); i += 7)
            ASSERT_TRUE(same_bits(answers[i], scene.surface.answer(points[i]))) << i;
    }
}

// Maps that are mixed for one time are mixed by the sums that a patch is mixed by.
TEST_P(PointKernelOf, maps_mixed_once_give_the_same_bits) {
    const HeldScene& scene = HeldScene::file(GetParam());
    std::vector<QueryPoint> points = scene.places(2003, 10e3, true);
    points[0] = {std::nan(""), 0, points[1].time_us}; // no point is left out
    for (const AnswerParts parts : {AnswerParts::all, AnswerParts::height})
        for (const Instructions instructions : supported_instructions()) {
            const PointKernel& kernel = point_kernel(instructions);
            MixedMaps mixed;
            bool were_mixed = false;
            for (int round = 0; round < 5; ++round) {
                std::vector<Answer> answers(points.size()), others(points.size());
                scene.surface.answer(points, others, {parts}, kernel);
                scene.surface.answer(points, answers, {parts, &mixed}, kernel);
                for (std::size_t i = 1; i < points.size(); ++i)
                    ASSERT_TRUE(same_bits(answers[i], others[i])) << i << " " << round;
                EXPECT_TRUE(answers[0].flags & answer_invalid);
                MixedMaps::Lent lent;
                mixed.lend(scene.surface, points[1].time_us, 0, kernel, lent);
                were_mixed = were_mixed || lent;
            }
            EXPECT_TRUE(were_mixed) << "10 000 points of one time";
        }
}

// Some of one time, some of their own, some of another: each is answered once, at its own time.
TEST_P(PointKernelOf, a_batch_of_many_times_has_the_same_bits_whatever_of_it_is_mixed) {
    const HeldScene& scene = HeldScene::file(GetParam());
    std::vector<QueryPoint> points = scene.places(3000, 10e3);
    const std::size_t many = MixedMaps::pays_from_points;
    for (std::size_t i = 0; i < 2 * many; ++i)
        points.push_back({points[i % 1000].x_m, points[i % 1000].y_m,
                          i < many + 3 ? scene.end_us / 3 : scene.end_us / 2});
    for (std::size_t i = 0; i < 1000; ++i)
        points.push_back(points[i]);
    std::vector<Answer> answers(points.size());
    MixedMaps mixed;
    scene.surface.answer(points, answers, {AnswerParts::all, &mixed});
    const std::vector<Answer> others = answered(scene.surface, points);
    for (std::size_t i = 0; i < points.size(); ++i)
        ASSERT_TRUE(same_bits(answers[i], others[i])) << i;
}

TEST_P(PointKernelOf, who_wants_the_height_alone_gets_the_same_height) {
    const HeldScene& scene = HeldScene::file(GetParam());
    const std::vector<QueryPoint> points = scene.places(1000, 10e3);
    const std::vector<Answer> all = answered(scene.surface, points);
    const std::vector<Answer> heights =
        answered(scene.surface, points, best_instructions(), AnswerParts::height);
    for (std::size_t i = 0; i < points.size(); ++i) {
        ASSERT_EQ(all[i].height_m, heights[i].height_m);
        ASSERT_EQ(all[i].error_m, heights[i].error_m);
        ASSERT_EQ(all[i].flags, heights[i].flags);
        ASSERT_EQ(heights[i].velocity_mps[2], 0.0);
    }
}

// A hull at walking pace, sixty steps a second, that jumps now and then. Both ways end within the tolerance of the solution.
TEST_P(PointKernelOf, points_that_are_remembered_have_the_answers_of_those_that_are_not) {
    const HeldScene& scene = HeldScene::file(GetParam());
    const double tolerance_m = inverse_tolerance_m(scene.budget.height_error_m);
    std::vector<QueryPoint> points = scene.places(203, 10e3, true);
    std::vector<PointMemory> memory(points.size());
    const Answering remembered{AnswerParts::all, nullptr, memory};
    std::vector<Answer> answers(points.size());
    const PointKernel& kernel = point_kernel(best_instructions());
    for (int step = 0; step < 60; ++step) {
        for (std::size_t i = 0; i < points.size(); ++i) {
            points[i].time_us = scene.end_us * step / 60;
            points[i].x_m += step % 20 == 19 ? 777.0 : 0.03;
        }
        scene.surface.answer(points, answers, remembered, kernel);
        const std::vector<Answer> others = answered(scene.surface, points);
        for (std::size_t i = 0; i < points.size(); ++i) {
            ASSERT_EQ(answers[i].flags, others[i].flags) << i << " " << step;
            if (others[i].flags & answer_folded)
                continue;
            const double slope = surface_slope(others[i]);
            ASSERT_NEAR(answers[i].height_m, others[i].height_m, 2 * tolerance_m * slope + 5e-6)
                << i << " " << step;
            ASSERT_NEAR(answers[i].velocity_mps[2], others[i].velocity_mps[2], 1e-2);
        }
    }
}

// Who is not known yet is looked for as ever, beside others that are.
TEST_P(PointKernelOf, who_is_not_remembered_has_the_same_bits_beside_those_that_are) {
    const HeldScene& scene = HeldScene::file(GetParam());
    const std::vector<QueryPoint> points = scene.places(1001, 10e3);
    const std::vector<Answer> others = answered(scene.surface, points);
    std::vector<PointMemory> memory(points.size());
    std::vector<Answer> answers(points.size());
    const Answering remembered{AnswerParts::all, nullptr, memory};
    scene.surface.answer(points, answers, remembered);
    for (std::size_t i = 0; i < points.size(); ++i) {
        ASSERT_TRUE(same_bits(answers[i], others[i])) << i;
        if (i % 3 == 0)
            memory[i] = {3, -4, false};
    }
    for (const Instructions instructions : supported_instructions()) {
        std::vector<PointMemory> again = memory;
        scene.surface.answer(points, answers, {AnswerParts::all, nullptr, again},
                             point_kernel(instructions));
        for (std::size_t i = 0; i < points.size(); i += 3)
            ASSERT_TRUE(same_bits(answers[i], others[i])) << i;
    }
}

// A memory may be of anywhere, or of no place at all.
TEST_P(PointKernelOf, a_memory_of_elsewhere_does_no_harm) {
    const HeldScene& scene = HeldScene::file(GetParam());
    const double tolerance_m = inverse_tolerance_m(scene.budget.height_error_m);
    const std::vector<QueryPoint> points = scene.places(500, 10e3);
    const std::vector<Answer> others = answered(scene.surface, points);
    constexpr double nowhere = std::numeric_limits<double>::quiet_NaN();
    for (const PointMemory& wrong :
         {PointMemory{1e9, 1e9, true}, PointMemory{3, -4, true}, PointMemory{nowhere, 0, true},
          PointMemory{0, -std::numeric_limits<double>::infinity(), true}}) {
        std::vector<PointMemory> memory(points.size(), wrong);
        std::vector<Answer> answers(points.size());
        scene.surface.answer(points, answers, {AnswerParts::all, nullptr, memory});
        for (std::size_t i = 0; i < points.size(); ++i) {
            ASSERT_EQ(answers[i].flags, others[i].flags) << i << " " << wrong.shift_x_m;
            if (!(others[i].flags & answer_folded)) {
                ASSERT_NEAR(answers[i].height_m, others[i].height_m,
                            2 * tolerance_m * surface_slope(others[i]) + 5e-6);
            }
        }
    }
}

// What one time costs is paid when as much has been lost without it, and never for times that nobody comes back to.
TEST(MixedMaps, are_mixed_once_a_time_has_been_asked_about_so_often_that_it_pays) {
    const HeldScene& scene = HeldScene::file("calm");
    const Surface& surface = scene.surface;
    const PointKernel& kernel = point_kernel(best_instructions());
    const auto lent = [&](MixedMaps& mixed, const Surface& of, TimeUs time_us, std::size_t points) {
        MixedMaps::Lent lent;
        mixed.lend(of, time_us, points, kernel, lent);
        return static_cast<bool>(lent);
    };
    constexpr std::size_t enough = MixedMaps::pays_from_points;
    MixedMaps mixed;
    EXPECT_FALSE(lent(mixed, surface, 0, enough - 1));
    EXPECT_TRUE(lent(mixed, surface, 0, 1));
    EXPECT_TRUE(lent(mixed, surface, 0, 1));
    EXPECT_FALSE(lent(mixed, surface, 1, 1)) << "another time begins anew";
    EXPECT_FALSE(lent(mixed, surface, 0, 1)) << "and the one before is forgotten";
    EXPECT_TRUE(lent(mixed, surface, 0, enough));
    const HeldScene& other = HeldScene::file("young");
    EXPECT_FALSE(lent(mixed, other.surface, 0, 1)) << "so does another surface";
    EXPECT_TRUE(lent(mixed, other.surface, 0, enough));
}

TEST(MixedMaps, stay_what_they_are_for_as_long_as_someone_has_them) {
    const HeldScene& scene = HeldScene::file("calm");
    const PointKernel& kernel = point_kernel(best_instructions());
    MixedMaps mixed;
    {
        MixedMaps::Lent first, second;
        mixed.lend(scene.surface, 0, MixedMaps::pays_from_points, kernel, first);
        ASSERT_TRUE(first);
        const float before = first.map(0)[1000];
        mixed.lend(scene.surface, scene.end_us / 2, MixedMaps::pays_from_points, kernel, second);
        EXPECT_FALSE(second) << "who comes with another time goes without";
        EXPECT_EQ(first.map(0)[1000], before);
    }
    MixedMaps::Lent third;
    mixed.lend(scene.surface, scene.end_us / 2, MixedMaps::pays_from_points, kernel, third);
    EXPECT_TRUE(third);
}

TEST(MixedMaps, threads_with_times_of_their_own_answer_as_one_alone) {
    const HeldScene& scene = HeldScene::file("north_sea_gale");
    MixedMaps mixed;
    std::vector<std::thread> threads;
    std::atomic<int> wrong = 0;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&, t] {
            std::vector<QueryPoint> points = scene.places(2500, 5e3, true);
            std::vector<Answer> answers(points.size());
            for (int round = 0; round < 12; ++round) {
                for (QueryPoint& point : points) // some together, some alone
                    point.time_us = scene.end_us * ((round / 4 + t / 2) % 3) / 3;
                scene.surface.answer(points, answers, {AnswerParts::all, &mixed});
                const std::vector<Answer> others = answered(scene.surface, points);
                for (std::size_t i = 0; i < points.size(); ++i)
                    wrong += !same_bits(answers[i], others[i]);
            }
        });
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_EQ(wrong, 0);
}

// What windows leave open is asked of patches, 3 us each: 0.05 % of a gale's places, and 1.1 % of where its tiles are small and keyframes
// come further apart. Naive: bounds of values and of rates by themselves, which leave 7 and 37 % open.
TEST(PointKernel, windows_leave_few_places_of_a_gale_open_at_any_time_between_keyframes) {
    const auto open_of_100_000 = [](const HeldScene& scene) {
        std::mt19937_64 random(9);
        std::uniform_real_distribution<double> place(-10e3, 10e3);
        int open = 0;
        for (TimeUs tenth = 0; tenth < 10; ++tenth) {
            const SurfaceSheets sheets(scene.surface, tenth * scene.end_us / 10);
            for (int i = 0; i < 10'000; ++i) {
                const double x_m = place(random);
                open += sheets.alone(sheets.cells({x_m, place(random)})) ? 0 : 1;
            }
        }
        return open;
    };
    Result<Scene> gale = read_scene(SEAWAY_SOURCE_DIR "/scenes/north_sea_gale.toml");
    ASSERT_TRUE(gale);
    EXPECT_LT(open_of_100_000(HeldScene::file("north_sea_gale")), 200);
    gale->cascades = accuracy_of(AccuracyPreset::fast).cascades;
    EXPECT_LT(open_of_100_000(HeldScene::of(gale)), 2500);
}

INSTANTIATE_TEST_SUITE_P(Seas, PointKernelOf,
                         ::testing::Values("calm", "north_sea_gale", "hurricane", "young"),
                         [](const auto& sea) { return std::string(sea.param); });

TEST(PointKernel, what_is_no_number_harms_no_neighbour) {
    const HeldScene& scene = HeldScene::file("north_sea_gale");
    constexpr double nan = std::numeric_limits<double>::quiet_NaN(),
                     infinite = std::numeric_limits<double>::infinity();
    std::vector<QueryPoint> points = scene.places(64, 10e3, true);
    const std::vector<Answer> before = answered(scene.surface, points);
    for (std::size_t i = 0; i < points.size(); i += 3)
        points[i].x_m = i % 2 ? nan : infinite;
    const std::vector<Answer> answers = answered(scene.surface, points);
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (i % 3 == 0)
            EXPECT_TRUE((answers[i].flags & answer_invalid) && std::isnan(answers[i].height_m));
        else
            EXPECT_TRUE(same_bits(answers[i], before[i]));
    }
}

// Nothing is read beside the maps.
TEST(PointKernel, a_time_far_outside_is_answered_and_flagged) {
    const HeldScene& scene = HeldScene::file("north_sea_gale");
    for (const TimeUs time_us : {TimeUs{-1}, 2 * scene.end_us, TimeUs{1'000'000'000'000'000}}) {
        const Answer answer = scene.surface.answer({1e9, -1e9, time_us});
        EXPECT_TRUE(answer.flags & answer_extrapolated) << time_us;
        EXPECT_LT(answer.error_m, 100) << "no bound, but not out of this world: " << time_us;
    }
}

TEST(PointKernel, none_and_one_cascade_are_answered) {
    const HeldScene& scene = HeldScene::file("north_sea_gale");
    const Surface flat({}, {}, {}, {});
    EXPECT_EQ(flat.answer({1, 2, 3}).height_m, 0.0);
    const Surface one(scene.surface.pairs().first(1), {}, {}, {});
    EXPECT_NEAR(one.answer({1, 2, 0}).height_m, one.answer_carefully({1, 2, 0}).height_m, 1e-4);
    scene.surface.answer({}, {});
}

} // namespace
} // namespace seaway::sea
