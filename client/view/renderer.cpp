// SPDX-License-Identifier: Apache-2.0
#include "client/view/renderer.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/check.h"
#include "gpu/descriptor_types.h"
#include "gpu/keep.h"
#include "shaders/view/mesh_comp.h"
#include "shaders/view/picture_vert.h"
#include "shaders/view/sea_frag.h"
#include "shaders/view/sea_vert.h"
#include "shaders/view/shown_bloom_frag.h"
#include "shaders/view/shown_frag.h"

namespace seaway::client {

namespace {

constexpr int rows_a_strip = 16;
constexpr std::size_t vertex_bytes = 2 * texel_bytes; ///< of shaders/view/bindings.glsl

using gpu::storage;
using gpu::texel_buffer;
using gpu::texture;
using gpu::uniform;

constexpr gpu::ExpectedBinding draw_bindings[] = {
    {"View", uniform},           {"Rows", storage},    {"vertices", texel_buffer},
    {"gradients", texel_buffer}, {"sky_map", texture}, {"geometry", texture},
};
constexpr gpu::ExpectedBinding shown_bindings[] = {{"View", uniform}, {"picture", texture}};
constexpr gpu::ExpectedBinding bloomed_bindings[] = {
    {"View", uniform}, {"picture", texture}, {"spread", texel_buffer}};

using gpu::keep;

void put(gpu::Buffer& buffer, const void* data, std::size_t bytes) {
    SEAWAY_CHECK(bytes <= buffer.mapped().size(), "upload is longer than its buffer");
    if (bytes > 0) // a mesh of the sky alone has no row, and its data no place
        std::memcpy(buffer.mapped().data(), data, bytes);
}

std::uint32_t scaled(int side, double scale) {
    return static_cast<std::uint32_t>(std::max(std::lround(side * scale), 1L));
}

} // namespace

Result<Renderer> Renderer::create(gpu::Device& device, int width, int height,
                                  const RenderOptions& options) {
    Renderer made(device, options);
    const Quality& quality = options.quality;
    const gpu::OffscreenSize size{.width = scaled(width, quality.scale),
                                  .height = scaled(height, quality.scale),
                                  .shown_width = static_cast<std::uint32_t>(width),
                                  .shown_height = static_cast<std::uint32_t>(height),
                                  .samples = quality.samples == 1 ? VK_SAMPLE_COUNT_1_BIT
                                                                  : VK_SAMPLE_COUNT_4_BIT};
    SEAWAY_TRY(keep(made.target_, gpu::Offscreen::create(device, size)));
    SEAWAY_TRY(
        keep(made.sea_, DeviceSea::create(device, {.nodes_a_point = quality.nodes_a_point})));
    SEAWAY_TRY(keep(made.sampler_, gpu::create_sampler(device, {.repeat = true})));
    SEAWAY_TRY(made.create_pipelines());
    SEAWAY_TRY(made.create_sky());
    constexpr std::size_t strip_bytes =
        std::size_t{rows_a_strip} * Mesh::columns_max * 6 * sizeof(std::uint32_t);
    SEAWAY_TRY(keep(made.indices_, gpu::Buffer::create(device, "mesh indices", strip_bytes,
                                                       gpu::BufferKind::upload)));
    for (Flight& flight : made.flights_)
        SEAWAY_TRY(made.create_flight(flight));
    return made;
}

Result<void> Renderer::create_pipelines() {
    const gpu::GraphicsOptions geometry{.depth_format = gpu::Offscreen::depth_format,
                                        .samples = target_.size().samples};
    using gpu::GraphicsPipeline;
    const auto pipeline = [&](GraphicsPipeline& target, const char* name,
                              std::span<const std::uint32_t> vertex,
                              std::span<const std::uint32_t> fragment,
                              std::span<const gpu::ExpectedBinding> bindings,
                              const gpu::GraphicsOptions& options) {
        return keep(target,
                    GraphicsPipeline::create(*device_, name, vertex, fragment, bindings, options));
    };
    SEAWAY_TRY(pipeline(geometry_, "sea", sea_vert, sea_frag, draw_bindings, geometry));
    lighting_ = Lighting(*device_, geometry.samples, draw_bindings);
    const gpu::GraphicsOptions bytes{.colour_format = gpu::Offscreen::shown_format};
    SEAWAY_TRY(pipeline(shown_, "film", picture_vert, shown_frag, shown_bindings, bytes));
    if (options_.quality.bloom_pixels > 0) {
        SEAWAY_TRY(pipeline(bloomed_, "film with bloom", picture_vert, shown_bloom_frag,
                            bloomed_bindings, bytes));
        SEAWAY_TRY(keep(bloom_, Bloom::create(*device_, target_.picture(),
                                              options_.quality.bloom_pixels, sampler_.get())));
    }
    return keep(mesh_, gpu::Kernel::create(*device_, "mesh", mesh_comp,
                                           {{{"View", uniform},
                                             {"Rows", storage},
                                             {"displacements", texel_buffer},
                                             {"Vertices", storage}},
                                            0,
                                            {shaders::view_group, 1, 1}}));
}

Result<void> Renderer::create_sky() {
    const gpu::ImageSpec sky{.width = shaders::sky_columns,
                             .height = shaders::sky_rows,
                             .layers = shaders::sky_layers,
                             .mips = gpu::full_mip_count(shaders::sky_columns, shaders::sky_rows),
                             .array = true};
    SEAWAY_TRY(keep(sky_map_.image, gpu::Image::create(*device_, "sky map", sky)));
    return keep(sky_map_.staging,
                gpu::Buffer::create(*device_, "sky map", sky_map_.image.texel_count() * texel_bytes,
                                    gpu::BufferKind::upload));
}

Result<void> Renderer::create_flight(Flight& flight) {
    using gpu::Buffer;
    using gpu::BufferKind;
    SEAWAY_TRY(
        keep(flight.values, Buffer::create(*device_, "view values", sizeof(shaders::ViewValues),
                                           BufferKind::upload)));
    SEAWAY_TRY(
        keep(flight.rows, Buffer::create(*device_, "mesh rows", Mesh::rows_max * sizeof(float),
                                         BufferKind::upload)));
    SEAWAY_TRY(keep(flight.timer, gpu::Timer::create(*device_, passes + 1)));
    SEAWAY_TRY(bind_film(flight));
    return keep(flight.commands, gpu::Commands::create(*device_));
}

Result<void> Renderer::take_sky(const Sky& sky) {
    if (sky_texels_ == sky.texels())
        return {};
    SEAWAY_TRY(finish()); // of a frame that still copies the old one
    sky_texels_ = sky.texels();
    put(sky_map_.staging, sky_texels_->data(), sky_texels_->size() * sizeof(float));
    sky_is_new_ = true;
    return {};
}

Result<void> Renderer::take_mesh(Flight& flight, const Mesh& mesh) {
    put(flight.rows, mesh.rows_m.data(), mesh.rows_m.size() * sizeof(float));
    const std::size_t bytes = std::max<std::size_t>(mesh.vertices(), 1) * vertex_bytes;
    if (vertices_.size_bytes() < bytes) {
        SEAWAY_TRY(finish());
        SEAWAY_TRY(keep(vertices_, gpu::Buffer::create(*device_, "mesh vertices", bytes,
                                                       gpu::BufferKind::device)));
        SEAWAY_TRY(keep(vertex_texels_,
                        gpu::TexelView::create(*device_, vertices_, VK_FORMAT_R32G32B32A32_SFLOAT,
                                               texel_bytes, 0, bytes)));
        ++generation_;
    }
    if (columns_ == mesh.columns || mesh.columns == 0)
        return {};
    SEAWAY_TRY(finish());
    columns_ = mesh.columns;
    const std::vector<std::uint32_t> strip = strip_indices(columns_, rows_a_strip);
    put(indices_, strip.data(), strip.size() * sizeof(std::uint32_t));
    return {};
}

Result<void> Renderer::bind(Flight& flight) {
    if (flight.generation == generation_ + sea_.generation())
        return {};
    const auto image = [&](const gpu::Image& of) {
        return gpu::sampled(sampler_.get(), of.view(), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    };
    SEAWAY_TRY(
        keep(flight.mesh,
             mesh_.bind(*device_, {gpu::whole(flight.values), gpu::whole(flight.rows),
                                   gpu::texels(sea_.displacements()), gpu::whole(vertices_)})));
    // All pipelines that draw the sea have the same bindings: one set serves them.
    const gpu::Resource drawn[] = {gpu::whole(flight.values),   gpu::whole(flight.rows),
                                   gpu::texels(vertex_texels_), gpu::texels(sea_.gradients()),
                                   image(sky_map_.image),       image(target_.geometry())};
    SEAWAY_TRY(keep(flight.draw, geometry_.bind(*device_, drawn)));
    flight.generation = generation_ + sea_.generation();
    return {};
}

Result<void> Renderer::bind_film(Flight& flight) {
    const gpu::Resource shown[] = {gpu::whole(flight.values),
                                   gpu::sampled(sampler_.get(), target_.picture().view(),
                                                VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL),
                                   gpu::texels(bloom_.texels())};
    if (options_.quality.bloom_pixels > 0)
        SEAWAY_TRY(keep(flight.bloomed, bloomed_.bind(*device_, shown)));
    return keep(flight.shown, shown_.bind(*device_, std::span(shown).first(2)));
}

bool Renderer::blooms(const Display& display) const {
    return options_.quality.bloom_pixels > 0 && display.view == DebugView::final &&
           display.bloom > 0;
}

Result<void> Renderer::prepare_debug(DebugView view) {
    if (view == DebugView::final || debug_)
        return {};
    Result<DebugPasses> made = DebugPasses::create(
        *device_, target_.size().samples == VK_SAMPLE_COUNT_1_BIT, gpu::Offscreen::shown_format);
    if (!made)
        return made.error();
    debug_.emplace(std::move(*made));
    return {};
}

Result<void> Renderer::bind_debug(Flight& flight) {
    if (flight.debug_generation == flight.generation)
        return {};
    const auto image = [&](const gpu::Image& of) {
        return gpu::sampled(sampler_.get(), of.view(), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    };
    const gpu::Resource resources[] = {
        gpu::whole(flight.values),        gpu::whole(flight.rows), gpu::texels(vertex_texels_),
        gpu::texels(sea_.gradients()),    image(sky_map_.image),   image(target_.geometry()),
        gpu::texels(sea_.displacements())};
    SEAWAY_TRY(keep(flight.debug, debug_->bind(*device_, resources)));
    flight.debug_generation = flight.generation;
    return {};
}

void Renderer::record_film(Flight& flight, DebugView view, bool blooms) {
    target_.begin_shown(flight.commands);
    if (view != DebugView::final) {
        debug_->record_colours(flight.commands, flight.shown);
    } else {
        if (blooms)
            bloomed_.record_bind(flight.commands, flight.bloomed);
        else
            shown_.record_bind(flight.commands, flight.shown);
        vkCmdDraw(flight.commands.get(), 3, 1, 0, 0);
    }
    target_.end_shown(flight.commands);
}

void Renderer::record_geometry(Flight& flight, const Mesh& mesh) {
    gpu::Commands& commands = flight.commands;
    target_.begin_geometry(commands);
    if (mesh.columns > 0) {
        geometry_.record_bind(commands, flight.draw);
        vkCmdBindIndexBuffer(commands.get(), indices_.get(), 0, VK_INDEX_TYPE_UINT32);
        const int cells = static_cast<int>(mesh.rows_m.size()) - 1;
        // A strip's indices count from its first vertex. The last strip is shorter: rows come first in a block of
        // columns, so it is drawn block by block.
        for (int row = 0; row < cells; row += rows_a_strip)
            for (const IndexRange& range :
                 strip_ranges(mesh.columns, rows_a_strip, std::min(rows_a_strip, cells - row)))
                vkCmdDrawIndexed(commands.get(), range.count, 1, range.first, row * mesh.columns,
                                 0);
    }
    target_.end_geometry(commands);
}

Result<void> Renderer::record(Flight& flight, const Mesh& mesh, DebugView view,
                              const Lighting::Needs& needs, Wanted wanted, bool blooms) {
    gpu::Commands& commands = flight.commands;
    SEAWAY_TRY(commands.begin());
    flight.timer.reset(commands);
    const auto stamp = [&] { flight.timer.stamp(commands); };
    if (std::exchange(sky_is_new_, false))
        gpu::record_upload(commands, sky_map_.staging, sky_map_.image, texel_bytes);
    commands.barrier(gpu::Stage::graphics, gpu::Stage::compute); // the frame before reads its maps
    stamp();
    const bool sees_sea = needs.sea;
    if (sees_sea || info(view).source == DebugSource::map)
        sea_.record(commands, flight.values);
    stamp();
    if (sees_sea)
        commands.dispatch_all(mesh_, flight.mesh, {}, mesh.vertices(), shaders::view_group);
    commands.barrier(gpu::Stage::compute, gpu::Stage::graphics);
    stamp();
    if (sees_sea || needs.under || view != DebugView::final)
        record_geometry(flight, mesh);
    stamp();
    if (view == DebugView::final) {
        lighting_.record(commands, target_, flight.draw, needs);
    } else {
        target_.begin_picture(commands);
        debug_->record(commands, flight.debug, view);
        target_.end_picture(commands);
    }
    stamp();
    spray_.record(commands, target_, next_);
    stamp();
    const bool with_bloom = blooms && wanted != Wanted::numbers;
    if (with_bloom)
        bloom_.record(commands);
    stamp();
    if (wanted == Wanted::numbers) {
        target_.read_picture(commands);
    } else {
        record_film(flight, view, with_bloom);
        if (wanted == Wanted::bytes)
            target_.read_shown(commands);
    }
    stamp();
    return commands.end();
}

Result<void> Renderer::draw(const SeaFrame& frame, const Camera& camera, const Sky& sky,
                            const DebugChoice& debug, const Display& display, Wanted wanted,
                            const Camera* mesh_of) {
    SEAWAY_CHECK(info(debug.view).source != DebugSource::table, "tables are not drawn here");
    SEAWAY_TRY(prepare_debug(debug.view));
    Flight& flight = flights_[next_];
    SEAWAY_TRY(wait(flight));
    Camera drawn = camera; // at the size that is drawn
    drawn.width = static_cast<int>(target_.size().width);
    drawn.height = static_cast<int>(target_.size().height);
    SEAWAY_TRY(take_sky(sky));
    if (!sea_.fits(frame))
        SEAWAY_TRY(finish()); // of a frame that still reads what is made anew
    SEAWAY_TRY(sea_.take(frame, flight.values));
    Camera meshed = mesh_of ? *mesh_of : drawn;
    meshed.width = drawn.width;
    meshed.height = drawn.height;
    const EyeSide eye = eye_side(frame, camera);
    drawn.z_m = eye.z_m;
    const bool under = mesh_of ? eye_side(frame, meshed).under : eye.under;
    const bool flat = info(debug.view).source == DebugSource::map;
    Mesh mesh = flat ? Mesh{} : build_mesh(meshed, frame, options_.quality.cell_pixels, under);
    mesh.apex_m += glm::dvec2(meshed.x_m - camera.x_m, meshed.y_m - camera.y_m);
    SEAWAY_TRY(take_mesh(flight, mesh));
    SEAWAY_TRY(bind(flight));
    if (debug_)
        SEAWAY_TRY(bind_debug(flight));
    shaders::ViewValues values = view_values(frame, drawn, sky, mesh, options_, debug, display);
    values.eye_depth_m = static_cast<float>(eye.depth_m);
    sea_.describe(frame, {camera.x_m, camera.y_m}, values);
    const bool spray = debug.view == DebugView::final && !eye.under && mesh.columns > 0;
    SEAWAY_TRY(spray_.prepare(*device_,
                              spray_values(frame, camera, spray ? options_.quality.spray_slots : 0),
                              next_, flight.values, sea_, target_, sampler_.get()));
    if (blooms(display))
        bloom_.describe(options_.quality.scale, values);
    put(flight.values, &values, sizeof values);
    const Lighting::Needs needs{mesh.columns > 0, sky_seen(values.sky, drawn), eye.under};
    if (debug.view == DebugView::final)
        SEAWAY_TRY(lighting_.prepare(needs));
    SEAWAY_TRY(record(flight, mesh, debug.view, needs, wanted, blooms(display)));
    SEAWAY_TRY_LET(flight.ticket, device_->submit(flight.commands));
    next_ = (next_ + 1) % flights_.size();
    return {};
}

Result<void> Renderer::wait(Flight& flight) {
    if (flight.ticket == 0)
        return {};
    SEAWAY_TRY(device_->wait(std::exchange(flight.ticket, 0)));
    SEAWAY_TRY_LET(pass_times_, flight.timer.read(*device_));
    return {};
}

Result<void> Renderer::finish() {
    for (std::size_t i = 0; i < flights_.size(); ++i) // the older one first
        SEAWAY_TRY(wait(flights_[(next_ + i) % flights_.size()]));
    return {};
}

Result<Picture> Renderer::render(const SeaFrame& frame, const Camera& camera, const Sky& sky,
                                 const DebugChoice& debug) {
    SEAWAY_TRY(draw(frame, camera, sky, debug, {}, Wanted::numbers));
    SEAWAY_TRY(finish());
    const gpu::OffscreenSize& size = target_.size();
    Picture picture{static_cast<int>(size.width), static_cast<int>(size.height), {}};
    picture.rgba.assign(target_.pixels().begin(), target_.pixels().end());
    return picture;
}

Result<ShownPicture> Renderer::show(const SeaFrame& frame, const Camera& camera, const Sky& sky,
                                    const DebugChoice& debug, const Display& display) {
    SEAWAY_TRY(draw(frame, camera, sky, debug, display, Wanted::bytes));
    SEAWAY_TRY(finish());
    return shown_picture();
}

ShownPicture Renderer::shown_picture() const {
    const gpu::OffscreenSize& size = target_.size();
    ShownPicture picture{
        static_cast<int>(size.shown_width), static_cast<int>(size.shown_height), {}};
    picture.rgba.assign(target_.bytes().begin(), target_.bytes().end());
    return picture;
}

Result<void> Renderer::develop_there(const Picture& picture, const Display& display) {
    return develop_as(picture, display, Wanted::nothing);
}

Result<void> Renderer::develop_as(const Picture& picture, const Display& display, Wanted wanted) {
    SEAWAY_TRY(prepare_debug(display.view));
    SEAWAY_TRY(finish());
    Flight& flight = flights_[next_];
    const std::size_t bytes = picture.rgba.size() * sizeof(float);
    if (undeveloped_.size_bytes() < bytes)
        SEAWAY_TRY(keep(undeveloped_, gpu::Buffer::create(*device_, "undeveloped picture", bytes,
                                                          gpu::BufferKind::upload)));
    put(undeveloped_, picture.rgba.data(), bytes);
    shaders::ViewValues values;
    set_display(values, display, options_.quality.scale);
    const bool with_bloom = blooms(display);
    if (with_bloom)
        bloom_.describe(options_.quality.scale, values);
    put(flight.values, &values, sizeof values);
    SEAWAY_TRY(flight.commands.begin());
    gpu::record_upload(flight.commands, undeveloped_, target_.picture(), texel_bytes);
    if (with_bloom)
        bloom_.record(flight.commands);
    record_film(flight, display.view, with_bloom);
    if (wanted == Wanted::bytes)
        target_.read_shown(flight.commands);
    SEAWAY_TRY(flight.commands.end());
    return device_->submit_and_wait(flight.commands);
}

Result<ShownPicture> Renderer::develop(const Picture& picture, const Display& display) {
    SEAWAY_TRY(develop_as(picture, display, Wanted::bytes));
    return shown_picture();
}

} // namespace seaway::client
