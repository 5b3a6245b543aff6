// SPDX-License-Identifier: Apache-2.0
#include "server/device/vulkan_tuning.h"

#include <algorithm>
#include <limits>
#include <memory>

#include "server/device/kernel_choices.h"
#include "server/device/vulkan_batch.h"

namespace seaway::server {

namespace {

constexpr int rounds = 6; ///< the first of which warms up

/// How long kernels take hangs on no value.
sea::CascadeModes any_modes(int size) {
    const std::size_t count = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
    sea::CascadeModes modes{.spec = {100.0, size}, .band = {0, 1e9}, .h0 = {}, .rate = {}};
    modes.h0.resize(count);
    modes.rate.resize(count);
    return modes;
}

} // namespace

KernelTuning usual_tuning() {
    return {.file = kernel_choices_path(), .measure = Measure::on_gpus};
}

Result<std::vector<double>> time_kernels(gpu::Device& device,
                                         std::span<const SynthesisKernels* const> kernels) {
    constexpr sea::FieldSet fields =
        sea::surface_fields | sea::FieldSet{sea::Field::slope_x, sea::Field::slope_y};
    std::vector<double> least(kernels.size(), std::numeric_limits<double>::infinity());
    std::vector<std::unique_ptr<VulkanBatch>> batches;
    const sea::CascadeModes modes = any_modes(kernels.front()->size());
    const sea::CascadeModes* const cascades[] = {&modes};
    for (const SynthesisKernels* each : kernels) {
        SEAWAY_TRY_LET(std::unique_ptr<VulkanBatch> batch, VulkanBatch::create(device, *each, 1));
        SEAWAY_TRY(batch->upload(cascades));
        batches.push_back(std::move(batch));
    }
    // Designs with longer rows bind one map less.
    int maps = fields.size();
    for (const auto& batch : batches)
        maps = std::min(maps, batch->maps_at_once());
    sea::FieldSet timed;
    for (const sea::Field field : fields)
        if (timed.size() < maps)
            timed |= sea::FieldSet{field};
    const VulkanBatch::Job job{0, 0};
    for (int round = 0; round < rounds; ++round)
        for (std::size_t i = 0; i < batches.size(); ++i) {
            const double before_s = batches[i]->device_seconds();
            SEAWAY_TRY(batches[i]->run({&job, 1}, pack(timed), {}));
            if (round > 0)
                least[i] = std::min(least[i], batches[i]->device_seconds() - before_s);
        }
    return least;
}

} // namespace seaway::server
