// SPDX-License-Identifier: Apache-2.0
#include "client/view/sea/spray.h"

#include <algorithm>
#include <cmath>

#include "gpu/descriptor_types.h"
#include "gpu/keep.h"
#include "sea/basics/constants.h"
#include "sea/spectrum/spectra.h"
#include "shaders/view/spray_comp.h"
#include "shaders/view/spray_frag.h"
#include "shaders/view/spray_one_frag.h"
#include "shaders/view/spray_vert.h"

namespace seaway::client {

namespace {

constexpr std::size_t plume_bytes = 2 * 4 * sizeof(float);
constexpr int wrap = 1 << 16;
/// Whitecaps cover so much at 23 m/s, and no more in higher winds.
constexpr double cover_max = 0.0759;

using gpu::storage;
using gpu::texel_buffer;
using gpu::texture;
using gpu::uniform;
constexpr gpu::ExpectedBinding spray_bindings[] = {
    {"View", uniform}, {"plumes", texel_buffer}, {"geometry", texture}};

int wrapped(double whole) {
    return static_cast<int>(whole - wrap * std::floor(whole / wrap));
}

int plumes_of(int slots) {
    return Spray::cells * Spray::cells * slots;
}

} // namespace

SprayValues spray_values(const SeaFrame& frame, const Camera& camera, int slots) {
    SprayValues out{};
    if (slots == 0 || frame.foam_mean <= spray_from_cover)
        return out;
    out.slots = slots;
    constexpr int cells_before = Spray::cells / 2;
    const double first[2] = {std::floor(camera.x_m / Spray::cell_m) - cells_before,
                             std::floor(camera.y_m / Spray::cell_m) - cells_before};
    const double eye_m[2] = {camera.x_m, camera.y_m};
    for (std::size_t i = 0; i < 2; ++i) {
        out.base[i] = wrapped(first[i]);
        out.origin_m[i] = static_cast<float>(first[i] * Spray::cell_m - eye_m[i]);
    }
    const double periods = sea::seconds_from_us(frame.time_us) / Spray::period_s;
    out.period = wrapped(std::floor(periods));
    out.moment = static_cast<float>(periods - std::floor(periods));
    // Callaghan's law turned round; a grown sea's wind by its height where that says more.
    const double by_cover = std::cbrt(frame.foam_mean / 4.82e-6) - 1.98;
    const double by_height = sea::grown_sea_wind_10m_mps(
        frame.significant_height_m * frame.significant_height_m / 16, sea::gravity_default_mps2);
    out.wind_mps = static_cast<float>(std::max(by_cover, by_height));
    // Phase speed of waves 20 significant heights long.
    out.crest_mps = static_cast<float>(
        std::sqrt(sea::gravity_default_mps2 * 20 * frame.significant_height_m / (2 * sea::pi)));
    out.strength = static_cast<float>(std::clamp(
        (frame.foam_mean - spray_from_cover) / (cover_max - spray_from_cover), 0.0, 1.0));
    return out;
}

Result<void> Spray::create(gpu::Device& device, const gpu::Offscreen& target, int slots) {
    using gpu::keep;
    const bool one = target.size().samples == VK_SAMPLE_COUNT_1_BIT;
    const std::span<const std::uint32_t> many_frag = spray_frag, one_frag = spray_one_frag;
    SEAWAY_TRY(keep(throw_, gpu::Kernel::create(device, "spray", spray_comp,
                                                {{{"View", uniform},
                                                  {"displacements", texel_buffer},
                                                  {"gradients", texel_buffer},
                                                  {"Plumes", storage}},
                                                 sizeof(SprayValues),
                                                 {shaders::view_group, 1, 1}})));
    Result<gpu::GraphicsPipeline> drawn = gpu::GraphicsPipeline::create(
        device, "spray", spray_vert, one ? one_frag : many_frag, spray_bindings, {.blended = true});
    if (!drawn)
        return Error{drawn.error().kind, drawn.error().message + "; --quality low has no spray"};
    draw_ = std::move(*drawn);
    const std::size_t bytes = static_cast<std::size_t>(plumes_of(slots)) * plume_bytes;
    SEAWAY_TRY(keep(plumes_, gpu::Buffer::create(device, "spray", bytes, gpu::BufferKind::device)));
    return keep(plume_texels_,
                gpu::TexelView::create(device, plumes_, VK_FORMAT_R32G32B32A32_SFLOAT,
                                       plume_bytes / 2, 0, bytes));
}

Result<void> Spray::prepare(gpu::Device& device, const SprayValues& values, std::size_t flight,
                            const gpu::Buffer& view, const DeviceSea& sea,
                            const gpu::Offscreen& target, VkSampler sampler) {
    values_ = values;
    if (values.slots == 0)
        return {};
    if (plumes_.size_bytes() == 0)
        SEAWAY_TRY(create(device, target, values.slots));
    const gpu::Resource drawn[] = {
        gpu::whole(view), gpu::texels(plume_texels_),
        gpu::sampled(sampler, target.geometry().view(), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL)};
    SEAWAY_TRY(gpu::keep(drawn_[flight], draw_.bind(device, drawn)));
    return gpu::keep(thrown_[flight],
                     throw_.bind(device, {gpu::whole(view), gpu::texels(sea.displacements()),
                                          gpu::texels(sea.gradients()), gpu::whole(plumes_)}));
}

void Spray::record(gpu::Commands& commands, gpu::Offscreen& target, std::size_t flight) {
    if (values_.slots == 0)
        return;
    ++passes_;
    const auto plumes = static_cast<std::uint32_t>(plumes_of(values_.slots));
    commands.barrier(gpu::Stage::graphics, gpu::Stage::compute); // the frame before draws them
    commands.dispatch(throw_, thrown_[flight], std::as_bytes(std::span(&values_, 1)),
                      (plumes + shaders::view_group - 1) / shaders::view_group);
    commands.barrier(gpu::Stage::compute, gpu::Stage::graphics);
    target.begin_over_picture(commands);
    draw_.record_bind(commands, drawn_[flight]);
    vkCmdDraw(commands.get(), 6 * plumes, 1, 0, 0);
    target.end_picture(commands);
}

} // namespace seaway::client
