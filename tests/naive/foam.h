// SPDX-License-Identifier: Apache-2.0
// Foam as it is first written: a number that frames multiply and add to.
#pragma once

#include <cmath>

namespace seaway::naive {

/// E1: what is left after so many frames.
inline double faded(int frames) {
    return std::pow(0.98, frames);
}

/// E2, E5: what breaks is added as long as the frame was, and nothing is taken away.
class SummedFoam {
  public:
    void advance(double breaking, double gain_per_s, double dt_s) {
        coverage_ += breaking * gain_per_s * dt_s;
    }
    double coverage() const { return coverage_; }

  private:
    double coverage_ = 0;
};

} // namespace seaway::naive
