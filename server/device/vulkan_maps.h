// SPDX-License-Identifier: Apache-2.0
// VulkanMaps: device memory for maps of one size, one after the other, of which keyframes hold what is theirs until
// their last reader lets go. Its length never changes: that is the bound on what readers can hold.
//
// Keyframes that the CPU reads hold them only where it reads device memory in place (gpu::Device::unified_memory); what
// stays on the device may stand in them on any. Maps are given back on any thread, also when the device that they were
// computed on has been given up; the rest is for one.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/result.h"
#include "gpu/buffer.h"
#include "sea/surface/maps/map_values.h"

namespace seaway::server {

/// Bytes of the maps of one size at most, and less where a device binds less at once.
inline constexpr std::size_t held_map_bytes_max = std::size_t{128} << 20;

class VulkanMaps : public std::enable_shared_from_this<VulkanMaps> {
  public:
    /// Calls of trim() over which the pages of a map that was given back wait for the next.
    static constexpr int kept_trims = 8;

    /// As many maps as may be held.
    static Result<std::shared_ptr<VulkanMaps>> create(std::shared_ptr<gpu::Device> device, int size,
                                                      std::size_t bytes_max = held_map_bytes_max);

    /// So many free maps in a row: the place of the first; none: too many are held.
    std::optional<std::size_t> take(std::size_t count);
    void give(std::size_t first, std::size_t count);
    /// Gives those that were taken back when its last holder lets go.
    std::shared_ptr<const void> keeper(std::size_t first, std::size_t count);
    /// Those that were taken, as the values of a keyframe that gives them back. Where the CPU can read them.
    sea::MapValues lend(std::size_t first, std::size_t count);

    /// From time to time: where device memory is this process's own, which it is of a processor as device, pages of maps that
    /// have been free over kept_trims of these calls go back to the system, some of them a call: of 16 MB, in 64 places. A millisecond. Not beside
    /// take().
    void trim();

    const gpu::Buffer& buffer() const { return buffer_; }
    const gpu::TexelView& view() const { return view_; }
    std::size_t held() const;
    /// What there is to say where a keyframe finds no place: it needs so many, and has taken `own` of them.
    Error full(std::size_t own, std::size_t needed) const;
    std::size_t size() const { return places_.size(); }

  private:
    VulkanMaps(std::shared_ptr<gpu::Device> device, std::size_t floats)
        : device_(std::move(device)), map_floats_(floats) {}
    struct Range {
        std::size_t first, count;
    };
    /// Maps that have been free for long enough: their pages are as good as given back.
    std::vector<Range> forget_pages();

    const std::shared_ptr<gpu::Device> device_; ///< goes last
    const std::size_t map_floats_;
    gpu::Buffer buffer_;
    gpu::TexelView view_;
    mutable std::mutex mutex_; ///< of what follows
    struct Place {
        bool taken = false;
        bool has_pages = false;  ///< it was taken since trim() gave them back
        std::uint64_t given = 0; ///< after so many trims
    };
    std::vector<Place> places_;
    std::uint64_t trims_ = 0;
};

/// Those of every size that was asked for.
class VulkanMapsBySize {
  public:
    /// Made when they are first asked for; where the device has no memory for so many, half of them, or a quarter. Null: not even
    /// one may be held.
    Result<VulkanMaps*> of_size(const std::shared_ptr<gpu::Device>& device, int size,
                                std::size_t bytes_max);
    /// Those that were made; null: none.
    VulkanMaps* find(int size) const {
        const auto found = maps_.find(size);
        return found != maps_.end() ? found->second.get() : nullptr;
    }
    void trim();

  private:
    std::map<int, std::shared_ptr<VulkanMaps>> maps_;
};

/// Maps that were taken, to be handed out one after the other; the rest is given back.
class TakenMaps {
  public:
    TakenMaps(VulkanMaps& maps, std::size_t first, std::size_t count)
        : maps_(maps), next_(first), end_(first + count) {}
    TakenMaps(const TakenMaps&) = delete;
    TakenMaps& operator=(const TakenMaps&) = delete;
    ~TakenMaps() { maps_.give(next_, end_ - next_); }

    /// As VulkanMaps::lend(), which gives them back itself where there is no memory for that.
    sea::MapValues lend(std::size_t count) {
        return maps_.lend(std::exchange(next_, next_ + count), count);
    }
    void give(std::size_t count) { maps_.give(std::exchange(next_, next_ + count), count); }

  private:
    VulkanMaps& maps_;
    std::size_t next_, end_;
};

} // namespace seaway::server
