// SPDX-License-Identifier: Apache-2.0
#include "server/device/vulkan_readback.h"

namespace seaway::server {

Result<void> VulkanReadbacks::collect() {
    const Pending& oldest = pending_.front();
    counts_.beside += pending_.size() > 1;
    SEAWAY_TRY(oldest.batch->finish(oldest.run));
    counts_.bytes += oldest.batch->travelled_bytes(oldest.run);
    copy_maps(oldest);
    pending_.pop_front();
    return {};
}

// Copying is bound by memory: a second thread makes it a third faster.
void VulkanReadbacks::copy_maps(const Pending& pending) {
    struct Map {
        const Pending& from;
        int job;
        int map;
        std::span<float> to;
    };
    std::vector<Map> maps;
    for (std::size_t job = 0; job < pending.keyframes.size(); ++job) {
        sea::Keyframe& keyframe = *pending.keyframes[job];
        keyframe.values =
            spare_->take(keyframe.plane_size() * static_cast<std::size_t>(keyframe.fields.size()));
        counts_.copies += !keyframe.fields.empty();
        for (const sea::Field field : keyframe.fields)
            maps.push_back({pending, static_cast<int>(job), pending.packing.map_of(field),
                            keyframe.plane(field)});
    }
    const Phase copy{[](const void* all, int index, int) {
                         const Map& map = (*static_cast<const std::vector<Map>*>(
                             all))[static_cast<std::size_t>(index)];
                         map.from.batch->read_map(map.from.run, map.job, map.map, map.to);
                     },
                     &maps, static_cast<int>(maps.size())};
    copiers_.run({&copy, 1});
}

} // namespace seaway::server
