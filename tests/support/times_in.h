// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace seaway::tests {

/// How often these words stand in a text.
inline int times_in(const std::string& text, const std::string& words) {
    int count = 0;
    for (std::size_t at = 0; (at = text.find(words, at)) != std::string::npos; ++at)
        ++count;
    return count;
}

} // namespace seaway::tests
