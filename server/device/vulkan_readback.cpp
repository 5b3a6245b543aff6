// SPDX-License-Identifier: Apache-2.0
#include "server/device/vulkan_readback.h"

#include <algorithm>

namespace seaway::server {

Result<void> VulkanReadbacks::collect() {
    const Pending& oldest = pending_.front();
    counters_.readbacks_beside += pending_.size() > 1;
    SEAWAY_TRY(oldest.batch->finish(oldest.run));
    for (const NewKeyframePtr& keyframe : oldest.keyframes) {
        keyframe->values = spare_->take(keyframe->plane_size() *
                                        static_cast<std::size_t>(keyframe->fields.size()));
        counters_.copies += !keyframe->fields.empty();
    }
    if (oldest.rounded)
        SEAWAY_TRY(take_rounded(oldest));
    else
        copy_maps(oldest);
    pending_.pop_front();
    return {};
}

/// A map that travelled as steps.
struct VulkanReadbacks::Travelled {
    std::span<const std::int16_t> from;
    float step;
    std::vector<std::int16_t>* steps; ///< with room for them: nothing here may throw
    std::span<float> values;

    void take() const {
        steps->assign(from.begin(), from.end());
        for (std::size_t i = 0; i < from.size(); ++i)
            values[i] = static_cast<float>(from[i]) * step;
    }
};

sea::FieldSet VulkanReadbacks::sort_maps(const Pending& pending, int job,
                                         std::vector<Travelled>& travelled) {
    sea::Keyframe& keyframe = *pending.keyframes[static_cast<std::size_t>(job)];
    sea::FieldSet too_large;
    for (sea::RoundedMap& map : keyframe.rounded) {
        const int place = pending.packing.map_of(map.field);
        if (!pending.batch->fits(pending.run, job, place)) {
            too_large.insert(map.field);
            ++counters_.maps_too_large[static_cast<std::size_t>(map.field)];
            continue;
        }
        map.steps.reserve(keyframe.plane_size());
    }
    std::erase_if(keyframe.rounded, [&](const auto& map) { return too_large.contains(map.field); });
    for (sea::RoundedMap& map : keyframe.rounded) {
        const int place = pending.packing.map_of(map.field);
        travelled.push_back({pending.batch->steps(pending.run, job, place), map.step, &map.steps,
                             keyframe.plane(map.field)});
    }
    return too_large;
}

Result<void> VulkanReadbacks::take_rounded(const Pending& pending) {
    std::vector<VulkanBatch::MapOf> again;
    std::vector<std::span<float>> planes;
    std::vector<Travelled> travelled;
    for (int job = 0; job < static_cast<int>(pending.keyframes.size()); ++job)
        for (const sea::Field field : sort_maps(pending, job, travelled)) {
            again.push_back({job, pending.packing.map_of(field)});
            planes.push_back(pending.keyframes[static_cast<std::size_t>(job)]->plane(field));
        }
    const Phase take{
        [](const void* all, int index, int) {
            (*static_cast<const std::vector<Travelled>*>(all))[static_cast<std::size_t>(index)]
                .take();
        },
        &travelled, static_cast<int>(travelled.size())};
    copiers_.run({&take, 1});
    counters_.maps_rounded += travelled.size();
    if (again.empty())
        return {};
    SEAWAY_TRY(pending.batch->read_exactly(pending.run, again));
    for (std::size_t i = 0; i < again.size(); ++i)
        pending.batch->read_map(pending.run, again[i].job, again[i].map, planes[i]);
    return {};
}

// Copying is bound by memory: a second thread makes it a third faster on two cores.
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
