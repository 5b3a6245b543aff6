// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/height_map.h"

#include <atomic>
#include <bit>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "tests/support/explicit_sea.h"

namespace seaway::sea {
namespace {

/// Two tiles of some dozens of waves, between keyframes 0.2 s apart.
Surface surface(double steepness, Choppiness choppiness = {1.0, 1.0}, bool folds = false) {
    const RealizationPtr sea =
        tests::make_sea({tests::random_cascade(131.0, 64, 9, 40, steepness, 3),
                         tests::random_cascade(23.0, 64, 12, 30, steepness, 4)},
                        choppiness);
    std::vector<SplinePair> pairs;
    for (int c = 0; c < 2; ++c) {
        const auto map = [&](TimeUs t) {
            return std::make_shared<const SplineMap>(*tests::exact_keyframe(sea, c, t));
        };
        pairs.push_back({map(0), map(200'000)});
    }
    return Surface(std::move(pairs), choppiness, {.reach_m = 2.0, .always = folds},
                   {.height_bound_m = 0.001, .displacement_bound_m = 0.001});
}

MapRequest request(MapKind kind = MapKind::height) {
    MapRequest r;
    r.kind = kind;
    r.x0_m = -37.5;
    r.y0_m = 12.25;
    r.width_m = 90.0;
    r.height_m = 60.0;
    r.columns = 120;
    r.rows = 80;
    r.time_us = 70'000;
    return r;
}

std::vector<float> all_values(const MapRequest& r, const Surface& surface,
                              MapOptions options = {}) {
    Result<std::unique_ptr<MapStream>> stream = MapStream::start(r, surface, std::move(options));
    EXPECT_TRUE(stream) << (stream ? "" : stream.error().message);
    std::vector<float> values;
    int next_row = 0;
    while (std::optional<MapChunk> chunk = (*stream)->next_chunk()) {
        EXPECT_EQ(chunk->first_row, next_row);
        next_row += chunk->rows;
        EXPECT_LE(chunk->values.size(), static_cast<std::size_t>(map_chunk_values_max));
        values.insert(values.end(), chunk->values.begin(), chunk->values.end());
    }
    EXPECT_EQ(next_row, r.rows);
    return values;
}

QueryPoint point(const MapRequest& r, std::size_t i) {
    const auto columns = static_cast<std::size_t>(r.columns);
    const std::size_t row = i / columns, column = i % columns;
    return {r.x0_m + static_cast<double>(column) * r.width_m / r.columns,
            r.y0_m + static_cast<double>(row) * r.height_m / r.rows, r.time_us};
}

/// Largest difference where a query finds one sheet and converges, m.
double worst(const MapRequest& r, const Surface& surface, const std::vector<float>& heights) {
    double worst_m = 0;
    for (std::size_t i = 0; i < heights.size(); ++i) {
        const Answer answer = surface.answer(point(r, i));
        if (!(answer.flags & (answer_folded | answer_not_converged)))
            worst_m =
                std::max(worst_m, std::abs(static_cast<double>(heights[i]) - answer.height_m));
    }
    return worst_m;
}

TEST(HeightMap, every_height_is_what_a_query_answers_within_the_stated_bound) {
    const Surface sea = surface(0.02);
    for (const Instructions instructions : supported_instructions()) {
        MapOptions options;
        options.instructions = instructions;
        const MapRequest r = request();
        EXPECT_LE(worst(r, sea, all_values(r, sea, options)), map_difference_max_m)
            << name(instructions);
    }
}

TEST(HeightMap, far_from_the_origin_and_coarse_or_fine_it_is_as_exact) {
    const Surface sea = surface(0.02);
    MapRequest r = request();
    r.x0_m = 1'000'000.3;
    r.y0_m = -1'000'000.7;
    EXPECT_LE(worst(r, sea, all_values(r, sea)), map_difference_max_m);
    r.width_m = 5000.0; // wider apart than the waves are long: neighbours tell nothing
    r.height_m = 5000.0;
    EXPECT_LE(worst(r, sea, all_values(r, sea)), map_difference_max_m);
    r.width_m = r.height_m = 0.5;
    EXPECT_LE(worst(r, sea, all_values(r, sea)), map_difference_max_m);
}

// Naive: one length of the last Newton step for all seas. Waves of centimetres bend within it.
TEST(HeightMap, of_waves_of_centimetres_every_height_is_what_a_query_answers) {
    for (const double length_m : {6.0, 2.0, 0.5}) {
        const RealizationPtr waves =
            tests::make_sea({tests::random_cascade(length_m, 128, 36, 300, 0.011, 3)}, {1.0, 1.0});
        const auto map = [&](TimeUs t) {
            return std::make_shared<const SplineMap>(*tests::exact_keyframe(waves, 0, t));
        };
        const Surface sea({{map(0), map(20'000)}}, {1.0, 1.0}, {.reach_m = 0.3},
                          {.height_bound_m = 0.001, .displacement_bound_m = 0.001});
        MapRequest r = request();
        r.width_m = r.height_m = 3.1 * length_m;
        r.time_us = 7'000;
        EXPECT_LE(worst(r, sea, all_values(r, sea)), 0.5 * map_difference_max_m) << length_m;
        r.kind = MapKind::normal;
        const std::vector<float> normals = all_values(r, sea);
        double turned = 0;
        for (std::size_t i = 0; i < normals.size() / 3; ++i)
            if (const Answer answer = sea.answer(point(r, i));
                !(answer.flags & (answer_folded | answer_not_converged)))
                for (std::size_t axis = 0; axis < 3; ++axis)
                    turned = std::max(turned, std::abs(static_cast<double>(normals[3 * i + axis]) -
                                                       answer.normal[axis]));
        // A query is a tenth of a millimetre off where it stops, and bends by as much there.
        EXPECT_LE(turned, 1e-3 + 1e-4 * 0.6 / (length_m / 128)) << length_m;
    }
}

// Naive: the number of a texel is an int, and is undefined where a map has more of them than two thousand million.
TEST(HeightMap, of_the_largest_width_over_a_tile_of_centimetres_is_as_exact) {
    const RealizationPtr waves =
        tests::make_sea({tests::random_cascade(0.1, 256, 9, 40, 0.02, 3)}, {1.0, 1.0});
    const auto map = [&](TimeUs t) {
        return std::make_shared<const SplineMap>(*tests::exact_keyframe(waves, 0, t));
    };
    const Surface sea({{map(0), map(200'000)}}, {1.0, 1.0}, {.reach_m = 0.01},
                      {.height_bound_m = 0.001, .displacement_bound_m = 0.001});
    MapRequest r = request();
    r.width_m = r.height_m = map_width_max_m; // 2560 texels a metre
    EXPECT_LE(worst(r, sea, all_values(r, sea)), map_difference_max_m);
}

// Far steeper than any sea: every third point is close to folding, and a neighbour's solution leads to
// another sheet at one place with several in eight.
TEST(HeightMap, where_the_surface_folds_every_height_and_normal_is_a_querys) {
    const Surface sea = surface(0.05, {2.5, 2.5}, true);
    const MapRequest r = request(), normals = request(MapKind::normal);
    const std::vector<float> heights = all_values(r, sea), turned = all_values(normals, sea);
    int folded = 0;
    for (std::size_t i = 0; i < heights.size(); ++i) {
        const Answer answer = sea.answer(point(r, i));
        folded += (answer.flags & answer_folded) != 0;
        ASSERT_EQ(heights[i], static_cast<float>(answer.height_m)) << i;
        for (std::size_t axis = 0; axis < 3; ++axis)
            ASSERT_EQ(turned[3 * i + axis], static_cast<float>(answer.normal[axis])) << i;
    }
    EXPECT_GE(folded, 30);
}

TEST(HeightMap, choppiness_of_each_axis_counts_for_itself) {
    const Surface sea = surface(0.02, {1.2, 0.0});
    const MapRequest r = request();
    EXPECT_LE(worst(r, sea, all_values(r, sea)), map_difference_max_m);
}

TEST(HeightMap, normals_are_those_of_queries) {
    // Both stop at a residual of 1e-4 m; the sharpest crest here turns by 2e-3 over that.
    const Surface sea = surface(0.02);
    const MapRequest r = request(MapKind::normal);
    const std::vector<float> normals = all_values(r, sea);
    for (std::size_t i = 0; i < normals.size() / 3; ++i) {
        const Answer answer = sea.answer(point(r, i));
        for (std::size_t axis = 0; axis < 3; ++axis)
            ASSERT_NEAR(static_cast<double>(normals[3 * i + axis]), answer.normal[axis], 2e-3);
    }
}

TEST(HeightMap, displacements_are_those_of_undisplaced_grid_points) {
    const Choppiness choppiness{1.2, 0.7};
    const Surface sea = surface(0.02, choppiness);
    const MapRequest r = request(MapKind::displacement);
    const std::vector<float> values = all_values(r, sea);
    for (std::size_t i = 0; i < values.size() / 3; ++i) {
        const QueryPoint at = point(r, i);
        const LagrangianPoint p = sea.at(at.x_m, at.y_m, at.time_us);
        const double expected[3] = {choppiness.x * p.displacement_x,
                                    choppiness.y * p.displacement_y, p.height};
        for (std::size_t axis = 0; axis < 3; ++axis) // single precision, amplitudes below 4 m
            ASSERT_NEAR(static_cast<double>(values[3 * i + axis]), expected[axis], 1e-5);
    }
}

TEST(HeightMap, threads_do_not_change_a_bit) {
    const Surface sea = surface(0.03);
    MapRequest r = request();
    r.columns = 4096; // several chunks
    r.rows = 100;
    MapOptions one, five;
    one.threads = 1;
    five.threads = 5;
    EXPECT_EQ(all_values(r, sea, one), all_values(r, sea, five));
}

std::atomic<int> row_pauses = 0;

TEST(HeightMap,
     who_lets_others_go_first_gets_the_same_map_with_a_pause_a_row_and_more_where_it_folds) {
    MapOptions paused;
    paused.pause = [] { ++row_pauses; };
    for (const bool folds : {false, true}) {
        const Surface sea = surface(0.03, {1.0, 1.0}, folds);
        row_pauses = 0;
        EXPECT_EQ(all_values(request(), sea, paused), all_values(request(), sea));
        // A row of 120 points that are solved one by one has one more.
        EXPECT_EQ(row_pauses, (folds ? 2 : 1) * request().rows);
    }
}

TEST(HeightMap, one_point_is_a_map) {
    const Surface sea = surface(0.02);
    MapRequest r = request();
    r.columns = r.rows = 1;
    EXPECT_LE(worst(r, sea, all_values(r, sea)), map_difference_max_m);
}

TEST(HeightMap, a_reader_that_leaves_stops_the_work) {
    const Surface sea = surface(0.02);
    MapRequest r = request();
    r.columns = r.rows = 4096;
    Result<std::unique_ptr<MapStream>> stream = MapStream::start(r, sea);
    ASSERT_TRUE(stream);
    EXPECT_TRUE((*stream)->next_chunk());
    stream->reset(); // returns: the workers end after the rows they are at
}

// Naive: only between chunks do the workers look whether anybody still wants them. A chunk that is
// under way when the reader leaves is not finished, so it is never said to be ready. Where every
// point is looked at with care a chunk takes a quarter of a second; where the reader has to wait so
// long it may be ready all the same: of a few times once is enough.
TEST(HeightMap, a_reader_that_leaves_stops_the_work_in_the_middle_of_a_chunk) {
    const Surface sea = surface(0.02, {1.0, 1.0}, true);
    MapRequest r = request();
    r.columns = r.rows = 4096;
    bool stopped = false;
    for (int i = 0; i < 10 && !stopped; ++i) {
        std::atomic<int> told = 0;
        MapOptions options;
        options.on_ready = [&] { ++told; };
        Result<std::unique_ptr<MapStream>> stream = MapStream::start(r, sea, options);
        ASSERT_TRUE(stream);
        std::this_thread::sleep_for(
            std::chrono::milliseconds(50)); // the maps are mixed, it is at work
        stream->reset();
        stopped = told == 0;
    }
    EXPECT_TRUE(stopped);
}

// Naive: who waits because enough lies ready is not told that some of it was taken.
TEST(HeightMap, work_that_has_run_as_far_ahead_as_it_may_goes_on_as_it_is_read) {
    const Surface sea = surface(0.02);
    MapRequest r = request(MapKind::displacement);
    r.columns = 4096;
    r.rows = 2 * map_chunks_ahead_max * (map_chunk_values_max / (3 * 4096));
    MapOptions one;
    one.threads = 1;
    Result<std::unique_ptr<MapStream>> stream = MapStream::start(r, sea, one);
    ASSERT_TRUE(stream);
    // Time to run ahead; on a machine too busy for that, the reader just waits a little.
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    const auto patience = std::chrono::steady_clock::now() + std::chrono::minutes(2);
    for (int rows = 0; rows < r.rows;) {
        while (!(*stream)->ready()) {
            ASSERT_LT(std::chrono::steady_clock::now(), patience) << rows << " rows, then nothing";
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        rows += (*stream)->next_chunk()->rows;
    }
    EXPECT_FALSE((*stream)->next_chunk());
}

TEST(HeightMap, the_reader_is_told_when_its_next_rows_are_ready) {
    const Surface sea = surface(0.02);
    MapRequest r = request();
    r.columns = 4096;
    std::mutex mutex;
    std::condition_variable told;
    int calls = 0;
    MapOptions options;
    options.on_ready = [&] {
        const std::scoped_lock lock(mutex);
        ++calls;
        told.notify_all();
    };
    Result<std::unique_ptr<MapStream>> stream = MapStream::start(r, sea, std::move(options));
    ASSERT_TRUE(stream);
    {
        std::unique_lock lock(mutex);
        told.wait(lock, [&] { return calls > 0; });
    }
    EXPECT_TRUE((*stream)->ready());
    EXPECT_TRUE((*stream)->next_chunk());
    stream->reset(); // before what on_ready refers to
}

TEST(HeightMap, a_request_out_of_range_is_an_error_that_names_the_field) {
    const Surface sea = surface(0.02);
    const auto message = [&](auto change) {
        MapRequest r = request();
        change(r);
        const Result<std::unique_ptr<MapStream>> stream = MapStream::start(r, sea);
        return stream ? std::string("accepted") : stream.error().message;
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto has = [](const std::string& text, const char* part) {
        return text.find(part) != std::string::npos;
    };
    EXPECT_TRUE(has(message([](MapRequest& r) { r.columns = 0; }), "columns = 0"));
    EXPECT_TRUE(has(message([](MapRequest& r) { r.columns = 4097; }), "columns = 4097"));
    EXPECT_TRUE(has(message([](MapRequest& r) { r.rows = -1; }), "rows = -1"));
    EXPECT_TRUE(has(message([](MapRequest& r) { r.width_m = 0; }), "width_m = 0"));
    EXPECT_TRUE(has(message([](MapRequest& r) { r.height_m = 2e6; }), "height_m"));
    EXPECT_TRUE(has(message([&](MapRequest& r) { r.width_m = nan; }), "width_m = nan"));
    EXPECT_TRUE(has(message([&](MapRequest& r) { r.x0_m = nan; }), "x0_m = nan"));
    EXPECT_TRUE(has(message([](MapRequest& r) { r.y0_m = -1e10; }), "y0_m"));
    EXPECT_TRUE(has(message([](MapRequest& r) { r.time_us = 200'001; }), "time_us = 200001"));
    EXPECT_FALSE(map_kind("heights"));
    EXPECT_EQ(*map_kind("normal"), MapKind::normal);
}

// Held as a formula: heights alone would stay inside the bound with any one part left out.
TEST(HeightMap, the_stated_bound_holds_height_and_sideways_errors_of_maps_and_codec) {
    const Choppiness choppiness{0.8, 1.5};
    const Surface plain = surface(0.02, choppiness);
    const Surface coded(plain.pairs(), choppiness, plain.folds(),
                        {.cascades = {{{0.001, 0.002, 0.003, 0.004, 0.01}, {.time_m = 0.005}},
                                      {{.east_m = 0.0006}, {.value_m = 0.006}}},
                         .height_bound_m = 0.01,
                         .displacement_bound_m = 0.013});
    // The worst place and moment of all; on a slope of one an error sideways by choppiness times that of
    // a map counts in full. Rates of 0.01 m/s between keyframes 0.2 s apart are half of the values' 4 mm,
    // whose sum of squares is largest at a keyframe.
    const double variance = 1e-6 * (1 + 4 + 9 + 16 + 0.36 + 1.5 * 1.5 * (25 + 36));
    const double stated = 5 * std::sqrt(variance) + 0.01 + 1.5 * 0.013 + map_difference_max_m;
    EXPECT_NEAR(map_height_error_m(coded), stated, 1e-12);
}

} // namespace
} // namespace seaway::sea
