// SPDX-License-Identifier: Apache-2.0
#include "server/device/vulkan_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <string>
#include <vector>

#include "server/device/vulkan_batch.h"

namespace seaway::server {

namespace {

using Complex = std::complex<double>;

constexpr double length_m = 100.0;
constexpr double depth_m = 5.0; // coth(kd) runs from 3.3 to 1
constexpr sea::Choppiness choppiness{1.3, 0.7};
constexpr sea::TimeUs checked_us = 86'400'000'123;
constexpr int checked_points = 37;
// Float transforms lose about 3e-7 of the sum of amplitudes; a wrong one loses all of it.
constexpr double tolerance = 1e-5;

/// A lattice walk that reaches every quarter of the plane and neither Nyquist nor k = 0.
struct Mode {
    int nx, ny;
    Complex h0;
    sea::Rate rate;
};

std::vector<Mode> check_modes(int size, bool band_limited) {
    std::vector<Mode> modes;
    int reach = size / 2 - 1;
    while (band_limited && !shaders::fits_band(reach, size))
        --reach;
    for (int i = 0; i < 24; ++i) {
        const int nx = (i * 7919 + 3) % (2 * reach + 1) - reach;
        const int ny = (i * 104729 + 11) % (2 * reach + 1) - reach;
        const double k = 2 * std::numbers::pi / length_m * std::hypot(nx, ny);
        if (nx != 0 || ny != 0)
            modes.push_back({nx, ny, std::polar(0.1 / (1 + i), 1.0 + i),
                             sea::rate_from_omega(std::sqrt(9.81 * k))});
    }
    return modes;
}

sea::CascadeModes lattice(int size, const std::vector<Mode>& modes) {
    const auto n = static_cast<std::size_t>(size);
    sea::CascadeModes cascade{.spec = {length_m, size}, .band = {0, 1e9}, .h0 = {}, .rate = {}};
    cascade.depth_m = depth_m;
    cascade.h0.resize(n * n);
    cascade.rate.resize(n * n);
    const auto at = [&](int nx, int ny) {
        return static_cast<std::size_t>((ny + size) % size) * n +
               static_cast<std::size_t>((nx + size) % size);
    };
    for (const Mode& mode : modes) {
        cascade.h0[at(mode.nx, mode.ny)] += mode.h0;
        cascade.rate[at(mode.nx, mode.ny)] = mode.rate;
        cascade.rate[at(-mode.nx, -mode.ny)] = mode.rate;
    }
    return cascade;
}

double basis(sea::Basis which, double kx, double ky) {
    const double k = std::hypot(kx, ky) * std::tanh(std::hypot(kx, ky) * depth_m);
    const std::array<double, 8> values{1,  kx / k,      ky / k,      kx,
                                       ky, kx * kx / k, ky * ky / k, kx * ky / k};
    return values[static_cast<std::size_t>(which)];
}

struct Sum {
    double value;
    double scale; ///< sum of the amplitudes: what errors are measured against
};

/// eta and its kin at one grid point: 2 Re(sum M h0 exp(i (k.x - w t))) over the stored modes.
Sum direct_sum(const std::vector<Mode>& modes, int size, sea::Field field, int x, int y) {
    const sea::FieldInfo& row = sea::info(field);
    Sum sum{0, 0};
    for (const Mode& mode : modes) {
        const double dk = 2 * std::numbers::pi / length_m;
        Complex m = row.weight * basis(row.basis, mode.nx * dk, mode.ny * dk);
        if (row.imaginary)
            m *= Complex(0, 1);
        if (row.time_rate)
            m *= Complex(0, -sea::omega_from_rate(mode.rate));
        const double turns = static_cast<double>(mode.nx * x + mode.ny * y) / size;
        const double phase = 2 * std::numbers::pi * turns - sea::phase_rad(mode.rate, checked_us);
        sum.value += 2 * (m * mode.h0 * std::polar(1.0, phase)).real();
        sum.scale += 2 * std::abs(m * mode.h0);
    }
    return sum;
}

Result<void> compare(int size, std::string_view what, int x, int y, double got, Sum truth) {
    // Written so that a NaN fails.
    if (std::abs(got - truth.value) <= tolerance * truth.scale)
        return {};
    return Error{DeviceError::cannot_do_this_sea,
                 "the device computes wrongly: size " + std::to_string(size) + ", " +
                     std::string(what) + " at (" + std::to_string(x) + ", " + std::to_string(y) +
                     ") is " + std::to_string(got) + ", should be " + std::to_string(truth.value)};
}

/// A tick that breaks on both sides of its threshold, with others' strains and a bias.
sea::FoamTick check_tick() {
    return {0.9f,   0.05f,  1.3f,   0.7f,   0.95f, 0.02f, 0.1f, 0.2f,
            0.005f, 0.003f, 0.004f, 0.001f, 1e-4f, 0.75f, 2.0f, 0.125f};
}

/// Of the rounded maps: of heights, which fit 16 bits, and of their rates, which do not.
constexpr float height_step_m = 0x1p-12f, rate_step_mps = 0x1p-30f;

struct Maps {
    std::vector<std::vector<float>> planes; ///< by field
    std::vector<float> jacobian;
    std::vector<float> foam;                ///< of a history of 1, after the tick
    std::vector<float> height_alone;        ///< computed without company
    std::vector<std::int16_t> height_steps; ///< empty: memory is read in place, and nothing rounded
    bool height_fits = false, rate_fits = false;
};

/// Strains, and what is made of them.
Result<void> run_derived(gpu::Device& device, const SynthesisKernels& kernels, VulkanBatch& batch,
                         const VulkanBatch::Job& job, Maps& maps) {
    const sea::FieldSet asked =
        sea::strain_fields | sea::FieldSet{sea::Field::jacobian, sea::Field::foam};
    const Packing packing = pack(sea::strain_fields, asked);
    VulkanFoam histories(device, kernels.size());
    SEAWAY_TRY_LET(const FoamMapPtr history, histories.open(nullptr));
    FoamWork foam{&histories.histories(), {foam_step(check_tick())}, {1}};
    foam.steps[0].flags |= shaders::foam_keeps | shaders::foam_shows;
    foam.steps[0].history = histories.place(*history);
    foam.steps[0].shown = batch.place(packing, 0, sea::Field::foam);
    foam.steps[0].strain_xx = batch.place(packing, 0, sea::Field::strain_xx);
    foam.steps[0].strain_yy = batch.place(packing, 0, sea::Field::strain_yy);
    foam.steps[0].strain_xy = batch.place(packing, 0, sea::Field::strain_xy);
    SEAWAY_TRY(batch.run({&job, 1}, packing, {&choppiness, &foam}));
    for (const sea::Field field : sea::strain_fields)
        batch.read_map(VulkanBatch::own, 0, packing.map_of(field),
                       maps.planes[static_cast<std::size_t>(field)]);
    batch.read_map(VulkanBatch::own, 0, packing.map_of(sea::Field::foam), maps.foam);
    batch.read_map(VulkanBatch::own, 0, packing.map_of(sea::Field::jacobian), maps.jacobian);
    return {};
}

Result<void> run_rounding(VulkanBatch& batch, const VulkanBatch::Job& job, Maps& maps) {
    const Packing packing = pack({sea::Field::height, sea::Field::height_rate});
    const int height = packing.map_of(sea::Field::height),
              rate = packing.map_of(sea::Field::height_rate);
    VulkanBatch::Rounding rounding{packing.maps, {0, 0}};
    rounding.scales[static_cast<std::size_t>(height)] = 1 / height_step_m;
    rounding.scales[static_cast<std::size_t>(rate)] = 1 / rate_step_mps;
    SEAWAY_TRY(batch.run({&job, 1}, packing, {.rounding = &rounding}));
    const auto steps = batch.steps(VulkanBatch::own, 0, height);
    maps.height_steps.assign(steps.begin(), steps.end());
    maps.height_fits = batch.fits(VulkanBatch::own, 0, height);
    maps.rate_fits = batch.fits(VulkanBatch::own, 0, rate);
    return {};
}

Result<Maps> run(gpu::Device& device, const SynthesisKernels& kernels,
                 const sea::CascadeModes& cascade) {
    const sea::CascadeModes* const cascades[] = {&cascade};
    Result<std::unique_ptr<VulkanBatch>> batch = VulkanBatch::create(device, kernels, 1);
    if (!batch)
        return batch.error();
    SEAWAY_TRY((*batch)->upload(cascades));
    const VulkanBatch::Job job{0, checked_us};
    const std::size_t points = cascade.h0.size();
    Maps maps{{sea::field_count, std::vector<float>(points)},
              std::vector<float>(points),
              std::vector<float>(points),
              std::vector<float>(points),
              {}};
    SEAWAY_TRY(run_derived(device, kernels, **batch, job, maps));
    // Maps of 2048 do not all stand side by side.
    const sea::FieldSet others = sea::linear_fields.without(sea::strain_fields);
    SEAWAY_TRY((*batch)->run({&job, 1}, pack(others), {}));
    for (const sea::Field field : others)
        (*batch)->read_map(VulkanBatch::own, 0, pack(others).map_of(field),
                           maps.planes[static_cast<std::size_t>(field)]);
    SEAWAY_TRY((*batch)->run({&job, 1}, pack({sea::Field::height}), {}));
    (*batch)->read_map(VulkanBatch::own, 0, 0, maps.height_alone);
    if (!device.unified_memory())
        SEAWAY_TRY(run_rounding(**batch, job, maps));
    return maps;
}

Result<void> compare_point(const Maps& maps, const std::vector<Mode>& modes, int size, int x,
                           int y) {
    const std::size_t at =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(size) + static_cast<std::size_t>(x);
    std::array<Sum, sea::field_count> truth{};
    for (const sea::Field field : sea::linear_fields)
        truth[static_cast<std::size_t>(field)] = direct_sum(modes, size, field, x, y);
    for (const sea::Field field : sea::linear_fields) {
        const auto f = static_cast<std::size_t>(field);
        const std::string_view name = sea::info(field).name;
        SEAWAY_TRY(compare(size, name, x, y, maps.planes[f][at], truth[f]));
    }
    SEAWAY_TRY(compare(size, "height alone", x, y, maps.height_alone[at], truth[0]));
    if (!maps.height_steps.empty()) // half a step may be lost, too
        SEAWAY_TRY(compare(size, "height rounded", x, y,
                           static_cast<double>(maps.height_steps[at] * height_step_m),
                           {truth[0].value, truth[0].scale + 0.5 * height_step_m / tolerance}));
    const auto strain = [&](sea::Field field) { return truth[static_cast<std::size_t>(field)]; };
    const Sum xx = strain(sea::Field::strain_xx), yy = strain(sea::Field::strain_yy),
              xy = strain(sea::Field::strain_xy);
    const Sum determinant{(1 + choppiness.x * xx.value) * (1 + choppiness.y * yy.value) -
                              choppiness.x * choppiness.y * xy.value * xy.value,
                          (1 + choppiness.x * xx.scale) * (1 + choppiness.y * yy.scale)};
    SEAWAY_TRY(compare(size, "jacobian", x, y, maps.jacobian[at], determinant));
    float ratio = 1.0f;
    const std::array<float, 3> at_point{static_cast<float>(xx.value), static_cast<float>(yy.value),
                                        static_cast<float>(xy.value)};
    sea::foam_kernel_portable().advance(check_tick(), &at_point[0], &at_point[1], &at_point[2],
                                        &ratio, 1);
    // What breaks goes at most as the strains do, times the source.
    return compare(size, "foam", x, y, maps.foam[at],
                   {ratio, 2.0 * (1 + xx.scale) * (1 + yy.scale)});
}

} // namespace

Result<void> check_device(gpu::Device& device, const SynthesisKernels& kernels) {
    const std::vector<Mode> modes = check_modes(kernels.size(), kernels.transform->band_limited);
    Result<Maps> maps = run(device, kernels, lattice(kernels.size(), modes));
    if (!maps)
        return maps.error();
    if (!maps->height_steps.empty() && (!maps->height_fits || maps->rate_fits))
        return Error{DeviceError::cannot_do_this_sea,
                     "the device computes wrongly: size " + std::to_string(kernels.size()) +
                         ", which rounded maps do not fit 16 bits"};
    for (int i = 0; i < checked_points; ++i)
        SEAWAY_TRY(compare_point(*maps, modes, kernels.size(), i * 1009 % kernels.size(),
                                 i * 2003 % kernels.size()));
    return {};
}

} // namespace seaway::server
