// SPDX-License-Identifier: Apache-2.0
#include "server/net/map_places.h"

#include <algorithm>
#include <utility>

namespace seaway::server {

bool MapPlaces::ask(Begin begin) {
    if (state_->taken < state_->most) {
        begin(place(state_));
        return true;
    }
    if (static_cast<int>(state_->waiting.size()) < state_->ending) {
        state_->waiting.push_back(std::move(begin));
        return true;
    }
    std::shared_ptr<MapReader> slowest;
    std::erase_if(readers_, [&slowest](const std::weak_ptr<MapReader>& weak) {
        const std::shared_ptr<MapReader> reader = weak.lock();
        if (reader == nullptr)
            return true;
        if (reader->behind() > (slowest ? slowest->behind() : std::chrono::seconds(0)))
            slowest = reader;
        return false;
    });
    if (slowest == nullptr)
        return false;
    std::erase_if(readers_, [&slowest](const auto& weak) { return weak.lock() == slowest; });
    state_->waiting.push_back(std::move(begin));
    slowest->give_way();
    return true;
}

void MapPlaces::reads(std::weak_ptr<MapReader> reader) {
    std::erase_if(readers_, [](const auto& weak) { return weak.expired(); });
    readers_.push_back(std::move(reader));
}

void MapPlaces::stop() {
    std::deque<Begin> forgotten;
    forgotten.swap(state_->waiting);
    state_->most = 0;
}

MapPlaces::Place MapPlaces::place(const std::shared_ptr<State>& state) {
    ++state->taken;
    return Place(state.get(), GiveBack{state});
}

void MapPlaces::gave_back(const std::shared_ptr<State>& state, bool had_ended) {
    --state->taken;
    state->ending -= had_ended;
    if (state->waiting.empty() || state->taken >= state->most)
        return;
    const Begin begin = std::move(state->waiting.front());
    state->waiting.pop_front();
    begin(place(state));
}

} // namespace seaway::server
