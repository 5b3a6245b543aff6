// SPDX-License-Identifier: Apache-2.0
// VulkanReadbacks: keyframes whose maps are copied out of a device's memory, or out of where the device copied them to, in
// the order in which their runs were started; some runs may be under way at a time. For one thread.
#pragma once

#include <algorithm>
#include <deque>
#include <memory>
#include <span>
#include <vector>

#include "base/processors.h"
#include "base/result.h"
#include "base/thread_pool.h"
#include "sea/surface/maps/keyframe.h"
#include "server/device/spare_buffers.h"
#include "server/device/synthesizer.h"
#include "server/device/vulkan_batch.h"

namespace seaway::server {

class VulkanReadbacks {
  public:
    /// A run that was started, and the keyframes that its maps are for, one a job, without values.
    struct Pending {
        VulkanBatch* batch;
        VulkanBatch::RunId run;
        Packing packing;
        std::vector<NewKeyframePtr> keyframes; ///< where maps are rounded, with rows of what to
        bool rounded = false;
    };

    explicit VulkanReadbacks(std::shared_ptr<SpareBuffers> spare) : spare_(std::move(spare)) {}

    void add(Pending pending) { pending_.push_back(std::move(pending)); }
    std::size_t under_way() const { return pending_.size(); }
    /// Waits for the oldest run, and gives its keyframes their values.
    Result<void> collect();
    /// After an error: keyframes stay without values; their runs are the caller's to end.
    void forget() { pending_.clear(); }
    /// What collect() waits for.
    VulkanBatch& oldest() const { return *pending_.front().batch; }

    /// Of copies, of what travelled, and of what was rounded; nothing else.
    const SynthesisCounters& counters() const { return counters_; }

  private:
    struct Travelled;
    /// Those that fit 16 bits have room for their steps and are listed; the others are left, and have no row.
    sea::FieldSet sort_maps(const Pending& pending, int job, std::vector<Travelled>& travelled);
    Result<void> take_rounded(const Pending& pending);
    void copy_maps(const Pending& pending);

    const std::shared_ptr<SpareBuffers> spare_;
    std::deque<Pending> pending_; ///< oldest first
    /// A quarter of a large machine's: the rest is for who takes keyframes apart.
    ThreadPool copiers_{std::clamp(usable_processors() / 4, 2, 4), "sea-readback"};
    SynthesisCounters counters_;
};

} // namespace seaway::server
