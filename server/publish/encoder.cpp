// SPDX-License-Identifier: Apache-2.0
#include "server/publish/encoder.h"

#include <algorithm>
#include <chrono>

#include <fmt/format.h>

#include "protocol/limits.h"
#include "protocol/tile_codec.h"

namespace seaway::server {
namespace {

const EncodedField* find_field(const EncodedKeyframe* keyframe, sea::Field field, float error) {
    if (keyframe == nullptr)
        return nullptr;
    for (const EncodedField& map : keyframe->maps)
        if (map.field == field && map.error == error)
            return &map;
    return nullptr;
}

std::size_t bytes_of(const EncodedField& map) {
    std::size_t bytes = 0;
    for (const protocol::SharedBytes& part : map.parts)
        bytes += part->size();
    return bytes;
}

} // namespace

std::size_t message_bytes(const EncodedKeyframe& keyframe, sea::FieldSet fields) {
    std::size_t bytes = 0;
    for (const EncodedField& map : keyframe.maps)
        if (fields.contains(map.field))
            bytes += bytes_of(map);
    return bytes;
}

Result<EncodedKeyframePtr> Encoder::encode(const sea::Keyframe& keyframe,
                                           std::span<const float> codec_error, std::uint8_t quality,
                                           sea::FieldSet wanted, const CompactTiles& compact,
                                           Room* streamed) {
    SEAWAY_CHECK(codec_error.size() == static_cast<std::size_t>(keyframe.fields.size()),
                 "one codec bound for each field of a keyframe");
    const EncodedKeyframePtr known = find(keyframe, quality);
    auto encoded = std::make_shared<EncodedKeyframe>();
    encoded->number = known ? known->number : next_number_++;
    encoded->epoch = keyframe.epoch;
    encoded->cascade = keyframe.cascade;
    encoded->time_us = keyframe.time_us;
    encoded->quality = quality;
    const auto error_of = [&](sea::Field field) {
        return codec_error[static_cast<std::size_t>(keyframe.fields.index_of(field))];
    };
    sea::FieldSet smaller; // those to be encoded on the smaller grid
    for (const sea::Field field : keyframe.fields)
        if (compact.size > 0 && compact.size < keyframe.size && sea::is_linear(field) &&
            wanted.contains(field) && find_field(known.get(), field, error_of(field)) == nullptr)
            smaller.insert(field);
    const sea::Keyframe small = compacted(keyframe, smaller, compact.size);
    bool added = false;
    for (const sea::Field field : keyframe.fields) {
        const float error = error_of(field);
        if (const EncodedField* map = find_field(known.get(), field, error)) {
            encoded->maps.push_back(*map);
            counters_.fields_reused += wanted.contains(field) ? 1 : 0;
        } else if (wanted.contains(field)) {
            Result<EncodedField> map_made = encode_field(smaller.contains(field) ? small : keyframe,
                                                         field, error, encoded->number, compact);
            if (!map_made)
                return map_made.error();
            encoded->maps.push_back(std::move(*map_made));
            added = true;
        }
    }
    if (!added && known)
        return known;
    for (const EncodedField& map : encoded->maps) {
        encoded->fields.insert(map.field);
        encoded->bytes += bytes_of(map);
    }
    if (streamed != nullptr)
        encoded->place = streamed->take_anyway(encoded->bytes);
    EncodedKeyframePtr done = std::move(encoded);
    remember(done);
    return done;
}

sea::Keyframe Encoder::compacted(const sea::Keyframe& keyframe, sea::FieldSet fields, int size) {
    sea::Keyframe compact{
        keyframe.epoch, keyframe.cascade, keyframe.time_us, size, keyframe.length_m, fields, {}};
    if (fields.empty())
        return compact;
    const auto start = std::chrono::steady_clock::now();
    const auto at = regrids_.find({keyframe.size, size});
    const sea::Regrid& regrid =
        at != regrids_.end()
            ? at->second
            : regrids_.emplace(std::pair(keyframe.size, size), sea::Regrid(keyframe.size, size))
                  .first->second;
    regrid.maps(keyframe, fields, compact);
    counters_.seconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return compact;
}

Result<EncodedField> Encoder::encode_field(const sea::Keyframe& keyframe, sea::Field field,
                                           float error, std::uint64_t number,
                                           const CompactTiles& compact) {
    const auto start = std::chrono::steady_clock::now();
    const int side = protocol::limits::tile_side_max;
    const int per_axis = (keyframe.size + side - 1) / side;
    const std::span<const float> plane = keyframe.plane(field);
    EncodedField map{.field = field, .error = error, .parts = {}};
    for (int part = 0; part < per_axis * per_axis; ++part) {
        const int x0 = (part % per_axis) * side;
        const int y0 = (part / per_axis) * side;
        const protocol::TileHeader header{.keyframe = number,
                                          .epoch = keyframe.epoch,
                                          .cascade = keyframe.cascade,
                                          .field = field,
                                          .time_us = keyframe.time_us,
                                          .size = keyframe.size,
                                          .x0 = x0,
                                          .y0 = y0,
                                          .width = std::min(side, keyframe.size - x0),
                                          .height = std::min(side, keyframe.size - y0),
                                          .part = part,
                                          .parts = per_axis * per_axis,
                                          .error = error,
                                          .follows = compact.follows & sea::following(field),
                                          .coarser = compact.coarser};
        const auto offset = static_cast<std::size_t>(y0) * static_cast<std::size_t>(keyframe.size) +
                            static_cast<std::size_t>(x0);
        const auto payload =
            protocol::encode_tile(plane.subspan(offset), {header.width, header.height},
                                  static_cast<std::size_t>(keyframe.size), error);
        if (!payload)
            return Error{fmt::format("keyframe of cascade {} at {} us, field {}: {}",
                                     keyframe.cascade, keyframe.time_us, sea::info(field).name,
                                     payload.error().message)};
        map.parts.push_back(
            std::make_shared<const protocol::Bytes>(protocol::tile(header, *payload)));
    }
    counters_.fields_encoded += 1;
    counters_.samples += plane.size();
    counters_.bytes += bytes_of(map);
    counters_.seconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return map;
}

EncodedKeyframePtr Encoder::find(const sea::Keyframe& keyframe, std::uint8_t quality) const {
    const auto same = [&](const Remembered& held) {
        const EncodedKeyframe& it = *held.keyframe;
        return it.epoch == keyframe.epoch && it.cascade == keyframe.cascade &&
               it.time_us == keyframe.time_us && it.quality == quality;
    };
    const auto found = std::find_if(cache_.rbegin(), cache_.rend(), same);
    return found == cache_.rend() ? nullptr : found->keyframe;
}

void Encoder::remember(EncodedKeyframePtr encoded) {
    const std::uint64_t number = encoded->number;
    std::erase_if(cache_, [&](const auto& held) { return held.keyframe->number == number; });
    Room::Place place = room_->take_anyway(encoded->bytes);
    cache_.push_back({std::move(encoded), std::move(place)});
    while (room_->overfull() && !cache_.empty())
        cache_.pop_front();
}

} // namespace seaway::server
