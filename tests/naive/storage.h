// SPDX-License-Identifier: Apache-2.0
// Numbers kept in too few bits.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "tools/bench/accuracy/seas/half.h"

namespace seaway::naive {

/// C5, C7: what a half float keeps of a number.
inline float half(double value) {
    return bench::rounded_to_half(static_cast<float>(value));
}

/// C6: the same on a device that takes halves below the smallest normal one as zero.
inline float half_flushed(double value) {
    return std::abs(value) < 0x1p-14 ? 0.0f : half(value);
}

/// F5: 16 bits between the least and the greatest value of the tile: the step is what the range
/// makes it, whatever bound was asked for.
inline std::vector<float> coded_by_range(std::span<const float> samples) {
    const auto [least, greatest] = std::minmax_element(samples.begin(), samples.end());
    const double step = (static_cast<double>(*greatest) - *least) / 65535;
    std::vector<float> out;
    for (const float sample : samples)
        out.push_back(static_cast<float>(*least + step * std::nearbyint((sample - *least) / step)));
    return out;
}

/// F6: to the nearest multiple of twice the bound, in double; then it is a float.
inline float quantised(double value, double error) {
    return static_cast<float>(2 * error * std::nearbyint(value / (2 * error)));
}

/// F7: each frame coded as its difference to the frame before it, not to what was decoded of that:
/// errors add up from frame to frame.
class OpenLoopDeltas {
  public:
    explicit OpenLoopDeltas(float error) : step_(2.0 * error) {}
    /// What the decoder holds after this frame.
    const std::vector<float>& next(std::span<const float> frame) {
        decoded_.resize(frame.size());
        before_.resize(frame.size());
        for (std::size_t i = 0; i < frame.size(); ++i) {
            const double delta = static_cast<double>(frame[i]) - before_[i];
            decoded_[i] += static_cast<float>(step_ * std::nearbyint(delta / step_));
            before_[i] = frame[i];
        }
        return decoded_;
    }

  private:
    double step_;
    std::vector<float> before_, decoded_;
};

} // namespace seaway::naive
