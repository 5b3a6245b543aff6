// SPDX-License-Identifier: Apache-2.0
#include "client/view/bloom.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "gpu/descriptor_types.h"
#include "gpu/keep.h"
#include "shaders/view/bloom_down_comp.h"
#include "shaders/view/bloom_first_comp.h"
#include "shaders/view/bloom_up_comp.h"

namespace seaway::client {

namespace {

/// Texels of the coarsest level in the picture's height, about.
constexpr double coarsest_lines = 3;
/// Each level gives so much of the light of the one before, on four times its area.
constexpr double level_ratio = 0.55;
constexpr std::size_t bloom_texel_bytes = 4 * sizeof(float);

struct Push {
    int from[3], to[3], pixels;
    float share;
};
static_assert(sizeof(Push) == 32);

int halved(int side) {
    return (side + 1) / 2;
}

} // namespace

Result<Bloom> Bloom::create(gpu::Device& device, const gpu::Image& picture, int pixels,
                            VkSampler sampler) {
    using gpu::keep;
    Bloom made;
    made.pixels_ = pixels;
    int columns = static_cast<int>(picture.spec().width);
    int lines = static_cast<int>(picture.spec().height);
    const int halvings = static_cast<int>(std::lround(std::log2(lines / coarsest_lines)));
    const int count = std::clamp(halvings, 1, levels_max) - (pixels == 4 ? 1 : 0);
    int texels = 0;
    for (int level = 0; level < std::max(count, 1); ++level) {
        for (int side = level == 0 ? pixels : 2; side > 1; side /= 2) {
            columns = halved(columns);
            lines = halved(lines);
        }
        // The sum of a geometric series, of all coarser levels and of those with this one.
        const double coarser = 1 - std::pow(level_ratio, std::max(count, 1) - 1 - level);
        const double share = level_ratio * coarser / (1 - level_ratio + level_ratio * coarser);
        made.levels_.push_back({texels, columns, lines, static_cast<float>(share)});
        texels += columns * lines;
    }
    const std::size_t bytes = static_cast<std::size_t>(texels) * bloom_texel_bytes;
    SEAWAY_TRY(
        keep(made.buffer_, gpu::Buffer::create(device, "bloom", bytes, gpu::BufferKind::device)));
    const auto view = [&](gpu::TexelView& target, std::size_t range_bytes) {
        return keep(target,
                    gpu::TexelView::create(device, made.buffer_, VK_FORMAT_R32G32B32A32_SFLOAT,
                                           bloom_texel_bytes, 0, range_bytes));
    };
    SEAWAY_TRY(view(made.texels_, bytes));
    const Level& finest = made.levels_.front();
    SEAWAY_TRY(view(made.finest_,
                    static_cast<std::size_t>(finest.columns * finest.lines) * bloom_texel_bytes));
    SEAWAY_TRY(made.create_kernels(device, picture, sampler));
    return made;
}

Result<void> Bloom::create_kernels(gpu::Device& device, const gpu::Image& picture,
                                   VkSampler sampler) {
    using gpu::storage;
    const auto kernel = [&](gpu::Kernel& target, const char* name,
                            std::span<const std::uint32_t> spirv, const char* source,
                            VkDescriptorType type) {
        return gpu::keep(target, gpu::Kernel::create(device, name, spirv,
                                                     {{{source, type}, {"Spread", storage}},
                                                      sizeof(Push),
                                                      {shaders::view_group, 1, 1}}));
    };
    using gpu::texel_buffer;
    using gpu::texture;
    SEAWAY_TRY(kernel(first_, "bloom of the picture", bloom_first_comp, "picture", texture));
    SEAWAY_TRY(kernel(down_, "coarser bloom", bloom_down_comp, "levels", texel_buffer));
    SEAWAY_TRY(kernel(up_, "finer bloom", bloom_up_comp, "levels", texel_buffer));
    SEAWAY_TRY(gpu::keep(
        of_picture_, first_.bind(device, {gpu::sampled(sampler, picture.view(),
                                                       VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL),
                                          gpu::whole(buffer_)})));
    SEAWAY_TRY(
        gpu::keep(of_levels_, down_.bind(device, {gpu::texels(texels_), gpu::whole(buffer_)})));
    return gpu::keep(of_coarser_, up_.bind(device, {gpu::texels(texels_), gpu::whole(buffer_)}));
}

void Bloom::record(gpu::Commands& commands, const gpu::Kernel& kernel,
                   const gpu::Bindings& bindings, const Level& from, const Level& to) const {
    const Push push{{from.first, from.columns, from.lines},
                    {to.first, to.columns, to.lines},
                    pixels_,
                    to.share};
    const std::size_t texels =
        static_cast<std::size_t>(to.columns) * static_cast<std::size_t>(to.lines);
    commands.dispatch_all(kernel, bindings, std::as_bytes(std::span(&push, 1)), texels,
                          shaders::view_group);
    commands.barrier(gpu::Stage::compute, gpu::Stage::compute);
}

void Bloom::record(gpu::Commands& commands) const {
    record(commands, first_, of_picture_, {}, levels_.front());
    for (std::size_t level = 1; level < levels_.size(); ++level)
        record(commands, down_, of_levels_, levels_[level - 1], levels_[level]);
    for (std::size_t level = levels_.size() - 1; level > 0; --level)
        record(commands, up_, of_coarser_, levels_[level], levels_[level - 1]);
    commands.barrier(gpu::Stage::compute, gpu::Stage::graphics);
}

void Bloom::describe(double scale, shaders::ViewValues& values) const {
    values.bloom_per_shown = static_cast<float>(scale / pixels_);
    values.bloom_columns = levels_.front().columns;
    values.bloom_lines = levels_.front().lines;
}

} // namespace seaway::client
