// SPDX-License-Identifier: Apache-2.0
// The world that sessions talk to, over a simulation.
#include <atomic>
#include <chrono>
#include <cmath>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/bound_to_float.h"
#include "server/host/refusal.h"
#include "server/map_source.h"
#include "server/world.h"
#include "server/world_reports.h"
#include "tests/server/simulation/simulation_bench.h"
#include "tests/server/stopped_clock.h"
#include "tests/support/eventually.h"

namespace seaway::server {
namespace {

// Naive: only the simulation knows who may go, and the world forgets to tell it. A fetch of foam walks
// through hundreds of ticks: on a slow machine that was a quarter of a minute of work for nobody.
TEST(World, what_who_has_gone_asked_for_is_dropped_without_work) {
    Bench bench;
    SeaClock clock = stopped_at(0);
    World world(bench.course, clock);
    world.attach(*bench.simulation);
    auto here = std::make_shared<char>();
    const Asker asker(here);
    here = nullptr;
    std::atomic<int> gone = 0;
    const auto note = [&](const auto& result) {
        gone += !result && result.error().is(Refusal::gone);
    };
    const FieldSet with_foam = sea::surface_fields | FieldSet{Field::foam};
    world.fetch({{}, {~0u, with_foam}, asker}, note);  // the start of a subscription
    world.fetch({{0}, {~0u, with_foam}, asker}, note); // a fetch
    world.query({false, {{1.0, 2.0, 0}}, asker}, note);
    world.query({true, {{1.0, 2.0, 0}}, asker}, note);
    world.map(
        {{{"width_m", "10"}, {"height_m", "10"}, {"columns", "4"}, {"rows", "4"}}, asker, [] {}},
        note);
    EXPECT_TRUE(tests::eventually([&] {
        bench.settle(); // askers take turns: each time it is one of theirs
        return gone == 5;
    })) << "each is answered all the same";
    EXPECT_EQ(bench.simulation->counters().synthesis.transforms, 0u);
}

// ---- seas to come ------------------------------------------------------------------------------

/// A sea of waves of a minute and more, quickly made, that changes so many times.
SeaCoursePtr changing_course(int changes) {
    std::string rows;
    for (int i = 0; i < changes; ++i)
        rows += "[[weather]]\nat_s = " + std::to_string(100 + 40 * i) +
                "\nover_s = 20\nset.systems.0.from_deg = " + std::to_string(250 + i) + "\n";
    return *SeaCourse::begin(small_scene(rows));
}

// Naive: the message of the oldest sea is let go at once, as the oldest, and handed out all the same.
TEST(World, says_the_same_of_a_sea_however_many_others_were_asked_about_since) {
    SeaClock clock = stopped_at(0);
    const World world(changing_course(35), clock);
    const std::vector<std::uint8_t> first = *world.sea_state_message(1);
    for (std::uint32_t epoch = 2; epoch <= 71; ++epoch)
        (void)world.sea_state_message(epoch);
    for (int again = 0; again < 2; ++again) {
        EXPECT_TRUE(*world.sea_state_message(1) == first);
        ASSERT_EQ(world.sea_state_messages().size(), 1u);
        EXPECT_TRUE(*world.sea_state_messages().front() == first);
    }
}

// Naive: whoever fetches keyframes of a sea to come is told of it, and then nobody else is.
TEST(World, everybody_is_told_once_of_a_sea_that_somebody_has_asked_about_already) {
    TimeUs now_us = 0;
    SeaClock clock(
        0, [&now_us] { return now_us; }, [&now_us] { return now_us; });
    World world(changing_course(1), clock);
    std::vector<SharedBytes> told;
    world.announce_to([&told](SharedBytes message) { told.push_back(std::move(message)); });
    const SharedBytes glide = world.sea_state_message(2);
    (void)world.announce_due();
    EXPECT_EQ(told.size(), 0u) << "not yet";
    now_us = 95'000'000;
    (void)world.announce_due();
    (void)world.announce_due();
    ASSERT_EQ(told.size(), 1u);
    EXPECT_EQ(told.front(), glide);
}

// Naive: clients take the new time from the next look at the clock, and sample the sea that they were told of until the next one is told.
TEST(World, where_the_clock_leaps_over_a_change_nobody_is_told_of_it_is_not_sure_until_it_is_told) {
    TimeUs now_us = 0;
    SeaClock clock(
        0, [&now_us] { return now_us; }, [] { return 0; });
    World world(changing_course(1), clock);
    EXPECT_EQ(world.sea_time().unsure_us, 0);
    now_us = 50'000'000; // before it
    EXPECT_EQ(world.sea_time().unsure_us, 0);
    now_us = 3'600'000'000;
    const sea::SeaTime leapt = world.sea_time();
    EXPECT_EQ(leapt.sea_us, now_us);
    // Since before its first change begins, by which a client no longer takes for told what it holds.
    EXPECT_GT(leapt.unsure_us, now_us - 100'000'000 + World::announced_ahead_us / 2);
    (void)world.announce_due();
    EXPECT_EQ(world.sea_time().unsure_us, 0);
}

// Naive: of a sea to which nothing will ever come, the time until then is a number beyond all others.
TEST(World, before_sea_time_0_and_at_the_end_of_all_times_it_is_as_sure_as_ever) {
    for (const TimeUs now_us : {TimeUs{-5'000'000}, -sea::time_us_max, sea::time_us_max}) {
        SeaClock clock = stopped_at(now_us);
        const World world(changing_course(0), clock);
        EXPECT_EQ(world.sea_time().unsure_us, 0) << now_us;
    }
}

// Naive: it counts as told before it is, and is never told again.
TEST(World, of_a_sea_that_could_not_be_told_for_want_of_memory_all_are_told_next_time) {
    TimeUs now_us = 0;
    SeaClock clock(
        0, [&now_us] { return now_us; }, [&now_us] { return now_us; });
    World world(changing_course(1), clock);
    now_us = 95'000'000;
    int tries = 0;
    world.announce_to([&tries](const SharedBytes&) {
        if (++tries == 1)
            throw std::bad_alloc();
    });
    EXPECT_THROW((void)world.announce_due(), std::bad_alloc);
    (void)world.announce_due();
    const int told = tries;
    EXPECT_GT(told, 1);
    (void)world.announce_due();
    EXPECT_EQ(tries, told) << "and once";
}

// Naive: the choice as it came, of waves that this sea may not have.
TEST(World, an_answer_about_some_waves_says_which_of_this_sea_they_were) {
    Bench bench;
    SeaClock clock = stopped_at(0);
    World world(bench.course, clock);
    world.attach(*bench.simulation);
    const auto counted = [&](const sea::Looking& looking) {
        std::promise<std::optional<std::uint32_t>> said;
        world.query({false, {{1.0, 2.0, 0}}, Asker::who_stays(), looking},
                    [&](const auto& answers) {
                        EXPECT_TRUE(answers);
                        said.set_value(answers->cascades);
                    });
        return said.get_future().get();
    };
    EXPECT_EQ(counted({}), std::nullopt) << "who asks of all waves hears nothing of it";
    EXPECT_EQ(counted({.min_wavelength_m = 40}), 1u) << "the second tile is 43 m long";
    EXPECT_EQ(counted({.cascades = 0xfeu}), 2u);
    EXPECT_EQ(counted({.min_wavelength_m = 1e-3}), sea::all_cascades) << "none is left out";
}

// ---- what is granted and what is sent for it -------------------------------------------------

const FieldSet heights{Field::height, Field::height_rate};

TEST(World, a_grant_is_the_part_of_a_wish_that_the_sea_has_at_the_cheapest_rung_that_keeps_it) {
    const RunningSeaPtr sea = running_sea("[effects]\nslopes = false\n"); // two cascades
    SeaClock clock = stopped_at(0);
    const World world(steady_course(sea), clock);
    const auto granted = [&](std::uint32_t cascades, FieldSet fields, double error_m = 0,
                             bool compact = false) {
        return world.grant({.cascades = cascades,
                            .fields = fields,
                            .error_m = static_cast<float>(error_m),
                            .compact = compact});
    };
    EXPECT_EQ(granted(~0u, heights).cascades, 3u);
    EXPECT_EQ(granted(6u, heights).cascades, 2u);
    EXPECT_TRUE(granted(4u, heights).empty()) << "a cascade that there is not";
    EXPECT_EQ(granted(1u, heights | FieldSet{Field::slope_x}).fields, heights);
    EXPECT_TRUE(granted(1u, {Field::slope_x, Field::slope_y}).empty());
    // Rungs cost a codec error 1 to 16 times as large; the bound is that of level water. Compact ones follow, and
    // cost single precision twice more, on the way to the smaller grid and back.
    for (const bool compact : {false, true}) {
        double rung_m[5];
        for (std::size_t rung = 0; rung < 5; ++rung)
            rung_m[rung] =
                sea::level_error_m(sea->budget, std::pow(2.0, rung) * sea->budget.codec_error_m) +
                (compact ? 2.0 * sea->budget.single_precision_m : 0.0);
        for (const auto& [wish_m, rung] : {std::pair(0.0, 0u),
                                           {0.5 * rung_m[0], 0u},
                                           {0.999 * rung_m[1], 0u},
                                           {1.001 * rung_m[1], 1u},
                                           {0.999 * rung_m[2], 1u},
                                           {1.001 * rung_m[2], 2u},
                                           {1.001 * rung_m[3], 3u},
                                           {1e6, 4u}}) {
            const Demand grant = granted(1u, heights, wish_m, compact);
            EXPECT_EQ(grant.quality, rung + (compact ? 5u : 0u)) << wish_m;
            EXPECT_EQ(grant.error_m, bound_to_float(rung_m[rung])) << wish_m;
        }
    }
}

// Who takes compact maps has displacements without being sent them, from the heights that he is sent; so nobody computes
// them for him. Nothing follows from what was not asked for, nor from whole maps.
TEST(World, displacements_that_follow_from_heights_are_granted_and_not_sent) {
    const RunningSeaPtr sea = running_sea();
    SeaClock clock = stopped_at(0);
    const World world(steady_course(sea), clock);
    const FieldSet sideways{Field::displacement_x, Field::displacement_y,
                            Field::displacement_x_rate, Field::displacement_y_rate};
    const auto granted = [&](FieldSet fields, bool compact) {
        const Demand grant = world.grant({.cascades = 1u, .fields = fields, .compact = compact});
        return std::pair(grant.fields, grant.follows);
    };
    using Pair = std::pair<FieldSet, FieldSet>;
    ASSERT_TRUE(sea->budget.displacement_follows);
    EXPECT_EQ(granted(sea::surface_fields, true), Pair(heights, sideways));
    EXPECT_EQ(granted(sea::surface_fields, false), Pair(sea::surface_fields, FieldSet{}));
    EXPECT_EQ(granted(heights, true), Pair(heights, FieldSet{}));
    EXPECT_EQ(granted(sideways, true), Pair(sideways, FieldSet{}));
    const FieldSet some{Field::height, Field::displacement_x, Field::displacement_y_rate};
    EXPECT_EQ(granted(some, true), Pair(FieldSet{Field::height, Field::displacement_y_rate},
                                        FieldSet{Field::displacement_x}));
}

// Naive: by the depths of the two scenes. One that is cut on the way is still deeper than the one that it leads to.
TEST(World, displacements_do_not_follow_while_the_depth_of_a_glide_that_was_cut_goes_on) {
    const auto made = [](std::uint32_t epoch, double depth_m, double wind_mps) {
        std::string text = small_sea;
        text.replace(text.find("= 9.0"), 5, fmt::format("= {:.1f}", wind_mps));
        text.replace(text.find("seed = 7"), 8, fmt::format("seed = 7\ndepth_m = {:.1f}", depth_m));
        const Result<sea::Scene> scene = sea::parse_scene(text, "depths", ".");
        EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
        return *make_running_sea(*scene, epoch);
    };
    const RunningSeaPtr deep = made(1, 100, 9), tide = made(3, 30, 9), windy = made(5, 30, 10);
    constexpr sea::TimeUs s = 1'000'000;
    const RunningSeaPtr to_tide = *make_glide(*deep, *tide, 2, 0, 60 * s);
    EXPECT_FALSE(to_tide->budget.displacement_follows);
    const RunningSeaPtr cut = *make_glide(*to_tide, *windy, 4, 16 * s, 46 * s);
    EXPECT_FALSE(cut->budget.displacement_follows) << "it goes on being shallower";
    const RunningSeaPtr same = *make_glide(*tide, *windy, 4, 70 * s, 100 * s);
    EXPECT_TRUE(same->budget.displacement_follows);
    EXPECT_TRUE((*make_glide(*same, *tide, 6, 80 * s, 110 * s))->budget.displacement_follows);
    // Naive: 1 / (1 / 49) is not 49.
    const RunningSeaPtr calm = made(1, 49, 9), fresh = made(3, 49, 10), gale = made(5, 49, 12);
    const RunningSeaPtr rising = *make_glide(*calm, *fresh, 2, 0, 60 * s);
    EXPECT_TRUE((*make_glide(*rising, *gale, 4, 16 * s, 46 * s))->budget.displacement_follows);
}

// Naive: those of the sea that it leads to.
TEST(World, a_glide_is_told_the_stylised_waves_of_both_of_its_ends) {
    const RunningSeaPtr plain = running_sea();
    const RunningSeaPtr sines =
        running_sea("[[sea.system]]\ntype = \"sines\"\nlength_m = 43.0\n"
                    "shape = \"sine\"\nwavelength_m = 20.0\nfrom_deg = 90\n");
    for (const auto& [from, to] : {std::pair(plain, plain), {plain, sines}, {sines, plain}}) {
        const RunningSeaPtr glide = make_glide(*from, *to, 2, 0, 100'000'000).value();
        const auto told = sea_state_values(*glide, {2, 0, 100'000'000}, {}).cascades;
        EXPECT_FALSE(told[0].stylised);
        EXPECT_EQ(told[1].stylised, from != to);
    }
}

// Naive: by the sea that it leads to, and a client that feels long waves alone loses one in the moment in which it begins to fade.
TEST(World, a_glide_is_told_the_longest_wave_of_both_of_its_ends) {
    const RunningSeaPtr plain = running_sea();
    const RunningSeaPtr given =
        running_sea("[[sea.system]]\ntype = \"modes\"\nlength_m = 43.0\ndata = "
                    "'''\nnx,ny,amplitude_m,phase_rad\n1,0,2,0\n'''\n");
    for (const auto& [from, to] : {std::pair(plain, plain), {plain, given}, {given, plain}}) {
        const RunningSeaPtr glide = make_glide(*from, *to, 2, 0, 100'000'000).value();
        const auto told = sea_state_values(*glide, {2, 0, 100'000'000}, {});
        for (std::size_t c = 0; c < told.cascades.size(); ++c) {
            EXPECT_EQ(told.cascades[c].k_lo_radpm, to->realization->cascades[c].longest_radpm())
                << "frequencies are of the new sea's waves";
            EXPECT_EQ(told.longest_radpm(c),
                      std::min(from->realization->cascades[c].longest_radpm(),
                               to->realization->cascades[c].longest_radpm()));
        }
        EXPECT_EQ(sea_state_values(*to, {3, 100'000'000, 200'000'000}, {}).longest_radpm(1),
                  to->realization->cascades[1].longest_radpm());
    }
}

// Naive: whatever follows is named. A client would move points of a sea that is offered without sideways motion.
TEST(World, nothing_follows_that_the_sea_does_not_offer) {
    for (const std::string displacement : {"height", "choppy"}) {
        const RunningSeaPtr sea =
            running_sea("[effects]\ndisplacement = \"" + displacement + "\"\n");
        ASSERT_TRUE(sea->budget.displacement_follows);
        SeaClock clock = stopped_at(0);
        World world(steady_course(sea), clock);
        std::vector<KeyframeTiles> published;
        world.publish_to([&](KeyframeTiles tiles) { published.push_back(std::move(tiles)); });
        world.subscriptions().set(1, {1u, heights, 0, 5});
        auto keyframe = std::make_shared<sea::Keyframe>();
        keyframe->epoch = 1;
        keyframe->fields = heights;
        world.on_keyframe(keyframe);
        ASSERT_EQ(published.size(), 1u);
        EXPECT_EQ(published[0].follows,
                  displacement == "choppy" ? sea::following(heights) : FieldSet{});
    }
}

// Naive: what took the place of a change is told under its number and from its time on, and whoever hears that has no glide.
TEST(World, of_a_change_in_whose_place_another_came_nothing_is_told_and_no_keyframe_sent) {
    const auto course = *SeaCourse::begin(small_scene());
    SeaClock clock = stopped_at(0);
    World world(course, clock);
    std::vector<KeyframeTiles> published;
    world.publish_to([&](KeyframeTiles tiles) { published.push_back(std::move(tiles)); });
    world.subscriptions().set(1, {1u, heights, 0, 5});
    const auto keyframe_of = [](std::uint32_t epoch) {
        auto keyframe = std::make_shared<sea::Keyframe>();
        keyframe->epoch = epoch;
        keyframe->fields = heights;
        return keyframe;
    };
    const auto add = [&] {
        ASSERT_TRUE(course->add(small_scene(), 1000 * second_us, 1600 * second_us));
    };
    add();
    world.on_keyframe(keyframe_of(2));
    EXPECT_EQ(published.size(), 1u);
    EXPECT_TRUE(world.sea_state_message(3));
    add();
    world.on_keyframe(keyframe_of(2));
    world.on_keyframe(keyframe_of(3));
    EXPECT_EQ(published.size(), 1u);
    add(); // of the one before nobody has made the sea
    EXPECT_FALSE(world.sea_state_message(5));
    EXPECT_TRUE(world.sea_state_message(7));
    world.on_keyframe(keyframe_of(6));
    EXPECT_EQ(published.size(), 2u);
}

// Each keyframe at each rung that somebody has of its cascade, with the bounds of that rung.
TEST(World, a_keyframe_is_published_once_a_rung_in_use_with_the_bounds_of_the_rung) {
    const RunningSeaPtr sea = running_sea();
    SeaClock clock = stopped_at(0);
    World world(steady_course(sea), clock);
    std::vector<KeyframeTiles> published;
    world.publish_to([&](KeyframeTiles tiles) { published.push_back(std::move(tiles)); });
    world.subscriptions().set(1, {1u, heights, 0, 2});
    world.subscriptions().set(2, {3u, heights, 0, 0});
    world.subscriptions().set(3, {2u, heights, 0, 1});
    world.subscriptions().set(4, {2u, heights, 0, 1});
    world.subscriptions().set(5, {1u, heights, 0, 6});
    const std::vector<std::uint8_t> rungs[] = {{0, 2, 6}, {1, 0}}; // of the second two have 1
    for (int cascade = 0; cascade < 2; ++cascade) {
        auto keyframe = std::make_shared<sea::Keyframe>();
        keyframe->epoch = sea->epoch;
        keyframe->cascade = cascade;
        keyframe->fields = heights;
        published.clear();
        world.on_keyframe(keyframe);
        const auto& expected = rungs[cascade];
        ASSERT_EQ(published.size(), expected.size()) << cascade;
        for (std::size_t i = 0; i < expected.size(); ++i) {
            EXPECT_EQ(published[i].quality, expected[i]);
            EXPECT_EQ(published[i].rank, i);
            EXPECT_EQ(published[i].keyframe, keyframe);
            const bool compact = expected[i] >= 5;
            EXPECT_EQ(published[i].codec_error,
                      sea::codec_bounds(sea->budget, heights, cascade,
                                        std::pow(2.0, expected[i] % 5) * sea->budget.codec_error_m,
                                        compact));
            EXPECT_EQ(published[i].compact_size,
                      compact ? sea->budget.cascades[static_cast<std::size_t>(cascade)].compact_size
                              : 0);
        }
    }
    for (const SessionId session : {1, 2, 3, 4, 5})
        world.subscriptions().erase(session);
    published.clear();
    auto unwanted = std::make_shared<sea::Keyframe>();
    unwanted->epoch = sea->epoch;
    world.on_keyframe(unwanted);
    EXPECT_TRUE(published.empty()) << "nobody wants it";
}

TEST(World, a_fetch_brings_what_was_granted_in_its_rung_and_the_sea_is_named_in_answers) {
    Bench bench;
    SeaClock clock = stopped_at(0);
    World world(bench.course, clock);
    world.attach(*bench.simulation);
    std::vector<KeyframeTiles> tiles;
    std::atomic<bool> fetched = false;
    const TimeUs time_us = 5'000'001;
    world.fetch({{time_us}, {6u, heights | FieldSet{Field::foam}, 1e6f}, someone},
                [&](Result<FetchedPart> part) {
                    ASSERT_TRUE(part);
                    for (KeyframeTiles& one : part->tiles)
                        tiles.push_back(std::move(one));
                    fetched = part->last;
                });
    std::uint32_t epoch = 0;
    std::atomic<bool> answered = false;
    world.query({false, {{1, 2, time_us}}, someone}, [&](const Result<QueryAnswers>& answers) {
        ASSERT_TRUE(answers);
        epoch = answers->epoch;
        answered = true;
    });
    ASSERT_TRUE(tests::eventually([&] { return fetched.load(); }) &&
                tests::eventually([&] { return answered.load(); }));
    EXPECT_EQ(epoch, bench.sea->epoch);
    ASSERT_EQ(tiles.size(), 2u) << "of the second cascade alone, before and after";
    const TimeUs interval_us = bench.sea->budget.cascades[1].interval_us;
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(tiles[i].quality, 4);
        EXPECT_EQ(tiles[i].keyframe->cascade, 1);
        EXPECT_TRUE(tiles[i].keyframe->fields.contains(heights | FieldSet{Field::foam}));
        EXPECT_EQ(tiles[i].keyframe->time_us,
                  (time_us / interval_us + static_cast<TimeUs>(i)) * interval_us);
        EXPECT_EQ(tiles[i].codec_error,
                  sea::codec_bounds(bench.sea->budget, tiles[i].keyframe->fields, 1,
                                    16 * bench.sea->budget.codec_error_m));
    }
    Error refusal{""};
    world.fetch({{time_us}, {4u, heights}, someone},
                [&](const Result<FetchedPart>& part) { refusal = part.error(); });
    EXPECT_TRUE(refusal.is(Refusal::not_offered));
}

} // namespace
} // namespace seaway::server
