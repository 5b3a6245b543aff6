// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/device.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>

#include <fmt/format.h>

#include "base/elapsed.h"
#include "base/quantile.h"
#include "protocol/limits.h"
#include "protocol/tile_codec.h"
#include "server/device/device_choice.h"
#include "server/device/vulkan_synthesizer.h"
#include "server/simulation/foam_maps.h"
#include "server/simulation/readback.h"
#include "server/simulation/running_sea.h"
#include "tools/bench/accuracy/journal.h"
#include "tools/bench/accuracy/result_file.h"
#include "tools/bench/timing.h"
#include "tools/bench/yardsticks/arithmetic.h"
#include "tools/bench/yardsticks/fftw.h"
#include "tools/bench/yardsticks/mover.h"

namespace seaway::bench {

namespace {

using sea::Field;
using sea::FieldSet;

constexpr sea::TimeUs begin_us = 100'000'000;

struct Row {
    std::string what, fields;
    int size = 0;
    double device_s = 0, wall_s = 0, bytes = 0;
    double best_s = 0;     ///< that a Mover takes for as many bytes
    double operations = 0; ///< of its transforms, as they are counted (transform_operations)
};

/// What is measured, and what it is held against.
struct Bench {
    std::unique_ptr<server::Synthesizer> device;
    std::unique_ptr<server::Synthesizer> copying; ///< null: the native device
    std::unique_ptr<Mover> mover, readback;       ///< readback: null likewise
    std::unique_ptr<Arithmetic> arithmetic;
    std::unique_ptr<Fftw> fftw; ///< null: it is not there
    double bytes_per_s = 0, operations_per_s = 0;
};

/// By which transforms are compared: 5 N log2 N of complex numbers, half of it of real ones. Bands and fields that share a
/// source take fewer, evolution and foam come on top.
double transform_operations(int size) {
    const double points = static_cast<double>(size) * size;
    return 2.5 * points * std::log2(points);
}

/// The scene with all effects, on tiles of so many points.
Result<server::RunningSeaPtr> sea_of(const std::string& path, int size) {
    SEAWAY_TRY_LET(sea::Scene scene, sea::read_scene(path));
    for (sea::CascadeSpec& cascade : scene.cascades)
        cascade.size = size;
    scene.effects = {.choppy = true, .slopes = true, .foam = true};
    return server::make_running_sea(scene, 1);
}

/// One list of fields on one device, measured round by round.
struct Measured {
    Row row;
    FieldSet fields;
    server::Synthesizer* device;
    server::FoamMaps foam;
    server::Readback readback = server::Readback::exact;
    std::vector<double> device_s = {}, wall_s = {}, foam_s = {}, best_s = {};
    int ticks = 0;

    /// Each cascade a tick of its foam further on, as a stream goes.
    Result<void> once(const server::RunningSea& sea, bool counts) {
        std::vector<server::KeyframeRequest> requests;
        std::vector<std::vector<float>> bounds; // which the requests point to
        bounds.reserve(sea.budget.cascades.size());
        for (std::size_t c = 0; c < sea.budget.cascades.size(); ++c) {
            const sea::TimeUs tick_us =
                sea::foam_ticks(sea.scene.foam.decay_s, sea.budget.cascades[c].interval_us, 0)
                    .tick_us;
            requests.push_back({static_cast<int>(c), ticks * tick_us, fields});
            requests.back().rounding = bounds.emplace_back(
                server::rounding_bounds(sea.budget, fields, static_cast<int>(c), readback));
            if (fields.contains(Field::foam))
                SEAWAY_TRY(foam.walk_near(*device, requests.back().cascade, requests.back().time_us,
                                          sea::foam_ticks_max));
        }
        ++ticks;
        const server::SynthesisCounters before = device->counters();
        const auto start = std::chrono::steady_clock::now();
        SEAWAY_TRY(foam.synthesize(*device, requests));
        if (counts) {
            const server::SynthesisCounters spent = device->counters() - before;
            wall_s.push_back(seconds_since(start));
            device_s.push_back(spent.device_seconds + spent.foam_seconds);
            foam_s.push_back(spent.foam_seconds);
            row.operations = static_cast<double>(spent.transforms) * transform_operations(row.size);
        }
        return {};
    }
};

/// One row each, by what it is called.
std::vector<Measured> lists_of(const Bench& bench, const server::RunningSeaPtr& sea, int size) {
    const int cascades = static_cast<int>(sea->realization->cascades.size());
    const FieldSet eight = FieldSet{Field::height, Field::displacement_x, Field::displacement_y,
                                    Field::slope_x, Field::slope_y} |
                           sea::foam_inputs;
    const FieldSet foam{Field::foam}, all = sea->offered.without(foam);
    std::vector<Measured> lists;
    const auto add = [&](const char* what, const char* name, FieldSet fields,
                         server::Synthesizer* device,
                         server::Readback readback = server::Readback::exact) {
        lists.push_back(
            {{what, name, size, 0, 0,
              static_cast<double>(cascades * fields.size() * size * size) * sizeof(float)},
             fields,
             device,
             server::FoamMaps(server::steady_course(sea)),
             readback});
    };
    for (server::Synthesizer* one : {bench.device.get(), bench.copying.get()}) {
        if (one == nullptr)
            continue;
        const char* what = one == bench.device.get() ? "maps" : "copied";
        add(what, "height", {Field::height}, one);
        add(what, "eight", eight, one);
        add(what, "all", all, one);
        add(what, "all and foam", sea->offered, one);
    }
    add("maps", "strains", sea::foam_inputs, bench.device.get());
    add("maps", "foam", foam, bench.device.get());
    if (bench.copying) {
        add("rounded", "eight", eight, bench.copying.get(), server::Readback::rounded);
        add("rounded", "all", all, bench.copying.get(), server::Readback::rounded);
    }
    return lists;
}

/// A tick of foam of all tiles: by the device's clock alone, as strains travel and foam's keyframe has none; or, where there is
/// no such clock, what a keyframe of it takes more than one of the strains that it is made of.
Row foam_tick(std::span<const Measured> lists, int size) {
    const auto named = [&](std::string_view name) {
        return *std::ranges::find_if(lists, [&](const Measured& one) {
            return one.row.what == "maps" && one.row.fields == name;
        });
    };
    const Measured strains = named("strains"), foam = named("foam");
    std::vector<double> device_s, wall_s;
    for (std::size_t i = 0; i < foam.wall_s.size(); ++i) {
        const bool clocked = foam.foam_s[i] > 0;
        device_s.push_back(clocked ? foam.foam_s[i] : foam.device_s[i] - strains.device_s[i]);
        wall_s.push_back(clocked ? 0 : foam.wall_s[i] - strains.wall_s[i]);
    }
    return {"foam", "a tick", size, median(device_s), median(wall_s), foam.row.bytes};
}

/// Of the bytes of a row: what they take out of a device's memory, and half of them.
Result<void> measure_readback(const DeviceOptions& options, Mover& readback, const Row& of,
                              std::vector<Row>& rows) {
    for (const auto& [name, share] :
         std::initializer_list<std::pair<const char*, double>>{{"floats", 1.0}, {"16 bits", 0.5}}) {
        std::vector<double> seconds;
        for (int round = -1; round < options.rounds; ++round) {
            SEAWAY_TRY_LET(const double once_s,
                           readback.seconds(static_cast<std::size_t>(share * of.bytes)));
            if (round >= 0)
                seconds.push_back(once_s);
        }
        rows.push_back({"readback", name, of.size, 0, median(seconds), share * of.bytes});
    }
    return {};
}

/// As many transforms as a row has, and nothing before or after them.
Result<void> measure_fftw(const DeviceOptions& options, Fftw& fftw, const Row& of,
                          std::vector<Row>& rows) {
    const int count = static_cast<int>(std::lround(of.operations / transform_operations(of.size)));
    std::vector<double> seconds;
    for (int round = -1; round < options.rounds; ++round) {
        SEAWAY_TRY_LET(const double once_s, fftw.seconds(of.size, count));
        if (round >= 0)
            seconds.push_back(once_s);
    }
    rows.push_back({"fftw", of.fields, of.size, median(seconds), median(seconds), of.bytes, 0,
                    count * transform_operations(of.size)});
    return {};
}

/// In parts, as messages carry it.
Result<void> encode(std::span<const float> map, int size, float bound) {
    const int side = std::min(size, protocol::limits::tile_side_max);
    const auto stride = static_cast<std::size_t>(size);
    for (int y = 0; y < size; y += side)
        for (int x = 0; x < size; x += side)
            SEAWAY_TRY(protocol::encode_tile(map.subspan(static_cast<std::size_t>(y * size + x)),
                                             {side, side}, stride, bound));
    return {};
}

/// All fields of a keyframe of the longest tile, as a subscriber of the whole budget takes them.
Result<Row> measure_encode(const DeviceOptions& options, const server::RunningSea& sea,
                           server::Synthesizer& device, int size) {
    const FieldSet fields = sea.sampler_fields();
    const server::KeyframeRequest request{0, begin_us, fields};
    SEAWAY_TRY_LET(const auto made, device.synthesize({&request, 1}));
    const std::vector<float> bounds =
        sea::codec_bounds(sea.budget, fields, 0, sea.budget.codec_error_m);
    std::vector<double> seconds;
    for (int i = 0; i <= options.rounds; ++i) {
        const auto start = std::chrono::steady_clock::now();
        std::size_t f = 0;
        for (const Field field : fields)
            SEAWAY_TRY(encode(std::as_const(*made[0]).plane(field), size, bounds[f++]));
        if (i > 0)
            seconds.push_back(seconds_since(start));
    }
    return Row{"encode",
               "a sampler's",
               size,
               0,
               median(seconds),
               static_cast<double>(fields.size() * size * size) * sizeof(float)};
}

Result<void> measure_size(const DeviceOptions& options, Bench& bench, int size,
                          std::vector<Row>& rows) {
    SEAWAY_TRY_LET(const server::RunningSeaPtr sea, sea_of(options.scene, size));
    for (server::Synthesizer* one : {bench.device.get(), bench.copying.get()})
        if (one != nullptr)
            SEAWAY_TRY(one->set_sea(sea->realization, 1));
    std::vector<Measured> lists = lists_of(bench, sea, size);
    // Each runs twice in a row, the second one counts: what the one before it left in caches is not its own.
    for (int round = -1; round < options.rounds; ++round)
        for (Measured& one : lists) {
            if (bench.arithmetic->rests())
                SEAWAY_TRY(bench.arithmetic->operations_per_s());
            for (const bool second : {false, true})
                SEAWAY_TRY(one.once(*sea, second && round >= 0));
            const auto bytes = std::min(static_cast<std::size_t>(one.row.bytes), moved_bytes);
            SEAWAY_TRY(bench.mover->seconds(bytes));
            SEAWAY_TRY_LET(const double best_s, bench.mover->seconds(bytes));
            one.best_s.push_back(best_s * one.row.bytes / static_cast<double>(bytes));
        }
    for (Measured& one : lists) {
        one.row.device_s = median(one.device_s);
        one.row.wall_s = median(one.wall_s);
        one.row.best_s = median(one.best_s);
        rows.push_back(one.row);
    }
    rows.push_back(foam_tick(lists, size));
    for (const Measured& one : lists) {
        if (one.row.what != "maps" || (one.row.fields != "eight" && one.row.fields != "all"))
            continue;
        if (bench.readback && one.row.fields == "all" &&
            one.row.bytes <= static_cast<double>(moved_bytes))
            SEAWAY_TRY(measure_readback(options, *bench.readback, one.row, rows));
        if (bench.fftw)
            SEAWAY_TRY(measure_fftw(options, *bench.fftw, one.row, rows));
    }
    SEAWAY_TRY_LET(const Row encoded, measure_encode(options, *sea, *bench.device, size));
    rows.push_back(encoded);
    return {};
}

Result<Row> measure_start(const DeviceOptions& options, int size, bool cold) {
    SEAWAY_TRY_LET(const server::RunningSeaPtr sea, sea_of(options.scene, size));
    for (const auto& [variable, value] : std::initializer_list<std::pair<const char*, const char*>>{
             {"MESA_SHADER_CACHE_DISABLE", "true"}, {"__GL_SHADER_DISK_CACHE", "0"}}) {
        if (cold)
            setenv(variable, value, 1);
        else
            unsetenv(variable);
    }
    const auto start = std::chrono::steady_clock::now();
    SEAWAY_TRY_LET(const auto made, server::make_synthesizer(options.device));
    SEAWAY_TRY(made->set_sea(sea->realization, 1));
    return Row{"start", cold ? "cold" : "warm", size, 0, seconds_since(start), 0};
}

void print(const Bench& bench, const std::vector<Row>& rows, std::string& csv) {
    fmt::print("{}{}\nbest is {}, {:.1f} GB/s of memory, and {}, {:.0f} GFLOP/s{}{}\n\n",
               bench.device->description(),
               bench.arithmetic->rests() ? "; each row after a hundredth of a second of sums" : "",
               bench.mover->name(), 1e-9 * bench.bytes_per_s, bench.arithmetic->name(),
               1e-9 * bench.operations_per_s, bench.fftw ? "; " : "",
               bench.fftw ? bench.fftw->name() : "; FFTW is not there, nothing is held against it");
    fmt::print("{:<10} {:>5} {:<13} {:>10} {:>10} {:>8} {:>8} {:>8} {:>8} {:>9} {:>8}\n", "",
               "size", "fields", "device ms", "wall ms", "MB", "best ms", "best %", "memory %",
               "GFLOP/s", "arith. %");
    csv += "what,size,fields,device_ms,wall_ms,megabytes,best_ms,best_pct,memory_pct,gflop_per_s,"
           "arithmetic_pct\n";
    for (const Row& row : rows) {
        const double per_s = row.device_s > 0 ? 1 / row.device_s : 0.0;
        const double best = 100 * per_s * row.best_s;
        const double memory = 100 * per_s * row.bytes / bench.bytes_per_s;
        const double rate = row.what == "arithmetic" ? row.operations : per_s * row.operations;
        // FFTW runs on this processor, whatever is measured.
        const double arithmetic = row.what == "fftw" ? 0 : 100 * rate / bench.operations_per_s;
        fmt::print("{:<10} {:>5} {:<13} {:>10.3f} {:>10.3f} {:>8.2f} {:>8.3f} {:>8.1f} {:>8.1f} "
                   "{:>9.2f} {:>8.2f}\n",
                   row.what, row.size, row.fields, 1e3 * row.device_s, 1e3 * row.wall_s,
                   1e-6 * row.bytes, 1e3 * row.best_s, best, memory, 1e-9 * rate, arithmetic);
        csv +=
            fmt::format("{},{},{},{:.4g},{:.4g},{:.4g},{:.4g},{:.3g},{:.3g},{:.4g},{:.3g}\n",
                        row.what, row.size, row.fields, 1e3 * row.device_s, 1e3 * row.wall_s,
                        1e-6 * row.bytes, 1e3 * row.best_s, best, memory, 1e-9 * rate, arithmetic);
    }
}

Result<Row> measure_bandwidth(Mover& mover, int rounds) {
    std::vector<double> seconds;
    for (int round = -1; round < rounds; ++round) {
        SEAWAY_TRY_LET(const double once_s, mover.seconds(moved_bytes));
        if (round >= 0)
            seconds.push_back(once_s);
    }
    return Row{
        "bandwidth",    "", 0, median(seconds), median(seconds), static_cast<double>(moved_bytes),
        median(seconds)};
}

/// The fastest of some tries: a thread that wakes late computes nothing for a while. Its operations are those of a second.
Result<Row> measure_arithmetic(Arithmetic& arithmetic, int rounds) {
    double best = 0;
    for (int round = -1; round < rounds; ++round) {
        SEAWAY_TRY_LET(const double rate, arithmetic.operations_per_s());
        best = std::max(best, rate);
    }
    return Row{"arithmetic", "", 0, 0, 0, 0, 0, best};
}

/// Of the kernels of all sizes, for whoever starts later on this device.
Result<void> retune(const DeviceOptions& options, const server::DeviceChoice& choice) {
    if (!choice.vulkan)
        return Error{"--retune: the native device has one design of kernels"};
    server::KernelTuning tuning = server::usual_tuning();
    if (tuning.file.empty())
        return Error{"--retune: neither XDG_CACHE_HOME nor HOME says where to remember it"};
    tuning.measure = server::Measure::always;
    tuning.again = true;
    SEAWAY_TRY_LET(const auto device,
                   server::make_vulkan_synthesizer(
                       {.device = std::to_string(*choice.vulkan), .tuning = tuning}));
    for (const int size : options.sizes) {
        SEAWAY_TRY_LET(const server::RunningSeaPtr sea, sea_of(options.scene, size));
        SEAWAY_TRY(device->set_sea(sea->realization, 1));
    }
    fmt::print("{}: {}\n", tuning.file, device->description());
    return {};
}

/// With the rows of what does not hang on a size.
Result<Bench> open(const DeviceOptions& options, const server::DeviceChoice& choice,
                   std::vector<Row>& rows) {
    Bench bench;
    const int first = options.sizes.front();
    if (choice.vulkan) {
        const std::string pick = std::to_string(*choice.vulkan);
        // One that does not count leaves the driver's cache of kernels, and which design is the fastest.
        SEAWAY_TRY(measure_start(options, first, false));
        for (const bool cold : {true, false}) {
            SEAWAY_TRY_LET(const Row start, measure_start(options, first, cold));
            rows.push_back(start);
        }
        SEAWAY_TRY_LET(bench.mover, device_mover(pick));
        SEAWAY_TRY_LET(bench.readback, readback_mover(pick));
        SEAWAY_TRY_LET(bench.arithmetic, device_arithmetic(pick));
        SEAWAY_TRY_LET(bench.copying,
                       server::make_vulkan_synthesizer(
                           {.device = pick, .staged = true, .tuning = server::usual_tuning()}));
    } else {
        SEAWAY_TRY_LET(const Row start, measure_start(options, first, false));
        rows.push_back(start);
        bench.mover = native_mover();
        bench.arithmetic = native_arithmetic();
    }
    if (Result<std::unique_ptr<Fftw>> fftw = Fftw::open())
        bench.fftw = std::move(*fftw);
    SEAWAY_TRY_LET(const Row bandwidth, measure_bandwidth(*bench.mover, options.rounds));
    SEAWAY_TRY_LET(const Row arithmetic, measure_arithmetic(*bench.arithmetic, options.rounds));
    bench.bytes_per_s = bandwidth.bytes / bandwidth.best_s;
    bench.operations_per_s = arithmetic.operations;
    rows.insert(rows.end(), {bandwidth, arithmetic});
    SEAWAY_TRY_LET(bench.device, server::make_synthesizer(choice));
    return bench;
}

} // namespace

Result<void> run_device(const DeviceOptions& options) {
    if (options.sizes.empty())
        return Error{"--sizes: names none"};
    SEAWAY_TRY_LET(const server::DeviceChoice choice, server::choose_device(options.device));
    const std::string path = options.out + "/device.csv";
    SEAWAY_TRY(check_result(path));
    if (options.retune)
        SEAWAY_TRY(retune(options, choice));
    std::vector<Row> rows;
    SEAWAY_TRY_LET(Bench bench, open(options, choice, rows));
    for (const int size : options.sizes)
        SEAWAY_TRY(measure_size(options, bench, size, rows));
    std::string csv = fmt::format(
        "# seaway-bench device on {}; {}; {}; commit {}\n", bench.device->description(),
        bench.fftw ? bench.fftw->name() : "without FFTW", machine_name(), commit_name());
    print(bench, rows, csv);
    return write_result(path, csv);
}

} // namespace seaway::bench
