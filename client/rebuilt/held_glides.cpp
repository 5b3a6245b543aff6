// SPDX-License-Identifier: Apache-2.0
#include "client/rebuilt/held_glides.h"

#include <algorithm>
#include <utility>

namespace seaway::client {

OwnSeaPtr HeldGlides::find(std::uint32_t epoch, const GlideEnds& ends) {
    const auto found = std::ranges::find(glides_, epoch, &Glide::epoch);
    const auto is_same = [](const std::weak_ptr<const OwnSea>& held, const OwnSeaPtr& end) {
        return held.lock() == end;
    };
    if (found == glides_.end() || !std::ranges::equal(found->ends, ends, is_same))
        return nullptr;
    found->asked_about = true;
    std::rotate(found, found + 1, glides_.end());
    return glides_.back().sea;
}

void HeldGlides::keep(std::uint32_t epoch, sea::TimeUs end_us, const GlideEnds& ends,
                      OwnSeaPtr sea) {
    forget(epoch);
    if (glides_.size() == held_max)
        glides_.erase(glides_.begin());
    glides_.push_back({epoch, end_us, {ends.begin(), ends.end()}, std::move(sea)});
}

std::vector<std::uint32_t> HeldGlides::let_go_ended(sea::TimeUs now_us) {
    std::vector<std::uint32_t> gone;
    std::erase_if(glides_, [&](Glide& glide) {
        const bool goes = !std::exchange(glide.asked_about, false) && glide.end_us <= now_us;
        if (goes)
            gone.push_back(glide.epoch);
        return goes;
    });
    return gone;
}

void HeldGlides::forget(std::uint32_t epoch) {
    std::erase_if(glides_, [&](const Glide& glide) { return glide.epoch == epoch; });
}

} // namespace seaway::client
