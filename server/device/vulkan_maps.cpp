// SPDX-License-Identifier: Apache-2.0
#include "server/device/vulkan_maps.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/check.h"
#include "base/spare_memory.h"
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
    made->places_.resize(maps);
    return made;
}

// The first place that is long enough: what was read last is written next, and stays in the cache.
std::optional<std::size_t> VulkanMaps::take(std::size_t count) {
    const std::scoped_lock lock(mutex_);
    std::size_t free = 0;
    for (std::size_t i = 0; i < places_.size(); ++i) {
        free = places_[i].taken ? 0 : free + 1;
        if (free < count)
            continue;
        const std::size_t first = i + 1 - count;
        for (Place& place : std::span(places_).subspan(first, count))
            place.taken = place.has_pages = true;
        return first;
    }
    return std::nullopt;
}

void VulkanMaps::give(std::size_t first, std::size_t count) {
    const std::scoped_lock lock(mutex_);
    SEAWAY_CHECK(first + count <= places_.size(), "maps that were taken");
    for (Place& place : std::span(places_).subspan(first, count)) {
        place.taken = false;
        place.given = trims_;
    }
}

std::size_t VulkanMaps::forget_pages(std::size_t first, std::size_t most) {
    const std::scoped_lock lock(mutex_);
    std::size_t count = 0;
    for (Place& place : std::span(places_).subspan(first)) {
        const bool unused = !place.taken && place.has_pages && place.given + kept_trims <= trims_;
        if (count == most || !unused)
            break;
        place.has_pages = false;
        ++count;
    }
    return count;
}

void VulkanMaps::trim() {
    if (!device_->info().is_cpu() || buffer_.mapped().empty())
        return;
    constexpr std::size_t bytes_a_call = std::size_t{16} << 20;
    const std::size_t map_bytes = map_floats_ * sizeof(float);
    {
        const std::scoped_lock lock(mutex_);
        ++trims_;
    }
    std::size_t left = std::max<std::size_t>(bytes_a_call / map_bytes, 1);
    for (std::size_t first = 0; first < places_.size() && left > 0;) {
        const std::size_t count = forget_pages(first, left);
        give_back_pages(buffer_.mapped().subspan(first * map_bytes, count * map_bytes));
        left -= count;
        first += std::max<std::size_t>(count, 1);
    }
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
    return static_cast<std::size_t>(std::ranges::count(places_, true, &Place::taken));
}

Result<VulkanMaps*> VulkanMapsBySize::of_size(const std::shared_ptr<gpu::Device>& device, int size,
                                              std::size_t bytes_max) {
    std::shared_ptr<VulkanMaps>& maps = maps_[size];
    if (!maps) {
        SEAWAY_TRY_LET(maps, VulkanMaps::create(device, size, bytes_max));
    }
    return maps->size() > 0 ? maps.get() : nullptr;
}

void VulkanMapsBySize::trim() {
    for (const auto& [size, maps] : maps_)
        if (maps) // else there was no memory for them
            maps->trim();
}

} // namespace seaway::server
