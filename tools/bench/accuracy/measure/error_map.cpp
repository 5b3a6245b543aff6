// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/accuracy/measure/error_map.h"

#include <string>
#include <vector>

#include <fmt/format.h>

#include "base/whole_file.h"
#include "tools/bench/accuracy/truth/in_threads.h"
#include "tools/bench/accuracy/truth/points.h"

namespace seaway::bench {

namespace {

constexpr int map_side = 96;
constexpr double side_m = 240.0;

double coordinate(int index) {
    return side_m * index / (map_side - 1);
}

/// [y][x]
Result<std::vector<double>> heights(const sea::Scene& scene, const Configuration& configuration,
                                    Devices& devices, sea::TimeUs time_us) {
    SEAWAY_TRY_LET(const auto sea, ConfiguredSea::create(scene, configuration, devices));
    SEAWAY_TRY(sea->go_to(time_us));
    std::vector<double> all(map_side * map_side);
    in_threads(map_side, [&](int y) {
        for (int x = 0; x < map_side; ++x)
            all[static_cast<std::size_t>(y * map_side + x)] =
                sea->answer({coordinate(x), coordinate(y), time_us}).height_m;
    });
    return all;
}

} // namespace

Result<void> write_error_map(const sea::Scene& scene, const std::string& path, Devices& devices) {
    Configuration engine = balanced(scene);
    engine.space = SpaceRule::bilinear;
    engine.time = TimeRule::linear;
    engine.format = MapFormat::f16;
    engine.codec_error_m = 0.0;
    engine.fixed_point_steps = 3;
    Configuration exactly = clean(scene);
    exactly.evaluator = Evaluator::direct_sum;
    const sea::TimeUs time_us = sample_time_us(1);
    SEAWAY_TRY_LET(const auto truth, heights(scene, exactly, devices, time_us));
    SEAWAY_TRY_LET(const auto ours, heights(scene, balanced(scene), devices, time_us));
    SEAWAY_TRY_LET(const auto theirs, heights(scene, engine, devices, time_us));
    std::string rows = "x_m,y_m,height_m,balanced_m,engine_m\n";
    for (std::size_t i = 0; i < truth.size(); ++i)
        rows += fmt::format("{:.2f},{:.2f},{:.5f},{:.6f},{:.6f}\n",
                            coordinate(static_cast<int>(i) % map_side),
                            coordinate(static_cast<int>(i) / map_side), truth[i],
                            ours[i] - truth[i], theirs[i] - truth[i]);
    if (const Result<void> written = write_whole_file(path, rows); !written)
        return Error{fmt::format("{}: {}", path, written.error().message)};
    return {};
}

} // namespace seaway::bench
