// SPDX-License-Identifier: Apache-2.0
// The tile codec against those of libraries, on the same maps at the same bound, interleaved in one process; prints CSV.
//
//     bench_codec [--error 0.01] [--repeats 15]
//
// Work: heights and both displacements of three cascades of 256 x 256 (1000, 200 and 40 m, deep water) at winds of 8 and
// 20 m/s, one map at a time. Bits a sample are the mean of the three fields; speeds are medians over all maps of a codec, in
// MB of floats a second of one core. `largest_error_m` is measured: half precision knows no bound, and keeps one only
// where the sea is low enough for it. On a shared machine only ratios of speeds mean much. Exit code 1: ours has broken its
// bound, or takes more at 1 cm than it was accepted with.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "base/command_line.h"
#include "base/elapsed.h"
#include "base/quantile.h"
#include "sea/native/native_runner.h"
#include "sea/scene/scene.h"
#include "tests/bench/codec_contenders.h"
#include "tests/bench/contenders.h"

namespace seaway::bench {
namespace {

constexpr int map_side = 256;
const sea::FieldSet three_fields{sea::Field::height, sea::Field::displacement_x,
                                 sea::Field::displacement_y};

struct Tile {
    int wind_mps;
    std::size_t cascade;
    std::vector<float> map;
};

sea::Realization sea_of(int wind_mps) {
    const std::string text = fmt::format(R"(
[sea]
seed = 5
[[sea.system]]
type = "wind"
spectrum = "jonswap"
wind_speed_10m_mps = {}
from_deg = 250
fetch_m = 300e3
spreading = "hasselmann"
[[cascade]]
length_m = 1000.0
size = 256
[[cascade]]
length_m = 200.0
size = 256
[[cascade]]
length_m = 40.0
size = 256
[accuracy]
height_error_m = 0.05
)",
                                         wind_mps);
    return *sea::realize(*sea::parse_scene(text, "bench_codec", "."));
}

std::vector<Tile> tiles() {
    std::vector<Tile> all;
    for (const int wind_mps : {8, 20}) {
        const sea::Realization sea = sea_of(wind_mps);
        for (std::size_t c = 0; c < sea.cascades.size(); ++c) {
            auto cascade = *sea::NativeTransform::create(sea.cascades[c], sea.choppiness);
            std::vector<float> planes(std::size_t{3} * map_side * map_side);
            const sea::NativeTask task{&cascade, 12'345'678, three_fields, planes};
            sea::NativeRunner(1).run({&task, 1});
            for (std::size_t f = 0; f < 3; ++f)
                all.push_back(
                    {wind_mps,
                     c,
                     {planes.begin() + static_cast<std::ptrdiff_t>(f * map_side * map_side),
                      planes.begin() +
                          static_cast<std::ptrdiff_t>((f + 1) * map_side * map_side)}});
        }
    }
    return all;
}

/// Of heights and displacements at 1 cm, as measured when the codec was chosen: the mean of the cascades, and the worst.
constexpr double mean_bits_max = 2.4;
constexpr double worst_bits_max = 3.1;

struct Tally {
    std::map<std::pair<int, std::size_t>, double> bits; ///< of a sample, by wind and cascade
    std::vector<double> encode_ms, decode_ms;
    double largest_error_m = 0;
};

void code(const Codec& codec, const Tile& tile, float error_m, bool first, Tally& tally) {
    const double start = 1e3 * process_cpu_seconds();
    const std::vector<std::uint8_t> bytes = codec.encode(tile.map, map_side, error_m);
    const double between = 1e3 * process_cpu_seconds();
    const std::vector<float> back = codec.decode(bytes, map_side, error_m);
    tally.decode_ms.push_back(1e3 * process_cpu_seconds() - between);
    tally.encode_ms.push_back(between - start);
    if (!first)
        return;
    tally.bits[{tile.wind_mps, tile.cascade}] +=
        8.0 * static_cast<double>(bytes.size()) / (map_side * map_side) / 3;
    for (std::size_t i = 0; i < back.size(); ++i)
        tally.largest_error_m =
            std::max(tally.largest_error_m, std::abs(static_cast<double>(back[i]) - tile.map[i]));
}

struct Bits {
    double mean = 0;
    double worst = 0;
};

Bits bits_of(const Tally& tally) {
    Bits all;
    for (const auto& [key, bits] : tally.bits) {
        all.mean += bits / static_cast<double>(tally.bits.size());
        all.worst = std::max(all.worst, bits);
    }
    return all;
}

void print(const Codec& codec, const Tally& tally) {
    std::string line = codec.name;
    for (const auto& [key, bits] : tally.bits)
        line += fmt::format(",{:.2f}", bits);
    const auto mb_a_s = [](const std::vector<double>& ms) {
        return map_side * map_side * sizeof(float) * 1e-3 / median(ms);
    };
    const Bits bits = bits_of(tally);
    fmt::print("{},{:.2f},{:.2f},{:.0f},{:.0f},{:.4f}\n", line, bits.mean, bits.worst,
               mb_a_s(tally.encode_ms), mb_a_s(tally.decode_ms), tally.largest_error_m);
}

/// False: see above.
bool compare(float error_m, int repeats) {
    const std::vector<Tile> all = tiles();
    const std::vector<Codec> every = codecs();
    std::vector<Tally> tallies(every.size());
    for (int repeat = 0; repeat < repeats; ++repeat)
        for (const Tile& tile : all)
            for (std::size_t c = 0; c < every.size(); ++c)
                code(every[c], tile, error_m, repeat == 0, tallies[c]);
    for (std::size_t c = 0; c < every.size(); ++c)
        print(every[c], tallies[c]);
    const Bits own = bits_of(tallies.front());
    return tallies.front().largest_error_m <= double{error_m} &&
           (error_m < 0.01f || (own.mean <= mean_bits_max && own.worst <= worst_bits_max));
}

} // namespace
} // namespace seaway::bench

int main(int argc, char** argv) {
    using namespace seaway;
    CommandLine line("bench_codec", "The tile codec against those of libraries");
    double error_m = 0.01;
    int repeats = 15;
    line.option("--error", error_m).between(1e-6, 10.0);
    line.option("--repeats", repeats).between(1, 100'000);
    const Result<CommandLine::Next> next = line.read(argc, argv);
    if (!next) {
        fmt::print(stderr, "bench_codec: {}\n", next.error().message);
        return 2;
    }
    if (*next == CommandLine::Next::leave)
        return 0;
    fmt::print("# bound {} m, {} repeats; bits a sample by wind (m/s) and cascade\n", error_m,
               repeats);
    fmt::print("codec,8_c0,8_c1,8_c2,20_c0,20_c1,20_c2,mean,worst,encode_mb_s,decode_mb_s,largest_"
               "error_m\n");
    return bench::compare(static_cast<float>(error_m), repeats) ? 0 : 1;
}
