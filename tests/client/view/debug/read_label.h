// SPDX-License-Identifier: Apache-2.0
// Reads what legends and labels say from the bytes of a picture.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "client/view/debug/legend.h"
#include "client/view/debug/small_font.h"

namespace seaway::client {

/// The letter whose dots these pixels are; 0: none. Ink is brighter than 200 in each colour.
inline char letter_at(const ShownPicture& picture, int left, int top, int dot) {
    const auto ink = [&](int column, int row) {
        const int x = left + dot * column, y = top + dot * row;
        if (x >= picture.width || y >= picture.height)
            return false;
        const std::uint8_t* p = &picture.rgba[4 * static_cast<std::size_t>(y * picture.width + x)];
        return *std::min_element(p, p + 3) > 200;
    };
    for (char letter = ' '; letter <= '~'; ++letter) {
        bool same = true;
        for (int row = 0; row < letter_rows && same; ++row)
            for (int column = 0; column < letter_columns && same; ++column)
                same = ink(column, row) == letter_dot(letter, column, row);
        if (same)
            return letter;
    }
    return 0;
}

/// From this pixel to the right, as long as there are letters, up to two blanks.
inline std::string read_text(const ShownPicture& picture, int left, int top, int dot) {
    std::string text;
    for (int x = left; x + dot * letter_columns <= picture.width; x += dot * letter_advance) {
        const char letter = letter_at(picture, x, top, dot);
        if (letter == 0 || text.ends_with("  "))
            break;
        text += letter;
    }
    return text.substr(0, text.find_last_not_of(' ') + 1);
}

/// What can be read where a legend has its words.
inline std::vector<std::string> read_words(const ShownPicture& picture, const Legend& legend) {
    std::vector<std::string> words;
    for (const LegendWords& some : legend.words)
        words.push_back(read_text(picture, some.left, some.top, some.dot));
    return words;
}

} // namespace seaway::client
