// SPDX-License-Identifier: Apache-2.0
// How different two pictures look: colours in CIE L*a*b*, each block of 4 x 4 pixels as its mean, since an eye does
// not see on which of two neighbouring pixels an edge falls, and another driver may put it on the other.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "client/view/picture.h"

namespace seaway::tests {

struct PictureDifference {
    double mean = 0;       ///< of all blocks, CIE 1976 delta E; 2.3 is just noticeable (Mahy 1994)
    double seen_share = 0; ///< of blocks that differ by more than `seen`
    static constexpr double seen = 6;
    static constexpr double mean_max = 1.5, seen_share_max = 0.01;

    bool is_alike() const { return mean <= mean_max && seen_share <= seen_share_max; }
};

using Lab = std::array<double, 3>;

/// Of linear sRGB, white D65 (CIE 15:2004).
inline Lab lab_of(const std::array<double, 3>& rgb) {
    const double x = 0.4124564 * rgb[0] + 0.3575761 * rgb[1] + 0.1804375 * rgb[2];
    const double y = 0.2126729 * rgb[0] + 0.7151522 * rgb[1] + 0.0721750 * rgb[2];
    const double z = 0.0193339 * rgb[0] + 0.1191920 * rgb[1] + 0.9503041 * rgb[2];
    const auto f = [](double t) {
        return t > 216.0 / 24389.0 ? std::cbrt(t) : (24389.0 / 27.0 * t + 16) / 116;
    };
    const double fx = f(x / 0.95047), fy = f(y), fz = f(z / 1.08883);
    return {116 * fy - 16, 500 * (fx - fy), 200 * (fy - fz)};
}

inline double linear_of(std::uint8_t byte) {
    const double v = byte / 255.0;
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

/// Pictures of one size; what does not fill a block at the right and below is left out.
inline PictureDifference difference(const client::ShownPicture& a, const client::ShownPicture& b) {
    constexpr int side = 4;
    const auto block = [](const client::ShownPicture& picture, int left, int top) {
        std::array<double, 3> mean{};
        for (int y = top; y < top + side; ++y)
            for (int x = left; x < left + side; ++x)
                for (std::size_t c = 0; c < 3; ++c)
                    mean[c] +=
                        linear_of(picture.rgba[4 * (static_cast<std::size_t>(y) *
                                                        static_cast<std::size_t>(picture.width) +
                                                    static_cast<std::size_t>(x)) +
                                               c]) /
                        (side * side);
        return lab_of(mean);
    };
    PictureDifference found;
    int count = 0, seen = 0;
    for (int y = 0; y + side <= a.height; y += side)
        for (int x = 0; x + side <= a.width; x += side) {
            const Lab p = block(a, x, y), q = block(b, x, y);
            const double apart = std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
            found.mean += apart;
            seen += apart > PictureDifference::seen;
            ++count;
        }
    found.mean /= count;
    found.seen_share = static_cast<double>(seen) / count;
    return found;
}

} // namespace seaway::tests
