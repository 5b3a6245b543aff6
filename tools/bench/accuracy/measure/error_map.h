// SPDX-License-Identifier: Apache-2.0
// The error as a picture: heights over a square and how far two ways of computing them are from the
// sum of all waves, point by point.
#pragma once

#include <string>

#include "base/result.h"
#include "sea/scene/scene.h"
#include "tools/bench/accuracy/seas/configured_sea.h"

namespace seaway::bench {

/// Writes `path`, rows of x_m,y_m,height_m,balanced_m,engine_m: the truth, the balanced preset's error,
/// and that of the same maps at 16 bits, filtered and interpolated linearly. About 3 s. A file that is
/// there is replaced: it may be of another seed.
Result<void> write_error_map(const sea::Scene& scene, const std::string& path, Devices& devices);

} // namespace seaway::bench
