// SPDX-License-Identifier: Apache-2.0
// Light that dense air scatters, by two streams: what a geometric series of the same light all around cannot give.
//
// Eddington's approximation over horizontal layers (Shettle and Weinman 1970, J. Atmos. Sci. 27, 1048). Scattering that
// is forward by the first moment g of the phase function counts 1 - g times as if it were isotropic (similarity, van de
// Hulst 1980, chapter 14), as it does in the scaled depths of Joseph, Wiscombe and Weinman 1976: what goes on forward
// still lights what is below. Absorption is left as it is.
//
// Pure functions; thread-safe. A column of 512 layers takes 0.2 ms of CPU.
#pragma once

#include <vector>

#include "client/view/sky/transmittance.h"

namespace seaway::client {

/// Optical depth of the whole air, straight up, by wavelength.
glm::dvec3 depth_of_air(const Air& air);

/// Share of two streams where the air has this depth; what is left is the series': 0 up to 2.5, which is a visibility of
/// 2.3 km, 1 from 6 on.
glm::dvec3 two_stream_share(const glm::dvec3& depth);

class TwoStream {
  public:
    /// Under a sun of illuminance 1 above the air.
    TwoStream(const Air& air, const TransmittanceTable& transmittance, double sun_cosine);

    /// Radiance that a scatterer at this height meets from the brighter half of all directions, but for the sun's disc, as far as it is scattered on forward. Never
    /// negative.
    glm::dvec3 at(double height_m) const;

    static constexpr int layers = 512;

  private:
    double thickness_m_;
    std::vector<glm::dvec3> mean_; ///< from below
};

} // namespace seaway::client
