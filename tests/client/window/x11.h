// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace seaway::tests {

/// What a desktop sends when the cross of a window of X11 is clicked. False: no such display.
bool ask_to_close(const std::string& display, unsigned long window);

/// Dots an inch, as desktops tell programs; 96 is the usual. False: no such display.
bool set_dots_an_inch(const std::string& display, int dots);

} // namespace seaway::tests
