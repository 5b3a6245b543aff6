// SPDX-License-Identifier: Apache-2.0
#include "server/device/vulkan_maps.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/check.h"
#include "server/device/synthesizer.h"
#include "server/device/vulkan_fields.h"

namespace seaway::server {

Result<std::shared_ptr<VulkanMaps>> VulkanMaps::create(std::shared_ptr<gpu::Device> device,
                                                       int size, std::size_t bytes_max) {
    const auto points = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
    const std::size_t maps =
        std::min(bytes_max, gpu::bound_bytes_max(*device, vec4_bytes)) / (points * sizeof(float));
    std::shared_ptr<VulkanMaps> made(new VulkanMaps(std::move(device), points));
    if (maps == 0)
        return made;
    const std::size_t used_bytes = maps * points * sizeof(float);
    SEAWAY_TRY_LET(made->buffer_, gpu::Buffer::create(*made->device_, "held maps", used_bytes,
                                                      gpu::BufferKind::device));
    SEAWAY_TRY_LET(made->view_, gpu::TexelView::create(*made->device_, made->buffer_,
                                                       VK_FORMAT_R32G32B32A32_SFLOAT, vec4_bytes, 0,
                                                       used_bytes));
    made->taken_.resize(maps, false);
    return made;
}

// The first place that is long enough: what was read last is written next, and stays in the cache.
std::optional<std::size_t> VulkanMaps::take(std::size_t count) {
    const std::scoped_lock lock(mutex_);
    std::size_t free = 0;
    for (std::size_t i = 0; i < taken_.size(); ++i) {
        free = taken_[i] ? 0 : free + 1;
        if (free < count)
            continue;
        const std::size_t first = i + 1 - count;
        std::fill_n(taken_.begin() + static_cast<std::ptrdiff_t>(first), count, true);
        return first;
    }
    return std::nullopt;
}

void VulkanMaps::give(std::size_t first, std::size_t count) {
    const std::scoped_lock lock(mutex_);
    SEAWAY_CHECK(first + count <= taken_.size(), "maps that were taken");
    std::fill_n(taken_.begin() + static_cast<std::ptrdiff_t>(first), count, false);
}

std::shared_ptr<const void> VulkanMaps::keeper(std::size_t first, std::size_t count) {
    return {this,
            [maps = shared_from_this(), first, count](const void*) { maps->give(first, count); }};
}

sea::MapValues VulkanMaps::lend(std::size_t first, std::size_t count) {
    const std::span<float> values =
        buffer_.mapped_as<float>().subspan(first * map_floats_, count * map_floats_);
    return sea::MapValues::lent(values, keeper(first, count));
}

Error VulkanMaps::full(std::size_t own, std::size_t needed) const {
    return {DeviceError::out_of_memory,
            fmt::format("{} of {} maps of size {} are held, and the next keyframe takes {}",
                        held() - own, size(),
                        std::lround(std::sqrt(static_cast<double>(map_floats_))), needed)};
}

std::size_t VulkanMaps::held() const {
    const std::scoped_lock lock(mutex_);
    return static_cast<std::size_t>(std::ranges::count(taken_, true));
}

} // namespace seaway::server
