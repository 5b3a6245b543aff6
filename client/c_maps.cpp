// SPDX-License-Identifier: Apache-2.0
// The C interface for engines: whole maps into the caller's memory (seaway_engine.h).
#include <bit>
#include <cmath>
#include <limits>

#include "client/c_api.h"
#include "protocol/limits.h"

using namespace seaway;
using namespace seaway::client;
using namespace seaway::client::c;

namespace {

constexpr std::size_t map_wish_least = sizeof(seaway_map_wish);
constexpr uint32_t channels_max = 4;

/// IEEE binary16, to the nearest, ties to even.
uint16_t half_of(float value) {
    const uint32_t bits = std::bit_cast<uint32_t>(value);
    const auto sign = static_cast<uint16_t>(bits >> 16 & 0x8000u);
    const float size = std::abs(value);
    if (!(size < 65520.0f)) // what would round to more than the largest
        return static_cast<uint16_t>(sign | (std::isnan(value) ? 0x7e00u : 0x7c00u));
    if (size < 6.103515625e-5f) // subnormal: whole multiples of 2^-24
        return static_cast<uint16_t>(sign | static_cast<uint32_t>(std::nearbyint(size * 0x1p24f)));
    const uint32_t rest = (bits & 0x7fffffffu) - (112u << 23); // another bias of the exponent
    return static_cast<uint16_t>(sign | (rest + 0xfffu + (rest >> 13 & 1u)) >> 13);
}

/// What halves of such values are off by, at most.
double half_error(float largest) {
    if (largest == 0)
        return 0;
    if (!(largest < 65520.0f)) // infinity stands for it
        return std::numeric_limits<double>::infinity();
    return largest < 6.103515625e-5f ? 0x1p-25 : std::ldexp(1.0, std::ilogb(largest) - 11);
}

Result<std::vector<std::optional<sea::Field>>> channels_of(const seaway_map_wish& wish) {
    if (wish.channels < 1 || wish.channels > channels_max)
        return bad(fmt::format("seaway_map_wish.channels is {}: it must be 1 to {}", wish.channels,
                               channels_max));
    if (wish.type != SEAWAY_FLOAT && wish.type != SEAWAY_HALF)
        return bad(fmt::format("seaway_map_wish.type is {}: it must be SEAWAY_FLOAT or SEAWAY_HALF",
                               wish.type));
    std::vector<std::optional<sea::Field>> channels;
    for (uint32_t c = 0; c < wish.channels; ++c) {
        const uint32_t field = wish.field[c];
        if (field != SEAWAY_NO_FIELD && field >= static_cast<uint32_t>(sea::field_count))
            return bad(fmt::format("seaway_map_wish.field[{}] is {}: it must be 0 to {} or "
                                   "SEAWAY_NO_FIELD",
                                   c, field, sea::field_count - 1));
        channels.push_back(field == SEAWAY_NO_FIELD
                               ? std::nullopt
                               : std::optional(static_cast<sea::Field>(field)));
    }
    return channels;
}

void add_rounding(const CascadeMap& made, std::span<const std::optional<sea::Field>> channels,
                  seaway_map& map) {
    float height = 0, displacement = 0;
    for (std::size_t i = 0; i < made.values.size(); ++i) {
        const std::optional<sea::Field> field = channels[i % channels.size()];
        const float size = std::abs(made.values[i]);
        if (field == sea::Field::height)
            height = std::max(height, size);
        else if (field == sea::Field::displacement_x || field == sea::Field::displacement_y)
            displacement = std::max(displacement, size);
    }
    map.error_m += half_error(height);
    map.displacement_error_m += half_error(displacement);
}

void write_rows(const CascadeMap& made, const seaway_map_wish& wish, std::size_t stride,
                unsigned char* to) {
    const std::size_t row = static_cast<std::size_t>(made.size) * wish.channels;
    std::vector<uint16_t> halves(row);
    for (std::size_t y = 0; y < static_cast<std::size_t>(made.size); ++y) {
        const std::span<const float> values = std::span(made.values).subspan(y * row, row);
        if (wish.type == SEAWAY_HALF) {
            std::ranges::transform(values, halves.begin(), half_of);
            std::memcpy(to + y * stride, halves.data(), row * sizeof(uint16_t));
        } else {
            std::memcpy(to + y * stride, values.data(), row * sizeof(float));
        }
    }
}

} // namespace

seaway_code seaway_get_map(const seaway_client* client, const seaway_map_wish* wish, void* texels,
                           size_t bytes, seaway_map* map) {
    return guarded([&]() -> Result<void> {
        if (!client || !wish || !map)
            return bad("seaway_get_map: client, wish and map must not be null");
        SEAWAY_TRY_LET(const seaway_map_wish wanted,
                       sized(wish, map_wish_least, "seaway_map_wish"));
        SEAWAY_TRY(has_room(map, offsetof(seaway_map, error_m), "seaway_map"));
        SEAWAY_TRY_LET(const auto channels, channels_of(wanted));
        if (wanted.cascade >= uint32_t{protocol::limits::cascades_max})
            return bad(fmt::format("seaway_map_wish.cascade is {}: a sea has {} at most",
                                   wanted.cascade, protocol::limits::cascades_max));
        SEAWAY_TRY_LET(const CascadeMap made, client->client->map(static_cast<int>(wanted.cascade),
                                                                  wanted.time_us, channels));
        const std::size_t texel =
            wanted.channels * (wanted.type == SEAWAY_HALF ? sizeof(uint16_t) : sizeof(float));
        const auto grid = static_cast<std::size_t>(made.size);
        const std::size_t row = grid * texel;
        const std::size_t stride = wanted.row_stride == 0 ? row : wanted.row_stride;
        if (stride < row || stride > (std::size_t{1} << 32))
            return bad(
                fmt::format("seaway_map_wish.row_stride is {}: a row has {} bytes", stride, row));
        seaway_map to{};
        to.grid = static_cast<uint32_t>(made.size);
        to.length_m = made.length_m;
        to.time_us = wanted.time_us;
        to.error_m = made.error_m;
        to.displacement_error_m = made.displacement_error_m;
        to.epoch = made.epoch;
        to.flags = made.flags;
        to.bytes = (grid - 1) * stride + row;
        to.foam_mean = made.foam_mean;
        if (texels && bytes < to.bytes)
            return bad(fmt::format("seaway_get_map: the map takes {} bytes, room is for {}",
                                   to.bytes, bytes));
        if (wanted.type == SEAWAY_HALF)
            add_rounding(made, channels, to);
        if (texels)
            write_rows(made, wanted, stride, static_cast<unsigned char*>(texels));
        return give(to, map, offsetof(seaway_map, error_m), "seaway_map");
    });
}
