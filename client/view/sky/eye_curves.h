// SPDX-License-Identifier: Apache-2.0
// From wavelengths to linear sRGB. Pure functions.
#pragma once

#include <cmath>

#include <glm/glm.hpp>

namespace seaway::client {

inline double eye_lobe(double x, double middle, double below, double above) {
    const double t = (x - middle) / (x < middle ? below : above);
    return std::exp(-0.5 * t * t);
}

/// What light of one wavelength is to eyes: CIE 1931 after Wyman, Sloan, Shirley 2013, to linear sRGB.
inline glm::dvec3 eye_curves(double nm) {
    const double x = 1.056 * eye_lobe(nm, 599.8, 37.9, 31.0) +
                     0.362 * eye_lobe(nm, 442.0, 16.0, 26.7) -
                     0.065 * eye_lobe(nm, 501.1, 20.4, 26.2);
    const double y =
        0.821 * eye_lobe(nm, 568.8, 46.9, 40.5) + 0.286 * eye_lobe(nm, 530.9, 16.3, 31.1);
    const double z =
        1.217 * eye_lobe(nm, 437.0, 11.8, 36.0) + 0.681 * eye_lobe(nm, 459.0, 26.0, 13.8);
    return {3.2406 * x - 1.5372 * y - 0.4986 * z, -0.9689 * x + 1.8758 * y + 0.0415 * z,
            0.0557 * x - 0.2040 * y + 1.0570 * z};
}

} // namespace seaway::client
