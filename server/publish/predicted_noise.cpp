// SPDX-License-Identifier: Apache-2.0
#include "server/publish/predicted_noise.h"

#include <algorithm>
#include <cmath>

#include "sea/surface/budget/error_budget.h"
#include "sea/surface/maps/hermite.h"

namespace seaway::server {

using sea::Field;

namespace {

std::vector<float> off(std::span<const float> decoded, std::span<const float> original) {
    std::vector<float> by(decoded.size());
    for (std::size_t i = 0; i < by.size(); ++i)
        by[i] = decoded[i] - original[i];
    return by;
}

double rounded_before(const sea::Keyframe& sent, Field field) {
    const sea::RoundedMap* const rounded = sent.rounded_map(field);
    return rounded ? sea::rounded_rms(static_cast<double>(rounded->error)) : 0.0;
}

double mean_square(std::span<const float> values) {
    double sum = 0;
    for (const float value : values)
        sum += sea::square(static_cast<double>(value));
    return sum / static_cast<double>(values.size());
}

/// Mean square between two keyframes.
double mixed_m2(const PredictedNoise& a, const PredictedNoise& b, const sea::HermiteWeights& w) {
    double sum = 0;
    for (std::size_t i = 0; i < a.height_m.size(); ++i)
        sum += sea::square(w.value[0] * static_cast<double>(a.height_m[i]) +
                           w.value[1] * static_cast<double>(a.rate_mps[i]) +
                           w.value[2] * static_cast<double>(b.height_m[i]) +
                           w.value[3] * static_cast<double>(b.rate_mps[i]));
    return sum / static_cast<double>(a.height_m.size());
}

/// The least that MapLoss::between_m can be, squared, so that what it says is no less than what there is at a quarter, half and three
/// quarters of the way. Half way alone would do once a stream has settled; rates of its first keyframes are even noise, which counts
/// most at a quarter.
double between_m2(const PredictedNoise& a, const PredictedNoise& b, sea::TimeUs apart_us,
                  double at_m2, const sea::MapLoss& rounded) {
    double most_m2 = 0;
    for (const double share : {0.25, 0.5, 0.75}) {
        const sea::HermiteWeights w =
            sea::hermite_weights(0, apart_us, std::llround(share * static_cast<double>(apart_us)));
        const double there_m2 = mixed_m2(a, b, w) + rounded.at(share, w).coded_m2;
        most_m2 = std::max(most_m2, at_m2 + (there_m2 - at_m2) / sea::between_keyframes(share));
    }
    return most_m2;
}

} // namespace

PredictedNoise noise_of(const sea::Keyframe& sent, std::span<const float> height_decoded,
                        std::span<const float> rate_decoded, const sea::Regrid* same) {
    PredictedNoise all{off(height_decoded, sent.plane(Field::height)),
                       off(rate_decoded, sent.plane(Field::height_rate)),
                       rounded_before(sent, Field::height),
                       rounded_before(sent, Field::height_rate)};
    if (same == nullptr)
        return all;
    PredictedNoise left{std::vector<float>(sent.plane_size()),
                        std::vector<float>(sent.plane_size()), all.rounded_m, all.rounded_mps};
    same->maps(all.height_m, all.rate_mps, left.height_m, left.rate_mps);
    return left;
}

sea::CodedNoise told_of(const PredictedNoise& noise, sea::TimeUs time_us,
                        const NoiseBefore& before) {
    const double at_m2 = mean_square(noise.height_m) + sea::square(noise.rounded_m);
    sea::CodedNoise told{.at_m = std::sqrt(at_m2)};
    if (before.noise == nullptr || before.noise->height_m.size() != noise.height_m.size())
        return told;
    sea::MapLoss rounded; // the larger of both
    rounded.value_m = std::max(noise.rounded_m, before.noise->rounded_m);
    rounded.rate_mps = std::max(noise.rounded_mps, before.noise->rounded_mps);
    const double before_m2 =
        mean_square(before.noise->height_m) + sea::square(before.noise->rounded_m);
    told.before = before.number;
    told.before_us = before.time_us;
    told.between_m = std::sqrt(between_m2(*before.noise, noise, time_us - before.time_us,
                                          std::max(at_m2, before_m2), rounded));
    return told;
}

} // namespace seaway::server
