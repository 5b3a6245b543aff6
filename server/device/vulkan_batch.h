// SPDX-License-Identifier: Apache-2.0
// VulkanBatch: the cascades of one size on the device, and the memory in which their keyframes are
// computed, several to a submission.
//
// Where the CPU cannot read that memory, maps are copied to some that it can. A run that another follows is computed to a
// place of its own, one of three, from where the transfer queue copies them while the next run is computed. That memory
// is made when it is first used: as much again, three times, on the device and beside it.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/result.h"
#include "gpu/buffer.h"
#include "gpu/commands.h"
#include "gpu/timer.h"
#include "sea/waves/realization.h"
#include "server/device/synthesis_stage.h"
#include "server/device/vulkan_fields.h"
#include "server/device/vulkan_foam.h"
#include "server/device/vulkan_kernels.h"
#include "server/device/vulkan_maps.h"

namespace seaway::server {

class VulkanBatch {
  public:
    /// One keyframe: which cascade (position among those given to create()), when.
    struct Job {
        int cascade;
        sea::TimeUs phase_time_us;
    };

    /// `kernels` must outlive it, and `held`, whose maps runs may leave their results in. Up to `cascade_count` cascades
    /// can be uploaded.
    static Result<std::unique_ptr<VulkanBatch>> create(gpu::Device& device,
                                                       const SynthesisKernels& kernels,
                                                       int cascade_count,
                                                       const VulkanMaps* held = nullptr);

    Result<void> upload(std::span<const sea::CascadeModes* const> cascades);

    /// Jobs of this many maps that fit into one run; 0: not even one.
    int max_jobs(int maps) const;
    /// Of a run: as many as the device binds at once.
    int maps_at_once() const { return capacity_maps_; }

    /// Of the maps of each job the first ones, which were asked for, travel as whole steps of 16 bits.
    struct Rounding {
        int asked = 0;
        std::vector<float>
            scales; ///< [job][map]: steps in one unit; 0: of this map nothing is wanted
    };
    /// What is done to the maps once they are there.
    struct After {
        const sea::Choppiness* jacobian =
            nullptr;                    ///< the Jacobian; the strains must be in the packing
        const FoamWork* foam = nullptr; ///< histories go on
        const Rounding* rounding =
            nullptr; ///< where memory is not read in place, of maps that are not held; see can_round()
    };
    /// Computes; with an empty packing only what comes after. Maps go to those that are held, from `first_held` on, or
    /// to memory of this object, from where read_map() copies them.
    Result<void> run(std::span<const Job> jobs, const Packing& packing, const After& after,
                     std::optional<std::size_t> first_held = {});

    /// Runs that may be under way with others after them.
    static constexpr int ring_slots = 3;
    using RunId = int; ///< which place a run has: of the ring, or `own`
    static constexpr RunId own = ring_slots;

    /// Is there memory for one more run that others follow? The ring is made when it is first asked for; where that has once been
    /// too much, runs go one after the other, and what there is of it is let go of.
    Result<bool> can_be_followed();
    /// Is there memory for what the next run has besides where it is rounded? Made when it is first asked for; where that has once
    /// been too much, no more of it is. `more`: as start() takes it.
    Result<bool> can_round(bool more);

    /// The first half of run(): it is under way. `more`: another may be started before this one is finished, at most
    /// ring_slots at a time; where memory is not read in place and can_be_followed(). Without `more` there is no other way for it to go than
    /// run() has: one submission, and it must be finished before the next is started.
    Result<RunId> start(std::span<const Job> jobs, const Packing& packing, const After& after,
                        std::optional<std::size_t> first_held, bool more);
    /// The second: its maps are there for read_map(), until the next run takes its place.
    Result<void> finish(RunId run);
    /// After an error of either, here or elsewhere: waits for all that are under way, and forgets them.
    void abandon();

    /// Where a map of a job stands, for FoamWork.
    std::uint32_t place(const Packing& packing, std::size_t job, sea::Field field,
                        std::optional<std::size_t> first_held = {}) const {
        return static_cast<std::uint32_t>((first_held.value_or(0) +
                                           job * static_cast<std::size_t>(packing.maps) +
                                           static_cast<std::size_t>(packing.map_of(field))) *
                                          points() / 4);
    }

    /// What the passes of this request leave, for every pass but the last, which leaves the maps. Computes once a pass and
    /// part (vulkan_parts.h).
    Result<std::vector<SynthesisStage>> stages(const Job& job, const KeyframeRequest& request);

    /// Of a run that was finished, unless its maps are held: copies one map, [y][x]; `map` as in Packing.
    void read_map(RunId run, int job, int map, std::span<float> out) const;
    /// Of a run that was rounded instead: whether 16 bits are enough for a map, and where its steps are, [y][x].
    bool fits(RunId run, int job, int map) const;
    std::span<const std::int16_t> steps(RunId run, int job, int map) const;
    struct MapOf {
        int job, map;
    };
    /// These travel as they are, for read_map(); there are no steps after that.
    Result<void> read_exactly(RunId run, std::span<const MapOf> maps);

    /// From time to time, between two runs: where device memory is this process's own (VulkanMaps::trim), pages between the passes of which as
    /// many of these calls saw no need go back to the system. What is left of a ring that there is no memory for goes on any device.
    void trim();

    std::uint64_t dispatches() const { return dispatches_; }
    /// Of maps, from memory that the CPU cannot read to where it can.
    std::uint64_t travelled_bytes() const { return travelled_bytes_; }
    /// By the device's clock where passes are timed, else by ours; foam is told apart by the device's alone.
    double device_seconds() const { return device_seconds_; }
    double foam_seconds() const { return foam_seconds_; }
    /// Whether each pass is timed. So it is, but not by a device without time stamps, nor by a CPU
    /// as device: there a stamp waits for all threads, 30 to 40 us each (docs/performance/maps.md).
    void time_passes(bool wanted) { time_passes_ = wanted; }
    /// Of the last run that was timed, pass by pass; the Jacobian and foam last.
    std::span<const double> pass_seconds() const { return pass_seconds_; }

  private:
    /// Whether several keyframes of one size share their dispatches. On a processor one at a time is faster where the
    /// scratch of one just fits the cache; a GPU needs them all to have enough to do (docs/performance/maps.md).
    static bool batches(const gpu::Device& device, int size) {
        return size <= (device.info().is_cpu() ? 256 : 1024);
    }
    static constexpr int most_jobs = 64;

    VulkanBatch(gpu::Device& device, const SynthesisKernels& kernels)
        : device_(device), kernels_(kernels),
          time_passes_(!device.info().is_cpu() && device.time_stamp_bits() > 0) {}
    Result<void> allocate(int cascade_count);
    Result<void> bind();
    /// Floats that one job has in memory after a pass that is not the last.
    std::size_t pass_floats(std::size_t pass, const Packing& packing) const;
    Result<std::vector<float>> output(const Job& job, const Packing& packing, std::size_t pass);
    /// Of fields that it computes at once; sources have numbers from `first_source` on.
    Result<std::vector<SynthesisStage>> stages_of(const Job& job, const Packing& packing,
                                                  int first_source);
    /// Where the maps of a run go, and what is bound to it.
    struct Target {
        const gpu::Buffer* maps = nullptr;
        const gpu::TexelView* view = nullptr;
        gpu::Bindings last, jacobian, foam;
        gpu::TexelView histories;
        std::size_t histories_bytes =
            0; ///< of those that `foam` names: others are in a larger buffer
    };
    /// What a run under way has for itself.
    struct Slot {
        gpu::Commands commands;
        gpu::Timer timer;
        Target target;
        gpu::Buffer readback; ///< none: the target is read in place
        // Of the ring.
        gpu::Buffer maps;
        gpu::TexelView view;
        gpu::Commands copying;
        // Where maps are rounded.
        gpu::Buffer rounded;
        gpu::Bindings rounding;
        // Of its run.
        std::size_t jobs = 0, maps_a_job = 0;
        std::size_t asked = 0;   ///< maps of a job that travel, its first
        bool is_rounded = false; ///< they are
        bool foam = false, under_way = false;
        std::uint64_t ticket = 0, copied = 0; ///< of the transfer queue; 0: it has nothing to do
        std::chrono::steady_clock::time_point started;
    };
    const Slot& slot_of(RunId run) const {
        return run == own ? own_ : ring_[static_cast<std::size_t>(run)];
    }
    Slot& slot_of(RunId run) { return const_cast<Slot&>(std::as_const(*this).slot_of(run)); }
    Result<void> make(Slot& slot);
    RunId free_slot() const;
    /// Of one that there was no memory for what is not under way: nobody asks for it.
    void let_ring_go();
    Result<void> submit(Slot& slot, bool copies);
    Result<void> record_copying(Slot& slot);
    Result<void> make_rounding(Slot& slot);
    void record_rounding(Slot& slot, std::uint32_t first_map);
    /// What travels of it, to where the CPU reads it.
    void copy_out(const Slot& slot, gpu::Commands& commands);
    void travel(gpu::Commands& commands, const gpu::Buffer& from, const gpu::Buffer& to,
                std::size_t bytes, std::size_t from_at = 0, std::size_t to_at = 0);
    bool any_under_way() const;

    /// The first `passes` passes, to the slot's target or to what is held.
    Result<void> record(Slot& slot, std::span<const Job> jobs, const Packing& packing,
                        const After& after, std::size_t passes,
                        std::optional<std::size_t> first_held);
    void record_passes(Slot& slot, const Target& target, const Packing& packing, const After& after,
                       std::size_t passes, const shaders::SynthesisPush& push, std::uint32_t jobs);
    /// What a run of its own leaves, all or some of its passes.
    void record_readback(Slot& slot, const Packing& packing, std::size_t passes);
    void stamp(Slot& slot);
    Result<void> read_timer(Slot& slot, double wall_seconds);
    void write(Slot& slot, gpu::Buffer& buffer, std::span<const std::byte> bytes);
    void dispatch(Slot& slot, const SynthesisKernels::Pass& pass, const gpu::Bindings& bindings,
                  const shaders::SynthesisPush& push, std::uint32_t jobs);
    Result<void> bind(Target& target);
    /// To the histories of a run.
    Result<void> bind_foam(Target& target, const gpu::Buffer& histories);
    void dispatch_jacobian(Slot& slot, const Target& target, const Packing& packing,
                           const sea::Choppiness& choppiness, std::uint32_t first_map,
                           std::uint32_t jobs);
    void record_foam(Slot& slot, const Target& target, const FoamWork& foam);
    /// Makes `bytes` of `result` visible to this side.
    void read_back(Slot& slot, const gpu::Buffer& result, std::size_t bytes);
    std::vector<gpu::Resource> resources(std::size_t pass, const gpu::Buffer& to) const;
    std::size_t points() const {
        return static_cast<std::size_t>(kernels_.size()) *
               static_cast<std::size_t>(kernels_.size());
    }
    std::uint32_t stamps() const { return static_cast<std::uint32_t>(kernels_.passes.size()) + 4; }
    std::size_t map_bytes() const { return points() * sizeof(float); }
    /// Of each scratch, for one map of one job.
    std::size_t scratch_map_bytes() const {
        return kernels_.transform->scratch_complexes * complex_bytes;
    }

    gpu::Device& device_;
    const SynthesisKernels& kernels_;
    bool time_passes_;
    int capacity_maps_ = 0;
    std::size_t scratch_needed_bytes_ = 0; ///< of each, since trim() looked
    int trims_ = 0;
    std::vector<float> steps_; ///< wavenumber step of each cascade, rad/m
    gpu::Buffer modes_, rates_, orbits_, jobs_, rows_, foam_steps_, scales_, scratch_[2];
    gpu::TexelView modes_view_, rates_view_, orbits_view_, jobs_view_, rows_view_, foam_steps_view_,
        scales_view_, scratch_views_[2];
    std::vector<gpu::Bindings> bindings_; ///< one a pass but the last
    Target held_;
    Slot own_; ///< of runs that nothing follows: their maps go to what is held, or to the scratch
    std::array<Slot, ring_slots> ring_;
    bool ring_lacks_memory_ = false;
    bool rounding_lacks_memory_ = false;             ///< some place does
    std::chrono::steady_clock::time_point computed_; ///< when the last run was seen to be
    std::uint64_t dispatches_ = 0;
    std::uint64_t travelled_bytes_ = 0;
    double device_seconds_ = 0;
    double foam_seconds_ = 0;
    std::vector<double> pass_seconds_;
};

} // namespace seaway::server
