// SPDX-License-Identifier: Apache-2.0
#include "sea/basics/cascade.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>

namespace seaway::sea {

namespace {

double band_end(const CascadeSpec& cascade) {
    return band_end_share_of_nyquist * cascade.nyquist_radpm();
}

} // namespace

Result<std::vector<Band>> assign_bands(std::span<const CascadeSpec> cascades) {
    if (cascades.empty())
        return Error{"no cascade: a sea needs a tile at least"};
    std::vector<Band> bands;
    bands.reserve(cascades.size());
    // The first mode of the longest tile; half a step keeps rounding away from the boundary.
    double start = 0.5 * cascades.front().wavenumber_step_radpm();
    for (std::size_t c = 0; c < cascades.size(); ++c) {
        double end = band_end(cascades[c]);
        if (c + 1 < cascades.size()) {
            const CascadeSpec& next = cascades[c + 1];
            if (!(next.length_m < cascades[c].length_m))
                return Error{
                    fmt::format("cascades must go from the longest tile to the shortest, but "
                                "length_m = {} is followed by {}",
                                cascades[c].length_m, next.length_m)};
            end = std::min(end, band_start_steps * next.wavenumber_step_radpm());
            if (end < next.wavenumber_step_radpm())
                return Error{fmt::format(
                    "cascades leave a gap: length_m = {}, size = {} ends at {:.4g} rad/m, but "
                    "length_m = {} cannot hold waves below {:.4g} rad/m; use a larger size or a "
                    "tile in between",
                    cascades[c].length_m, cascades[c].size, end, next.length_m,
                    next.wavenumber_step_radpm())};
        }
        if (!(start < end))
            return Error{fmt::format("cascade with length_m = {}, size = {} owns no waves: the one "
                                     "before it already reaches {:.4g} rad/m",
                                     cascades[c].length_m, cascades[c].size, start)};
        bands.push_back({start, end});
        start = end;
    }
    return bands;
}

} // namespace seaway::sea
