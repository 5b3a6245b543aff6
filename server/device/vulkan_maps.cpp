// SPDX-License-Identifier: Apache-2.0
#include "server/device/vulkan_maps.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/check.h"
#include "base/spare_memory.h"
#include "gpu/call.h"
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

std::vector<VulkanMaps::Range> VulkanMaps::forget_pages() {
    constexpr std::size_t bytes_a_call = std::size_t{16} << 20, ranges_a_call = 64;
    std::size_t left = std::max<std::size_t>(bytes_a_call / (map_floats_ * sizeof(float)), 1);
    std::vector<Range> ranges;
    const std::scoped_lock lock(mutex_);
    ++trims_;
    for (std::size_t i = 0; i < places_.size() && left > 0; ++i) {
        Place& place = places_[i];
        if (place.taken || !place.has_pages || place.given + kept_trims > trims_)
            continue;
        const bool goes_on = !ranges.empty() && ranges.back().first + ranges.back().count == i;
        if (!goes_on && ranges.size() == ranges_a_call)
            break;
        if (!goes_on)
            ranges.push_back({i, 0});
        ++ranges.back().count;
        place.has_pages = false;
        --left;
    }
    return ranges;
}

void VulkanMaps::trim() {
    if (!device_->info().is_cpu() || buffer_.mapped().empty())
        return;
    const std::size_t map_bytes = map_floats_ * sizeof(float);
    for (const Range& range : forget_pages()) // who takes is who trims: none of them meanwhile
        give_back_pages(buffer_.mapped().subspan(range.first * map_bytes, range.count * map_bytes));
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
        Result<std::shared_ptr<VulkanMaps>> made = VulkanMaps::create(device, size, bytes_max);
        for (; !made && gpu::is_out_of_memory(made.error()) && bytes_max > 0; bytes_max /= 2)
            made = VulkanMaps::create(device, size, bytes_max / 2);
        SEAWAY_TRY_LET(maps, std::move(made));
    }
    return maps->size() > 0 ? maps.get() : nullptr;
}

void VulkanMapsBySize::trim() {
    for (const auto& [size, maps] : maps_)
        if (maps) // else there was no memory for them
            maps->trim();
}

} // namespace seaway::server
