// SPDX-License-Identifier: Apache-2.0
// What a configuration is labelled by: the error against all waves of the spectrum. Errors against the
// waves that its tiles hold are measured; the waves that no tile holds are independent of them, many and
// so normally distributed, with a variance that the spectrum gives (laws.h, missing_waves).
//
// Pure functions; thread-safe.
#pragma once

#include <span>

namespace seaway::bench {

/// So that `percent` of |e + sigma z| stay below, over errors e as they were measured and normal z. To
/// 1e-9 of itself. 0 for no errors and no sigma; infinite where one of them is no finite number.
double percentile_with_normal(std::span<const double> errors, double sigma, double percent);

/// Of |z| itself: 2.576 for 99 %.
double normal_percentile(double percent);

} // namespace seaway::bench
