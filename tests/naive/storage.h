// SPDX-License-Identifier: Apache-2.0
// Numbers kept in too few bits.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace seaway::naive {

/// C5, C7: what a half float keeps of a number (IEEE 754 binary16, to nearest).
inline float half(double value) {
    if (value == 0 || !std::isfinite(value))
        return static_cast<float>(value);
    int exponent = 0;
    std::frexp(value, &exponent);
    const double ulp = std::ldexp(1.0, std::max(exponent, -13) - 11);
    const double kept = std::nearbyint(value / ulp) * ulp;
    return static_cast<float>(std::abs(kept) > 65504
                                  ? std::copysign(std::numeric_limits<double>::infinity(), value)
                                  : kept);
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
