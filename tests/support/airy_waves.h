// SPDX-License-Identifier: Apache-2.0
// Ten waves of linear theory at finite depth, as handbooks tabulate them (Airy; Shore Protection
// Manual 1984, 2.23; Dean and Dalrymple 1991, 4), and the scene that has one of them alone.
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace seaway::tests {

/// Computed apart from this project with 40 digits: w^2 = g k tanh(kd) solved for k by bisection and
/// secant steps (mpmath), g = 9.81, no surface tension; L = 2 pi / k. kd runs from 0.2 to 10.
struct AiryWave {
    double period_s, depth_m, height_m;
    double k_radpm, length_m, coth_kd;

    double celerity_mps() const { return length_m / period_s; }
    double amplitude_m() const { return 0.5 * height_m; }
    /// Of the water at the surface: pi H / T, times coth(kd) sideways.
    double vertical_speed_mps() const { return std::numbers::pi * height_m / period_s; }
    double horizontal_speed_mps() const { return vertical_speed_mps() * coth_kd; }
    double horizontal_displacement_m() const { return amplitude_m() * coth_kd; }
};

inline constexpr AiryWave airy_waves[] = {
    {25, 6, 0.6, 0.032971363046605556, 190.56492442542343, 5.1206629329841063},
    {20, 10, 1.0, 0.032260473489911768, 194.76419988517568, 3.2065646410417773},
    {25, 20, 2.0, 0.018337130214562937, 342.64823522873944, 2.8478732545660489},
    {25, 50, 4.0, 0.011994076733746175, 523.85735448076669, 1.8627566006005367},
    {4, 2, 0.3, 0.38723649680998845, 16.225705373692237, 1.5395916104952271},
    {10, 20, 3.0, 0.051825681472200044, 121.23690665891132, 1.2878174103568088},
    {8, 15, 5.5, 0.076821211281851543, 81.789719301965024, 1.2217163761364671},
    {15, 100, 6.0, 0.018747723538629103, 335.14390663129195, 1.0481907657836738},
    {6, 40, 2.5, 0.11181535727511577, 56.192507543665413, 1.0002607493295607},
    {3, 22.5, 0.7, 0.44714483801651251, 14.051789874285782, 1.0000000036506138}};

/// Its direction of travel: lattice steps (3, 4) of a tile of five wavelengths.
inline constexpr double airy_east = 0.6, airy_north = 0.8;

inline std::string airy_scene(const AiryWave& wave, double choppiness) {
    return fmt::format("[sea]\nchoppiness = {}\ndepth_m = {}\nsurface_tension = false\n"
                       "[[sea.system]]\ntype = \"modes\"\nlength_m = {:.17g}\ndata = '''\n"
                       "nx,ny,amplitude_m,phase_rad\n3,4,{:.17g},0\n'''\n"
                       "[[cascade]]\nlength_m = {:.17g}\nsize = 512\n"
                       "[accuracy]\nheight_error_m = 1e-5\n",
                       choppiness, wave.depth_m, 5 * wave.length_m, wave.amplitude_m(),
                       5 * wave.length_m);
}

/// A place of the surface, where linear theory puts it and how its water moves there.
struct AiryPoint {
    double x_m, y_m;
    long long time_us;
    double height_m;
    double velocity_mps[3];
};

/// Points all along the wave at four times, the last after a hundred periods: a celerity that is off
/// by 1e-8 of itself would show.
inline std::vector<AiryPoint> airy_points(const AiryWave& wave, double choppiness) {
    std::vector<AiryPoint> points;
    for (const double periods : {0.0, 0.125, 7.4, 100.375}) {
        const auto time_us = static_cast<long long>(std::llround(1e6 * periods * wave.period_s));
        const double travelled_m = wave.celerity_mps() * (static_cast<double>(time_us) * 1e-6);
        for (int i = 0; i < 12; ++i) {
            const double along_m = travelled_m + (i / 12.0 - 0.25) * wave.length_m;
            const double theta = wave.k_radpm * (along_m - travelled_m);
            const double moved_m = -choppiness * wave.horizontal_displacement_m() * std::sin(theta);
            const double u = wave.horizontal_speed_mps() * std::cos(theta);
            const double across_m = 3.7 * i; // along the crest nothing changes
            points.push_back(
                {airy_east * (along_m + moved_m) - airy_north * across_m,
                 airy_north * (along_m + moved_m) + airy_east * across_m,
                 time_us,
                 wave.amplitude_m() * std::cos(theta),
                 {airy_east * u, airy_north * u, wave.vertical_speed_mps() * std::sin(theta)}});
        }
    }
    return points;
}

} // namespace seaway::tests
