// SPDX-License-Identifier: Apache-2.0
#include "server/device/vulkan_synthesizer.h"

#include <algorithm>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "base/check.h"
#include "base/thread_pool.h"
#include "gpu/device.h"
#include "sea/surface/maps/sine_maps.h"
#include "server/device/spare_buffers.h"
#include "server/device/vulkan_batch.h"
#include "server/device/vulkan_check.h"
#include "server/device/vulkan_foam.h"
#include "server/device/vulkan_kernel_shelf.h"
#include "server/device/vulkan_maps.h"
#include "server/device/vulkan_parts.h"

namespace seaway::server {

namespace {

constexpr int first_checked_size = 64;
constexpr sea::FieldSet strains{sea::Field::strain_xx, sea::Field::strain_yy,
                                sea::Field::strain_xy};

sea::FieldSet linear_part(sea::FieldSet fields) {
    return fields & sea::linear_fields;
}

bool fits_band(const sea::CascadeModes* cascade) {
    const int size = cascade->spec.size;
    const auto n = static_cast<std::size_t>(size);
    for (std::size_t i = 0; i < cascade->h0.size(); ++i)
        if (cascade->h0[i] != 0.0 &&
            !(shaders::fits_band(sea::signed_index(static_cast<int>(i % n), size), size) &&
              shaders::fits_band(sea::signed_index(static_cast<int>(i / n), size), size)))
            return false;
    return true;
}

class Vulkan final : public VulkanSynthesizer {
  public:
    static Result<std::unique_ptr<VulkanSynthesizer>> create(const VulkanOptions& options);
    static Result<std::unique_ptr<VulkanSynthesizer>> create(std::shared_ptr<gpu::Device> device,
                                                             const VulkanOptions& options);

    std::string description() const override;
    Result<void> set_sea(sea::RealizationPtr sea, std::uint32_t epoch) override;
    Result<FoamMapPtr> open_foam(int size, const FoamMap* from) override;
    Result<std::vector<NewKeyframePtr>>
    synthesize(std::span<const KeyframeRequest> requests) override;
    Result<std::vector<StandingKeyframe>>
    synthesize_there(std::span<const KeyframeRequest> requests) override;
    Result<std::vector<SynthesisStage>> stages(const KeyframeRequest& request) override;
    SynthesisCounters counters() const override;
    std::vector<std::string> validation_messages() const override {
        return device_->validation().validation_messages();
    }

  private:
    /// Requests that one series of dispatches can serve.
    struct Batch {
        int size;
        sea::FieldSet fields;
        bool looks; ///< foam does, at strains
        std::vector<std::size_t> requests;

        bool jacobian() const { return fields.contains(sea::Field::jacobian); }
        /// By transforms.
        sea::FieldSet computed() const {
            return jacobian() || looks ? linear_part(fields) | strains : linear_part(fields);
        }
        /// `apart`: as pack() takes it.
        Packing packing(std::size_t apart = 0) const { return pack(computed(), fields, apart); }
    };

    Vulkan() = default;
    /// What is on the device for the cascades of one size.
    struct Group {
        std::unique_ptr<VulkanBatch> batch;
        std::size_t cascades;
        bool band_limited;
    };
    VulkanBatch& batch_of(const KeyframeRequest& request);
    std::vector<Batch> sort(std::span<const KeyframeRequest> requests) const;
    /// Does `jobs(device_batch, batch, indices)` for some requests after the other that one run serves, by their places.
    template <class Jobs>
    Result<void> run(std::span<const KeyframeRequest> requests, const Jobs& jobs);
    Result<void> run_jobs(VulkanBatch& device_batch, const Batch& batch,
                          std::span<const KeyframeRequest> requests,
                          std::span<const std::size_t> indices, std::span<NewKeyframePtr> out);
    using Requests = std::span<const KeyframeRequest>;
    Result<StandingKeyframe> run_job_there(VulkanBatch& device_batch, const Batch& batch,
                                           Requests requests, std::size_t index);
    Result<void> run_on_device(VulkanBatch& device_batch, const Batch& batch,
                               const Packing& packing, std::span<const KeyframeRequest> requests,
                               std::span<const std::size_t> indices,
                               std::optional<std::size_t> first_held);
    /// Maps of a size that keyframes hold where they were computed; null: they are copied.
    Result<VulkanMaps*> held_maps(int size);
    /// Without values.
    std::shared_ptr<sea::Keyframe> keyframe(const KeyframeRequest& request) const;
    /// The maps of the last run, to keyframes[job].
    void copy_maps(const VulkanBatch& device_batch, const Packing& packing,
                   std::span<const std::shared_ptr<sea::Keyframe>> keyframes);

    // Order of members is order of construction; the device goes last.
    std::shared_ptr<gpu::Device> device_; ///< with keyframes that hold maps
    std::unique_ptr<KernelShelf> kernels_;
    std::size_t held_map_bytes_ = held_map_bytes_max;
    bool maps_stay_ = false;
    std::map<int, std::shared_ptr<VulkanMaps>>
        held_;                       ///< by size, of any sea; none: they are copied
    std::map<int, Group> groups_;    ///< by size, of this sea
    std::map<int, VulkanFoam> foam_; ///< by size, of any sea
    sea::RealizationPtr sea_;
    std::uint32_t epoch_ = 0;
    std::vector<int> position_; ///< of each cascade within its batch
    std::shared_ptr<SpareBuffers> spare_ = std::make_shared<SpareBuffers>();
    ThreadPool copiers_{2};
    SynthesisCounters counters_;
};

Result<std::unique_ptr<VulkanSynthesizer>> Vulkan::create(const VulkanOptions& options) {
    Result<std::unique_ptr<gpu::Device>> device = gpu::Device::create(
        {.pick = options.device, .validation = options.validation, .staged = options.staged});
    if (!device)
        return device.error();
    return create(std::shared_ptr<gpu::Device>(std::move(*device)), options);
}

Result<std::unique_ptr<VulkanSynthesizer>> Vulkan::create(std::shared_ptr<gpu::Device> device,
                                                          const VulkanOptions& options) {
    std::unique_ptr<Vulkan> made(new Vulkan);
    made->device_ = std::move(device);
    made->kernels_ =
        std::make_unique<KernelShelf>(*made->device_, options.any_device_kernels, options.tuning);
    made->held_map_bytes_ = options.held_map_bytes;
    made->maps_stay_ = options.maps_stay;
    if (const auto checked = made->kernels_->get(first_checked_size, true); !checked)
        return checked.error();
    return std::unique_ptr<VulkanSynthesizer>(std::move(made));
}

std::string Vulkan::description() const {
    return device_->info().name + ", " + device_->info().driver + ", kernels" +
           kernels_->description();
}

Result<void> Vulkan::set_sea(sea::RealizationPtr sea, std::uint32_t epoch) {
    std::map<int, std::vector<const sea::CascadeModes*>> by_size;
    std::vector<int> position;
    for (const sea::CascadeModes& cascade : sea->cascades) {
        std::vector<const sea::CascadeModes*>& cascades = by_size[cascade.spec.size];
        position.push_back(static_cast<int>(cascades.size()));
        cascades.push_back(&cascade);
        counters_.cascades += cascade.is_there();
    }
    sea_.reset(); // until all is uploaded there is no sea
    std::erase_if(groups_, [&](const auto& group) { return by_size.count(group.first) == 0; });
    for (const auto& [size, cascades] : by_size) {
        const bool band_limited = std::all_of(cascades.begin(), cascades.end(), fits_band);
        const auto old = groups_.find(size);
        if (old == groups_.end() || old->second.cascades != cascades.size() ||
            old->second.band_limited != band_limited) {
            groups_.erase(size);
            SEAWAY_TRY_LET(const SynthesisKernels* pipelines, kernels_->get(size, band_limited));
            SEAWAY_TRY_LET(const VulkanMaps* held, held_maps(size));
            Result<std::unique_ptr<VulkanBatch>> made =
                VulkanBatch::create(*device_, *pipelines, static_cast<int>(cascades.size()), held);
            if (!made)
                return made.error();
            groups_[size] = {std::move(*made), cascades.size(), band_limited};
        }
        SEAWAY_TRY(groups_[size].batch->upload(cascades));
    }
    sea_ = std::move(sea);
    epoch_ = epoch;
    position_ = std::move(position);
    return {};
}

VulkanBatch& Vulkan::batch_of(const KeyframeRequest& request) {
    SEAWAY_CHECK(request.cascade >= 0 &&
                     static_cast<std::size_t>(request.cascade) < sea_->cascades.size(),
                 "a keyframe of a cascade that the sea does not have");
    return *groups_.at(sea_->cascades[static_cast<std::size_t>(request.cascade)].spec.size).batch;
}

std::vector<Vulkan::Batch> Vulkan::sort(std::span<const KeyframeRequest> requests) const {
    std::vector<Batch> batches;
    for (std::size_t i = 0; i < requests.size(); ++i) {
        const KeyframeRequest& request = requests[i];
        const int size = sea_->cascades[static_cast<std::size_t>(request.cascade)].spec.size;
        const bool looks = request.foam != nullptr && request.foam->looks(request.fields);
        const sea::FieldSet fields = request.fields;
        // The latest that will do, and none before one that holds a turn of the same foam map.
        const auto same = std::find_if(batches.rbegin(), batches.rend(), [&](const Batch& batch) {
            return (batch.size == size && batch.fields == fields && batch.looks == looks) ||
                   has_turn_of(batch.requests, requests, request.foam);
        });
        if (same != batches.rend() && same->size == size && same->fields == fields &&
            same->looks == looks)
            same->requests.push_back(i);
        else
            batches.push_back({size, fields, looks, {i}});
    }
    return batches;
}

Result<std::vector<NewKeyframePtr>> Vulkan::synthesize(std::span<const KeyframeRequest> requests) {
    if (!sea_)
        return Error{"no sea on the device: the last one could not be uploaded"};
    std::vector<KeyframeRequest> parts;
    std::vector<std::size_t> counts;
    for (const KeyframeRequest& request : requests) {
        const std::vector<KeyframeRequest> more =
            parts_of(request, batch_of(request).maps_at_once());
        parts.insert(parts.end(), more.begin(), more.end());
        counts.push_back(more.size());
    }
    std::vector<NewKeyframePtr> made(parts.size());
    SEAWAY_TRY(run(parts, [&](VulkanBatch& device_batch, const Batch& batch, auto indices) {
        return run_jobs(device_batch, batch, parts, indices, made);
    }));
    counters_.keyframes += requests.size();
    if (parts.size() == requests.size())
        return made;
    std::vector<NewKeyframePtr> out;
    for (std::size_t i = 0, first = 0; i < requests.size(); first += counts[i++]) {
        out.push_back(counts[i] == 1 ? made[first] : keyframe(requests[i]));
        if (counts[i] == 1)
            continue;
        sea::Keyframe& whole = *out.back();
        whole.values =
            spare_->take(whole.plane_size() * static_cast<std::size_t>(whole.fields.size()));
        join(std::span(made).subspan(first, counts[i]), whole);
    }
    return out;
}

Result<std::vector<StandingKeyframe>>
Vulkan::synthesize_there(std::span<const KeyframeRequest> requests) {
    SEAWAY_CHECK(maps_stay_, "maps stay where VulkanOptions say that they may");
    if (!sea_)
        return Error{"no sea on the device: the last one could not be uploaded"};
    std::vector<StandingKeyframe> out(requests.size());
    // One keyframe a run, and what it is made of elsewhere: so keyframes of one length stand side by side, and what one
    // leaves fits the next.
    const auto there = [&](VulkanBatch& device_batch, const Batch& batch,
                           auto indices) -> Result<void> {
        for (const std::size_t index : indices) {
            SEAWAY_TRY_LET(out[index], run_job_there(device_batch, batch, requests, index));
        }
        return {};
    };
    SEAWAY_TRY(run(requests, there));
    counters_.keyframes += requests.size();
    return out;
}

template <class Jobs>
Result<void> Vulkan::run(std::span<const KeyframeRequest> requests, const Jobs& jobs) {
    for (const Batch& batch : sort(requests)) {
        VulkanBatch& device_batch = *groups_.at(batch.size).batch;
        const std::span<const std::size_t> all(batch.requests);
        const auto at_once =
            static_cast<std::size_t>(std::max(device_batch.max_jobs(batch.packing().maps), 1));
        for (std::size_t first = 0; first < all.size(); first += at_once) {
            const std::size_t count = std::min(at_once, all.size() - first);
            if (const Result<void> done = jobs(device_batch, batch, all.subspan(first, count));
                !done)
                return Error{done.error().kind, device_->info().name + ": " + done.error().message};
        }
    }
    return {};
}

Result<VulkanMaps*> Vulkan::held_maps(int size) {
    if (!(device_->unified_memory() || maps_stay_) || held_map_bytes_ == 0)
        return static_cast<VulkanMaps*>(nullptr);
    std::shared_ptr<VulkanMaps>& maps = held_[size];
    if (!maps) {
        SEAWAY_TRY_LET(maps, VulkanMaps::create(device_, size, held_map_bytes_));
    }
    return maps->size() > 0 ? maps.get() : nullptr;
}

Result<void> Vulkan::run_on_device(VulkanBatch& device_batch, const Batch& batch,
                                   const Packing& packing,
                                   std::span<const KeyframeRequest> requests,
                                   std::span<const std::size_t> indices,
                                   std::optional<std::size_t> first_held) {
    std::vector<VulkanBatch::Job> jobs;
    for (const std::size_t index : indices)
        jobs.push_back({position_[static_cast<std::size_t>(requests[index].cascade)],
                        sea_->phase_time(requests[index].time_us)});
    const auto histories = foam_.find(batch.size);
    const FoamWork foam = foam_work(
        histories == foam_.end() ? nullptr : &histories->second, requests, indices,
        [&](std::size_t job, sea::Field field) {
            return device_batch.place(packing, job, field, first_held);
        },
        counters_.foam_ticks);
    if (packing.fields == 0 && foam.empty())
        return {};
    const std::uint64_t dispatches = device_batch.dispatches();
    const double seconds = device_batch.device_seconds();
    const double foam_seconds = device_batch.foam_seconds();
    SEAWAY_TRY(device_batch.run(
        jobs, packing,
        {batch.jacobian() ? &sea_->choppiness : nullptr, foam.empty() ? nullptr : &foam},
        first_held));
    counters_.dispatches += device_batch.dispatches() - dispatches;
    counters_.device_seconds += device_batch.device_seconds() - seconds;
    counters_.foam_seconds += device_batch.foam_seconds() - foam_seconds;
    counters_.transforms += jobs.size() * static_cast<std::size_t>(packing.fields);
    return {};
}

Result<void> Vulkan::run_jobs(VulkanBatch& device_batch, const Batch& batch,
                              std::span<const KeyframeRequest> requests,
                              std::span<const std::size_t> indices, std::span<NewKeyframePtr> out) {
    const Packing packing = batch.packing();
    const auto maps = static_cast<std::size_t>(packing.maps);
    const auto asked = static_cast<std::size_t>(batch.fields.size());
    const bool holds = asked > 0 && device_->unified_memory() && held_.contains(batch.size);
    VulkanMaps* held = holds ? held_[batch.size].get() : nullptr;
    const std::optional<std::size_t> first =
        held != nullptr ? held->take(indices.size() * maps) : std::nullopt;
    const Result<void> ran = run_on_device(device_batch, batch, packing, requests, indices, first);
    std::vector<std::shared_ptr<sea::Keyframe>> keyframes;
    for (const std::size_t index : indices)
        keyframes.push_back(keyframe(requests[index]));
    for (std::size_t job = 0; first && job < indices.size(); ++job) {
        const std::size_t own = *first + job * maps;
        keyframes[job]->values = held->lend(own, asked);
        held->give(own + asked, maps - asked); // what they were made of
    }
    SEAWAY_TRY(ran);
    if (!first)
        copy_maps(device_batch, packing, keyframes);
    // Waves that no transform can carry are added point by point (scenes with stylised sines).
    for (std::size_t job = 0; job < indices.size(); ++job) {
        const KeyframeRequest& request = requests[indices[job]];
        for (const sea::SineField& field :
             sea_->cascades[static_cast<std::size_t>(request.cascade)].sines)
            sea::add_sines(field, sea_->phase_time(request.time_us), *keyframes[job]);
        out[indices[job]] = std::move(keyframes[job]);
    }
    return {};
}

Result<StandingKeyframe> Vulkan::run_job_there(VulkanBatch& device_batch, const Batch& batch,
                                               Requests requests, std::size_t index) {
    const auto asked = static_cast<std::size_t>(batch.fields.size());
    const std::size_t made_of = static_cast<std::size_t>(batch.packing().maps) - asked;
    VulkanMaps& held = *held_.at(batch.size);
    const std::optional<std::size_t> own = held.take(asked);
    std::shared_ptr<const void> keeper = own ? held.keeper(*own, asked) : nullptr;
    const std::optional<std::size_t> other = own ? held.take(made_of) : std::nullopt;
    const std::shared_ptr<const void> for_now = other ? held.keeper(*other, made_of) : nullptr;
    if (!other || (made_of > 0 && *other < *own))
        return Error{
            DeviceError::out_of_memory,
            fmt::format("{} of {} maps of size {} are held, and the next keyframe takes {}",
                        held.held() - (own ? asked : 0), held.size(), batch.size, asked + made_of)};
    const Packing packing = batch.packing(made_of > 0 ? *other - *own - asked : 0);
    SEAWAY_TRY(run_on_device(device_batch, batch, packing, requests, {&index, 1}, *own));
    const std::size_t texel = *own * static_cast<std::size_t>(batch.size * batch.size / 4);
    return StandingKeyframe{requests[index].time_us, batch.size, batch.fields, &held.view(), texel,
                            std::move(keeper)};
}

Result<FoamMapPtr> Vulkan::open_foam(int size, const FoamMap* from) {
    Result<FoamMapPtr> opened = foam_.try_emplace(size, *device_, size).first->second.open(from);
    if (!opened)
        return Error{device_->info().name + ": " + opened.error().message};
    return opened;
}

std::shared_ptr<sea::Keyframe> Vulkan::keyframe(const KeyframeRequest& request) const {
    const sea::CascadeSpec& spec = sea_->cascades[static_cast<std::size_t>(request.cascade)].spec;
    std::shared_ptr<sea::Keyframe> made = make_keyframe(spare_);
    made->epoch = epoch_;
    made->cascade = request.cascade;
    made->time_us = request.time_us;
    made->size = spec.size;
    made->length_m = spec.length_m;
    made->fields = request.fields;
    return made;
}

// Copying is bound by memory: a second thread makes it a third faster.
void Vulkan::copy_maps(const VulkanBatch& device_batch, const Packing& packing,
                       std::span<const std::shared_ptr<sea::Keyframe>> keyframes) {
    struct Map {
        const VulkanBatch& from;
        int job;
        int map;
        std::span<float> to;
    };
    std::vector<Map> maps;
    for (std::size_t job = 0; job < keyframes.size(); ++job) {
        sea::Keyframe& keyframe = *keyframes[job];
        keyframe.values =
            spare_->take(keyframe.plane_size() * static_cast<std::size_t>(keyframe.fields.size()));
        counters_.copies += !keyframe.fields.empty();
        for (const sea::Field field : keyframe.fields)
            maps.push_back({device_batch, static_cast<int>(job), packing.map_of(field),
                            keyframe.plane(field)});
    }
    const Phase copy{[](const void* all, int index, int) {
                         const Map& map = (*static_cast<const std::vector<Map>*>(
                             all))[static_cast<std::size_t>(index)];
                         map.from.read_map(map.job, map.map, map.to);
                     },
                     &maps, static_cast<int>(maps.size())};
    copiers_.run({&copy, 1});
}

Result<std::vector<SynthesisStage>> Vulkan::stages(const KeyframeRequest& request) {
    const auto cascade = static_cast<std::size_t>(request.cascade);
    const bool jacobian = request.fields.contains(sea::Field::jacobian);
    const sea::FieldSet linear = linear_part(request.fields);
    return groups_.at(sea_->cascades[cascade].spec.size)
        .batch->stages({position_[cascade], sea_->phase_time(request.time_us)},
                       pack(jacobian ? linear | strains : linear));
}

SynthesisCounters Vulkan::counters() const {
    return counters_;
}

} // namespace

Result<std::unique_ptr<VulkanSynthesizer>> make_vulkan_synthesizer(const VulkanOptions& options) {
    return Vulkan::create(options);
}

Result<std::unique_ptr<VulkanSynthesizer>>
make_vulkan_synthesizer(std::shared_ptr<gpu::Device> device, const VulkanOptions& options) {
    return Vulkan::create(std::move(device), options);
}

} // namespace seaway::server
