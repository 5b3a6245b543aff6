// SPDX-License-Identifier: Apache-2.0
// The configurations that a tuner chooses from: layouts of tiles by where their waves end, and budgets.
// The same ones whatever is asked for, so that a looser target never costs more: its candidates are those
// of the tighter one, and more of them.
//
// Pure functions; thread-safe; some milliseconds.
#pragma once

#include <vector>

#include "sea/scene/scene.h"
#include "tools/bench/accuracy/seas/configuration.h"

namespace seaway::bench {

/// Knobs and their values.
struct TuneSpace {
    std::vector<int> sizes{64, 128, 256, 512};
    /// Waves up to these wavenumbers are held, rad/m.
    std::vector<double> k_ends_radpm;
    /// How many tiles more than the fewest that leave no gap.
    std::vector<int> more_tiles{0, 1, 2};
    /// The finest tile with as many points as the others, or half as many a side.
    std::vector<int> finest_divisors{1, 2};
    std::vector<double> height_errors_m; ///< ascending
};

/// Waves down to 80 m .. 1.6 cm by factors of 2^(1/3); budgets of 0.01 mm .. 1 m, ten a decade.
TuneSpace whole_space();

/// One layout: tiles from the scene's longest to the one that ends at k_end, evenly apart.
struct Layout {
    std::vector<sea::CascadeSpec> cascades;
    double k_end_radpm;
};

/// All layouts of the space that leave no gap, without repetition.
std::vector<Layout> layouts(const TuneSpace& space, double longest_tile_m);

} // namespace seaway::bench
