// SPDX-License-Identifier: Apache-2.0
// Bytes as the tiles that a client is sent, in any order, of any keyframe: refused, or put together to keyframes
// that hold what somebody waits for; what is held stays bounded. Input: two bytes of length, then a message,
// and so on; a payload is encoded anew where the first byte of the length is odd, so that tiles are found whole.
#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "client/held/tile_assembly.h"
#include "protocol/tile_codec.h"

using namespace seaway;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    client::TileAssembly assembly;
    protocol::MessageReader reader(protocol::Sender::server);
    const protocol::CascadeInfo cascade{.length_m = 100, .size = 64, .interval_us = 100'000};
    const sea::WaveLaw law{};
    std::vector<float> samples, expected, decoded;
    const sea::FieldSet requested[] = {{sea::Field::height}, sea::surface_fields};
    while (size >= 2) {
        const bool whole = (data[0] & 1u) != 0;
        const std::size_t length = static_cast<std::size_t>(data[0] >> 1) << 8 | data[1];
        data += 2;
        size -= 2;
        const std::size_t taken = length < size ? length : size;
        const auto message = reader.read({data, taken});
        data += taken;
        size -= taken;
        const wire::Tile* tile = message ? (*message)->body_as_Tile() : nullptr;
        if (tile == nullptr || !protocol::check(*tile))
            continue;
        const protocol::TileHeader header = protocol::header(*tile);
        std::vector<std::uint8_t> payload(tile->payload()->begin(), tile->payload()->end());
        if (whole && header.width * header.height <= 64 * 64) {
            const protocol::TileShape shape{header.width, header.height};
            const auto stride = static_cast<std::size_t>(header.width);
            samples.resize(stride * static_cast<std::size_t>(header.height));
            for (std::size_t i = 0; i < samples.size(); ++i)
                samples[i] = 0.25f + 0.01f * static_cast<float>(i % 7);
            expected.assign(samples.size(), 0.25f);
            decoded.resize(samples.size());
            // Of a keyframe that is to another: the difference to a flat sea, which that may have been.
            const auto forms =
                protocol::encode_tile_forms(samples, shape, stride, 0.01f, expected, decoded);
            const bool differs = header.base != 0 && header.base != header.keyframe;
            if (forms)
                payload = differs && !forms->difference.empty() ? forms->difference : forms->whole;
        }
        const auto added =
            assembly.add(header, payload, cascade, 0, sea::surface_fields, requested, law);
        if (added && added->complete && added->complete->keyframe().fields.empty())
            std::abort();
        if (assembly.keyframes() > client::TileAssembly::keyframes_max ||
            assembly.bytes() > client::TileAssembly::bytes_max)
            std::abort();
    }
    for (const auto& held : assembly.finish({sea::Field::height}))
        if (!held->keyframe().fields.contains(sea::Field::height))
            std::abort();
    return 0;
}
