// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/device.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>

#include <fmt/format.h>

#include "base/thread_pool.h"
#include "gpu/commands.h"
#include "gpu/device.h"
#include "gpu/kernel.h"
#include "protocol/limits.h"
#include "protocol/tile_codec.h"
#include "server/device/device_choice.h"
#include "server/device/vulkan_synthesizer.h"
#include "server/simulation/foam_maps.h"
#include "server/simulation/running_sea.h"
#include "shaders/shared/synthesis.h"
#include "shaders/synthesis.h"
#include "tools/bench/accuracy/journal.h"
#include "tools/bench/timing.h"

namespace seaway::bench {

namespace {

using sea::Field;
using sea::FieldSet;
using Clock = std::chrono::steady_clock;

constexpr sea::TimeUs begin_us = 100'000'000;
/// Larger than what caches hold.
constexpr std::size_t moved_bytes = std::size_t{64} << 20;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

struct Row {
    std::string what, fields;
    int size = 0;
    double device_s = 0, wall_s = 0, bytes = 0;
    double best_s = 0; ///< that a Mover takes for as many bytes
};

double median(std::vector<double> seconds) {
    const auto middle = seconds.begin() + static_cast<std::ptrdiff_t>(seconds.size() / 2);
    std::ranges::nth_element(seconds, middle);
    return *middle;
}

/// What memory gives at best: as many bytes as maps have, written by nothing but stores.
class Mover {
  public:
    virtual ~Mover() = default;
    virtual std::string name() const = 0;
    /// That it takes for `bytes`, at most moved_bytes.
    virtual Result<double> seconds(std::size_t bytes) = 0;
};

/// All threads, each its part.
class Stores final : public Mover {
  public:
    std::string name() const override {
        return fmt::format("stores of {} threads", pool_.threads());
    }
    Result<double> seconds(std::size_t bytes) override {
        const Work work{memory_, bytes / static_cast<std::size_t>(pool_.threads())};
        const Phase store{[](const void* context, int chunk, int) {
                              const Work& own = *static_cast<const Work*>(context);
                              std::memset(own.memory.data() +
                                              static_cast<std::size_t>(chunk) * own.part,
                                          chunk + 1, own.part);
                          },
                          &work, pool_.threads()};
        const auto start = Clock::now();
        pool_.run({&store, 1});
        return seconds_since(start);
    }

  private:
    struct Work {
        std::vector<char>& memory;
        std::size_t part;
    };
    ThreadPool pool_;
    mutable std::vector<char> memory_ = std::vector<char>(moved_bytes);
};

/// A kernel that reads as synthesis kernels do, and writes.
class Copies final : public Mover {
  public:
    static Result<std::unique_ptr<Mover>> create(const std::string& pick) {
        std::unique_ptr<Copies> made(new Copies);
        SEAWAY_TRY_LET(made->device_, gpu::Device::create({.pick = pick}));
        gpu::Device& device = *made->device_;
        SEAWAY_TRY_LET(
            made->kernel_,
            gpu::Kernel::create(device, shaders::copy().name, shaders::copy().spirv,
                                {.bindings = {{"source", VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER},
                                              {"Target", VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}},
                                 .push_constant_bytes = 0,
                                 .local_size = {shaders::synthesis_workgroup, 1, 1}}));
        for (gpu::Buffer* buffer : {&made->from_, &made->to_}) {
            SEAWAY_TRY_LET(*buffer, gpu::Buffer::create(device, "copied", moved_bytes,
                                                        gpu::BufferKind::device));
        }
        SEAWAY_TRY_LET(made->view_,
                       gpu::TexelView::create(device, made->from_, VK_FORMAT_R32G32B32A32_SFLOAT,
                                              texel, 0, moved_bytes));
        SEAWAY_TRY_LET(made->bindings_, made->kernel_.bind(device, {gpu::texels(made->view_),
                                                                    gpu::whole(made->to_)}));
        SEAWAY_TRY_LET(made->commands_, gpu::Commands::create(device));
        SEAWAY_TRY(gpu::run_once(
            device, [&](gpu::Commands& commands) { commands.fill(made->from_, 0, moved_bytes); }));
        return std::unique_ptr<Mover>(std::move(made));
    }
    std::string name() const override { return "a copy kernel"; }
    Result<double> seconds(std::size_t bytes) override {
        SEAWAY_TRY(commands_.begin());
        commands_.dispatch(
            kernel_, bindings_, {},
            static_cast<std::uint32_t>(bytes / texel / shaders::synthesis_workgroup));
        commands_.barrier(gpu::Stage::compute, gpu::Stage::host);
        SEAWAY_TRY(commands_.end());
        const auto start = Clock::now();
        SEAWAY_TRY(device_->submit_and_wait(commands_));
        return seconds_since(start);
    }

  private:
    static constexpr std::size_t texel = 16;
    Copies() = default;
    std::unique_ptr<gpu::Device> device_;
    gpu::Kernel kernel_;
    gpu::Buffer from_, to_;
    gpu::TexelView view_;
    gpu::Bindings bindings_;
    gpu::Commands commands_;
};

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
    std::vector<double> device_s = {}, wall_s = {}, best_s = {};
    int ticks = 0;

    /// Each cascade a tick of its foam further on, as a stream goes.
    Result<void> once(const server::RunningSea& sea, bool counts) {
        std::vector<server::KeyframeRequest> requests;
        for (std::size_t c = 0; c < sea.budget.cascades.size(); ++c) {
            const sea::TimeUs tick_us =
                sea::foam_ticks(sea.scene.foam.decay_s, sea.budget.cascades[c].interval_us, 0)
                    .tick_us;
            requests.push_back({static_cast<int>(c), ticks * tick_us, fields});
            if (fields.contains(Field::foam))
                SEAWAY_TRY(foam.walk_near(*device, requests.back().cascade, requests.back().time_us,
                                          sea::foam_ticks_max));
        }
        ++ticks;
        const server::SynthesisCounters before = device->counters();
        const auto start = Clock::now();
        SEAWAY_TRY(foam.synthesize(*device, requests));
        if (counts) {
            const server::SynthesisCounters spent = device->counters() - before;
            wall_s.push_back(seconds_since(start));
            device_s.push_back(spent.device_seconds + spent.foam_seconds);
        }
        return {};
    }
};

Result<void> measure_size(const DeviceOptions& options, server::Synthesizer& device,
                          server::Synthesizer* copying, Mover& mover, int size,
                          std::vector<Row>& rows) {
    SEAWAY_TRY_LET(const server::RunningSeaPtr sea, sea_of(options.scene, size));
    const int cascades = static_cast<int>(sea->realization->cascades.size());
    const FieldSet eight = FieldSet{Field::height, Field::displacement_x, Field::displacement_y,
                                    Field::slope_x, Field::slope_y} |
                           sea::foam_inputs;
    const FieldSet foam{Field::foam};
    std::vector<Measured> all;
    for (server::Synthesizer* one : {&device, copying}) {
        if (one == nullptr)
            continue;
        SEAWAY_TRY(one->set_sea(sea->realization, 1));
        for (const auto& [name, fields] : std::initializer_list<std::pair<const char*, FieldSet>>{
                 {"height", {Field::height}},
                 {"eight", eight},
                 {"all", sea->offered.without(foam)},
                 {"all and foam", sea->offered}})
            all.push_back(
                {{one == &device ? "maps" : "copied", name, size, 0, 0,
                  static_cast<double>(cascades * fields.size() * size * size) * sizeof(float)},
                 fields,
                 one,
                 server::FoamMaps(server::steady_course(sea))});
    }
    // Each runs twice in a row, the second one counts: what the one before it left in caches is not its own.
    for (int round = -1; round < options.rounds; ++round)
        for (Measured& one : all) {
            for (const bool second : {false, true})
                SEAWAY_TRY(one.once(*sea, second && round >= 0));
            SEAWAY_TRY(mover.seconds(static_cast<std::size_t>(one.row.bytes)));
            SEAWAY_TRY_LET(const double best_s,
                           mover.seconds(static_cast<std::size_t>(one.row.bytes)));
            one.best_s.push_back(best_s);
        }
    for (Measured& one : all) {
        one.row.device_s = median(one.device_s);
        one.row.wall_s = median(one.wall_s);
        one.row.best_s = median(one.best_s);
        rows.push_back(one.row);
    }
    return {};
}

/// All fields of a keyframe of the longest tile, as a subscriber of the whole budget takes them.
Result<Row> measure_encode(const DeviceOptions& options, server::Synthesizer& device, int size) {
    SEAWAY_TRY_LET(const server::RunningSeaPtr sea, sea_of(options.scene, size));
    SEAWAY_TRY(device.set_sea(sea->realization, 1));
    const FieldSet fields = sea->sampler_fields();
    const server::KeyframeRequest request{0, begin_us, fields};
    SEAWAY_TRY_LET(const auto made, device.synthesize({&request, 1}));
    const std::vector<float> bounds =
        sea::codec_bounds(sea->budget, fields, 0, sea->budget.codec_error_m);
    std::vector<double> seconds;
    for (int i = 0; i <= options.rounds; ++i) {
        const auto start = Clock::now();
        std::size_t f = 0;
        for (const Field field : fields)
            SEAWAY_TRY(protocol::encode_tile(std::as_const(*made[0]).plane(field), {size, size},
                                             static_cast<std::size_t>(size), bounds[f++]));
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

Result<Row> measure_start(const DeviceOptions& options, int size, bool cold) {
    SEAWAY_TRY_LET(const server::RunningSeaPtr sea, sea_of(options.scene, size));
    for (const auto& [variable, value] : std::initializer_list<std::pair<const char*, const char*>>{
             {"MESA_SHADER_CACHE_DISABLE", "true"}, {"__GL_SHADER_DISK_CACHE", "0"}}) {
        if (cold)
            setenv(variable, value, 1);
        else
            unsetenv(variable);
    }
    const auto start = Clock::now();
    SEAWAY_TRY_LET(const auto made, server::make_synthesizer(options.device));
    SEAWAY_TRY(made->set_sea(sea->realization, 1));
    return Row{"start", cold ? "cold" : "warm", size, 0, seconds_since(start), 0};
}

void print(const std::string& device, const std::string& mover, double bytes_per_s,
           const std::vector<Row>& rows, std::ofstream& file) {
    fmt::print(
        "{}; best is {}, {:.1f} GB/s of memory\n\n{:<10} {:>5} {:<13} {:>10} {:>10} {:>8} {:>8} "
        "{:>8} {:>8}\n",
        device, mover, 1e-9 * bytes_per_s, "", "size", "fields", "device ms", "wall ms", "MB",
        "best ms", "best %", "memory %");
    file << "what,size,fields,device_ms,wall_ms,megabytes,best_ms,best_pct,memory_pct\n";
    for (const Row& row : rows) {
        const double per_cent = row.device_s > 0 ? 100 / row.device_s : 0.0;
        const double best = per_cent * row.best_s, memory = per_cent * row.bytes / bytes_per_s;
        fmt::print("{:<10} {:>5} {:<13} {:>10.3f} {:>10.3f} {:>8.2f} {:>8.3f} {:>8.1f} {:>8.1f}\n",
                   row.what, row.size, row.fields, 1e3 * row.device_s, 1e3 * row.wall_s,
                   1e-6 * row.bytes, 1e3 * row.best_s, best, memory);
        file << fmt::format("{},{},{},{:.4g},{:.4g},{:.4g},{:.4g},{:.3g},{:.3g}\n", row.what,
                            row.size, row.fields, 1e3 * row.device_s, 1e3 * row.wall_s,
                            1e-6 * row.bytes, 1e3 * row.best_s, best, memory);
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

} // namespace

Result<void> run_device(const DeviceOptions& options) {
    if (options.sizes.empty())
        return Error{"--sizes: names none"};
    SEAWAY_TRY_LET(const server::DeviceChoice choice, server::choose_device(options.device));
    if (options.retune)
        SEAWAY_TRY(retune(options, choice));
    std::vector<Row> rows;
    std::unique_ptr<Mover> mover;
    std::unique_ptr<server::Synthesizer> copying;
    const int first = options.sizes.front();
    if (choice.vulkan) {
        const std::string pick = std::to_string(*choice.vulkan);
        for (const bool cold : {true, false}) {
            SEAWAY_TRY_LET(const Row start, measure_start(options, first, cold));
            rows.push_back(start);
        }
        SEAWAY_TRY_LET(mover, Copies::create(pick));
        SEAWAY_TRY_LET(copying, server::make_vulkan_synthesizer({.device = pick, .staged = true}));
    } else {
        SEAWAY_TRY_LET(const Row start, measure_start(options, first, false));
        rows.push_back(start);
        mover = std::make_unique<Stores>();
    }
    SEAWAY_TRY_LET(const Row bandwidth, measure_bandwidth(*mover, options.rounds));
    rows.push_back(bandwidth);
    SEAWAY_TRY_LET(const auto device, server::make_synthesizer(choice));
    for (const int size : options.sizes)
        SEAWAY_TRY(measure_size(options, *device, copying.get(), *mover, size, rows));
    SEAWAY_TRY_LET(
        const Row encoded,
        measure_encode(options, *device, std::min(first, protocol::limits::tile_side_max)));
    rows.push_back(encoded);
    std::error_code failed;
    std::filesystem::create_directories(options.out, failed);
    const std::string path = options.out + "/device.csv";
    std::ofstream file(path);
    file << fmt::format("# seaway-bench device on {}; {}; commit {}\n", device->description(),
                        machine_name(), commit_name());
    print(device->description(), mover->name(), bandwidth.bytes / bandwidth.best_s, rows, file);
    return file.flush() ? Result<void>() : Result<void>(Error{"cannot write " + path});
}

} // namespace seaway::bench
