// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/accuracy/seas/tile_stream.h"

#include <algorithm>
#include <cmath>

#include "base/elapsed.h"
#include "base/worse.h"
#include "protocol/tile_codec.h"
#include "sea/surface/maps/regrid.h"
#include "sea/waves/realize.h"
#include "server/host/grant.h"

namespace seaway::bench {

namespace {

using sea::Field;
using sea::FieldSet;

server::Quality quality_of(Tiles form) {
    return server::number_of(
        {.compact = form != Tiles::whole, .predicted = form == Tiles::predicted});
}

} // namespace

TileStream::TileStream(const Waves& waves, Tiles form, double codec_error_m)
    : budget_(waves.budget), depth_m_(waves.state.depth_m), quality_(quality_of(form)),
      law_(sea::wave_law(waves.state, *waves.used)), costs_(waves.budget.cascades.size()),
      streams_(waves.budget.cascades.size()) {
    budget_.codec_error_m = codec_error_m;
}

bool TileStream::follows_last(int cascade, sea::TimeUs time_us) const {
    const auto c = static_cast<std::size_t>(cascade);
    const server::EncodedKeyframePtr& last = streams_[c].last;
    return last && time_us == last->time_us + budget_.cascades[c].interval_us;
}

int TileStream::leads_to(int cascade, sea::TimeUs time_us) const {
    const bool predicted =
        law_ && server::maps_of(budget_, cascade, server::predicted_fields, quality_).predicted;
    return predicted && !follows_last(cascade, time_us) ? leads : 0;
}

Result<void> TileStream::lead(sea::Keyframe& keyframe) {
    Stream& stream = streams_[static_cast<std::size_t>(keyframe.cascade)];
    if (!follows_last(keyframe.cascade, keyframe.time_us))
        ++stream.epoch;
    keyframe.epoch = stream.epoch;
    const server::RungMaps maps =
        server::maps_of(budget_, keyframe.cascade, keyframe.fields, quality_);
    const FieldSet follows = sea::following(keyframe.fields) & keyframe.fields &
                             server::follows_of(budget_, keyframe.fields, quality_);
    SEAWAY_TRY_LET(stream.last, encoder_.encode(keyframe, maps.codec_error, quality_,
                                                keyframe.fields.without(follows),
                                                {maps.compact_size, follows, maps.coarser,
                                                 maps.predicted ? law_ : std::nullopt}));
    stream.taken = false;
    return {};
}

Result<client::HeldKeyframePtr> TileStream::take(const sea::Keyframe& keyframe, bool differs) {
    Stream& stream = streams_[static_cast<std::size_t>(keyframe.cascade)];
    const protocol::CascadeInfo info{.length_m = keyframe.length_m, .size = keyframe.size};
    protocol::MessageReader reader(protocol::Sender::server);
    client::HeldKeyframePtr held;
    for (const server::EncodedField& map : stream.last->maps)
        for (const protocol::SharedBytes& part :
             differs && !map.differences.empty() ? map.differences : map.parts) {
            SEAWAY_TRY_LET(const wire::Message* message, reader.read(*part));
            const wire::Tile& tile = *message->body_as_Tile();
            SEAWAY_TRY_LET(const client::TileAssembly::Added added,
                           assembly_.add(protocol::header(tile),
                                         {tile.payload()->data(), tile.payload()->size()}, info,
                                         depth_m_, keyframe.fields, {}, law_));
            if (added.complete)
                held = added.complete;
        }
    stream.taken = true;
    return held ? Result<client::HeldKeyframePtr>(held)
                : Error{"a keyframe that was sent is not whole again"};
}

Result<void> TileStream::send(sea::Keyframe& keyframe) {
    const Stream& stream = streams_[static_cast<std::size_t>(keyframe.cascade)];
    if (follows_last(keyframe.cascade, keyframe.time_us) && !stream.taken) {
        sea::Keyframe last = keyframe;
        last.fields = stream.last->fields;
        SEAWAY_TRY(take(last, false));
    }
    const double start_s = process_cpu_seconds();
    SEAWAY_TRY(lead(keyframe));
    const double encoded_s = process_cpu_seconds();
    SEAWAY_TRY_LET(const client::HeldKeyframePtr held, take(keyframe, true));
    const double taken_s = process_cpu_seconds();
    SEAWAY_TRY_LET(const double over_bound, worst_over_bound(keyframe, *stream.last));
    CodingCost& cost = costs_[static_cast<std::size_t>(keyframe.cascade)];
    ++cost.keyframes;
    cost.bytes += message_bytes(*stream.last, keyframe.fields, true);
    cost.bytes_made += stream.last->bytes;
    cost.encode_s += encoded_s - start_s;
    cost.decode_s += taken_s - encoded_s;
    cost.worst_over_bound = worse(cost.worst_over_bound, over_bound);
    for (const Field field : keyframe.fields)
        std::ranges::copy(held->keyframe().plane(field), keyframe.plane(field).begin());
    return {};
}

Result<double> TileStream::worst_over_bound(const sea::Keyframe& keyframe,
                                            const server::EncodedKeyframe& encoded) const {
    // Two maps go to the smaller grid at once: to the same bits as the encoder's only with the same partners.
    const int size =
        server::maps_of(budget_, keyframe.cascade, keyframe.fields, quality_).compact_size;
    const bool smaller = size > 0 && size < keyframe.size;
    sea::Keyframe small{keyframe.epoch,    keyframe.cascade, keyframe.time_us,    size,
                        keyframe.length_m, encoded.fields,   std::vector<float>{}};
    if (smaller)
        sea::Regrid(keyframe.size, size).maps(keyframe, encoded.fields, small);
    const sea::Keyframe& sent = smaller ? small : keyframe;
    const auto stride = static_cast<std::size_t>(sent.size);
    double worst = 0;
    for (const server::EncodedField& map : encoded.maps) {
        std::vector<float> decoded(sent.plane_size());
        protocol::MessageReader reader(protocol::Sender::server);
        for (const protocol::SharedBytes& part : map.parts) {
            SEAWAY_TRY_LET(const wire::Message* message, reader.read(*part));
            const wire::Tile& tile = *message->body_as_Tile();
            const std::size_t first = tile.y0() * stride + tile.x0();
            SEAWAY_TRY(protocol::decode_tile({tile.payload()->data(), tile.payload()->size()},
                                             {tile.width(), tile.height()}, stride,
                                             std::span(decoded).subspan(first)));
        }
        const std::span<const float> original = sent.plane(map.field);
        for (std::size_t i = 0; i < decoded.size(); ++i)
            worst = worse(worst, std::abs(static_cast<double>(decoded[i]) -
                                          static_cast<double>(original[i])) /
                                     static_cast<double>(map.error));
    }
    return worst;
}

} // namespace seaway::bench
