// SPDX-License-Identifier: Apache-2.0
// What the readers of seaway-view's options share.
#pragma once

#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

#include "base/result.h"

namespace seaway::client {

inline Result<void> require(bool fine, const std::string& what) {
    if (!fine)
        return Error{what};
    return {};
}

/// The whole of the text is a finite number.
inline bool parse_number(std::string_view text, double& value) {
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
    return failure == std::errc{} && end == text.data() + text.size() && std::isfinite(value);
}

} // namespace seaway::client
