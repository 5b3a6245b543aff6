// SPDX-License-Identifier: Apache-2.0
// The sea at points, by direct sum in double precision.
#pragma once

#include <vector>

#include "sea/surface/answer.h"
#include "sea/surface/inverse.h"
#include "sea/waves/realization.h"

namespace seaway::inspect {

/// One answer a point, in order, flagged answer_exact; error_m bounds the inverse displacement and
/// rounding. About 1 ms a point, ten where the sea folds often, and 5 ms for each distinct time.
std::vector<sea::Answer> answer_points(const sea::RealizationPtr& sea, const sea::FoldSearch& folds,
                                       const std::vector<sea::QueryPoint>& points);

} // namespace seaway::inspect
