// SPDX-License-Identifier: Apache-2.0
// Band-limited random seas on one cascade, and the slow sum that is the truth about them. For tests
// of synthesizers.
#pragma once

#include <complex>
#include <memory>
#include <utility>
#include <vector>

#include "sea/basics/field.h"
#include "sea/surface/maps/keyframe.h"
#include "sea/waves/realization.h"

namespace seaway::server {

/// Deep-water waves of every direction up to a share of Nyquist, Hs about 3 m, amplitudes falling
/// as k^-2.
class RandomSea {
  public:
    RandomSea(int size, double length_m, unsigned seed, sea::Choppiness choppiness = {},
              double share_of_nyquist = 0.6);
    const sea::CascadeModes& cascade() const { return realization_->cascades.front(); }
    sea::RealizationPtr realization() const { return realization_; }

  private:
    std::shared_ptr<sea::Realization> realization_;
};

/// eta = amplitude cos(k.x - omega t), k = 2 pi (nx, ny) / length.
class OneWave {
  public:
    OneWave(int size, double length_m, int nx, int ny, double amplitude_m, double omega_radps);
    sea::RealizationPtr realization() const { return realization_; }

  private:
    std::shared_ptr<sea::Realization> realization_;
};

/// One field of one cascade at one time, mode by mode in double.
class FieldSum {
  public:
    FieldSum(const sea::CascadeModes& cascade, sea::Field field, sea::TimeUs time_us);
    double at(int x, int y) const; ///< at a grid node
    double rms() const { return rms_; }

  private:
    struct Mode {
        int nx, ny;
        std::complex<double> amplitude;
    };
    int size_;
    std::vector<Mode> modes_;
    std::vector<std::complex<double>> unit_; ///< exp(2 pi i n / size)
    double rms_ = 0;                         ///< over the tile, exact
};

/// The same nodes at every call.
std::vector<std::pair<int, int>> random_nodes(int size, int count);

inline std::size_t node(const sea::Keyframe& map, int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(map.size) +
           static_cast<std::size_t>(x);
}

} // namespace seaway::server
