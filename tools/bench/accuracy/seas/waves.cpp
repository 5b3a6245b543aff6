// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/accuracy/seas/waves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <optional>
#include <tuple>

#include "sea/basics/constants.h"

namespace seaway::bench {

namespace {

using Complex = std::complex<double>;

std::size_t at(int nx, int ny, int size) {
    return static_cast<std::size_t>((ny + size) % size * size + (nx + size) % size);
}

/// Cascade by cascade, each held to its own band: layouts that leave gaps can be had too.
Result<sea::Realization> with_bands(const sea::SeaState& state,
                                    const Configuration& configuration) {
    sea::Realization sea;
    for (std::size_t c = 0; c < configuration.cascades.size(); ++c) {
        const sea::Band band = configuration.bands[c];
        sea::SeaState part = state;
        part.wavenumber_min_radpm = band.k_lo_radpm;
        part.wavenumber_max_radpm = band.k_hi_radpm;
        SEAWAY_TRY_LET(sea::Realization tile, sea::realize(part, {&configuration.cascades[c], 1}));
        tile.cascades[0].band = band;
        sea.choppiness = tile.choppiness;
        sea.loop_period_us = tile.loop_period_us;
        sea.cascades.push_back(std::move(tile.cascades[0]));
    }
    return sea;
}

} // namespace

sea::ErrorBudget budget_of(const sea::Realization& sea, const Configuration& configuration) {
    std::optional<sea::TimeUs> interval_us = configuration.interval_us;
    if (configuration.time == TimeRule::every_frame)
        interval_us = sea::us_from_seconds(1.0 / frames_per_s);
    if (!interval_us)
        return sea::plan_budget(sea, configuration.height_error_m);
    const std::vector<sea::TimeUs> all(sea.cascades.size(), *interval_us);
    return sea::plan_budget(sea, configuration.height_error_m, all);
}

Result<Waves> configured_waves(const sea::Scene& scene, const Configuration& configuration) {
    Waves waves;
    waves.state = scene.sea;
    if (configuration.choppiness)
        waves.state.choppiness = {*configuration.choppiness, *configuration.choppiness};
    SEAWAY_TRY_LET(sea::Realization all, configuration.bands.empty()
                                             ? sea::realize(waves.state, configuration.cascades)
                                             : with_bands(waves.state, configuration));
    sea::Realization used = all;
    if (configuration.k_max_radpm < std::numeric_limits<double>::infinity())
        used = up_to(used, configuration.k_max_radpm);
    if (configuration.modes_kept > 0)
        used = largest_modes(used, configuration.modes_kept);
    if (configuration.oversampling > 1)
        used = oversampled(used, configuration.oversampling);
    waves.budget = budget_of(used, configuration);
    waves.all = std::make_shared<const sea::Realization>(std::move(all));
    waves.used = std::make_shared<const sea::Realization>(std::move(used));
    return waves;
}

sea::Realization oversampled(const sea::Realization& sea, int factor) {
    sea::Realization finer = sea;
    for (std::size_t c = 0; c < sea.cascades.size(); ++c) {
        const sea::CascadeModes& from = sea.cascades[c];
        sea::CascadeModes& to = finer.cascades[c];
        const int size = from.spec.size * factor, half = from.spec.size / 2;
        to.spec.size = size;
        const auto points = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
        to.h0.assign(points, Complex{});
        to.rate.assign(points, 0);
        for (int ny = 1 - half; ny < half; ++ny)
            for (int nx = 1 - half; nx < half; ++nx) {
                to.h0[at(nx, ny, size)] = from.h0[at(nx, ny, from.spec.size)];
                to.rate[at(nx, ny, size)] = from.rate[at(nx, ny, from.spec.size)];
            }
    }
    return finer;
}

sea::Realization largest_modes(const sea::Realization& sea, int count) {
    struct Pair {
        double variance;
        std::size_t cascade, index, opposite;
    };
    std::vector<Pair> pairs;
    for (std::size_t c = 0; c < sea.cascades.size(); ++c) {
        const sea::CascadeModes& cascade = sea.cascades[c];
        const int size = cascade.spec.size;
        for (int ny = 0; ny < size / 2; ++ny)
            for (int nx = ny == 0 ? 1 : 1 - size / 2; nx < size / 2; ++nx) {
                const std::size_t i = at(nx, ny, size), j = at(-nx, -ny, size);
                const double variance = std::norm(cascade.h0[i]) + std::norm(cascade.h0[j]);
                if (variance > 0)
                    pairs.push_back({variance, c, i, j});
            }
    }
    std::sort(pairs.begin(), pairs.end(),
              [](const Pair& a, const Pair& b) { return a.variance > b.variance; });
    pairs.resize(std::min(pairs.size(), static_cast<std::size_t>(count)));
    sea::Realization kept = sea;
    for (sea::CascadeModes& cascade : kept.cascades)
        std::fill(cascade.h0.begin(), cascade.h0.end(), Complex{});
    for (const Pair& pair : pairs)
        for (const std::size_t i : {pair.index, pair.opposite})
            kept.cascades[pair.cascade].h0[i] = sea.cascades[pair.cascade].h0[i];
    return kept;
}

sea::Realization up_to(const sea::Realization& sea, double k_max_radpm) {
    sea::Realization kept = sea;
    for (std::size_t c = 0; c < kept.cascades.size(); ++c)
        for_each_wave(sea.cascades[c], [&](std::size_t i, double kx, double ky, double, double) {
            if (!(std::hypot(kx, ky) < k_max_radpm))
                kept.cascades[c].h0[i] = {};
        });
    return kept;
}

double phase_by_rule(sea::Rate rate, sea::TimeUs time_us, PhaseRule rule) {
    const double omega = sea::omega_from_rate(rate), t = sea::seconds_from_us(time_us);
    switch (rule) {
    case PhaseRule::fixed_point:
        return sea::phase_rad(rate, time_us);
    case PhaseRule::float64:
        return omega * t;
    case PhaseRule::float32:
        return static_cast<float>(omega) * static_cast<float>(t);
    }
    return 0;
}

sea::Realization as_seen_at(const sea::Realization& sea, sea::TimeUs time_us, PhaseRule rule) {
    sea::Realization seen = sea;
    for (sea::CascadeModes& cascade : seen.cascades)
        for (std::size_t i = 0; i < cascade.h0.size(); ++i)
            if (cascade.h0[i] != Complex{})
                cascade.h0[i] *= std::polar(1.0, -phase_by_rule(cascade.rate[i], time_us, rule));
    return seen;
}

double variance_of(const sea::Realization& sea) {
    double sum = 0;
    for (const sea::CascadeModes& cascade : sea.cascades)
        for_each_wave(cascade, [&](std::size_t, double, double, double variance, double) {
            sum += variance;
        });
    return sum;
}

} // namespace seaway::bench
