// SPDX-License-Identifier: Apache-2.0
// Letters of 5 x 7 dots, with one more row for what hangs below the line: for numbers over pictures, at any whole scale.
// Printable ASCII; anything else is a box. Pure.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace seaway::client {

inline constexpr int letter_columns = 5, letter_rows = 8, letter_advance = 6;

/// Is this dot of a letter set? column 0 .. 4 from the left, row 0 .. 7 from the top.
bool letter_dot(char letter, int column, int row);

/// Columns of dots that a line of text takes.
int text_columns(std::string_view text);

} // namespace seaway::client
