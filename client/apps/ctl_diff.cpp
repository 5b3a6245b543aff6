// SPDX-License-Identifier: Apache-2.0
#include "client/apps/ctl_diff.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "client/link/failure.h"

namespace seaway::client {

Result<std::string> difference_of(std::span<const sea::Answer> one,
                                  std::span<const sea::Answer> other, double clocks_s) {
    double most_m = 0, squares = 0;
    int beyond = 0, compared = 0, unsure = 0;
    for (std::size_t i = 0; i < one.size(); ++i) {
        const auto flags = one[i].flags | other[i].flags;
        unsure += (flags & sea::answer_stale) != 0;
        if (flags & (sea::answer_folded | sea::answer_extrapolated | sea::answer_stale |
                     sea::answer_invalid))
            continue;
        const double off_m = std::abs(one[i].height_m - other[i].height_m);
        ++compared;
        beyond += !(off_m <= one[i].error_m + other[i].error_m); // also what is no number
        most_m = std::max(most_m, off_m);
        squares += off_m * off_m;
    }
    const std::string said = fmt::format(
        "{{\"points\": {}, \"unsure\": {}, \"beyond_bounds\": {}, \"most_m\": {:.6f}, \"rms_m\": "
        "{:.6f}, \"clock_s\": {:.6f}}}\n",
        compared, unsure, beyond, most_m, std::sqrt(squares / std::max(compared, 1)), clocks_s);
    if (beyond > 0)
        return failed(Failure::refused, "the servers have different seas: " + said);
    if (compared == 0)
        return failed(Failure::refused,
                      fmt::format("nothing was compared: of {} points {} are answered by a server "
                                  "that is unsure of its sea (status says why), and of the others "
                                  "none has a height that is sure to be of one sheet and of a time "
                                  "that both have",
                                  one.size(), unsure));
    return said;
}

} // namespace seaway::client
