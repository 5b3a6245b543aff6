// SPDX-License-Identifier: Apache-2.0
#include "server/device/vulkan_synthesizer.h"

#include <algorithm>
#include <map>
#include <new>
#include <utility>

#include "base/check.h"
#include "gpu/device.h"
#include "server/device/spare_buffers.h"
#include "server/device/stylised_waves.h"
#include "server/device/vulkan_batch.h"
#include "server/device/vulkan_check.h"
#include "server/device/vulkan_foam.h"
#include "server/device/vulkan_kernel_shelf.h"
#include "server/device/vulkan_maps.h"
#include "server/device/vulkan_parts.h"
#include "server/device/vulkan_readback.h"
#include "server/device/vulkan_requests.h"

namespace seaway::server {

namespace {

constexpr int first_checked_size = 64;

class Vulkan final : public VulkanSynthesizer {
  public:
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
    SynthesisCounters counters() const override { return counters_ + readbacks_.counters(); }
    void trim() override {
        spare_->trim();
        held_.trim();
        for (const auto& [size, group] : groups_)
            group.batch->trim();
    }
    std::vector<std::string> validation_messages() const override {
        return device_->validation().validation_messages();
    }

  private:
    Vulkan() = default;
    /// What is on the device for the cascades of one size.
    struct Group {
        std::unique_ptr<VulkanBatch> batch;
        std::size_t cascades;
        bool band_limited;
    };
    VulkanBatch& batch_of(const KeyframeRequest& request);
    /// Requests that one run serves, by their places.
    struct Run {
        const RequestBatch* batch;
        VulkanBatch* on;
        std::span<const std::size_t> indices;
        bool more; ///< come after it
    };
    /// Does `jobs(run)` for all, one after the other.
    template <class Jobs>
    Result<void> run(std::span<const KeyframeRequest> requests, const Jobs& jobs);
    Result<void> make_parts(std::span<const KeyframeRequest> parts, std::span<NewKeyframePtr> made);
    Result<void> run_jobs(const Run& run, std::span<const KeyframeRequest> requests,
                          std::span<NewKeyframePtr> out);
    /// Maps go to keyframes by way of readbacks_.
    Result<void> run_copied(const Run& run, const Packing& packing,
                            std::span<const KeyframeRequest> requests,
                            std::span<const NewKeyframePtr> keyframes);
    Result<void> collect();
    /// After an error: nothing is under way any more.
    void end_runs();
    /// Of this side's memory; runs end.
    Error no_memory();
    /// With the device's name.
    Error named(const Error& error) const {
        return {error.kind, device_->info().name + ": " + error.message};
    }
    /// Of its one request.
    Result<StandingKeyframe> run_job_there(const Run& run,
                                           std::span<const KeyframeRequest> requests);
    /// Starts it; none: there is nothing to do on the device. `rounds`: there is memory for that.
    Result<std::optional<VulkanBatch::RunId>>
    start_on_device(const Run& run, const Packing& packing,
                    std::span<const KeyframeRequest> requests,
                    std::optional<std::size_t> first_held, bool more, bool rounds);
    /// Starts and finishes it.
    Result<void> run_on_device(const Run& run, const Packing& packing,
                               std::span<const KeyframeRequest> requests,
                               std::optional<std::size_t> first_held);
    /// What `work` does on it is counted.
    template <class Work>
    auto counted(VulkanBatch& device_batch, const Work& work);
    /// Maps of a size that keyframes hold where they were computed; null: they are copied.
    Result<VulkanMaps*> held_maps(int size);
    /// Without values.
    NewKeyframePtr keyframe(const KeyframeRequest& request) const;

    // Order of members is order of construction; the device goes last.
    std::shared_ptr<gpu::Device> device_; ///< with keyframes that hold maps
    std::unique_ptr<KernelShelf> kernels_;
    std::size_t held_map_bytes_ = held_map_bytes_max;
    bool maps_stay_ = false;
    VulkanMapsBySize held_;          ///< of any sea; none: they are copied
    std::map<int, Group> groups_;    ///< by size, of this sea
    std::map<int, VulkanFoam> foam_; ///< by size, of any sea
    sea::RealizationPtr sea_;
    std::uint32_t epoch_ = 0;
    std::vector<int> position_; ///< of each cascade within its batch
    std::shared_ptr<SpareBuffers> spare_ = std::make_shared<SpareBuffers>();
    VulkanReadbacks readbacks_{spare_};
    SynthesisCounters counters_;
};

Result<std::unique_ptr<VulkanSynthesizer>> Vulkan::create(std::shared_ptr<gpu::Device> device,
                                                          const VulkanOptions& options) {
    std::unique_ptr<Vulkan> made(new Vulkan);
    made->device_ = std::move(device);
    made->kernels_ =
        std::make_unique<KernelShelf>(*made->device_, options.any_device_kernels, options.tuning);
    made->held_map_bytes_ = options.held_map_bytes;
    made->maps_stay_ = options.maps_stay;
    SEAWAY_TRY(made->kernels_->get(first_checked_size, true));
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
        const bool band_limited = std::ranges::all_of(cascades, fits_band);
        const auto old = groups_.find(size);
        if (old == groups_.end() || old->second.cascades != cascades.size() ||
            old->second.band_limited != band_limited) {
            groups_.erase(size);
            SEAWAY_TRY_LET(const SynthesisKernels* pipelines, kernels_->get(size, band_limited));
            SEAWAY_TRY_LET(const VulkanMaps* held, held_maps(size));
            SEAWAY_TRY_LET(
                std::unique_ptr<VulkanBatch> made,
                VulkanBatch::create(*device_, *pipelines, static_cast<int>(cascades.size()), held));
            groups_[size] = {std::move(made), cascades.size(), band_limited};
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

Result<std::vector<NewKeyframePtr>>
Vulkan::synthesize(std::span<const KeyframeRequest> requests) try {
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
    SEAWAY_TRY(make_parts(parts, made));
    counters_.keyframes += with_fields(requests);
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
    add_stylised(requests, *sea_, out, counters_);
    return out;
} catch (const std::bad_alloc&) {
    return no_memory();
}

Result<std::vector<StandingKeyframe>>
Vulkan::synthesize_there(std::span<const KeyframeRequest> requests) try {
    SEAWAY_CHECK(maps_stay_, "maps stay where VulkanOptions say that they may");
    if (!sea_)
        return Error{"no sea on the device: the last one could not be uploaded"};
    std::vector<StandingKeyframe> out(requests.size());
    // One keyframe a run, and what it is made of elsewhere: so keyframes of one length stand side by side, and what one
    // leaves fits the next.
    SEAWAY_TRY(run(requests, [&](const Run& run) -> Result<void> {
        for (const std::size_t& index : run.indices) {
            const Run one{run.batch, run.on, {&index, 1}, run.more};
            SEAWAY_TRY_LET(out[index], run_job_there(one, requests));
        }
        return {};
    }));
    counters_.keyframes += with_fields(requests);
    return out;
} catch (const std::bad_alloc&) {
    return no_memory();
}

template <class Jobs>
Result<void> Vulkan::run(std::span<const KeyframeRequest> requests, const Jobs& jobs) {
    const std::vector<RequestBatch> batches =
        sort_requests(requests, *sea_, !device_->unified_memory());
    for (const RequestBatch& batch : batches) {
        VulkanBatch& device_batch = *groups_.at(batch.size).batch;
        const std::span<const std::size_t> all(batch.requests);
        const auto at_once =
            static_cast<std::size_t>(std::max(device_batch.max_jobs(batch.packing().maps), 1));
        for (std::size_t first = 0; first < all.size(); first += at_once) {
            const std::size_t count = std::min(at_once, all.size() - first);
            const bool more = first + count < all.size() || &batch != &batches.back();
            if (const Result<void> done =
                    jobs(Run{&batch, &device_batch, all.subspan(first, count), more});
                !done)
                return named(done.error());
        }
    }
    return {};
}

Result<VulkanMaps*> Vulkan::held_maps(int size) {
    if (!(device_->unified_memory() || maps_stay_) || held_map_bytes_ == 0)
        return static_cast<VulkanMaps*>(nullptr);
    return held_.of_size(device_, size, held_map_bytes_);
}

template <class Work>
auto Vulkan::counted(VulkanBatch& device_batch, const Work& work) {
    const std::uint64_t dispatches = device_batch.dispatches();
    const std::uint64_t travelled = device_batch.travelled_bytes();
    const double seconds = device_batch.device_seconds();
    const double foam_seconds = device_batch.foam_seconds();
    auto done = work();
    counters_.dispatches += device_batch.dispatches() - dispatches;
    counters_.readback_bytes += device_batch.travelled_bytes() - travelled;
    counters_.device_seconds += device_batch.device_seconds() - seconds;
    counters_.foam_seconds += device_batch.foam_seconds() - foam_seconds;
    return done;
}

Result<std::optional<VulkanBatch::RunId>>
Vulkan::start_on_device(const Run& run, const Packing& packing,
                        std::span<const KeyframeRequest> requests,
                        std::optional<std::size_t> first_held, bool more, bool rounds) {
    const auto rounding =
        rounds ? rounding_of(*run.batch, packing, requests, run.indices) : std::nullopt;
    std::vector<VulkanBatch::Job> jobs;
    for (const std::size_t index : run.indices)
        jobs.push_back({position_[static_cast<std::size_t>(requests[index].cascade)],
                        sea_->phase_time(requests[index].time_us)});
    const auto histories = foam_.find(run.batch->size);
    const FoamWork foam = foam_work(
        histories == foam_.end() ? nullptr : &histories->second, requests, run.indices,
        [&](std::size_t job, sea::Field field) {
            return run.on->place(packing, job, field, first_held);
        },
        counters_.foam_ticks);
    if (packing.fields == 0 && foam.empty())
        return std::optional<VulkanBatch::RunId>();
    SEAWAY_TRY_LET(const VulkanBatch::RunId id, counted(*run.on, [&] {
                       return run.on->start(jobs, packing,
                                            {run.batch->jacobian() ? &sea_->choppiness : nullptr,
                                             foam.empty() ? nullptr : &foam,
                                             rounding ? &*rounding : nullptr},
                                            first_held, more);
                   }));
    counters_.transforms += jobs.size() * static_cast<std::size_t>(packing.fields);
    return std::optional(id);
}

Result<void> Vulkan::run_on_device(const Run& run, const Packing& packing,
                                   std::span<const KeyframeRequest> requests,
                                   std::optional<std::size_t> first_held) {
    SEAWAY_TRY_LET(const std::optional<VulkanBatch::RunId> id,
                   start_on_device(run, packing, requests, first_held, false, false));
    const Result<void> ran =
        id ? counted(*run.on, [&] { return run.on->finish(*id); }) : Result<void>();
    if (!ran)
        run.on->abandon();
    return ran;
}

Result<void> Vulkan::make_parts(std::span<const KeyframeRequest> parts,
                                std::span<NewKeyframePtr> made) {
    Result<void> ran = run(parts, [&](const Run& run) { return run_jobs(run, parts, made); });
    while (ran && readbacks_.under_way() > 0)
        if (const Result<void> collected = collect(); !collected)
            ran = named(collected.error());
    if (!ran) {
        end_runs();
        return refused_for_now(ran.error());
    }
    return {};
}

Result<void> Vulkan::run_jobs(const Run& run, std::span<const KeyframeRequest> requests,
                              std::span<NewKeyframePtr> out) {
    const RequestBatch& batch = *run.batch;
    const Packing packing = batch.packing();
    const auto maps = static_cast<std::size_t>(packing.maps);
    const auto asked = static_cast<std::size_t>(batch.fields.size());
    std::vector<NewKeyframePtr> keyframes;
    for (const std::size_t index : run.indices) {
        keyframes.push_back(keyframe(requests[index]));
        out[index] = keyframes.back();
    }
    VulkanMaps* const held =
        asked > 0 && device_->unified_memory() ? held_.find(batch.size) : nullptr;
    const std::optional<std::size_t> first =
        held != nullptr ? held->take(keyframes.size() * maps) : std::nullopt;
    if (!first)
        return run_copied(run, packing, requests, keyframes);
    TakenMaps taken(*held, *first, keyframes.size() * maps);
    SEAWAY_TRY(run_on_device(run, packing, requests, first));
    for (const NewKeyframePtr& keyframe : keyframes) {
        keyframe->values = taken.lend(asked);
        taken.give(maps - asked); // what they were made of
    }
    return {};
}

Result<void> Vulkan::run_copied(const Run& run, const Packing& packing,
                                std::span<const KeyframeRequest> requests,
                                std::span<const NewKeyframePtr> keyframes) {
    if (run.batch->fields.empty())
        return run_on_device(run, packing, requests, {});
    bool more = run.more && !device_->unified_memory();
    while (readbacks_.under_way() >= VulkanBatch::ring_slots)
        SEAWAY_TRY(collect());
    if (more) {
        SEAWAY_TRY_LET(more, run.on->can_be_followed());
    }
    SEAWAY_TRY_LET(const bool rounds,
                   run.batch->rounds ? run.on->can_round(more) : Result<bool>(false));
    SEAWAY_TRY_LET(const std::optional<VulkanBatch::RunId> id,
                   start_on_device(run, packing, requests, {}, more, rounds));
    if (!id) { // foam alone, without a turn: whoever asked fills it
        for (const NewKeyframePtr& keyframe : keyframes)
            keyframe->values.resize(keyframe->plane_size());
        return {};
    }
    for (std::size_t job = 0; rounds && job < keyframes.size(); ++job)
        keyframes[job]->rounded = rounded_maps(requests[run.indices[job]]);
    readbacks_.add({run.on, *id, packing, {keyframes.begin(), keyframes.end()}, rounds});
    while (!more && readbacks_.under_way() > 0) // what follows all the same has the same place
        SEAWAY_TRY(collect());
    return {};
}

Result<void> Vulkan::collect() {
    return counted(readbacks_.oldest(), [&] { return readbacks_.collect(); });
}

void Vulkan::end_runs() {
    for (const auto& [size, group] : groups_)
        group.batch->abandon();
    readbacks_.forget();
}

Error Vulkan::no_memory() {
    end_runs();
    return named({DeviceError::out_of_memory, "out of host memory"});
}

Result<StandingKeyframe> Vulkan::run_job_there(const Run& run,
                                               std::span<const KeyframeRequest> requests) {
    const RequestBatch& batch = *run.batch;
    const auto asked = static_cast<std::size_t>(batch.fields.size());
    const std::size_t made_of = static_cast<std::size_t>(batch.packing().maps) - asked;
    VulkanMaps& held = *held_.find(batch.size);
    const std::optional<std::size_t> own = held.take(asked);
    const std::shared_ptr<const void> keeper = own ? held.keeper(*own, asked) : nullptr;
    const auto other = own ? held.take(made_of) : std::nullopt;
    const std::shared_ptr<const void> for_now = other ? held.keeper(*other, made_of) : nullptr;
    if (!other || (made_of > 0 && *other < *own))
        return held.full(own ? asked : 0, asked + made_of);
    const Packing packing = batch.packing(made_of > 0 ? *other - *own - asked : 0);
    SEAWAY_TRY(run_on_device(run, packing, requests, *own));
    const std::size_t texel = *own * static_cast<std::size_t>(batch.size * batch.size / 4);
    const sea::TimeUs time_us = requests[run.indices[0]].time_us;
    return StandingKeyframe{time_us, batch.size, batch.fields, &held.view(), texel, keeper};
}

Result<FoamMapPtr> Vulkan::open_foam(int size, const FoamMap* from) try {
    Result<FoamMapPtr> opened = foam_.try_emplace(size, *device_, size).first->second.open(from);
    return opened ? opened : Result<FoamMapPtr>(refused_for_now(named(opened.error())));
} catch (const std::bad_alloc&) {
    return no_memory();
}

NewKeyframePtr Vulkan::keyframe(const KeyframeRequest& request) const {
    const sea::CascadeSpec& spec = sea_->cascades[static_cast<std::size_t>(request.cascade)].spec;
    NewKeyframePtr made = make_keyframe(spare_);
    *made = {epoch_, request.cascade, request.time_us, spec.size, spec.length_m, request.fields};
    return made;
}

Result<std::vector<SynthesisStage>> Vulkan::stages(const KeyframeRequest& request) {
    return batch_of(request).stages(
        {position_[static_cast<std::size_t>(request.cascade)], sea_->phase_time(request.time_us)},
        request);
}

} // namespace

Result<std::unique_ptr<VulkanSynthesizer>> make_vulkan_synthesizer(const VulkanOptions& options) {
    Result<std::unique_ptr<gpu::Device>> device = gpu::Device::create(
        {.pick = options.device, .validation = options.validation, .staged = options.staged});
    if (!device)
        return device.error();
    return Vulkan::create(std::move(*device), options);
}

Result<std::unique_ptr<VulkanSynthesizer>>
make_vulkan_synthesizer(std::shared_ptr<gpu::Device> device, const VulkanOptions& options) {
    return Vulkan::create(std::move(device), options);
}

} // namespace seaway::server
