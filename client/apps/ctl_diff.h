// SPDX-License-Identifier: Apache-2.0
// What the answers of two servers about the same points say of their seas. Pure; thread-safe.
#pragma once

#include <span>
#include <string>

#include "base/result.h"
#include "sea/surface/answer.h"

namespace seaway::client {

/// Of as many answers of each, in the order of the points: how many were compared, how many of those are apart by more than both
/// bounds, the most and the root of the mean square, as a line of JSON. Heights of folds and those beyond what a server has are not
/// compared; nor are those of a server that is unsure of its sea, whose bounds hold whatever may have changed. `clocks_s` is put
/// down as it is. Errors, of kind Failure::refused: some are apart by more than their bounds; none could be compared.
Result<std::string> difference_of(std::span<const sea::Answer> one,
                                  std::span<const sea::Answer> other, double clocks_s);

} // namespace seaway::client
