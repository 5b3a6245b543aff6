// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/maps/predictor.h"

#include <algorithm>

namespace seaway::sea {

void Predictor::maps(int size, double length_m, const WaveLaw& law, TimeUs forward_us,
                     std::span<const float> height, std::span<const float> rate,
                     std::span<float> height_then, std::span<float> rate_then) {
    const Kept& known = kept(size, length_m, law, forward_us);
    known.regrid.maps(height, rate, known.rotations, height_then, rate_then);
}

const Predictor::Kept& Predictor::kept(int size, double length_m, const WaveLaw& law,
                                       TimeUs forward_us) {
    const auto found = std::ranges::find_if(kept_, [&](const Kept& one) {
        return one.rotations.size() == size && one.length_m == length_m && one.law == law &&
               one.forward_us == forward_us;
    });
    if (found != kept_.end())
        return *found;
    Rotations rotations(size, length_m, law, forward_us);
    std::size_t bytes = rotations.bytes();
    for (const Kept& one : kept_)
        bytes += one.rotations.bytes();
    for (; !kept_.empty() && (kept_.size() >= kept_max || bytes > kept_bytes_max);
         kept_.pop_front())
        bytes -= kept_.front().rotations.bytes();
    return kept_.emplace_back(
        Kept{length_m, law, forward_us, std::move(rotations), Regrid(size, size)});
}

} // namespace seaway::sea
