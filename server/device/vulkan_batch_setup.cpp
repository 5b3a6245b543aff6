// SPDX-License-Identifier: Apache-2.0
// VulkanBatch before its first run: memory, bindings, the modes.
#include <algorithm>
#include <bit>
#include <cmath>

#include "base/check.h"
#include "server/device/vulkan_batch.h"
#include "shaders/shared/synthesis.h"

namespace seaway::server {

namespace {

using gpu::Buffer;
using gpu::BufferKind;
using gpu::TexelView;

constexpr int most_maps = sea::linear_field_count + 2; ///< of one job: the Jacobian and foam, too

Result<void> make(gpu::Device& device, Buffer& buffer, TexelView* view, VkFormat format,
                  const char* name, std::size_t bytes, std::size_t texel_bytes, BufferKind kind) {
    Result<Buffer> made = Buffer::create(device, name, bytes, kind);
    if (!made)
        return made.error();
    buffer = std::move(*made);
    if (view == nullptr)
        return {};
    Result<TexelView> made_view = TexelView::create(device, buffer, format, texel_bytes, 0, bytes);
    if (!made_view)
        return Error{made_view.error().kind,
                     "buffer \"" + std::string(name) + "\": " + made_view.error().message};
    *view = std::move(*made_view);
    return {};
}

/// Maps whose memory between two passes can be bound at once.
std::size_t maps_that_fit(const gpu::Device& device, const shaders::Transform& transform) {
    return gpu::bound_bytes_max(device, vec4_bytes) /
           (std::size_t{transform.scratch_complexes} * complex_bytes);
}

/// Keyframes of all fields that may be made together without much of a device's memory: with what is read back and the ring
/// their maps stand there five times.
int jobs_with_memory(const gpu::Device& device, const SynthesisKernels& kernels) {
    constexpr std::size_t share = 64;
    const std::size_t job_bytes =
        most_maps * std::size_t{kernels.transform->scratch_complexes} * complex_bytes;
    const std::size_t jobs =
        static_cast<std::size_t>(device.info().memory_bytes) / share / job_bytes;
    return static_cast<int>(std::clamp<std::size_t>(jobs, 1, 1024));
}

template <class T>
Result<void> take(T& place, Result<T> made) {
    if (!made)
        return made.error();
    place = std::move(*made);
    return {};
}

} // namespace

Result<std::unique_ptr<VulkanBatch>> VulkanBatch::create(gpu::Device& device,
                                                         const SynthesisKernels& kernels,
                                                         int cascade_count,
                                                         const VulkanMaps* held) {
    std::unique_ptr<VulkanBatch> made(new VulkanBatch(device, kernels));
    const int together = VulkanBatch::batches(device, kernels.size()) ? cascade_count : 1;
    const int wished = most_maps * std::min(together, jobs_with_memory(device, kernels));
    made->capacity_maps_ = static_cast<int>(std::min<std::size_t>(
        static_cast<std::size_t>(wished), maps_that_fit(device, *kernels.transform)));
    if (held != nullptr) {
        made->held_.maps = &held->buffer();
        made->held_.view = &held->view();
    }
    SEAWAY_TRY(made->allocate(cascade_count));
    SEAWAY_TRY(made->bind());
    return made;
}

Result<void> VulkanBatch::allocate(int cascade_count) {
    constexpr VkFormat rgba32f = VK_FORMAT_R32G32B32A32_SFLOAT;
    constexpr VkFormat rgba32ui = VK_FORMAT_R32G32B32A32_UINT;
    constexpr VkFormat rg32ui = VK_FORMAT_R32G32_UINT;
    constexpr VkFormat r32f = VK_FORMAT_R32_SFLOAT;
    const std::size_t modes = points() * static_cast<std::size_t>(cascade_count);
    const std::size_t scratch_bytes =
        static_cast<std::size_t>(capacity_maps_) * scratch_map_bytes();
    constexpr std::size_t row_bytes = shaders::row_texels_max * vec4_bytes;
    constexpr std::size_t step_bytes = shaders::foam_steps_max * sizeof(shaders::FoamStep);
    struct Wish {
        Buffer& buffer;
        TexelView* view;
        VkFormat format;
        const char* name;
        std::size_t bytes, texel_bytes;
    };
    const Wish wishes[] = {
        {modes_, &modes_view_, rgba32f, "modes", modes * vec4_bytes, vec4_bytes},
        {rates_, &rates_view_, rg32ui, "rates", modes * sizeof(sea::Rate), sizeof(sea::Rate)},
        {orbits_, &orbits_view_, r32f, "orbits", modes * sizeof(float), sizeof(float)},
        {jobs_, &jobs_view_, rgba32ui, "jobs",
         VulkanBatch::most_jobs * sizeof(shaders::SynthesisJob), vec4_bytes},
        {rows_, &rows_view_, rgba32f, "rows", row_bytes, vec4_bytes},
        {scratch_[0], &scratch_views_[0], rgba32f, "first scratch", scratch_bytes, vec4_bytes},
        {scratch_[1], &scratch_views_[1], rgba32f, "second scratch", scratch_bytes, vec4_bytes},
        {foam_steps_, &foam_steps_view_, rgba32ui, "foam steps", step_bytes, vec4_bytes},
        {scales_, &scales_view_, r32f, "scales", shaders::rounded_maps_max * sizeof(float),
         sizeof(float)}};
    for (const Wish& wish : wishes)
        SEAWAY_TRY(server::make(device_, wish.buffer, wish.view, wish.format, wish.name, wish.bytes,
                                wish.texel_bytes, BufferKind::device));
    const std::size_t last = (kernels_.passes.size() + 1) % 2;
    own_.target.maps = &scratch_[last];
    own_.target.view = &scratch_views_[last];
    if (!own_.target.maps->mapped().empty())
        return {};
    return server::make(device_, own_.readback, nullptr, rgba32f, "readback", scratch_bytes,
                        vec4_bytes, BufferKind::readback);
}

Result<void> VulkanBatch::make(Slot& slot) {
    const std::size_t bytes = static_cast<std::size_t>(capacity_maps_) * map_bytes();
    slot = {};
    Slot made;
    SEAWAY_TRY(server::make(device_, made.maps, &made.view, VK_FORMAT_R32G32B32A32_SFLOAT,
                            "maps under way", bytes, vec4_bytes, BufferKind::device));
    SEAWAY_TRY(server::make(device_, made.readback, nullptr, VK_FORMAT_UNDEFINED,
                            "readback of a ring", bytes, vec4_bytes, BufferKind::readback));
    SEAWAY_TRY(take(made.commands, gpu::Commands::create(device_)));
    SEAWAY_TRY(take(made.copying, gpu::Commands::create(device_, gpu::Queue::transfer)));
    SEAWAY_TRY(take(made.timer, gpu::Timer::create(device_, stamps())));
    slot = std::move(made);
    slot.target.maps = &slot.maps;
    slot.target.view = &slot.view;
    if (const Result<void> bound = bind(slot.target); !bound) {
        slot = {};
        return bound;
    }
    return {};
}

Result<void> VulkanBatch::make_rounding(Slot& slot) {
    if (slot.rounding.get() != VK_NULL_HANDLE)
        return {};
    const std::size_t bytes = shaders::rounded_maps_max * sizeof(std::uint32_t) +
                              static_cast<std::size_t>(capacity_maps_) * map_bytes() / 2;
    SEAWAY_TRY(server::make(device_, slot.rounded, nullptr, VK_FORMAT_UNDEFINED, "rounded maps",
                            bytes, vec4_bytes, BufferKind::device));
    return take(slot.rounding, kernels_.round.bind(device_, {gpu::texels(*slot.target.view),
                                                             gpu::texels(scales_view_),
                                                             gpu::whole(slot.rounded)}));
}

std::vector<gpu::Resource> VulkanBatch::resources(std::size_t pass, const gpu::Buffer& to) const {
    const gpu::Resource source = gpu::texels(scratch_views_[(pass + 1) % 2]);
    const gpu::Resource target = gpu::whole(to);
    switch (kernels_.passes[pass].kind) {
    case shaders::PassKind::evolve:
    case shaders::PassKind::evolve_source:
        return {gpu::texels(modes_view_), gpu::texels(rates_view_),  gpu::texels(jobs_view_),
                gpu::texels(rows_view_),  gpu::texels(orbits_view_), target};
    case shaders::PassKind::fields:
        return {source, gpu::texels(jobs_view_), gpu::texels(rows_view_), target};
    case shaders::PassKind::lines_x:
        return {source, gpu::texels(rows_view_), target};
    case shaders::PassKind::lines_y:
        break;
    }
    return {source, target};
}

Result<void> VulkanBatch::bind() {
    bindings_.resize(kernels_.passes.size() - 1);
    for (std::size_t i = 0; i < bindings_.size(); ++i)
        SEAWAY_TRY(take(bindings_[i],
                        kernels_.passes[i].kernel.bind(device_, resources(i, scratch_[i % 2]))));
    SEAWAY_TRY(bind(own_.target));
    if (held_.maps != nullptr)
        SEAWAY_TRY(bind(held_));
    SEAWAY_TRY(take(own_.commands, gpu::Commands::create(device_)));
    return take(own_.timer, gpu::Timer::create(device_, stamps()));
}

Result<void> VulkanBatch::bind(Target& target) {
    const std::size_t last = kernels_.passes.size() - 1;
    SEAWAY_TRY(take(target.last,
                    kernels_.passes[last].kernel.bind(device_, resources(last, *target.maps))));
    return take(target.jacobian, kernels_.jacobian.bind(device_, {gpu::texels(*target.view),
                                                                  gpu::whole(*target.maps)}));
}

Result<void> VulkanBatch::bind_foam(Target& target, const gpu::Buffer& histories) {
    if (target.histories_bytes == histories.size_bytes())
        return {};
    target.histories_bytes = 0;
    SEAWAY_TRY(
        take(target.histories, TexelView::create(device_, histories, VK_FORMAT_R32G32B32A32_SFLOAT,
                                                 vec4_bytes, 0, histories.size_bytes())));
    SEAWAY_TRY(
        take(target.foam,
             kernels_.foam.bind(device_, {gpu::texels(*target.view), gpu::texels(foam_steps_view_),
                                          gpu::texels(target.histories), gpu::whole(histories),
                                          gpu::whole(*target.maps)})));
    target.histories_bytes = histories.size_bytes();
    return {};
}

Result<void> VulkanBatch::upload(std::span<const sea::CascadeModes* const> cascades) {
    const auto n = static_cast<std::size_t>(kernels_.size());
    std::vector<float> modes;
    modes.reserve(points() * 4 * cascades.size());
    std::vector<sea::Rate> rates;
    rates.reserve(points() * cascades.size());
    std::vector<float> orbits;
    orbits.reserve(points() * cascades.size());
    steps_.clear();
    for (const sea::CascadeModes* cascade : cascades) {
        steps_.push_back(static_cast<float>(cascade->spec.wavenumber_step_radpm()));
        if (!cascade->is_there()) {
            modes.resize(modes.size() + points() * 4);
            rates.resize(rates.size() + points());
            orbits.resize(orbits.size() + points());
            continue;
        }
        SEAWAY_CHECK(cascade->h0.size() == points() && cascade->rate.size() == points(),
                     "a cascade of another size");
        for (std::size_t i = 0; i < points(); ++i) {
            const bool transposed = kernels_.transform->transposed;
            const std::size_t y = transposed ? i % n : i / n, x = transposed ? i / n : i % n;
            const std::complex<double> here = cascade->h0[y * n + x];
            const std::complex<double> mirror = cascade->h0[(n - y) % n * n + (n - x) % n];
            SEAWAY_CHECK((x != n / 2 && y != n / 2) || here == 0.0,
                         "the mode without a partner must be zero");
            modes.insert(modes.end(),
                         {static_cast<float>(here.real()), static_cast<float>(here.imag()),
                          static_cast<float>(mirror.real()), static_cast<float>(-mirror.imag())});
            rates.push_back(cascade->rate[y * n + x]);
            const double k = cascade->spec.wavenumber_step_radpm() *
                             std::hypot(sea::signed_index(static_cast<int>(x), kernels_.size()),
                                        sea::signed_index(static_cast<int>(y), kernels_.size()));
            orbits.push_back(static_cast<float>(sea::orbit_aspect(k, cascade->depth_m)));
        }
    }
    SEAWAY_TRY(gpu::upload(device_, modes_, std::as_bytes(std::span(modes))));
    SEAWAY_TRY(gpu::upload(device_, orbits_, std::as_bytes(std::span(orbits))));
    // Little-endian: the low word of a rate comes first, as RG32UI wants it.
    static_assert(std::endian::native == std::endian::little);
    return gpu::upload(device_, rates_, std::as_bytes(std::span(rates)));
}

} // namespace seaway::server
