// SPDX-License-Identifier: Apache-2.0
#include "client/view/sky/two_stream.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "client/view/sky/scattering.h"

namespace seaway::client {

namespace {

using std::numbers::pi;
constexpr int layers = TwoStream::layers;
constexpr double thinnest = 1e-7; ///< depth of a layer, so that its conductance is a number

/// Thin below, where the air is dense: the height of a layer's lower edge.
double edge_m(const Air& air, double layer) {
    const double root = layer / layers;
    return root * root * air.thickness_m;
}

/// What a layer does to light of one wavelength that goes straight up.
struct Layer {
    double depth = 0;     ///< as it is, of the air above its middle too
    double scattered = 0; ///< as if it were isotropic
    double absorbed = 0;
    double above = 0, scaled_above = 0; ///< depth from its middle to space, as it is and scaled
    double forward = 0;                 ///< first moment of what is scattered
    double beam = 0, lit = 0;           ///< normal to the sun's beam: scaled, and as it is
};
using Column = std::array<std::array<Layer, layers>, 3>;

Column column_of(const Air& air, const TransmittanceTable& transmittance, double sun_cosine) {
    // The first moment of Cornette's and Shanks's function (1992, equation 9).
    const double g = air.aerosol_asymmetry;
    const double moment = g * 3 * (4 + g * g) / (5 * (2 + g * g)), isotropic = 1 - moment;
    Column out;
    glm::dvec3 above(0), scaled_above(0);
    for (int i = layers - 1; i >= 0; --i) {
        const double middle_m = edge_m(air, i + 0.5), high_m = edge_m(air, i + 1) - edge_m(air, i);
        const Medium medium = air.at(middle_m);
        const glm::dvec3 depth = medium.extinction_per_m * high_m;
        const glm::dvec3 scattered =
            (medium.rayleigh_per_m + isotropic * medium.aerosol_per_m) * high_m;
        const glm::dvec3 absorbed =
            glm::max(depth - (medium.rayleigh_per_m + medium.aerosol_per_m) * high_m, 0.0);
        const glm::dvec3 lit = transmittance.to_disc(middle_m, sun_cosine, disc_radius_rad);
        for (int c = 0; c < 3; ++c) {
            Layer& layer = out[static_cast<std::size_t>(c)][static_cast<std::size_t>(i)];
            const double scaled = scattered[c] + absorbed[c];
            layer = {depth[c], scattered[c], absorbed[c], above[c] + depth[c] / 2,
                     scaled_above[c] + scaled / 2};
            const double scattering = medium.rayleigh_per_m[c] + medium.aerosol_per_m[c];
            layer.forward = scattering > 0 ? moment * medium.aerosol_per_m[c] / scattering : 0;
            layer.lit = lit[c];
            // Along the sun's way as straight up.
            layer.beam = layer.above > 0 && lit[c] > 0
                             ? std::pow(lit[c], layer.scaled_above / layer.above)
                             : lit[c];
            above[c] += depth[c];
            scaled_above[c] += scaled;
        }
    }
    return out;
}

/// Mean radiances of the diffuse light, from below: what a layer passes on to its neighbours, absorbs and is given by the beam.
/// ground: what the sea sends back of the beam.
std::array<double, layers> diffuse(const std::array<Layer, layers>& column, double ground_albedo,
                                   double sun_cosine) {
    const auto thick = [&](int i) {
        const Layer& layer = column[static_cast<std::size_t>(i)];
        return std::max(layer.scattered + layer.absorbed, thinnest);
    };
    // I = I0 + I1 cos: no light comes down from space, and of what falls on the sea its share goes up.
    const double to_space = 1 / (2.0 / 3 + thick(layers - 1) / 2);
    const double kept = 1 - ground_albedo;
    const double sea = 2.0 / 3 * (1 + ground_albedo) + kept * thick(0) / 2;
    std::array<double, layers> up{}, value{};
    double below = kept / sea; // conductance to what is below, without a value of its own
    double given = ground_albedo * std::max(sun_cosine, 0.0) * column[0].beam / (pi * sea);
    for (int i = 0; i < layers; ++i) {
        const auto at = static_cast<std::size_t>(i);
        const Layer& layer = column[at];
        const double next = i + 1 < layers ? 2 / (thick(i) + thick(i + 1)) : to_space;
        // Eliminated from below: all terms are positive, so nothing is lost to rounding.
        const double leak = below + 3 * layer.absorbed;
        given += 3 / (4 * pi) * layer.scattered * layer.beam;
        up[at] = next / (leak + next);
        value[at] = given / (leak + next);
        below = leak * up[at];
        given *= up[at];
    }
    double above = 0;
    for (int i = layers - 1; i >= 0; --i) {
        const auto at = static_cast<std::size_t>(i);
        const double next = i + 1 < layers ? 2 / (thick(i) + thick(i + 1)) : to_space;
        const double here = value[at] + up[at] * above;
        // Scattered on forward, light of the brighter half of all directions reaches an eye that looks there: below dense air
        // upwards, above it downwards.
        value[at] =
            here + 2.0 / 3 * std::max(column[at].forward, 0.0) * next * std::abs(above - here);
        above = here;
    }
    return value;
}

} // namespace

glm::dvec3 depth_of_air(const Air& air) {
    glm::dvec3 sum(0);
    for (int i = 0; i < layers; ++i)
        sum +=
            air.at(edge_m(air, i + 0.5)).extinction_per_m * (edge_m(air, i + 1) - edge_m(air, i));
    return sum;
}

glm::dvec3 two_stream_share(const glm::dvec3& depth) {
    return glm::smoothstep(glm::dvec3(2.5), glm::dvec3(6), depth);
}

TwoStream::TwoStream(const Air& air, const TransmittanceTable& transmittance, double sun_cosine)
    : thickness_m_(air.thickness_m), mean_(layers) {
    const Column column = column_of(air, transmittance, sun_cosine);
    for (int c = 0; c < 3; ++c) {
        const auto& layer = column[static_cast<std::size_t>(c)];
        const std::array<double, layers> found = diffuse(layer, air.ground_albedo, sun_cosine);
        for (std::size_t i = 0; i < layers; ++i)
            // What goes on forward is no longer the disc's.
            mean_[i][c] = found[i] + std::max(layer[i].beam - layer[i].lit, 0.0) / (4 * pi);
    }
}

glm::dvec3 TwoStream::at(double height_m) const {
    const double x = std::clamp(
        std::sqrt(std::clamp(height_m / thickness_m_, 0.0, 1.0)) * layers - 0.5, 0.0, layers - 1.0);
    const int low = std::min(static_cast<int>(x), layers - 2);
    const auto at = static_cast<std::size_t>(low);
    return glm::mix(mean_[at], mean_[at + 1], x - low);
}

} // namespace seaway::client
