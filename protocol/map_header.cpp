// SPDX-License-Identifier: Apache-2.0
#include "protocol/map_header.h"

#include <bit>
#include <string_view>

#include "base/bound_to_float.h"
#include "base/check.h"

namespace seaway::protocol {

std::array<std::uint8_t, map_header_bytes> map_header(const sea::MapRequest& request,
                                                      double error_m) {
    std::array<std::uint8_t, map_header_bytes> bytes{};
    std::size_t at = 0;
    const auto put = [&](std::uint64_t value, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i)
            bytes[at++] = static_cast<std::uint8_t>(value >> (8 * i));
    };
    for (const char c : std::string_view("SWMP"))
        put(static_cast<std::uint8_t>(c), 1);
    put(1, 2);
    put(static_cast<std::uint64_t>(request.kind), 2);
    put(static_cast<std::uint64_t>(request.columns), 4);
    put(static_cast<std::uint64_t>(request.rows), 4);
    put(static_cast<std::uint64_t>(sea::map_components(request.kind)), 4);
    put(std::bit_cast<std::uint32_t>(bound_to_float(error_m)), 4);
    for (const double value : {request.x0_m, request.y0_m, request.width_m, request.height_m})
        put(std::bit_cast<std::uint64_t>(value), 8);
    put(static_cast<std::uint64_t>(request.time_us), 8);
    SEAWAY_CHECK(at == map_header_bytes, "the header is as long as it says");
    return bytes;
}

} // namespace seaway::protocol
