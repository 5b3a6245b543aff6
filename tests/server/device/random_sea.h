// SPDX-License-Identifier: Apache-2.0
// Band-limited random seas on one cascade, and the slow sum that is the truth about them. For tests
// of synthesizers.
#pragma once

#include <array>
#include <complex>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "sea/basics/field.h"
#include "sea/foam/foam_kernel.h"
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

/// A tick in which strains break.
inline constexpr sea::FoamTick some_tick{0.9f, 0.0f, 1.0f, 1.0f, 1.0f,  0.01f, 0.0f, 0.0f,
                                         0.0f, 0.0f, 0.0f, 0.0f, 1e-4f, 0.5f,  1.0f, 0.0f};

/// A node of a grid: x, y.
using GridNode = std::pair<int, int>;

/// Fields of one cascade at one time and at some grid nodes, mode by mode in double.
class FieldSums {
  public:
    FieldSums(const sea::CascadeModes& cascade, sea::FieldSet fields, sea::TimeUs time_us,
              std::span<const GridNode> nodes = {});
    /// At the node of this number.
    double at(sea::Field field, std::size_t node) const { return of(field).at[node]; }
    double rms(sea::Field field) const { return of(field).rms; } ///< over the tile, exact

  private:
    struct Sum {
        std::vector<double> at;
        double rms = 0;
    };
    /// What all fields have in common, and is looked up for each of them.
    struct Turns {
        std::vector<std::complex<double>> of_node; ///< exp(2 pi i n / size)
        std::vector<std::complex<double>> of_time; ///< [mode]: exp(-i w t)
    };
    static Sum sum_of(const sea::CascadeModes& cascade, sea::Field field, const Turns& turns,
                      std::span<const GridNode> nodes);
    const Sum& of(sea::Field field) const { return sums_[static_cast<std::size_t>(field)]; }

    std::array<Sum, sea::field_count> sums_; ///< of fields that were not asked for: empty
};

/// The same nodes at every call.
std::vector<GridNode> random_nodes(int size, int count);

inline std::size_t node(const sea::Keyframe& map, int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(map.size) +
           static_cast<std::size_t>(x);
}
inline std::size_t node(const sea::Keyframe& map, const GridNode& at) {
    return node(map, at.first, at.second);
}

} // namespace seaway::server
