// SPDX-License-Identifier: Apache-2.0
// What somebody may have meant by a word that is none of those that there are. Pure; thread-safe.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace seaway {

/// "; the nearest is depth_m", or nothing where more than half of its letters would have to be others.
std::string nearest_of(std::string_view word, std::span<const std::string> words);

} // namespace seaway
