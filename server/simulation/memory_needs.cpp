// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/memory_needs.h"

#include <algorithm>

#include "sea/surface/height_map.h"
#include "sea/surface/maps/spline_map.h"
#include "server/host/encoded_spectrum.h"
#include "server/simulation/foam_maps.h"
#include "server/simulation/keyframe_source.h"

namespace seaway::server {

namespace {

std::size_t points(const sea::CascadeModes& modes) {
    const auto size = static_cast<std::size_t>(modes.spec.size);
    return size * size;
}

/// Keyframes of all fields that may be asked for, and what foam stands on.
struct KeyframeBytes {
    std::size_t largest = 0, of_all_cascades = 0;
};

KeyframeBytes keyframe_bytes(const RunningSea& sea) {
    const auto fields =
        static_cast<std::size_t>(with_foam_inputs(sea.offered | sea.sampler_fields()).size());
    KeyframeBytes bytes;
    for (const sea::CascadeModes& modes : sea.realization->cascades) {
        const std::size_t one = points(modes) * fields * sizeof(float);
        bytes.largest = std::max(bytes.largest, one);
        bytes.of_all_cascades += one;
    }
    return bytes;
}

/// As encoded: of our scenes 0.2 to 0.4 bytes a grid point, of those that want much finer heights some more.
std::size_t spectrum_bytes(const RunningSea& sea) {
    std::size_t bytes = 0;
    for (const sea::CascadeModes& modes : sea.realization->cascades)
        bytes += 4 * points(modes);
    return std::min(bytes, encoded_spectrum_bytes_max);
}

} // namespace

std::size_t surface_bytes(const RunningSea& sea) {
    const auto fields = static_cast<std::size_t>(sea.sampler_fields().size());
    std::size_t bytes = 0;
    for (const sea::CascadeModes& modes : sea.realization->cascades)
        bytes += 2 * (fields * points(modes) * sizeof(float) +
                      sea::SplineMap::bytes_of(modes.spec.size));
    return bytes;
}

std::size_t map_bytes(const RunningSea& sea) {
    std::size_t bytes = surface_bytes(sea);
    for (const sea::CascadeModes& modes : sea.realization->cascades)
        bytes += sea::SplineMap::bytes_of(modes.spec.size) / 2; // mixed, without rates
    constexpr std::size_t chunks = sea::map_chunks_ahead_max + 2;
    return bytes + chunks * sea::map_chunk_values_max * sizeof(float);
}

MemoryNeeds needs_of(const RunningSea& sea) {
    const std::size_t surface = surface_bytes(sea);
    const KeyframeBytes keyframes = keyframe_bytes(sea);
    MemoryNeeds needs{};
    const auto need = [&needs](MemoryUse use) -> std::size_t& {
        return needs[static_cast<std::size_t>(use)];
    };
    for (const MemoryUse use :
         {MemoryUse::keyframes, MemoryUse::surfaces, MemoryUse::prompt_surfaces})
        need(use) = surface;
    need(MemoryUse::fetches) = std::max(keyframes.largest, samples_per_slice * sizeof(float));
    // Noise takes as many bytes in tiles as it has raw.
    for (const MemoryUse use : {MemoryUse::encoded, MemoryUse::streamed, MemoryUse::fetched})
        need(use) = keyframes.largest;
    // One is encoded while those of all cascades come.
    need(MemoryUse::encoding) = keyframes.largest + keyframes.of_all_cascades;
    need(MemoryUse::spectra) = finest_spectra_held * spectrum_bytes(sea);
    need(MemoryUse::maps) = maps_at_once_max * map_bytes(sea);
    return needs;
}

} // namespace seaway::server
