// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace seaway::tests {

/// What a desktop sends when the cross of a window of X11 is clicked. False: no such display.
bool ask_to_close(const std::string& display, unsigned long window);

} // namespace seaway::tests
