// SPDX-License-Identifier: Apache-2.0
#include "client/view/renderer.h"

#include <algorithm>
#include <cstring>

#include "base/check.h"
#include "shaders/view/debug_frag.h"
#include "shaders/view/final_frag.h"
#include "shaders/view/picture_vert.h"
#include "shaders/view/sea_frag.h"
#include "shaders/view/sea_vert.h"

namespace seaway::client {

namespace {

constexpr int rows_a_strip = 16;
constexpr std::size_t texel_bytes = 4 * sizeof(float);

constexpr gpu::ExpectedBinding view_bindings[] = {
    {"View", VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER},
    {"Rows", VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
    {"displacement_maps", VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
    {"gradient_maps", VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
    {"moment_maps", VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
    {"sky_map", VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
    {"geometry", VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
};

/// Takes the value out of a Result, or returns its error from the calling function's point of view.
template <class T>
Result<void> keep(T& target, Result<T> made) {
    if (!made)
        return made.error();
    target = std::move(*made);
    return {};
}

void put(gpu::Buffer& buffer, const void* data, std::size_t bytes) {
    SEAWAY_CHECK(bytes <= buffer.mapped().size(), "upload is longer than its buffer");
    std::memcpy(buffer.mapped().data(), data, bytes);
}

} // namespace

Result<Renderer> Renderer::create(gpu::Device& device, int width, int height,
                                  const RenderOptions& options) {
    Renderer made(device, options);
    SEAWAY_TRY(keep(made.target_, gpu::Offscreen::create(device, static_cast<std::uint32_t>(width),
                                                         static_cast<std::uint32_t>(height))));
    SEAWAY_TRY(keep(made.commands_, gpu::Commands::create(device)));
    SEAWAY_TRY(made.create_pipelines());
    SEAWAY_TRY(made.create_mesh_buffers());
    return made;
}

Result<void> Renderer::create_pipelines() {
    const gpu::GraphicsOptions geometry{.depth_format = gpu::Offscreen::depth_format,
                                        .samples = gpu::Offscreen::samples};
    using gpu::GraphicsPipeline;
    SEAWAY_TRY(keep(sea_, GraphicsPipeline::create(*device_, "sea", sea_vert, sea_frag,
                                                   view_bindings, geometry)));
    SEAWAY_TRY(keep(final_, GraphicsPipeline::create(*device_, "final", picture_vert, final_frag,
                                                     view_bindings, {})));
    SEAWAY_TRY(keep(debug_, GraphicsPipeline::create(*device_, "debug", picture_vert, debug_frag,
                                                     view_bindings, {})));
    SEAWAY_TRY(keep(sea_sampler_, gpu::create_sampler(*device_, {.repeat = true})));
    return keep(sky_sampler_, gpu::create_sampler(*device_, {}));
}

Result<void> Renderer::create_mesh_buffers() {
    using gpu::Buffer;
    using gpu::BufferKind;
    SEAWAY_TRY(keep(values_, Buffer::create(*device_, "view values", sizeof(shaders::ViewValues),
                                            BufferKind::upload)));
    SEAWAY_TRY(keep(rows_, Buffer::create(*device_, "mesh rows", Mesh::rows_max * sizeof(float),
                                          BufferKind::upload)));
    constexpr std::size_t strip_bytes =
        std::size_t{rows_a_strip} * Mesh::columns_max * 6 * sizeof(std::uint32_t);
    return keep(indices_,
                Buffer::create(*device_, "mesh indices", strip_bytes, BufferKind::upload));
}

Result<Renderer::Upload> Renderer::create_upload(std::string_view name,
                                                 const gpu::ImageSpec& spec) {
    Upload made;
    SEAWAY_TRY(keep(made.image, gpu::Image::create(*device_, name, spec)));
    SEAWAY_TRY(keep(made.staging,
                    gpu::Buffer::create(*device_, name, made.image.texel_count() * texel_bytes,
                                        gpu::BufferKind::upload)));
    return made;
}

Result<void> Renderer::create_images(int nodes, int cascades) {
    const auto side = static_cast<std::uint32_t>(nodes);
    const gpu::ImageSpec maps{.width = side,
                              .height = side,
                              .layers = static_cast<std::uint32_t>(cascades),
                              .mips = gpu::full_mip_count(side, side),
                              .array = true};
    if (displacement_.image.view() != VK_NULL_HANDLE &&
        displacement_.image.spec().width == maps.width &&
        displacement_.image.spec().layers == maps.layers)
        return {};
    for (Upload* upload : {&displacement_, &gradient_, &moment_})
        SEAWAY_TRY(keep(*upload, create_upload("sea maps", maps)));
    const gpu::ImageSpec sky{.width = Sky::map_width,
                             .height = Sky::map_height,
                             .mips = gpu::full_mip_count(Sky::map_width, Sky::map_height)};
    SEAWAY_TRY(keep(sky_map_, create_upload("sky map", sky)));
    return bind();
}

Result<void> Renderer::bind() {
    const auto map = [](const Upload& upload, const gpu::OwnedSampler& sampler) {
        return gpu::sampled(sampler.get(), upload.image.view(),
                            VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    };
    const gpu::Resource resources[] = {gpu::whole(values_),
                                       gpu::whole(rows_),
                                       map(displacement_, sea_sampler_),
                                       map(gradient_, sea_sampler_),
                                       map(moment_, sea_sampler_),
                                       map(sky_map_, sky_sampler_),
                                       gpu::sampled(sea_sampler_.get(), target_.geometry().view(),
                                                    VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL)};
    // All pipelines have the same bindings: one set serves them.
    return keep(bindings_, sea_.bind(*device_, resources));
}

void Renderer::fill_mesh(const Mesh& mesh) {
    put(rows_, mesh.rows_m.data(), mesh.rows_m.size() * sizeof(float));
    if (columns_ == mesh.columns)
        return;
    columns_ = mesh.columns;
    const std::vector<std::uint32_t> strip = strip_indices(columns_, rows_a_strip);
    put(indices_, strip.data(), strip.size() * sizeof(std::uint32_t));
}

Result<void> Renderer::record(const Mesh& mesh, DebugView view) {
    SEAWAY_TRY(commands_.begin());
    for (const Upload* upload : {&displacement_, &gradient_, &moment_, &sky_map_})
        gpu::record_upload(commands_, upload->staging, upload->image, texel_bytes);
    target_.begin_geometry(commands_);
    sea_.record_bind(commands_, bindings_);
    vkCmdBindIndexBuffer(commands_.get(), indices_.get(), 0, VK_INDEX_TYPE_UINT32);
    const int cells = static_cast<int>(mesh.rows_m.size()) - 1;
    for (int row = 0; row < cells; row += rows_a_strip) {
        const int rows = std::min(rows_a_strip, cells - row);
        vkCmdDrawIndexed(commands_.get(), static_cast<std::uint32_t>(rows * (mesh.columns - 1) * 6),
                         1, 0, row * mesh.columns, 0);
    }
    target_.end_geometry(commands_);
    target_.begin_picture(commands_);
    (view == DebugView::final ? final_ : debug_).record_bind(commands_, bindings_);
    vkCmdDraw(commands_.get(), 3, 1, 0, 0);
    target_.end_picture(commands_);
    return commands_.end();
}

Result<Picture> Renderer::render(const SeaFrame& frame, const Camera& camera, const Sky& sky,
                                 const DebugChoice& debug) {
    SEAWAY_CHECK(!frame.cascades.empty() && frame.cascades.size() <= shaders::view_cascades_max,
                 "1 .. view_cascades_max cascades");
    const SeaMaps maps = build_maps(frame);
    statistics_ = maps.statistics;
    SEAWAY_TRY(create_images(maps.nodes, maps.cascades));
    const double finest_m = frame.cascades.back().spec.spacing_m() / 2;
    const Mesh mesh = build_mesh(camera, maps.statistics, finest_m, options_.cell_pixels);
    fill_mesh(mesh);
    const shaders::ViewValues values = view_values(frame, maps, camera, sky, mesh, options_, debug);
    put(values_, &values, sizeof values);
    const std::vector<float> sky_texels = sky.map();
    put(displacement_.staging, maps.displacement.data(), maps.displacement.size() * sizeof(float));
    put(gradient_.staging, maps.gradient.data(), maps.gradient.size() * sizeof(float));
    put(moment_.staging, maps.moment.data(), maps.moment.size() * sizeof(float));
    put(sky_map_.staging, sky_texels.data(), sky_texels.size() * sizeof(float));
    SEAWAY_TRY(record(mesh, debug.view));
    SEAWAY_TRY(device_->submit_and_wait(commands_));
    Picture picture{static_cast<int>(target_.width()), static_cast<int>(target_.height()), {}};
    picture.rgba.assign(target_.pixels().begin(), target_.pixels().end());
    return picture;
}

} // namespace seaway::client
