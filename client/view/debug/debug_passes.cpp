// SPDX-License-Identifier: Apache-2.0
#include "client/view/debug/debug_passes.h"

#include "gpu/descriptor_types.h"
#include "gpu/keep.h"
#include "shaders/view/debug_frag.h"
#include "shaders/view/debug_map_frag.h"
#include "shaders/view/debug_one_frag.h"
#include "shaders/view/numbers_frag.h"
#include "shaders/view/picture_vert.h"

namespace seaway::client {

namespace {

using gpu::texel_buffer;
using gpu::texture;
using gpu::uniform;

constexpr gpu::ExpectedBinding number_bindings[] = {
    {"View", uniform},
    {"Rows", VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
    {"vertices", texel_buffer},
    {"gradients", texel_buffer},
    {"sky_map", texture},
    {"geometry", texture},
    {"displacements", texel_buffer},
};
constexpr gpu::ExpectedBinding colour_bindings[] = {{"View", uniform}, {"picture", texture}};

void draw(gpu::Commands& commands, const gpu::GraphicsPipeline& pipeline,
          const gpu::Bindings& bound) {
    pipeline.record_bind(commands, bound);
    vkCmdDraw(commands.get(), 3, 1, 0, 0);
}

} // namespace

Result<DebugPasses> DebugPasses::create(gpu::Device& device, bool one, VkFormat shown_format) {
    using gpu::GraphicsPipeline;
    using Spirv = std::span<const std::uint32_t>;
    DebugPasses made;
    const Spirv sea = one ? Spirv(debug_one_frag) : Spirv(debug_frag);
    SEAWAY_TRY(gpu::keep(made.sea_, GraphicsPipeline::create(device, "debug", picture_vert, sea,
                                                             number_bindings, {})));
    SEAWAY_TRY(gpu::keep(made.map_, GraphicsPipeline::create(device, "debug map", picture_vert,
                                                             debug_map_frag, number_bindings, {})));
    SEAWAY_TRY(gpu::keep(made.colours_, GraphicsPipeline::create(device, "numbers", picture_vert,
                                                                 numbers_frag, colour_bindings,
                                                                 {.colour_format = shown_format})));
    return made;
}

void DebugPasses::record(gpu::Commands& commands, const gpu::Bindings& bound,
                         DebugView view) const {
    draw(commands, info(view).source == DebugSource::map ? map_ : sea_, bound);
}

void DebugPasses::record_colours(gpu::Commands& commands, const gpu::Bindings& bound) const {
    draw(commands, colours_, bound);
}

} // namespace seaway::client
