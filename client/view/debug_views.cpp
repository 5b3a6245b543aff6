// SPDX-License-Identifier: Apache-2.0
#include "client/view/debug_views.h"

#include <charconv>
#include <string>

namespace seaway::client {

Result<DebugChoice> parse_debug_view(std::string_view text) {
    DebugChoice choice;
    const std::size_t colon = text.find(':');
    const std::string_view name = text.substr(0, colon);
    std::string names;
    for (const DebugViewInfo& row : debug_view_table) {
        names += (names.empty() ? "" : ", ") + std::string(row.name);
        if (row.name != name)
            continue;
        choice.view = row.view;
        if (colon == std::string_view::npos)
            return choice;
        const std::string_view number = text.substr(colon + 1);
        const auto [end, failure] =
            std::from_chars(number.data(), number.data() + number.size(), choice.cascade);
        if (row.view == DebugView::cascade && failure == std::errc{} &&
            end == number.data() + number.size() && choice.cascade >= 0 &&
            choice.cascade < shaders::view_cascades_max)
            return choice;
        return Error{"--debug " + std::string(text) +
                     ": a number stands only after cascade:, 0 .. " +
                     std::to_string(shaders::view_cascades_max - 1)};
    }
    return Error{"--debug " + std::string(text) + ": no such view; there are " + names};
}

} // namespace seaway::client
