// SPDX-License-Identifier: Apache-2.0
// Predictions: what heights and their rates of a keyframe are expected to be, from an earlier one, of which tiles bring only the
// difference (docs/protocol.md, "Predicted maps"). Holds the newest keyframes that others may be differences to, as they were sent:
// two of each cascade of each of two seas, some 50 KB each for a grid of 81. For one thread.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "base/large_vector.h"
#include "protocol/limits.h"
#include "protocol/messages.h"
#include "sea/surface/maps/predictor.h"

namespace seaway::client {

class Predictions {
  public:
    struct Maps {
        LargeVector<float> height, rate; ///< [y][x]
        std::span<const float> of(sea::Field field) const {
            return field == sea::Field::height ? height : rate;
        }
    };
    /// Both are needed, or neither is.
    static constexpr sea::FieldSet fields{sea::Field::height, sea::Field::height_rate};

    /// Others may be differences to this one (`header.base`). Of a map that is larger than limits::predicted_size_max, or on a
    /// grid that nothing is predicted on (sea::Regrid::takes), there are none.
    void keep(const protocol::TileHeader& header, double length_m, int size, Maps maps);

    /// For the tile of a difference; null: what it is the difference to is not here, or is none that this could be. Valid
    /// until the next call.
    const Maps* expected(const protocol::TileHeader& header, const sea::WaveLaw& law);

  private:
    struct Base {
        std::uint64_t number;
        std::uint32_t epoch;
        int cascade;
        sea::TimeUs time_us;
        double length_m;
        int size;
        Maps maps;
    };
    static constexpr std::size_t of_a_cascade = 2;
    /// Of all bases: two of eight cascades of 512, of a sea and the next.
    static constexpr std::size_t bytes_max = 64u * 1024 * 1024;
    static constexpr std::size_t bases_max = of_a_cascade * 2 * protocol::limits::cascades_max;

    std::deque<Base> bases_; ///< newest last
    sea::Predictor predictor_;
    std::optional<protocol::TileHeader> expected_of_; ///< what expected_ was made for
    Maps expected_;
};

} // namespace seaway::client
