// SPDX-License-Identifier: Apache-2.0
#include "server/publish/encoder.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>

#include <fmt/format.h>

#include "base/elapsed.h"
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

std::size_t difference_bytes(const EncodedField& map) {
    std::size_t bytes = 0;
    for (const protocol::SharedBytes& part : map.differences)
        bytes += part->size();
    return bytes;
}

/// Differences that are no smaller than what they are to stand for are let go of.
void keep_if_smaller(EncodedKeyframe& keyframe) {
    std::size_t whole = 0, differences = 0;
    for (const EncodedField& map : keyframe.maps)
        if (!map.differences.empty()) {
            whole += bytes_of(map);
            differences += difference_bytes(map);
        }
    if (differences < whole)
        return;
    keyframe.base = 0;
    for (EncodedField& map : keyframe.maps)
        map.differences.clear();
}

/// A part of a map from `offset` on; `decoded` where it is the base of what follows, `expected` where something is. What the
/// samples are off already is taken from the bound.
Result<protocol::TileForms> forms_of(const sea::Keyframe& keyframe, sea::Field field,
                                     protocol::TileShape shape, std::size_t offset, float error,
                                     std::span<const float> expected, std::span<float> decoded) {
    const auto stride = static_cast<std::size_t>(keyframe.size);
    const std::span<const float> part = keyframe.plane(field).subspan(offset);
    const sea::RoundedMap* const rounded = keyframe.rounded_map(field);
    const float left = rounded ? std::nextafter(error - rounded->error, 0.0f) : error;
    if (!(left >= 0))
        return Error{fmt::format("samples were rounded to {}, which is more than the bound of {}",
                                 rounded->error, error)};
    if (!expected.empty())
        return protocol::encode_tile_forms(part, shape, stride, left, expected.subspan(offset),
                                           decoded.subspan(offset));
    protocol::TileForms forms;
    if (rounded && !rounded->steps.empty()) {
        SEAWAY_TRY_LET(forms.whole,
                       protocol::encode_tile_steps(std::span(rounded->steps).subspan(offset), shape,
                                                   stride, rounded->step, left));
    } else {
        SEAWAY_TRY_LET(forms.whole, protocol::encode_tile(part, shape, stride, left));
    }
    if (!decoded.empty())
        SEAWAY_TRY(protocol::decode_tile(forms.whole, shape, stride, decoded.subspan(offset)));
    return forms;
}

/// Where the parts of a map lie, row by row.
std::vector<protocol::TileHeader> parts_of(const sea::Keyframe& keyframe, sea::Field field) {
    const int side = protocol::limits::tile_side_max;
    const int per_axis = (keyframe.size + side - 1) / side;
    std::vector<protocol::TileHeader> parts;
    for (int part = 0; part < per_axis * per_axis; ++part) {
        const int x0 = (part % per_axis) * side;
        const int y0 = (part / per_axis) * side;
        parts.push_back({.epoch = keyframe.epoch,
                         .cascade = keyframe.cascade,
                         .field = field,
                         .time_us = keyframe.time_us,
                         .size = keyframe.size,
                         .x0 = x0,
                         .y0 = y0,
                         .width = std::min(side, keyframe.size - x0),
                         .height = std::min(side, keyframe.size - y0),
                         .part = part,
                         .parts = per_axis * per_axis});
    }
    return parts;
}

} // namespace

std::size_t message_bytes(const EncodedKeyframe& keyframe, sea::FieldSet fields, bool differs) {
    std::size_t bytes = 0;
    for (const EncodedField& map : keyframe.maps)
        if (fields.contains(map.field))
            bytes += differs && !map.differences.empty() ? difference_bytes(map) : bytes_of(map);
    return bytes;
}

sea::FieldSet maps_that_bring(const EncodedKeyframe& keyframe, sea::FieldSet fields,
                              sea::FieldSet follows) {
    const sea::FieldSet wished = keyframe.fields & (fields | follows.without(keyframe.follows));
    const sea::FieldSet maps = wished.without(keyframe.follows & sea::following(wished));
    const sea::FieldSet brought = maps | (keyframe.follows & sea::following(maps));
    return brought.contains(fields | follows) ? maps : sea::FieldSet{};
}

Result<EncodedKeyframePtr> Encoder::encode(const sea::Keyframe& keyframe,
                                           std::span<const float> codec_error, Quality quality,
                                           sea::FieldSet wanted, const CompactTiles& compact,
                                           Room* streamed) {
    SEAWAY_CHECK(codec_error.size() == static_cast<std::size_t>(keyframe.fields.size()),
                 "one codec bound for each field of a keyframe");
    const EncodedKeyframePtr known = find(keyframe, quality);
    if (streamed != nullptr && !known)
        forget_what_is_over(keyframe, quality);
    const std::uint64_t number = known ? known->number : next_number_++;
    const auto encoded = std::make_shared<EncodedKeyframe>(
        EncodedKeyframe{number, keyframe.epoch, keyframe.cascade, keyframe.time_us, quality});
    const auto error_of = [&](sea::Field field) {
        return codec_error[static_cast<std::size_t>(keyframe.fields.index_of(field))];
    };
    sea::FieldSet smaller; // those to be encoded on the smaller grid
    for (const sea::Field field : keyframe.fields)
        if (compact.size > 0 && compact.size < keyframe.size && sea::is_linear(field) &&
            wanted.contains(field) && find_field(known.get(), field, error_of(field)) == nullptr)
            smaller.insert(field);
    const sea::Keyframe small = compacted(keyframe, smaller, compact.size);
    const auto sent = [&](sea::Field field) -> const sea::Keyframe& {
        return smaller.contains(field) ? small : keyframe;
    };
    std::optional<Step> step;
    if (compact.law && (wanted & keyframe.fields).contains(predicted_fields) &&
        (!known || (known->fields & predicted_fields).empty()))
        step = step_to(sent(sea::Field::height), quality, compact, !smaller.empty());
    encoded->base = step ? step->from : known ? known->base : 0;
    bool added = false;
    for (const sea::Field field : keyframe.fields) {
        const float error = error_of(field);
        if (const EncodedField* map = find_field(known.get(), field, error)) {
            encoded->maps.push_back(*map);
            count({.fields_reused = wanted.contains(field) ? 1u : 0u});
        } else if (wanted.contains(field)) {
            SEAWAY_TRY_LET(EncodedField made, encode_field(sent(field), field, error, number,
                                                           compact, step ? &*step : nullptr));
            encoded->maps.push_back(std::move(made));
            added = true;
        }
    }
    if (step) {
        keep_if_smaller(*encoded);
        count({.fields_predicted = encoded->base != 0 ? 2u : 0u});
        keep(std::move(*step), sent(sea::Field::height), *encoded, *compact.law);
    }
    // What was made for a fetch has no place: the stream needs one that has.
    if (!added && known && (streamed == nullptr || known->place))
        return known;
    for (const EncodedField& map : encoded->maps) {
        encoded->fields.insert(map.field);
        encoded->follows |= compact.follows & sea::following(map.field);
        encoded->bytes += bytes_of(map) + difference_bytes(map);
    }
    if (streamed != nullptr)
        encoded->place = streamed->take_anyway(encoded->bytes);
    remember(encoded);
    return EncodedKeyframePtr(encoded);
}

sea::Keyframe Encoder::compacted(const sea::Keyframe& keyframe, sea::FieldSet fields, int size) {
    sea::Keyframe compact{keyframe.epoch, keyframe.cascade,  keyframe.time_us,
                          size,           keyframe.length_m, fields};
    if (fields.empty())
        return compact;
    // What a map was rounded by is noise in all waves; of that as much is left as there are waves on the smaller grid, so that
    // five deviations of it are within the bound of the whole map's.
    compact.rounded = keyframe.rounded;
    compact.forget_steps(keyframe.fields);
    const auto start = std::chrono::steady_clock::now();
    regrid(keyframe.size, size).maps(keyframe, fields, compact);
    count({.seconds = seconds_since(start)});
    return compact;
}

const sea::Regrid& Encoder::regrid(int from, int to) {
    const auto at = regrids_.find({from, to});
    return at != regrids_.end()
               ? at->second
               : regrids_.emplace(std::pair(from, to), sea::Regrid(from, to)).first->second;
}

std::optional<Encoder::Step> Encoder::step_to(const sea::Keyframe& sent, Quality quality,
                                              const CompactTiles& compact, bool regridded) {
    if (!sea::Regrid::takes(sent.size) || sent.size > protocol::limits::predicted_size_max)
        return std::nullopt;
    Step step{.regridded = regridded};
    for (Step::Map* map : {&step.height, &step.rate})
        map->decoded.resize(sent.plane_size());
    const auto base = std::ranges::find_if(bases_, [&](const Base& one) {
        return one.epoch == sent.epoch && one.cascade == sent.cascade && one.quality == quality;
    });
    if (base == bases_.end() || base->size != sent.size || base->law != *compact.law)
        return step;
    if (base->time_us >= sent.time_us)
        return std::nullopt;
    step.from = base->number;
    step.before = {&base->noise, base->number, base->time_us};
    for (Step::Map* map : {&step.height, &step.rate})
        map->expected.resize(sent.plane_size());
    const auto start = std::chrono::steady_clock::now();
    predictor_.maps(sent.size, sent.length_m, *compact.law, sent.time_us - base->time_us,
                    base->height, base->rate, step.height.expected, step.rate.expected);
    count({.seconds = seconds_since(start)});
    return step;
}

sea::CodedNoise Encoder::lost(const sea::Keyframe& sent, Step& step) {
    step.noise = noise_of(sent, step.height.decoded, step.rate.decoded,
                          step.regridded ? &regrid(sent.size, sent.size) : nullptr);
    return told_of(step.noise, sent.time_us, step.before);
}

void Encoder::keep(Step step, const sea::Keyframe& sent, const EncodedKeyframe& as,
                   const sea::WaveLaw& law) {
    std::erase_if(bases_, [&](const Base& one) {
        return one.epoch == as.epoch && one.cascade == as.cascade && one.quality == as.quality;
    });
    if (bases_.size() >= bases_max)
        bases_.pop_front();
    Room::Place place = room_->take_anyway(4 * sent.plane_size() * sizeof(float));
    bases_.push_back({as.epoch, as.cascade, as.quality, as.number, as.time_us, sent.size, law,
                      std::move(step.height.decoded), std::move(step.rate.decoded),
                      std::move(step.noise), std::move(place), trims_});
}

Result<EncodedField> Encoder::encode_field(const sea::Keyframe& keyframe, sea::Field field,
                                           float error, std::uint64_t number,
                                           const CompactTiles& compact, Step* step) {
    Step::Map* const map_step = step ? step->map_of(field) : nullptr;
    const std::uint64_t from = map_step ? step->from : 0;
    const auto start = std::chrono::steady_clock::now();
    EncodedField map{.field = field, .error = error, .parts = {}};
    std::vector<std::pair<protocol::TileHeader, protocol::TileForms>> made;
    for (protocol::TileHeader header : parts_of(keyframe, field)) {
        header.keyframe = number;
        header.error = error;
        header.follows = compact.follows & sea::following(field);
        header.coarser = compact.coarser;
        header.base = map_step ? number : 0;
        const auto offset =
            static_cast<std::size_t>(header.y0) * static_cast<std::size_t>(keyframe.size) +
            static_cast<std::size_t>(header.x0);
        auto forms = forms_of(keyframe, field, {header.width, header.height}, offset, error,
                              map_step ? std::span(map_step->expected) : std::span<float>(),
                              map_step ? std::span(map_step->decoded) : std::span<float>());
        if (!forms)
            return Error{fmt::format("keyframe of cascade {} at {} us, field {}: {}",
                                     keyframe.cascade, keyframe.time_us, sea::info(field).name,
                                     forms.error().message)};
        made.emplace_back(header, *std::move(forms));
    }
    sea::CodedNoise noise; // the rate is the second of the two
    if (map_step && field == sea::Field::height_rate)
        noise = lost(keyframe, *step);
    for (auto& [header, forms] : made) {
        header.noise = noise;
        map.parts.push_back(
            std::make_shared<const protocol::Bytes>(protocol::tile(header, forms.whole)));
        if (from == 0)
            continue;
        header.base = from;
        map.differences.push_back(forms.difference.empty()
                                      ? map.parts.back()
                                      : std::make_shared<const protocol::Bytes>(
                                            protocol::tile(header, forms.difference)));
    }
    count({.fields_encoded = 1,
           .samples = keyframe.plane_size(),
           .bytes = bytes_of(map) + difference_bytes(map),
           .seconds = seconds_since(start)});
    return map;
}

void Encoder::count(const EncoderCounters& more) {
    const std::lock_guard lock(counting_);
    counters_.fields_encoded += more.fields_encoded;
    counters_.fields_reused += more.fields_reused;
    counters_.fields_predicted += more.fields_predicted;
    counters_.samples += more.samples;
    counters_.bytes += more.bytes;
    counters_.seconds += more.seconds;
}

EncoderCounters Encoder::counters() const {
    const std::lock_guard lock(counting_);
    return counters_;
}

EncodedKeyframePtr Encoder::find(const sea::Keyframe& keyframe, Quality quality) {
    const auto same = [&](const Remembered& held) {
        const EncodedKeyframe& it = *held.keyframe;
        return it.epoch == keyframe.epoch && it.cascade == keyframe.cascade &&
               it.time_us == keyframe.time_us && it.quality == quality;
    };
    const auto found = std::find_if(cache_.rbegin(), cache_.rend(), same);
    if (found == cache_.rend())
        return nullptr;
    found->used = streamed_[{keyframe.cascade, quality}];
    found->trims = trims_;
    return found->keyframe;
}

void Encoder::remember(EncodedKeyframePtr encoded) {
    const std::uint64_t number = encoded->number;
    std::erase_if(cache_, [&](const auto& held) { return held.keyframe->number == number; });
    const std::uint64_t used = streamed_[{encoded->cascade, encoded->quality}];
    Room::Place place = room_->take_anyway(encoded->bytes);
    cache_.push_back({std::move(encoded), std::move(place), used, trims_});
    while (room_->overfull() && !cache_.empty())
        cache_.pop_front();
    while (room_->overfull() && !bases_.empty()) // what comes next is sent whole
        bases_.pop_front();
}

void Encoder::trim() {
    std::erase_if(cache_, [this](const Remembered& held) {
        return held.trims + (held.keyframe->place ? streamed_trims : 0) < trims_;
    });
    std::erase_if(bases_, [this](const Base& one) { return one.trims + streamed_trims < trims_; });
    ++trims_;
}

void Encoder::forget_what_is_over(const sea::Keyframe& next, Quality quality) {
    std::erase_if(bases_, [&](const Base& one) {
        return std::abs(one.time_us - next.time_us) > base_away_us_max;
    });
    const std::uint64_t now = ++streamed_[{next.cascade, quality}];
    std::erase_if(cache_, [&](const Remembered& held) {
        return held.keyframe->cascade == next.cascade && held.keyframe->quality == quality &&
               held.used + unused_max < now;
    });
}

} // namespace seaway::server
