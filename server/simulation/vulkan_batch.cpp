// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/vulkan_batch.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstring>

#include "base/check.h"
#include "shaders/shared/synthesis.h"

namespace seaway::server {

namespace {

using gpu::Buffer;
using gpu::BufferKind;
using gpu::Stage;
using gpu::TexelView;

constexpr std::size_t float_bytes = 4;
constexpr std::size_t vec4_bytes = 16;
constexpr std::size_t complex_bytes = 8;
constexpr int strain_fields = 3; // what the Jacobian is made of

// Above this size one keyframe at a time is faster: its scratch stays in the cache
// (docs/performance.md).
constexpr int largest_batched_size = 256;
constexpr int fields_per_batched_cascade = 8;
constexpr int most_jobs = 64;

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
        return Error{"buffer \"" + std::string(name) + "\": " + made_view.error().message};
    *view = std::move(*made_view);
    return {};
}

template <class T>
Result<void> take(T& place, Result<T> made) {
    if (!made)
        return made.error();
    place = std::move(*made);
    return {};
}

} // namespace

Result<std::unique_ptr<VulkanBatch>>
VulkanBatch::create(gpu::Device& device, const SynthesisKernels& kernels, int cascade_count) {
    std::unique_ptr<VulkanBatch> made(new VulkanBatch(device, kernels));
    constexpr int all_fields = shaders::max_fields;
    made->capacity_fields_ = kernels.size() <= largest_batched_size
                                 ? std::max(all_fields, fields_per_batched_cascade * cascade_count)
                                 : all_fields;
    if (Result<void> allocated = made->allocate(cascade_count); !allocated)
        return allocated.error();
    if (Result<void> bound = made->bind(); !bound)
        return bound.error();
    return made;
}

Result<void> VulkanBatch::allocate(int cascade_count) {
    constexpr VkFormat rgba32f = VK_FORMAT_R32G32B32A32_SFLOAT;
    constexpr VkFormat rgba32ui = VK_FORMAT_R32G32B32A32_UINT;
    constexpr VkFormat rg32ui = VK_FORMAT_R32G32_UINT;
    const std::size_t modes = points() * static_cast<std::size_t>(cascade_count);
    const std::size_t map_bytes = static_cast<std::size_t>(kernels_.transform->scratch_complexes) *
                                  static_cast<std::size_t>(capacity_fields_) * complex_bytes;
    const std::size_t jacobian_bytes =
        points() * static_cast<std::size_t>(capacity_fields_ / strain_fields) * float_bytes;
    constexpr std::size_t row_bytes =
        (shaders::first_field_texel + shaders::max_fields) * vec4_bytes;
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
        {jobs_, &jobs_view_, rgba32ui, "jobs", most_jobs * sizeof(shaders::SynthesisJob),
         vec4_bytes},
        {rows_, &rows_view_, rgba32f, "rows", row_bytes, vec4_bytes},
        {scratch_[0], &scratch_views_[0], rgba32f, "first scratch", map_bytes, vec4_bytes},
        {scratch_[1], &scratch_views_[1], rgba32f, "second scratch", map_bytes, vec4_bytes},
        {jacobian_, nullptr, rgba32f, "jacobian", jacobian_bytes, vec4_bytes}};
    for (const Wish& wish : wishes)
        if (Result<void> made = make(device_, wish.buffer, wish.view, wish.format, wish.name,
                                     wish.bytes, wish.texel_bytes, BufferKind::device);
            !made)
            return made;
    if (!maps().mapped().empty())
        return {};
    jacobian_offset_ = map_bytes;
    return make(device_, readback_, nullptr, rgba32f, "readback", map_bytes + jacobian_bytes,
                vec4_bytes, BufferKind::readback);
}

std::vector<gpu::Resource> VulkanBatch::resources(std::size_t pass) const {
    const gpu::Resource source = gpu::texels(scratch_views_[(pass + 1) % 2]);
    const gpu::Resource target = gpu::whole(scratch_[pass % 2]);
    switch (kernels_.passes[pass].kind) {
    case shaders::PassKind::evolve:
        return {gpu::texels(modes_view_), gpu::texels(rates_view_), gpu::texels(jobs_view_),
                gpu::texels(rows_view_), target};
    case shaders::PassKind::fields:
        return {source, gpu::texels(jobs_view_), gpu::texels(rows_view_), target};
    case shaders::PassKind::lines_y:
    case shaders::PassKind::lines_x:
        break;
    }
    return {source, target};
}

Result<void> VulkanBatch::bind() {
    bindings_.resize(kernels_.passes.size());
    for (std::size_t i = 0; i < kernels_.passes.size(); ++i)
        if (Result<void> bound =
                take(bindings_[i], kernels_.passes[i].kernel.bind(device_, resources(i)));
            !bound)
            return bound;
    const std::size_t last = (kernels_.passes.size() + 1) % 2;
    if (Result<void> bound = take(
            jacobian_bindings_, kernels_.jacobian.bind(device_, {gpu::texels(scratch_views_[last]),
                                                                 gpu::whole(jacobian_)}));
        !bound)
        return bound;
    if (Result<void> made = take(commands_, gpu::Commands::create(device_)); !made)
        return made;
    const auto stamps = static_cast<std::uint32_t>(kernels_.passes.size()) + 2;
    return take(timer_, gpu::Timer::create(device_, stamps));
}

Result<void> VulkanBatch::upload(std::span<const sea::CascadeModes* const> cascades) {
    const auto n = static_cast<std::size_t>(kernels_.size());
    std::vector<float> modes;
    modes.reserve(points() * 4 * cascades.size());
    std::vector<sea::Rate> rates;
    rates.reserve(points() * cascades.size());
    steps_.clear();
    for (const sea::CascadeModes* cascade : cascades) {
        SEAWAY_CHECK(cascade->h0.size() == points() && cascade->rate.size() == points(),
                     "a cascade of another size");
        steps_.push_back(static_cast<float>(cascade->spec.wavenumber_step_radpm()));
        for (std::size_t i = 0; i < points(); ++i) {
            const bool transposed = kernels_.transform->lanes != 0;
            const std::size_t y = transposed ? i % n : i / n, x = transposed ? i / n : i % n;
            const std::complex<double> here = cascade->h0[y * n + x];
            const std::complex<double> mirror = cascade->h0[(n - y) % n * n + (n - x) % n];
            SEAWAY_CHECK((x != n / 2 && y != n / 2) || here == 0.0,
                         "the mode without a partner must be zero");
            modes.insert(modes.end(),
                         {static_cast<float>(here.real()), static_cast<float>(here.imag()),
                          static_cast<float>(mirror.real()), static_cast<float>(-mirror.imag())});
            rates.push_back(cascade->rate[y * n + x]);
        }
    }
    if (Result<void> sent = gpu::upload(device_, modes_, std::as_bytes(std::span(modes))); !sent)
        return sent;
    // Little-endian: the low word of a rate comes first, as RG32UI wants it.
    static_assert(std::endian::native == std::endian::little);
    return gpu::upload(device_, rates_, std::as_bytes(std::span(rates)));
}

int VulkanBatch::max_jobs(int fields) const {
    if (kernels_.size() > largest_batched_size || fields == 0)
        return 1;
    return std::clamp(capacity_fields_ / fields, 1, most_jobs);
}

void VulkanBatch::write(Buffer& buffer, std::span<const std::byte> bytes) {
    if (!buffer.mapped().empty()) {
        std::memcpy(buffer.mapped().data(), bytes.data(), bytes.size());
        return;
    }
    commands_.update(buffer, bytes);
}

Result<void> VulkanBatch::record(std::span<const Job> jobs, const Packing& packing,
                                 const sea::Choppiness* choppiness) {
    std::vector<shaders::SynthesisJob> texels;
    for (const Job& job : jobs) {
        const auto time = static_cast<std::uint64_t>(job.phase_time_us);
        texels.push_back(
            {static_cast<std::uint32_t>(job.cascade), static_cast<std::uint32_t>(time),
             static_cast<std::uint32_t>(time >> 32),
             std::bit_cast<std::uint32_t>(steps_[static_cast<std::size_t>(job.cascade)])});
    }
    if (Result<void> begun = commands_.begin(); !begun)
        return begun;
    if (time_passes_)
        timer_.reset(commands_);
    write(jobs_, std::as_bytes(std::span(texels)));
    write(rows_, std::as_bytes(std::span(packing.rows)));
    if (jobs_.mapped().empty())
        commands_.barrier(Stage::copy, Stage::compute);
    stamp();
    const shaders::SynthesisPush push{static_cast<std::uint32_t>(packing.sources),
                                      static_cast<std::uint32_t>(packing.fields)};
    const auto count = static_cast<std::uint32_t>(jobs.size());
    for (std::size_t i = 0; i < kernels_.passes.size(); ++i) {
        if (i > 0)
            commands_.barrier(Stage::compute, Stage::compute);
        dispatch(kernels_.passes[i], bindings_[i], push, count);
        stamp();
    }
    if (choppiness != nullptr) {
        commands_.barrier(Stage::compute, Stage::compute);
        dispatch_jacobian(packing, *choppiness, count);
        stamp();
    }
    finish(jobs.size(), push.fields, choppiness != nullptr);
    return commands_.end();
}

// Groups go last: drivers that cut a dispatch in halves then cut each source and field in halves.
void VulkanBatch::dispatch(const SynthesisKernels::Pass& pass, const gpu::Bindings& bindings,
                           const shaders::SynthesisPush& push, std::uint32_t jobs) {
    std::uint32_t parts = 1;
    if (pass.kind == shaders::PassKind::lines_y || pass.kind == shaders::PassKind::fields)
        parts = push.sources;
    if (pass.kind == shaders::PassKind::lines_x)
        parts = push.fields;
    commands_.dispatch(pass.kernel, bindings, std::as_bytes(std::span(&push, 1)), parts, jobs,
                       pass.groups);
}

void VulkanBatch::dispatch_jacobian(const Packing& packing, const sea::Choppiness& choppiness,
                                    std::uint32_t jobs) {
    const auto plane = [&](sea::Field field) {
        return static_cast<std::uint32_t>(packing.plane_of(field));
    };
    const shaders::JacobianPush push{static_cast<std::uint32_t>(packing.fields),
                                     plane(sea::Field::strain_xx),
                                     plane(sea::Field::strain_yy),
                                     plane(sea::Field::strain_xy),
                                     static_cast<float>(choppiness.x),
                                     static_cast<float>(choppiness.y),
                                     static_cast<std::uint32_t>(kernels_.size())};
    const auto groups = static_cast<std::uint32_t>(points() / 4 / shaders::synthesis_workgroup);
    commands_.dispatch(kernels_.jacobian, jacobian_bindings_, std::as_bytes(std::span(&push, 1)),
                       groups, 1, jobs);
}

void VulkanBatch::finish(std::size_t jobs, std::size_t fields, bool jacobian) {
    if (readback_.size_bytes() == 0) {
        commands_.barrier(Stage::compute, Stage::host);
        return;
    }
    commands_.barrier(Stage::compute, Stage::copy);
    commands_.copy(maps(), readback_, points() * jobs * fields * float_bytes);
    if (jacobian)
        commands_.copy(jacobian_, readback_, points() * jobs * float_bytes, 0, jacobian_offset_);
    commands_.barrier(Stage::copy, Stage::host);
}

Result<void> VulkanBatch::run(std::span<const Job> jobs, const Packing& packing,
                              const sea::Choppiness* choppiness) {
    SEAWAY_CHECK(packing.fields > 0 && !jobs.empty(), "nothing to run");
    SEAWAY_CHECK(static_cast<int>(jobs.size()) <= max_jobs(packing.fields), "too many jobs");
    if (Result<void> recorded = record(jobs, packing, choppiness); !recorded)
        return recorded;
    const auto start = std::chrono::steady_clock::now();
    if (Result<void> done = device_.submit_and_wait(commands_); !done)
        return done;
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
    fields_ = static_cast<std::size_t>(packing.fields);
    dispatches_ += kernels_.passes.size() + (choppiness != nullptr ? 1 : 0);
    return read_timer(wall.count());
}

void VulkanBatch::stamp() {
    if (time_passes_)
        timer_.stamp(commands_);
}

Result<void> VulkanBatch::read_timer(double wall_seconds) {
    if (!time_passes_) {
        device_seconds_ += wall_seconds;
        return {};
    }
    Result<std::vector<double>> seconds = timer_.read(device_);
    if (!seconds)
        return seconds.error();
    pass_seconds_ = std::move(*seconds);
    for (const double pass : pass_seconds_)
        device_seconds_ += pass;
    return {};
}

void VulkanBatch::read_plane(int job, int plane, std::span<float> out) const {
    const std::byte* from = (readback_.size_bytes() ? readback_ : maps()).mapped().data();
    const std::size_t index =
        static_cast<std::size_t>(job) * fields_ + static_cast<std::size_t>(plane);
    std::memcpy(out.data(), from + index * points() * float_bytes, points() * float_bytes);
}

void VulkanBatch::read_jacobian(int job, std::span<float> out) const {
    const std::byte* from = readback_.size_bytes() ? readback_.mapped().data() + jacobian_offset_
                                                   : jacobian_.mapped().data();
    std::memcpy(out.data(), from + static_cast<std::size_t>(job) * points() * float_bytes,
                points() * float_bytes);
}

} // namespace seaway::server
