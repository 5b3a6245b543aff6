// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/budget/spending.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>

#include "base/check.h"
#include "sea/surface/budget/interpolation_laws.h"

namespace seaway::sea {

namespace {

constexpr std::size_t interval_count = std::size(keyframe_intervals_us);

/// The intervals of one cascade with what they lose, worked out when they are asked for.
class Intervals {
  public:
    Intervals(const CascadeWaves& waves, double weight, double strain_max)
        : waves_(waves), weight_(weight) {
        while (at_ + 1 < interval_count &&
               !(waves.told_by(us()) && waves.time_strain_rms(us()) <= strain_max))
            ++at_;
    }
    TimeUs us() const { return keyframe_intervals_us[at_]; }
    double loss_m2() const { return loss_of(at_); }
    double points_per_s() const { return rate_of(at_); }
    bool shortest() const { return at_ + 1 == interval_count; }
    void shorten() { ++at_; }
    /// What the next shorter interval saves of the loss for each grid point a second more.
    double gain() const {
        return (loss_of(at_) - loss_of(at_ + 1)) / (rate_of(at_ + 1) - rate_of(at_));
    }

  private:
    double rate_of(std::size_t i) const {
        return waves_.points() / seconds_from_us(keyframe_intervals_us[i]);
    }
    double loss_of(std::size_t i) const {
        if (!losses_[i])
            losses_[i] = waves_.time_costs_m2(keyframe_intervals_us[i], weight_);
        return *losses_[i];
    }

    const CascadeWaves& waves_;
    double weight_;
    std::size_t at_ = 0;
    mutable std::optional<double> losses_[interval_count];
};

/// Bits a sample of a map whose predictor leaves `detail_m2`, quantised in steps of twice the bound. The
/// rounding of the four neighbours that predict it is left too.
double bits(double detail_m2, double bound_m) {
    const double step2 = 4.0 * bound_m * bound_m;
    return 0.5 *
           std::log2(2.0 * std::numbers::pi * std::numbers::e * (detail_m2 / step2 + 4.0 / 12.0));
}

} // namespace

double value_bound_m(double variance_m2, double sideways_weight) {
    return std::sqrt(3.0 * variance_m2 / codec_peak(rate_over_value * rate_over_value) /
                     (1.0 + sideways_weight * sideways_weight));
}

Spending spend_at(std::span<const CascadeWaves> cascades, std::span<const TimeUs> intervals_us,
                  double variance_m2, double sideways_weight) {
    Spending spending{{intervals_us.begin(), intervals_us.end()}, 0, {}, 0};
    std::vector<double> points_per_s;
    double coded_points_per_s = 0;
    for (std::size_t c = 0; c < cascades.size(); ++c) {
        points_per_s.push_back(cascades[c].points() / seconds_from_us(intervals_us[c]));
        if (cascades[c].detail_m2() > 0)
            coded_points_per_s += points_per_s[c];
    }
    double strain2 = 0;
    for (std::size_t c = 0; c < cascades.size(); ++c) {
        // Flat water needs no bits, and no error.
        const bool coded = cascades[c].detail_m2() > 0;
        spending.codec_shares.push_back(coded ? points_per_s[c] / coded_points_per_s : 0.0);
        strain2 += variance_m2 * spending.codec_shares[c] * spline_slope_variance_gain /
                   (cascades[c].spacing_m() * cascades[c].spacing_m());
    }
    if (const double strain = fold_sigmas * std::sqrt(strain2); strain > strain_error_max)
        variance_m2 *= strain_error_max / strain * (strain_error_max / strain);
    spending.codec_m2 = variance_m2;
    for (std::size_t c = 0; c < cascades.size(); ++c) {
        spending.bits_per_s += points_per_s[c] * keyframe_bits;
        if (!(spending.codec_shares[c] > 0))
            continue;
        const double value_m =
            value_bound_m(variance_m2 * spending.codec_shares[c], sideways_weight);
        const double rate_mps = rate_over_value * value_m / seconds_from_us(intervals_us[c]);
        spending.bits_per_s +=
            points_per_s[c] * (3.0 * bits(cascades[c].detail_m2(), value_m) +
                               3.0 * bits(cascades[c].rate_detail_m2ps2(), rate_mps));
    }
    return spending;
}

Spending spend(std::span<const CascadeWaves> cascades, double variance_m2, double sideways_weight) {
    SEAWAY_CHECK(variance_m2 > 0, "a budget is spent");
    std::vector<Intervals> at;
    for (const CascadeWaves& waves : cascades)
        at.emplace_back(waves, sideways_weight,
                        strain_error_max / fold_sigmas /
                            std::sqrt(static_cast<double>(cascades.size())));
    std::vector<TimeUs> intervals_us(cascades.size());
    std::optional<Spending> best;
    for (;;) {
        double lost_m2 = 0, keyframes_bits_per_s = 0;
        for (std::size_t c = 0; c < at.size(); ++c) {
            intervals_us[c] = at[c].us();
            lost_m2 += at[c].loss_m2();
            keyframes_bits_per_s += keyframe_bits * at[c].points_per_s();
        }
        if (best && keyframes_bits_per_s > best->bits_per_s)
            break; // and it only grows from here on
        if (lost_m2 < variance_m2) {
            Spending spending =
                spend_at(cascades, intervals_us, variance_m2 - lost_m2, sideways_weight);
            if (!best || spending.bits_per_s < best->bits_per_s)
                best = std::move(spending);
        }
        Intervals* next = nullptr;
        for (Intervals& cascade : at)
            if (!cascade.shortest() && (next == nullptr || cascade.gain() > next->gain()))
                next = &cascade;
        if (next == nullptr)
            break;
        next->shorten();
    }
    return best ? *best : spend_at(cascades, intervals_us, 0.5 * variance_m2, sideways_weight);
}

} // namespace seaway::sea
