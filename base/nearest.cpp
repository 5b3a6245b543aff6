// SPDX-License-Identifier: Apache-2.0
#include "base/nearest.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

namespace seaway {
namespace {

/// How many letters are changed, left out or put in to make one word of the other (Levenshtein).
std::size_t changes_between(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t corner = std::exchange(row[0], i + 1);
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t changed = corner + (a[i] == b[j] ? 0 : 1);
            corner = std::exchange(row[j + 1], std::min({changed, row[j] + 1, row[j + 1] + 1}));
        }
    }
    return row.back();
}

} // namespace

std::string nearest_of(std::string_view word, std::span<const std::string> words) {
    std::string best;
    std::size_t fewest = word.size() / 2; // more is another word, not a slip
    for (const std::string& one : words)
        if (const std::size_t changes = changes_between(word, one); changes <= fewest) {
            if (changes == fewest && !best.empty())
                continue;
            fewest = changes;
            best = one;
        }
    return best.empty() ? "" : "; the nearest is " + best;
}

} // namespace seaway
