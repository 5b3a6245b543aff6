// SPDX-License-Identifier: Apache-2.0
// Pictures of everything between a scene and its maps: h0(k), h(k,t), what each pass of the transform
// leaves and every map but foam, which is a history, for every cascade, from any device.
//
// DIR/cascade<c>_<stage>[_<of what>].png is scaled to what it holds, with the scale in the picture; the
// .exr beside it has the numbers themselves, complex ones as channels re and im. Spectra are shown as
// magnitudes on a logarithmic scale; h0 and h are turned so that k = 0 is in the middle, north up, and
// the stages of a device are drawn as they lie in its memory. Maps have north up, too. In an .exr the south is first (seaway.rows).
#pragma once

#include <string>

#include "base/result.h"
#include "sea/waves/realization.h"

namespace seaway::inspect {

struct ImagesOptions {
    std::string folder;            ///< made if it is not there
    std::string device = "native"; ///< or what a Vulkan device is chosen by
    sea::TimeUs time_us = 0;
};

/// Writes the pictures; the number of files. Errors: a device that cannot do the sea, a file.
Result<int> write_images(const sea::RealizationPtr& sea, const ImagesOptions& options);

} // namespace seaway::inspect
