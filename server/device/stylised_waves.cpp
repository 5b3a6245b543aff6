// SPDX-License-Identifier: Apache-2.0
#include "server/device/stylised_waves.h"

#include <chrono>

#include "base/elapsed.h"
#include "sea/surface/maps/sine_maps.h"

namespace seaway::server {

void add_stylised(std::span<const KeyframeRequest> requests, const sea::Realization& sea,
                  std::span<const NewKeyframePtr> made, SynthesisCounters& counters) {
    const auto start = std::chrono::steady_clock::now();
    std::uint64_t sums = 0;
    for (std::size_t i = 0; i < requests.size(); ++i)
        for (const sea::SineField& field :
             sea.cascades[static_cast<std::size_t>(requests[i].cascade)].sines) {
            made[i]->forget_steps(sea::sine_fields);
            sums += sea::add_sines(field, sea.phase_time(requests[i].time_us), *made[i]);
        }
    if (sums == 0)
        return;
    counters.stylised_sums += sums;
    counters.device_seconds += seconds_since(start);
}

} // namespace seaway::server
