// SPDX-License-Identifier: Apache-2.0
// SynthesisStage: an intermediate result of a synthesis as a device has it in memory, for pictures and for whoever
// looks for a mistake (seaway-inspect --images). Not made while keyframes are served.
#pragma once

#include <string>
#include <vector>

namespace seaway::server {

struct SynthesisStage {
    std::string pass; ///< which pass left it: "lines", or a kernel's name
    std::string name; ///< what it is of: "h", "h/k ky", "source 2", "field 0"
    int rows = 0;
    int columns = 0;
    bool complex = true;
    std::vector<float> values; ///< [row][column], complex ones [row][column][re, im]
};

} // namespace seaway::server
