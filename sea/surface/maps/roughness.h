// SPDX-License-Identifier: Apache-2.0
// How much a field of displacements varies, and how strongly it squeezes the surface.
#pragma once

#include <algorithm>
#include <cmath>

#include "sea/waves/realization.h"

namespace seaway::sea {

/// How much a field of displacements varies at most between any two places of a region.
struct Roughness {
    double range_m = 0;      ///< |D(a) - D(b)|
    double strain_range = 0; ///< |grad D(a) - grad D(b)|, largest singular value
    double bend_per_m = 0;   ///< |grad D(a) - grad D(b)| / |a - b|
};

/// Likewise, of its height.
struct Rise {
    double range_m = 0; ///< |height(a) - height(b)|
    double slope = 0;   ///< |height(a) - height(b)| / |a - b|
};

/// Lower bound of the smallest eigenvalue of I + sqrt(lambda) grad D sqrt(lambda), from bounds of the
/// strains of each cascade. Above zero all over a convex region, X + lambda D(X) is one to one there:
/// a monotone map.
class Squeeze {
  public:
    explicit Squeeze(const Choppiness& choppiness)
        : x_(choppiness.x), y_(choppiness.y), cross_(std::sqrt(choppiness.x * choppiness.y)) {}

    void add(double xx_min, double yy_min, double xy_size) {
        xx_ += x_ * xx_min;
        yy_ += y_ * yy_min;
        xy_ += cross_ * xy_size;
    }
    /// It grows with both diagonal elements and falls with the size of the other one.
    double smallest() const {
        const double half = 0.5 * (xx_ - yy_);
        return 0.5 * (xx_ + yy_) - std::sqrt(half * half + xy_ * xy_);
    }

  private:
    double x_, y_, cross_;
    double xx_ = 1, yy_ = 1, xy_ = 0;
};

} // namespace seaway::sea
