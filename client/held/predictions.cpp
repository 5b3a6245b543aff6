// SPDX-License-Identifier: Apache-2.0
#include "client/held/predictions.h"

#include <algorithm>

namespace seaway::client {

void Predictions::keep(const protocol::TileHeader& header, double length_m, int size, Maps maps) {
    const auto same_cascade = [&](const Base& one) {
        return one.epoch == header.epoch && one.cascade == header.cascade;
    };
    if (size > protocol::limits::predicted_size_max || !sea::Regrid::takes(size) ||
        std::ranges::any_of(bases_, [&](const Base& one) { return one.number == header.keyframe; }))
        return;
    // Those that are fetched meanwhile lie before those that are streamed.
    if (std::ranges::count_if(bases_, same_cascade) >= static_cast<int>(of_a_cascade)) {
        auto oldest = bases_.end();
        for (auto at = bases_.begin(); at != bases_.end(); ++at)
            if (same_cascade(*at) && (oldest == bases_.end() || at->time_us < oldest->time_us))
                oldest = at;
        if (oldest->time_us > header.time_us)
            return;
        bases_.erase(oldest);
    }
    const auto bytes = [](const Maps& of) { return 2 * sizeof(float) * of.height.size(); };
    std::size_t held = bytes(maps);
    for (const Base& one : bases_)
        held += bytes(one.maps);
    for (; !bases_.empty() && (bases_.size() >= bases_max || held > bytes_max); bases_.pop_front())
        held -= bytes(bases_.front().maps);
    bases_.push_back({header.keyframe, header.epoch, header.cascade, header.time_us, length_m, size,
                      std::move(maps)});
}

const Predictions::Maps* Predictions::expected(const protocol::TileHeader& header,
                                               const sea::WaveLaw& law) {
    const auto base = std::ranges::find_if(bases_, [&](const Base& one) {
        return one.number == header.base && one.epoch == header.epoch &&
               one.cascade == header.cascade && one.size == header.size;
    });
    if (base == bases_.end())
        return nullptr;
    const bool same = expected_of_ && expected_of_->keyframe == header.keyframe &&
                      expected_of_->base == header.base && expected_of_->epoch == header.epoch &&
                      expected_of_->cascade == header.cascade &&
                      expected_of_->size == header.size && expected_of_->time_us == header.time_us;
    if (same)
        return &expected_;
    for (LargeVector<float>* map : {&expected_.height, &expected_.rate})
        map->resize(base->maps.height.size());
    predictor_.maps(base->size, base->length_m, law, header.time_us - base->time_us,
                    base->maps.height, base->maps.rate, expected_.height, expected_.rate);
    expected_of_ = header;
    return &expected_;
}

} // namespace seaway::client
