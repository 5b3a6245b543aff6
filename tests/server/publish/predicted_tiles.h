// SPDX-License-Identifier: Apache-2.0
// Keyframes of running_keyframe() as an encoder makes them, and as a client has them.
#pragma once

#include <cstring>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "client/held/tile_assembly.h"
#include "server/publish/encoder.h"
#include "tests/server/publish/predicted_sea.h"
#include "tests/server/publish/tile_of.h"

namespace seaway::server {

inline constexpr sea::FieldSet both_fields{sea::Field::height, sea::Field::height_rate};
inline constexpr CompactTiles predicted{.law = predicted_law};
inline constexpr Quality quality = 10;
inline const std::vector<float> bounds{1e-3f, 4e-3f, 1e-2f};

inline EncodedKeyframePtr encode(Encoder& encoder, const sea::Keyframe& keyframe,
                                 const CompactTiles& how = predicted, Quality of = quality) {
    const auto made = encoder.encode(
        keyframe, std::span(bounds).first(static_cast<std::size_t>(keyframe.fields.size())), of,
        keyframe.fields, how);
    EXPECT_TRUE(made);
    return *made;
}

inline std::size_t bytes_of(const std::vector<protocol::SharedBytes>& parts) {
    std::size_t bytes = 0;
    for (const protocol::SharedBytes& part : parts)
        bytes += part->size();
    return bytes;
}

/// Takes messages; what comes together.
inline client::HeldKeyframePtr take(client::TileAssembly& assembly,
                                    const std::vector<protocol::SharedBytes>& messages,
                                    bool* unpredicted = nullptr) {
    client::HeldKeyframePtr complete;
    for (const protocol::SharedBytes& bytes : messages) {
        const wire::Tile& tile = tile_of(bytes);
        const auto added = assembly.add(
            protocol::header(tile), {tile.payload()->data(), tile.payload()->size()},
            {.length_m = predicted_length_m, .size = 20}, 0, both_fields, {}, predicted_law);
        EXPECT_TRUE(added) << added.error().message;
        if (added && added->complete)
            complete = added->complete;
        if (unpredicted != nullptr && added && added->unpredicted)
            *unpredicted = true;
    }
    return complete;
}

inline std::vector<protocol::SharedBytes> messages_of(const EncodedKeyframe& keyframe,
                                                      bool differs) {
    std::vector<protocol::SharedBytes> all;
    for (const EncodedField& map : keyframe.maps)
        for (const protocol::SharedBytes& part : differs ? map.differences : map.parts)
            all.push_back(part);
    return all;
}

inline bool same_bits(const client::HeldKeyframe& a, const client::HeldKeyframe& b) {
    return a.keyframe().values.size() == b.keyframe().values.size() &&
           std::memcmp(a.keyframe().values.data(), b.keyframe().values.data(),
                       4 * a.keyframe().values.size()) == 0;
}

} // namespace seaway::server
