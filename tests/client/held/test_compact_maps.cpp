// SPDX-License-Identifier: Apache-2.0
// Maps that come on a smaller grid than their cascade's (docs/protocol.md, "Compact maps").
#include <algorithm>
#include <cmath>
#include <span>

#include <gtest/gtest.h>

#include "client/held/tile_assembly.h"
#include "client/local_surface.h"
#include "protocol/tile_codec.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/surface/maps/regrid.h"

namespace seaway::client {
namespace {

using sea::Field;
using sea::FieldSet;

constexpr double tile_m = 100;
constexpr FieldSet compact_fields{Field::height, Field::displacement_x, Field::height_rate};

struct CompactPart {
    protocol::TileHeader header;
    std::vector<std::uint8_t> payload;
};

/// One wave, which 9 points a side hold.
std::vector<float> wave_map(int size, double phase) {
    std::vector<float> map;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
            map.push_back(static_cast<float>(
                std::cos(2.0 * 3.14159265358979 * (3 * x - 2 * y) / size + phase)));
    return map;
}

CompactPart wave_part(Field field, int size, double phase) {
    CompactPart part;
    part.header.keyframe = 1;
    part.header.field = field;
    part.header.size = part.header.width = part.header.height = size;
    part.header.error = 1e-4f;
    const auto payload = protocol::encode_tile(wave_map(size, phase), {size, size},
                                               static_cast<std::size_t>(size), 1e-4f);
    EXPECT_TRUE(payload);
    part.payload = *payload;
    return part;
}

TEST(TileAssembly, compact_maps_are_brought_to_the_cascades_own_grid) {
    const protocol::CascadeInfo cascade{.length_m = tile_m, .size = 64};
    const FieldSet fields = compact_fields | FieldSet{Field::foam};
    TileAssembly assembly;
    HeldKeyframePtr complete;
    for (const Field field : fields) {
        const CompactPart part =
            wave_part(field, field == Field::foam ? 64 : 10, static_cast<double>(field));
        const auto added = assembly.add(part.header, part.payload, cascade, 0, fields, {});
        ASSERT_TRUE(added) << added.error().message;
        complete = added->complete;
    }
    ASSERT_TRUE(complete);
    EXPECT_EQ(complete->keyframe().size, 64);
    EXPECT_TRUE(complete->compact());
    EXPECT_DOUBLE_EQ(complete->coded_spacing_m(), 10.0);
    // 77 of 100 waves lie within the disc of 10 points a side... of the rest of rounding nothing is left.
    EXPECT_NEAR(complete->coded_rms(Field::height),
                1e-4 / std::sqrt(3.0) * std::sqrt(sea::disc_share(10)), 1e-9);
    const HeldKeyframePtr spline = HeldKeyframe::as_spline(complete);
    EXPECT_TRUE(spline->compact()) << "who keeps the spline alone states the same";
    EXPECT_EQ(spline->coded_rms(Field::height), complete->coded_rms(Field::height));
    EXPECT_EQ(spline->coded_spacing_m(), complete->coded_spacing_m());
    for (const Field field : fields) {
        const std::vector<float> wanted = wave_map(64, static_cast<double>(field));
        for (std::size_t i = 0; i < wanted.size();
             ++i) // 1e-4 at 100 points, mixed by weights of 4 at most
            ASSERT_NEAR(complete->keyframe().plane(field)[i], wanted[i], 4e-4)
                << sea::info(field).name;
    }
    EXPECT_EQ(assembly.bytes(), 0u);
}

// Nobody sends displacements that follow from heights: who waits for them has them made, with heights' errors, who
// does not has none of them.
TEST(TileAssembly, displacements_that_follow_from_heights_are_made_for_who_waits_for_them) {
    const protocol::CascadeInfo cascade{.length_m = tile_m, .size = 64};
    const FieldSet sent{Field::height, Field::height_rate};
    constexpr double pi = 3.14159265358979;
    for (const FieldSet wanted : {sea::surface_fields, compact_fields, sent})
        for (const bool by_request : {false, true}) {
            TileAssembly assembly;
            HeldKeyframePtr complete;
            for (const Field field : sent) {
                CompactPart part = wave_part(field, 10, static_cast<double>(field));
                part.header.follows = sea::following(sea::surface_fields); // its own alone count
                const FieldSet requested[] = {wanted};
                const auto added = assembly.add(part.header, part.payload, cascade, 50.0,
                                                by_request ? FieldSet{} : wanted,
                                                std::span(requested).first(by_request ? 1 : 0));
                ASSERT_TRUE(added) << added.error().message;
                complete = added->complete;
                EXPECT_EQ(complete != nullptr, field == Field::height_rate);
                EXPECT_EQ(added->acknowledge, !by_request && field == Field::height_rate);
            }
            ASSERT_TRUE(complete);
            ASSERT_TRUE(complete->fields().contains(wanted));
            EXPECT_EQ(complete->fields(), wanted | sent);
            EXPECT_EQ(assembly.keyframes(), 0u);
            // cos(k.x + p) moves water by -k/|k| coth(k d) sin(k.x + p), k = (3, -2) 2 pi / 100 m.
            const double index = std::sqrt(13.0), kd = 2.0 * pi * index / tile_m * 50.0;
            for (const Field field : wanted) {
                const bool rate = sea::info(field).time_rate, follows = !sent.contains(field);
                const bool along_x =
                    field == Field::displacement_x || field == Field::displacement_x_rate;
                EXPECT_EQ(complete->follows(field), follows);
                EXPECT_EQ(complete->error(field), 1e-4f);
                EXPECT_NEAR(complete->coded_rms(field),
                            complete->coded_rms(Field::height) *
                                (follows ? std::sqrt(sea::Orbits(10, tile_m, 50.0).gain()) : 1.0),
                            1e-12);
                const double amplitude =
                    follows ? (along_x ? 3.0 : -2.0) / index / std::tanh(kd) : 1.0;
                const std::vector<float> wave =
                    wave_map(64, (rate ? 3.0 : 0.0) + (follows ? 0.5 * pi : 0.0));
                for (std::size_t i = 0; i < wave.size(); ++i)
                    ASSERT_NEAR(complete->keyframe().plane(field)[i],
                                amplitude * static_cast<double>(wave[i]), 4e-4)
                        << sea::info(field).name;
            }
        }
}

// A request for displacements, made when heights of the stream were there already.
TEST(TileAssembly, what_follows_is_made_for_a_request_that_comes_later) {
    const protocol::CascadeInfo cascade{.length_m = tile_m, .size = 64};
    const FieldSet sent{Field::height, Field::height_rate};
    TileAssembly assembly;
    for (const Field field : sent) {
        CompactPart part = wave_part(field, 10, 0);
        part.header.follows = sea::following(field);
        ASSERT_TRUE(
            assembly.add(part.header, part.payload, cascade, 0, sent | FieldSet{Field::foam}, {}));
    }
    const FieldSet more[] = {sea::surface_fields | FieldSet{Field::foam}};
    const CompactPart foam = wave_part(Field::foam, 64, 0);
    const auto added = assembly.add(foam.header, foam.payload, cascade, 0, {}, more);
    ASSERT_TRUE(added && added->complete);
    EXPECT_EQ(added->complete->fields(), more[0]);
    EXPECT_TRUE(assembly.finish(more[0]).empty()) << "handed out already";
}

TEST(TileAssembly, grids_that_no_compact_map_may_have_are_errors) {
    const auto why_not = [](const std::vector<CompactPart>& parts, int size) {
        TileAssembly assembly;
        for (const CompactPart& part : parts) {
            const auto added =
                assembly.add(part.header, part.payload, {.length_m = tile_m, .size = size}, 0,
                             compact_fields, {});
            if (!added)
                return added.error().message;
        }
        return std::string("no error");
    };
    CompactPart own = wave_part(Field::height, 64, 0);
    own.header.follows = sea::following(Field::height);
    EXPECT_NE(why_not({own}, 64).find("not compact"), std::string::npos);
    const CompactPart height = wave_part(Field::height, 10, 0),
                      rate = wave_part(Field::height_rate, 12, 0);
    EXPECT_EQ(why_not({height}, 64), "no error");
    EXPECT_NE(why_not({height}, 9).find("map of size 10, the cascade's is 9"), std::string::npos);
    EXPECT_NE(why_not({wave_part(Field::foam, 10, 0)}, 64).find("map of size 10"),
              std::string::npos);
    EXPECT_NE(why_not({wave_part(Field::height, 14, 0)}, 64).find("map of size 14"),
              std::string::npos)
        << "transforms are of products of 2, 3 and 5";
    EXPECT_NE(why_not({height, rate}, 64).find("map of size 12, others of the keyframe have 10"),
              std::string::npos);
}

// What was coded on a smaller grid is a sum of long waves: less of it by the corners of the square that nobody has,
// no less between the grid points, and far less steep.
TEST(LocalAnswer, a_compact_keyframes_codec_error_is_that_of_waves_of_the_smaller_grid) {
    SeaState state;
    state.epoch = 1;
    state.cascades.push_back({.length_m = tile_m, .size = 16, .interval_us = 100'000});
    state.losses = {{{0.1, 0.2, 0.3}, {0.4, 0.5, 0.6}}};
    state.single_precision_m = 0.01;
    state.single_precision_displacement_m = 0.02;
    HeldKeyframe::FieldErrors errors{};
    for (const Field field : sea::surface_fields)
        errors[static_cast<std::size_t>(field)] = 0.003f;
    const auto held = [&](sea::TimeUs time_us, int compact_size) {
        sea::Keyframe made{1, 0, time_us, 16, tile_m, sea::surface_fields, {}};
        made.values.resize(made.plane_size() * 6);
        return std::make_shared<const HeldKeyframe>(std::move(made), errors,
                                                    HeldKeyframe::Compact{compact_size, {}, 0.5});
    };
    const double whole_m = 0.003 / std::sqrt(3.0), share = sea::disc_share(10);
    for (const auto& [first, second] : {std::pair(10, 10), {10, 0}, {0, 10}}) {
        const KeyframePair pair{held(0, first), held(100'000, second), true};
        const sea::MapError error = local_map_error(state, {&pair, 1});
        const sea::CascadeLoss& loss = error.cascades[0];
        const double value_m = first == second ? whole_m * std::sqrt(share) : whole_m;
        EXPECT_NEAR(loss.height.value_m, value_m, 1e-9);
        EXPECT_NEAR(loss.displacement.rate_mps, value_m, 1e-9);
        EXPECT_EQ(loss.height.coded_relief, 0);
        EXPECT_EQ(loss.displacement.coded_relief, 0);
        EXPECT_DOUBLE_EQ(error.height_bound_m, 0.03) << "on the way to the smaller grid and back";
        EXPECT_DOUBLE_EQ(error.displacement_bound_m, 0.06);
        // (pi / spacing)^2 / 4 of the variance, or that of a spline through the finer grid's own samples.
        const double largest = loss.displacement.largest_variance_m2(0.1) -
                               loss.displacement.interpolation_variance_m2();
        const double gain = std::max(std::pow(3.14159265358979 * 10 / tile_m, 2) / 4.0,
                                     first == second ? 0.0 : 3.4217 / std::pow(tile_m / 16, 2));
        EXPECT_NEAR(
            error.codec_strain_bound,
            sea::coded_strain_bound({state.choppiness_x, state.choppiness_y}, largest * gain),
            1e-6 * error.codec_strain_bound);
    }
}

// What a server found that rounding left is of two keyframes that follow each other; of others, and where it says nothing, it is
// even noise. Naive: the rms of a keyframe that is told serves for any pair that it is of.
TEST(LocalAnswer, what_a_server_found_that_rounding_left_counts_between_those_two_keyframes_alone) {
    HeldKeyframe::FieldErrors errors{};
    for (const Field field : sea::surface_fields)
        errors[static_cast<std::size_t>(field)] = 0.003f;
    const auto held = [&](sea::TimeUs time_us, const sea::CodedNoise& noise) {
        sea::Keyframe made{1, 0, time_us, 16, tile_m, sea::surface_fields, {}};
        made.values.resize(made.plane_size() * 6);
        return std::make_shared<const HeldKeyframe>(
            std::move(made), errors,
            HeldKeyframe::Compact{.size = 0, .follows = {}, .noise = noise});
    };
    const auto height = [&](const HeldKeyframePtr& before, const HeldKeyframePtr& after) {
        sea::CascadeLoss loss;
        add_codec(loss, {before, after, true});
        EXPECT_NEAR(loss.displacement.value_m, 0.003 / std::sqrt(3.0), 1e-9) << "as ever";
        return loss.height;
    };
    const auto first = held(0, {.number = 7, .at_m = 1e-3});
    const auto second = held(100'000, {9, 7, 0, 2e-3, 0.5e-3});
    const sea::MapLoss told = height(first, second);
    EXPECT_EQ(told.coded_relief, 0) << "waves have no relief between grid points";
    const auto at = [](const sea::MapLoss& loss, double share) {
        return std::sqrt(
            loss.at(share, sea::hermite_weights(0, 100'000, std::llround(1e5 * share))).coded_m2);
    };
    EXPECT_DOUBLE_EQ(at(told, 0), 2e-3) << "the larger of both";
    EXPECT_DOUBLE_EQ(at(told, 1), 2e-3);
    EXPECT_DOUBLE_EQ(at(told, 0.5), 0.5e-3);
    EXPECT_NEAR(std::pow(at(told, 0.25), 2), 4e-6 - 3.75e-6 * 27 / 64, 1e-15);
    EXPECT_DOUBLE_EQ(told.largest_variance_m2(0.1), 4e-6);
    EXPECT_DOUBLE_EQ(at(told, 1.25), 2e-3) << "beyond them nothing is a bound";
    const sea::MapLoss even = height(held(0, {}), held(100'000, {}));
    for (const auto& [before, after] :
         {std::pair(held(-100'000, {.number = 7, .at_m = 1e-3}), second),
          {held(0, {}), second},
          {held(0, {.number = 8, .at_m = 1e-3}), second}, // of that time, coded otherwise
          {first, held(100'000, {.number = 9, .before = 7, .at_m = 2e-3})},
          {second, second}}) {
        const sea::MapLoss loss = height(before, after);
        EXPECT_DOUBLE_EQ(at(loss, 0.5), at(even, 0.5));
        EXPECT_DOUBLE_EQ(loss.largest_variance_m2(0.1), even.largest_variance_m2(0.1));
    }
}

} // namespace
} // namespace seaway::client
