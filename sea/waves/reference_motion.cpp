// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "sea/waves/reference.h"

namespace seaway::sea {

namespace {

/// What is left of a wave below still water, of what it is at the surface.
struct Shares {
    double along; ///< cosh(k (z + d)) / cosh(kd): sideways, and of the pressure
    double up;    ///< sinh(k (z + d)) / sinh(kd)
};

/// By exponentials of what is 0 or less, so that nothing overflows. k > 0, -depth <= z <= 0.
Shares shares_at(double k_radpm, double z_m, double depth_m) {
    const double deep = std::exp(k_radpm * z_m);
    const double twice_kd = 2 * k_radpm * depth_m;
    constexpr double deep_enough = 80; // the floor is not felt: exp(-80) is nothing beside 1
    if (twice_kd + 2 * k_radpm * z_m > deep_enough)
        return {deep, deep};
    const double here = std::expm1(-(twice_kd + 2 * k_radpm * z_m)); // exp(-2 k (z + d)) - 1
    const double surface = std::expm1(-twice_kd);
    return {deep * (2 + here) / (2 + surface), deep * here / surface};
}

/// Of eight pairs.
struct BlockShares {
    Lanes along, up;
    Lanes pressure; ///< of a height: w^2 / (k tanh(kd)) of its waves, m/s^2
};

BlockShares block_shares(const PairSpectrum& waves, const Lanes& kx_radpm, double ky_radpm,
                         double z_m, double depth_m) {
    BlockShares shares{};
    for (int lane = 0; lane < sum_lanes; ++lane) {
        const double omega_radps =
            std::max(waves.east.omega_radps.at[lane], waves.west.omega_radps.at[lane]);
        if (omega_radps == 0)
            continue; // no wave
        const double k_radpm = std::hypot(kx_radpm.at[lane], ky_radpm);
        const Shares here = shares_at(k_radpm, z_m, depth_m);
        shares.along.at[lane] = here.along;
        shares.up.at[lane] = here.up;
        shares.pressure.at[lane] =
            here.along * omega_radps * omega_radps / (k_radpm * std::tanh(k_radpm * depth_m));
    }
    return shares;
}

PairBlock scaled(const PairBlock& pair, const Lanes& shares) {
    PairBlock made;
    for (int i = 0; i < 2; ++i)
        for (int lane = 0; lane < sum_lanes; ++lane) {
            made.even[i].at[lane] = pair.even[i].at[lane] * shares.at[lane];
            made.odd[i].at[lane] = pair.odd[i].at[lane] * shares.at[lane];
        }
    return made;
}

} // namespace

/// Sums of waves of which there is as much as is left below: sideways rates and, as a height, the pressure; and
/// the rate of heights.
struct DirectSum::Moment::Motion {
    LagrangianPoint along;
    LagrangianPoint up;
};

void DirectSum::Moment::add_motion(std::size_t tile, double x_m, double y_m, double still_z_m,
                                   Motion& motion) const {
    const Tile& t = sum_->tiles_[tile];
    const double depth_m = sum_->sea_->cascades[tile].depth_m;
    const double z_m = std::clamp(still_z_m, -depth_m, 0.0);
    std::vector<WaveRun> runs = t.runs; // of blocks of their own
    std::vector<Lanes> over_k_m;
    std::vector<PairBlock> pressure, rate_along, rate_up;
    for (WaveRun& run : runs) {
        const std::size_t first = over_k_m.size();
        for (std::size_t b = run.begin; b < run.end; ++b) {
            const std::size_t at = static_cast<std::size_t>(run.first) / sum_lanes + b - run.begin;
            const BlockShares shares =
                block_shares(sum_->spectrum_[b], t.kx_radpm[at], run.ky_radpm, z_m, depth_m);
            over_k_m.push_back(sum_->displacement_over_k_m_[b]);
            pressure.push_back(scaled(height_[b], shares.pressure));
            rate_along.push_back(scaled(rate_[b], shares.along));
            rate_up.push_back(scaled(rate_[b], shares.up));
        }
        run.begin = first;
        run.end = over_k_m.size();
    }
    TileWaves waves{runs.data(),       runs.size(),     pressure.data(),
                    rate_along.data(), over_k_m.data(), t.kx_radpm.data()};
    add(tile, waves, x_m, y_m, motion.along);
    waves.rate = rate_up.data();
    add(tile, waves, x_m, y_m, motion.up);
}

WaterMotion DirectSum::Moment::motion(double x_m, double y_m, double still_z_m) const {
    if (!std::isfinite(x_m) || !std::isfinite(y_m) || std::isnan(still_z_m)) {
        constexpr double nan = std::numeric_limits<double>::quiet_NaN();
        return {{nan, nan, nan}, nan};
    }
    Motion motion;
    for (std::size_t t = 0; t < sum_->tiles_.size(); ++t)
        if (has(t))
            add_motion(t, x_m, y_m, still_z_m, motion);
    return {
        {motion.along.displacement_x_rate, motion.along.displacement_y_rate, motion.up.height_rate},
        motion.along.height};
}

} // namespace seaway::sea
