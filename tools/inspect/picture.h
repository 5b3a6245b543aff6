// SPDX-License-Identifier: Apache-2.0
// The picture of a scene, 1200 x 700: the spectrum asked for with the bands of the cascades and the
// energy of the drawn modes; the directional spectrum; the spreading.
#pragma once

#include <string>

#include "tools/inspect/report.h"

namespace seaway::inspect {

/// Writes a PNG; an error if the file cannot be written.
Result<void> draw_picture(const Report& report, const std::string& path);

} // namespace seaway::inspect
