// SPDX-License-Identifier: Apache-2.0
#include "client/held/tile_assembly.h"

#include <algorithm>
#include <bit>
#include <iterator>

#include <fmt/format.h>

#include "protocol/limits.h"
#include "protocol/tile_codec.h"
#include "sea/basics/dispersion.h"

namespace seaway::client {

using protocol::TileHeader;
using sea::Field;
using sea::FieldSet;

namespace {

/// So that the difference of two times always fits.
constexpr sea::TimeUs time_max_us = (std::int64_t{1} << 62) - 1;

Error bad_tile(const TileHeader& header, std::string_view why) {
    return Error{fmt::format("tile of {}, cascade {}, at {} us: {}", sea::info(header.field).name,
                             header.cascade, header.time_us, why)};
}

bool same_keyframe(const TileHeader& a, const TileHeader& b) {
    return a.keyframe == b.keyframe && a.epoch == b.epoch && a.cascade == b.cascade &&
           a.time_us == b.time_us;
}

std::size_t area(int width, int height) {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

} // namespace

Result<TileAssembly::Added>
TileAssembly::add(const TileHeader& header, std::span<const std::uint8_t> payload,
                  const protocol::CascadeInfo& cascade, double depth_m, FieldSet streamed,
                  std::span<const FieldSet> requested, const std::optional<sea::WaveLaw>& law) {
    if (header.time_us > time_max_us || header.time_us < -time_max_us)
        return bad_tile(header, "the time is out of range");
    std::span<const float> expected;
    if (protocol::is_difference(payload)) {
        if (!law || !Predictions::fields.contains(header.field))
            return bad_tile(header, "a difference, where nothing is predicted");
        const Predictions::Maps* maps = predictions_.expected(header, *law);
        if (maps == nullptr)
            return Added{.unpredicted = true};
        expected = maps->of(header.field);
    }
    Pending& pending = pending_for(header, cascade, depth_m, streamed);
    pending.repeated = false;
    if (Result<void> taken = take(pending, header, payload, expected); !taken) {
        if (taken.error().is(protocol::TileMiss::other_expected))
            return Added{.unpredicted = true};
        return taken.error();
    }
    FieldSet waited_for = pending.streamed;
    for (const FieldSet fields : requested)
        waited_for |= fields;
    pending.whole |= pending.received | (pending.follows & waited_for);
    const auto newly_whole = [&](FieldSet fields) {
        return !fields.empty() && pending.whole.contains(fields) &&
               !pending.handed_out.contains(fields);
    };
    // Who asks again for what was handed out, and is still waited for by a stream of more, gets it with its first tile.
    const auto asked_again = [&](FieldSet fields) {
        const FieldSet sent = fields & pending.received;
        return pending.repeated && pending.finished_then != finished_ && header.part == 0 &&
               !sent.empty() && header.field == *sent.begin() &&
               pending.handed_out.contains(fields);
    };
    const auto satisfied = [&](FieldSet fields) { return pending.handed_out.contains(fields); };
    Added added;
    added.acknowledge = !pending.streamed.empty() && pending.whole.contains(pending.streamed);
    if (newly_whole(pending.streamed) ||
        std::any_of(requested.begin(), requested.end(), newly_whole) ||
        std::any_of(requested.begin(), requested.end(), asked_again))
        added.complete = assemble(pending);
    if (!pending.handed_out.empty() && satisfied(pending.streamed) &&
        std::all_of(requested.begin(), requested.end(), satisfied))
        forget(std::prev(pending_.end()));
    return added;
}

TileAssembly::Pending& TileAssembly::pending_for(const TileHeader& header,
                                                 const protocol::CascadeInfo& cascade,
                                                 double depth_m, FieldSet streamed) {
    const auto found = std::find_if(pending_.begin(), pending_.end(), [&](const Pending& pending) {
        return same_keyframe(pending.header, header);
    });
    if (found != pending_.end()) {
        pending_.splice(pending_.end(), pending_, found);
        return pending_.back();
    }
    if (pending_.size() >= keyframes_max)
        drop_oldest();
    Pending& begun = pending_.emplace_back(
        Pending{header, cascade.length_m, depth_m, cascade.size, 0, streamed, {}, {}, {}, {}, {}});
    begun.stylised = cascade.stylised;
    return begun;
}

Result<void> TileAssembly::check_grid(Pending& pending, const TileHeader& header) {
    const bool may_be_smaller = header.size < pending.size && sea::is_linear(header.field) &&
                                sea::Regrid::takes(header.size) && sea::Regrid::takes(pending.size);
    if (header.size != pending.size && !may_be_smaller)
        return bad_tile(
            header, fmt::format("map of size {}, the cascade's is {}", header.size, pending.size));
    if (!sea::is_linear(header.field))
        return {};
    if (pending.linear_size != 0 && header.size != pending.linear_size)
        return bad_tile(header, fmt::format("map of size {}, others of the keyframe have {}",
                                            header.size, pending.linear_size));
    if (!header.follows.empty() && header.size == pending.size)
        return bad_tile(header, "fields follow from a map that is not compact");
    pending.linear_size = header.size;
    return {};
}

Result<void> TileAssembly::begin_map(Pending& pending, const TileHeader& header) {
    const std::size_t bytes = area(header.size, header.size) * sizeof(float);
    while (bytes_ + bytes > bytes_max) {
        if (&pending_.front() == &pending)
            return bad_tile(header, "the keyframe is too large");
        drop_oldest();
    }
    bytes_ += bytes;
    Map& map = pending.maps[static_cast<std::size_t>(header.field)];
    map.values.resize(area(header.size, header.size));
    map.size = header.size;
    map.parts = header.parts;
    map.follows = header.follows;
    return {};
}

Result<void> TileAssembly::take(Pending& pending, const TileHeader& header,
                                std::span<const std::uint8_t> payload,
                                std::span<const float> expected) {
    Map& map = pending.maps[static_cast<std::size_t>(header.field)];
    if (map.parts == 0) {
        SEAWAY_TRY(check_grid(pending, header));
        SEAWAY_TRY(begin_map(pending, header));
    }
    if (header.size != map.size)
        return bad_tile(header,
                        fmt::format("size {}, the map began with {}", header.size, map.size));
    if (header.parts != map.parts)
        return bad_tile(header,
                        fmt::format("{} parts, the map began with {}", header.parts, map.parts));
    if (header.follows != map.follows)
        return bad_tile(header, "other fields follow from it than its first part said");
    const std::uint64_t part_bit = std::uint64_t{1} << header.part;
    if ((map.parts_seen & part_bit) != 0) { // the copy of another delivery
        pending.repeated = true;
        return {};
    }
    const std::size_t samples = area(header.width, header.height);
    if (map.samples_seen + samples > map.values.size())
        return bad_tile(header, "its parts are larger than the map");
    const auto stride = static_cast<std::size_t>(header.size);
    const std::size_t first =
        static_cast<std::size_t>(header.y0) * stride + static_cast<std::size_t>(header.x0);
    const protocol::TileShape shape{header.width, header.height};
    const std::span<float> values = std::span(map.values).subspan(first);
    const Result<void> decoded =
        expected.empty() ? protocol::decode_tile(payload, shape, stride, values)
                         : protocol::decode_tile_difference(payload, shape, stride,
                                                            expected.subspan(first), values);
    if (!decoded && decoded.error().is(protocol::TileMiss::other_expected))
        return decoded.error();
    if (!decoded)
        return bad_tile(header, decoded.error().message);
    map.parts_seen |= part_bit;
    map.samples_seen += samples;
    map.error = std::max(map.error, header.error);
    if (std::popcount(map.parts_seen) < map.parts)
        return {};
    if (map.samples_seen != map.values.size())
        return bad_tile(header, "its parts do not cover the map");
    pending.received.insert(header.field);
    if (header.noise.at_m > 0)
        pending.noise = header.noise;
    pending.follows |= map.follows & sea::following(header.field);
    if (header.base != 0 && Predictions::fields.contains(header.field) &&
        pending.received.contains(Predictions::fields))
        keep_as_base(pending, header);
    return {};
}

void TileAssembly::keep_as_base(const Pending& pending, const TileHeader& header) {
    const auto values = [&](Field field) {
        return pending.maps[static_cast<std::size_t>(field)].values;
    };
    predictions_.keep(header, pending.length_m, header.size,
                      {values(Field::height), values(Field::height_rate)});
}

std::vector<HeldKeyframePtr> TileAssembly::finish(FieldSet fields) {
    ++finished_;
    std::vector<HeldKeyframePtr> complete;
    for (Pending& pending : pending_) {
        pending.whole |= pending.follows & fields;
        if (!fields.empty() && pending.whole.contains(fields) &&
            !pending.handed_out.contains(fields))
            complete.push_back(assemble(pending));
    }
    // What was handed out and is not being streamed has been waited for by this request alone;
    // beyond that, only the stream's own keyframes can still be under way.
    for (auto pending = pending_.begin(); pending != pending_.end();) {
        const auto next = std::next(pending);
        if (!pending->handed_out.empty() && pending->handed_out.contains(pending->streamed))
            forget(pending);
        pending = next;
    }
    while (pending_.size() > protocol::limits::credit_max)
        drop_oldest();
    return complete;
}

const sea::Regrid& TileAssembly::regrid(const Pending& pending) {
    const std::pair sides(pending.linear_size, pending.size);
    if (const auto known = regrids_.find(sides); known != regrids_.end())
        return known->second;
    if (regrids_.size() >= protocol::limits::cascades_max)
        regrids_.clear();
    return regrids_.emplace(sides, sea::Regrid(sides.first, sides.second)).first->second;
}

const sea::Orbits& TileAssembly::orbits(const Pending& pending) {
    const std::tuple key(pending.linear_size, pending.length_m, pending.depth_m);
    if (const auto known = orbits_.find(key); known != orbits_.end())
        return known->second;
    if (orbits_.size() >= protocol::limits::cascades_max)
        orbits_.clear();
    const double depth_m = pending.depth_m > 0 ? pending.depth_m : sea::deep_water_m;
    return orbits_.emplace(key, sea::Orbits(pending.linear_size, pending.length_m, depth_m))
        .first->second;
}

void TileAssembly::enlarge(const Pending& pending, FieldSet fields, sea::Keyframe& keyframe) {
    if (fields.empty())
        return;
    sea::Keyframe small{keyframe.epoch,
                        keyframe.cascade,
                        keyframe.time_us,
                        pending.linear_size,
                        keyframe.length_m,
                        fields,
                        {}};
    for (const Field field : fields) {
        const Map& map = pending.maps[static_cast<std::size_t>(field)];
        small.values.insert(small.values.end(), map.values.begin(), map.values.end());
    }
    regrid(pending).maps(small, fields, keyframe);
}

void TileAssembly::displace(const Pending& pending, sea::Keyframe& keyframe) {
    const auto plane = [&](Field field) {
        return keyframe.fields.contains(field) ? keyframe.plane(field) : std::span<float>();
    };
    // What no tile brought, and only that.
    const auto made = [&](Field field) {
        return pending.received.contains(field) ? std::span<float>() : plane(field);
    };
    const auto from = [&](Field field) -> std::span<const float> {
        return pending.maps[static_cast<std::size_t>(field)].values;
    };
    // One of the two alone is taken twice.
    const bool height = pending.received.contains(Field::height);
    const bool rate = pending.received.contains(Field::height_rate);
    regrid(pending).maps(from(height ? Field::height : Field::height_rate),
                         from(rate ? Field::height_rate : Field::height), orbits(pending),
                         {plane(Field::height), plane(Field::height_rate)},
                         {made(Field::displacement_x), made(Field::displacement_x_rate)},
                         {made(Field::displacement_y), made(Field::displacement_y_rate)});
}

HeldKeyframePtr TileAssembly::assemble(Pending& pending) {
    sea::Keyframe keyframe;
    keyframe.epoch = pending.header.epoch;
    keyframe.cascade = pending.header.cascade;
    keyframe.time_us = pending.header.time_us;
    keyframe.size = pending.size;
    keyframe.length_m = pending.length_m;
    keyframe.stylised = pending.stylised;
    keyframe.fields = pending.whole;
    HeldKeyframe::FieldErrors errors{};
    keyframe.values.resize(static_cast<std::size_t>(pending.whole.size()) * keyframe.plane_size());
    FieldSet smaller;
    HeldKeyframe::Compact compact;
    for (const Field field : pending.received) {
        const Map& map = pending.maps[static_cast<std::size_t>(field)];
        errors[static_cast<std::size_t>(field)] = map.error;
        if (map.size == pending.size)
            std::copy(map.values.begin(), map.values.end(), keyframe.plane(field).begin());
        else
            smaller.insert(field);
        const FieldSet made = sea::following(field) & pending.whole.without(pending.received);
        compact.follows |= made;
        for (const Field follower : made)
            errors[static_cast<std::size_t>(follower)] = map.error;
    }
    if (!compact.follows.empty()) {
        compact.gain = orbits(pending).gain();
        displace(pending, keyframe);
        smaller = smaller.without({Field::height, Field::height_rate});
    }
    enlarge(pending, smaller, keyframe);
    compact.coarser = pending.header.coarser;
    compact.noise = pending.noise;
    if (pending.linear_size < pending.size)
        compact.size = pending.linear_size;
    pending.handed_out = pending.whole;
    pending.finished_then = finished_;
    return std::make_shared<const HeldKeyframe>(std::move(keyframe), errors, compact);
}

void TileAssembly::drop_oldest() {
    if (pending_.front().handed_out.empty())
        ++dropped_;
    forget(pending_.begin());
}

void TileAssembly::forget(std::list<Pending>::iterator pending) {
    for (const Map& map : pending->maps)
        bytes_ -= map.values.size() * sizeof(float);
    pending_.erase(pending);
}

} // namespace seaway::client
