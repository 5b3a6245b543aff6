// SPDX-License-Identifier: Apache-2.0
// One OpenEXR file: maps of one size, a channel each, and what one has to know about them as header
// attributes.
//
// Line y of the image is row y of the map, south to north, which most viewers show upside down; or the
// other way round, as programs expect that put the origin of texture coordinates at the lower left.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "base/result.h"

namespace seaway::exr {

struct ExrChannel {
    std::string name;
    std::span<const float> values; ///< [y][x], row 0 first
};

/// Header attribute: a number (EXR double) or a text.
using ExrAttribute = std::pair<std::string, std::variant<double, std::string>>;

enum class ExrCompression { none, rle, zip, piz };

/// Names as on the command line; an error lists them.
Result<ExrCompression> exr_compression(std::string_view name);

struct ExrMap {
    int width = 0;
    int height = 0;
    std::vector<ExrChannel> channels;
    std::vector<ExrAttribute> attributes;
    bool half = false; ///< 16 bits a value: 11 significant ones, up to 65504
    ExrCompression compression = ExrCompression::none;
    bool upside_down = false; ///< line 0 is the last row of the map
};

/// Writes beside the path and renames, so that a file that is there is whole. Values that half
/// cannot hold are an error.
Result<void> write_exr(const std::string& path, const ExrMap& map);

} // namespace seaway::exr
