// SPDX-License-Identifier: Apache-2.0
// Vulkan kernels against two FFTW programs, interleaved in one process; prints a table or CSV.
//
//     bench_kernels [--sizes 128,256,512] [--repeats 40] [--reach SHARE] [--device auto] [--csv]
//     bench_kernels --start [--sizes ...]
//
// `--start` measures CPU time until a size is compiled and checked; for a cold start set
// MESA_SHADER_CACHE_DISABLE=true. Else the work is three cascades of one size, eight fields
// (height, two displacements, two slopes, three strains). `--reach` is the radius of the disc of
// modes in use as a share of Nyquist: 2 uses all of them, 0.6 those of a sea made from spectra.
//
//   maps DESIGN:       submit to eight maps a cascade in device memory
//   vulkan keyframes:  Synthesizer::synthesize, with the copy to keyframes
//   plain, strongest:  the FFTW programs of fftw_yardstick.h, with eight maps a cascade at the end;
//                      "unsplit": two fields interleaved, as the transform leaves them
//
// Medians of interleaved repeats: on a shared machine only the ratios mean much. CPU time, of all
// threads together, is the steadier of the two there.
#include <cstdio>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "base/command_line.h"
#include "base/elapsed.h"
#include "base/quantile.h"
#include "server/device/vulkan_batch.h"
#include "server/device/vulkan_synthesizer.h"
#include "tests/bench/contenders.h"
#include "tests/bench/fftw_yardstick.h"
#include "tests/sea/native/random_modes.h"

namespace seaway::bench {
namespace {

using sea::Field;

struct Settings {
    std::vector<int> sizes{128, 256, 512};
    int repeats = 40;
    double reach = 2;
    std::string device = "auto";
    bool csv = false;
    bool start = false;
};

template <class T>
T need(Result<T> result) {
    if (!result) {
        fmt::print(stderr, "{}\n", result.error().message);
        std::exit(1);
    }
    return std::move(*result);
}

void need(const Result<void>& result) {
    if (!result) {
        fmt::print(stderr, "{}\n", result.error().message);
        std::exit(1);
    }
}

/// The device's own maps, without the copies of the synthesizer.
class DeviceMaps {
  public:
    DeviceMaps(gpu::Device& device, const std::vector<sea::CascadeModes>& modes,
               const shaders::Transform& transform)
        : kernels_(need(server::SynthesisKernels::create(device, transform))),
          batch_(need(server::VulkanBatch::create(device, kernels_, cascade_count))) {
        std::vector<const sea::CascadeModes*> cascades;
        for (const sea::CascadeModes& cascade : modes)
            cascades.push_back(&cascade);
        need(batch_->upload(cascades));
    }

    void run(sea::FieldSet fields, int cascades, sea::TimeUs time_us) {
        const server::Packing packing = server::pack(fields);
        std::vector<server::VulkanBatch::Job> jobs;
        for (int cascade = 0; cascade < cascades; ++cascade) {
            jobs.push_back({cascade, time_us});
            if (static_cast<int>(jobs.size()) == batch_->max_jobs(packing.maps) ||
                cascade + 1 == cascades) {
                need(batch_->run(jobs, packing, {}));
                jobs.clear();
            }
        }
        const std::span<const double> passes = batch_->pass_seconds(); // empty until timed
        passes_.resize(passes.size());
        for (std::size_t i = 0; i < passes.size(); ++i)
            passes_[i].push_back(passes[i] * 1e3);
    }

    std::string name() const { return std::string(kernels_.transform->design); }
    void time_passes() {
        passes_.clear();
        batch_->time_passes(true);
    }

    /// Median milliseconds of each pass of the last submission of a run.
    std::string passes() {
        std::string text;
        for (const std::vector<double>& pass : passes_) {
            text += fmt::format(" {:.3f}", median(pass));
        }
        return text;
    }

  private:
    server::SynthesisKernels kernels_;
    std::unique_ptr<server::VulkanBatch> batch_;
    std::vector<std::vector<double>> passes_;
};

void report(const Settings& settings, int size, const std::vector<Contender>& contenders) {
    const Contender& plain = contenders[0];
    const Contender& strongest = contenders[1];
    for (const Contender& contender : contenders) {
        const double ms = median(contender.wall_ms), cpu = median(contender.cpu_ms);
        fmt::print(fmt::runtime(settings.csv ? "{},{},{:.4f},{:.3f},{:.3f},{:.4f},{:.3f},{:.3f}\n"
                                             : "{:5} {:24} {:8.3f} {:6.2f} {:6.2f}   {:8.3f} "
                                               "{:6.2f} {:6.2f}\n"),
                   size, contender.name, ms, ms / median(plain.wall_ms),
                   ms / median(strongest.wall_ms), cpu, cpu / median(plain.cpu_ms),
                   cpu / median(strongest.cpu_ms));
    }
    std::fflush(stdout);
}

void time_size(const Settings& settings, gpu::Device& device, int size) {
    const std::vector<sea::CascadeModes> modes = three_cascades(size, settings.reach);
    FftwYardstick strongest(FftwProgram::split_batch, modes), plain(FftwProgram::plain, modes);
    auto sea = std::make_shared<sea::Realization>();
    sea->cascades = modes;
    auto synthesizer = need(server::make_vulkan_synthesizer({.device = settings.device}));
    need(synthesizer->set_sea(sea, 1));
    const bool band_limited = shaders::fits_band(static_cast<int>(settings.reach * size / 2), size);
    std::vector<std::unique_ptr<DeviceMaps>> designs;
    for (const shaders::Transform* transform :
         server::fitting_transforms(device.info(), size, band_limited))
        designs.push_back(std::make_unique<DeviceMaps>(device, modes, *transform));
    DeviceMaps& best = *designs.front();
    std::vector<server::NewKeyframePtr> keyframes;
    const auto synthesize = [&](sea::TimeUs t_us) {
        std::vector<server::KeyframeRequest> requests;
        for (int cascade = 0; cascade < cascade_count; ++cascade)
            requests.push_back({cascade, t_us, eight_fields});
        keyframes = need(synthesizer->synthesize(requests));
    };
    std::vector<Contender> contenders{
        {"plain", [&](auto t) { plain.run(t, true); }},
        {"strongest", [&](auto t) { strongest.run(t, true); }},
        {"plain unsplit", [&](auto t) { plain.run(t, false); }},
        {"strongest unsplit", [&](auto t) { strongest.run(t, false); }},
        {"vulkan keyframes", synthesize},
        {"maps, height only", [&](auto t) { best.run({Field::height}, cascade_count, t); }},
        {"maps, one cascade", [&](auto t) { best.run(eight_fields, 1, t); }}};
    for (const auto& design : designs)
        contenders.push_back({"maps " + design->name(),
                              [&d = *design](auto t) { d.run(eight_fields, cascade_count, t); }});
    for (Contender& contender : contenders)
        contender.run(12'345'678);
    const std::size_t floats = keyframes[0]->values.size();
    for (std::size_t i = 0; i < keyframes.size(); ++i)
        for (const FftwYardstick* yardstick : {&plain, &strongest})
            check_same(keyframes[i]->values, yardstick->planes().subspan(i * floats, floats));
    for (int repeat = 0; repeat < settings.repeats; ++repeat)
        for (Contender& contender : contenders)
            run_timed(contender, repeat * 33'333);
    report(settings, size, contenders);
    for (const auto& design : designs) {
        design->time_passes();
        for (int repeat = 0; repeat < settings.repeats; ++repeat)
            design->run(eight_fields, cascade_count, repeat);
        fmt::print("# {} {}: passes of the last submission, ms:{}\n", size, design->name(),
                   design->passes());
    }
}

/// What each design costs until it can be used, the device's own check apart.
void time_start(const Settings& settings, int size) {
    auto sea = std::make_shared<sea::Realization>();
    sea->cascades.push_back(sea::random_modes(size, settings.reach * size / 2, 0, 100.0));
    for (const bool any_device : {false, true}) {
        const double begin = 1e3 * process_cpu_seconds();
        auto synthesizer = need(server::make_vulkan_synthesizer(
            {.device = settings.device, .any_device_kernels = any_device}));
        const double made = 1e3 * process_cpu_seconds();
        need(synthesizer->set_sea(sea, 1));
        fmt::print("{:5} {:7} device and its check {:6.0f} ms, the size {:6.0f} ms: {}\n", size,
                   any_device ? "any" : "fastest", made - begin, 1e3 * process_cpu_seconds() - made,
                   synthesizer->description());
    }
}

} // namespace
} // namespace seaway::bench

int main(int argc, char** argv) {
    using namespace seaway;
    bench::Settings settings;
    CommandLine line("bench_kernels", "Vulkan kernels against FFTW");
    line.option("--sizes", settings.sizes).separated_by(',');
    line.option("--repeats", settings.repeats).between(1, 1'000'000);
    line.option("--reach", settings.reach);
    line.option("--device", settings.device);
    line.option("--csv", settings.csv);
    line.option("--start", settings.start);
    const Result<CommandLine::Next> next = line.read(argc, argv);
    if (!next) {
        fmt::print(stderr, "bench_kernels: {}\n", next.error().message);
        return 2;
    }
    if (*next == CommandLine::Next::leave)
        return 0;
    if (settings.start) {
        for (const int size : settings.sizes)
            bench::time_start(settings, size);
        return 0;
    }
    const auto device = bench::need(gpu::Device::create({.pick = settings.device}));
    fmt::print("# {}, reach {} of Nyquist, {} repeats\n", device->info().name, settings.reach,
               settings.repeats);
    fmt::print("{}\n", settings.csv ? "size,program,wall_ms,wall_to_plain,wall_to_strongest,"
                                      "cpu_ms,cpu_to_plain,cpu_to_strongest"
                                    : " size program                   wall ms  /plain /strongest "
                                      " CPU ms  /plain /strongest");
    for (const int size : settings.sizes)
        bench::time_size(settings, *device, size);
}
