// SPDX-License-Identifier: Apache-2.0
// VulkanBatch pass by pass: what stands in memory between two of them (shaders/synthesis.h).
#include <algorithm>
#include <cstring>
#include <iterator>

#include <fmt/format.h>

#include "base/check.h"
#include "server/device/vulkan_batch.h"
#include "server/device/vulkan_parts.h"
#include "server/device/vulkan_requests.h"

namespace seaway::server {

namespace {

/// What a pass works on: all fields one by one, or the sources that they share.
int parts(const SynthesisKernels::Pass& pass, const Packing& packing) {
    return pass.kind == shaders::PassKind::fields ? packing.fields : packing.sources;
}

std::string field_at(const Packing& packing, int plane) {
    for (const sea::FieldInfo& field : sea::field_table)
        if (sea::is_linear(field.field) && packing.plane_of(field.field) == plane)
            return std::string(field.name);
    return fmt::format("field {}", plane);
}

/// Passes along y keep two neighbouring rows in a vec4; those along x two neighbouring points.
SynthesisStage stage_of(const SynthesisKernels::Pass& pass, int size, const float* texels) {
    const bool along_x = pass.kind == shaders::PassKind::fields;
    const auto width = static_cast<std::size_t>(pass.row_texels);
    const auto pairs = static_cast<std::size_t>(size) / 2;
    SynthesisStage stage;
    stage.rows = along_x ? size / 2 : size;
    stage.columns = static_cast<int>(along_x ? 2 * width : width);
    if (along_x) {
        stage.values.assign(texels, texels + pairs * width * 4);
        return stage;
    }
    stage.values.resize(pairs * width * 4);
    for (std::size_t pair = 0; pair < pairs; ++pair)
        for (std::size_t x = 0; x < width; ++x)
            for (std::size_t row = 0; row < 2; ++row)
                for (std::size_t part = 0; part < 2; ++part)
                    stage.values[((2 * pair + row) * width + x) * 2 + part] =
                        texels[(pair * width + x) * 4 + 2 * row + part];
    return stage;
}

} // namespace

std::size_t VulkanBatch::pass_floats(std::size_t pass, const Packing& packing) const {
    const SynthesisKernels::Pass& row = kernels_.passes[pass];
    return static_cast<std::size_t>(parts(row, packing)) *
           static_cast<std::size_t>(kernels_.size()) / 2 * row.row_texels * 4;
}

Result<std::vector<float>> VulkanBatch::output(const Job& job, const Packing& packing,
                                               std::size_t pass) {
    own_.asked = 0;
    SEAWAY_TRY(record(own_, {&job, 1}, packing, {}, pass + 1, {}));
    SEAWAY_TRY(device_.submit_and_wait(own_.commands));
    std::vector<float> floats(pass_floats(pass, packing));
    const std::byte* from =
        (own_.readback.size_bytes() ? own_.readback : scratch_[pass % 2]).mapped().data();
    std::memcpy(floats.data(), from, floats.size() * sizeof(float));
    return floats;
}

Result<std::vector<SynthesisStage>> VulkanBatch::stages_of(const Job& job, const Packing& packing,
                                                           int first_source) {
    std::vector<SynthesisStage> all;
    for (std::size_t i = 0; i + 1 < kernels_.passes.size(); ++i) {
        const SynthesisKernels::Pass& pass = kernels_.passes[i];
        SEAWAY_CHECK(pass.row_texels > 0, "a pass that is not the last leaves rows");
        SEAWAY_TRY_LET(const std::vector<float> floats, output(job, packing, i));
        const int count = parts(pass, packing);
        const std::size_t each = floats.size() / static_cast<std::size_t>(count);
        for (int part = 0; part < count; ++part) {
            SynthesisStage stage = stage_of(pass, kernels_.size(),
                                            floats.data() + static_cast<std::size_t>(part) * each);
            stage.pass = kernels_.transform->passes[i].shader.name;
            stage.name = pass.kind == shaders::PassKind::fields
                             ? field_at(packing, part)
                             : fmt::format("source {}", first_source + part);
            all.push_back(std::move(stage));
        }
    }
    return all;
}

Result<std::vector<SynthesisStage>> VulkanBatch::stages(const Job& job,
                                                        const KeyframeRequest& request) {
    std::vector<SynthesisStage> all;
    int sources = 0;
    for (const KeyframeRequest& part : parts_of(request, maps_at_once())) {
        const sea::FieldSet linear = part.fields & sea::linear_fields;
        const bool jacobian = part.fields.contains(sea::Field::jacobian);
        if (!jacobian && linear.size() == 0)
            continue;
        const Packing packing = pack(jacobian ? linear | sea::strain_fields : linear);
        SEAWAY_TRY_LET(std::vector<SynthesisStage> some, stages_of(job, packing, sources));
        std::ranges::move(some, std::back_inserter(all));
        sources += packing.sources;
    }
    return all;
}

} // namespace seaway::server
