// SPDX-License-Identifier: Apache-2.0
#include "sea/foam/foam_law.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include "base/check.h"

namespace seaway::sea {

namespace {

double normal_density(double z) {
    return std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::numbers::pi);
}

double normal_share(double z) {
    return 0.5 * std::erfc(-z / std::numbers::sqrt2);
}

/// Phi(-t) / phi(t) for t >= 0, Mills' ratio, from phi(t).
double mills_ratio(double t, double density) {
    if (t < 6)
        return normal_share(-t) / density;
    if (density == 0) // whatever it is
        return 1 / t;
    double fraction = t;
    for (int n = t < 8 ? 20 : 12; n > 0; --n) // right to the last digit
        fraction = t + n / fraction;
    return 1 / fraction;
}

/// E[max(0, q)] + bias P(q > 0) of the parabola q = mean - width z - curvature (z^2 - 1), z standard
/// normal: q is positive left of its upper root; the lower root is many deviations away.
double parabola_excess(double mean, double width, double curvature, double bias) {
    const double top = mean + curvature;
    const double discriminant = width * width + 4 * curvature * top;
    if (!(discriminant > 0))
        return width > 0 || curvature > 0 || !(mean > 0) ? 0.0 : mean + bias;
    const double root = 2 * top / (width + std::sqrt(discriminant));
    const double t = std::abs(root);
    const double density = normal_density(t);
    const double mills = mills_ratio(t, density);
    const double linear = 1 - t * mills;
    const double square = t * linear + mills;
    const double excess = root > 0 ? mean + density * (width * linear + curvature * square)
                                   : density * (width * linear - curvature * square);
    return std::max(excess, 0.0) + (bias != 0 ? bias * normal_share(root) : 0.0);
}

/// Lower Cholesky factor of the moments in the order a, c, b; a degenerate axis becomes zero.
struct Cholesky {
    double aa, ca, cc, ba, bc, bb;

    explicit Cholesky(const StrainMoments& m) {
        const auto root = [](double x) { return x > 0 ? std::sqrt(x) : 0.0; };
        const auto ratio = [](double x, double y) { return y > 0 ? x / y : 0.0; };
        aa = root(m.aa);
        ca = ratio(m.ac, aa);
        // What rounding leaves of a degenerate axis is not an axis.
        const double cc_rest = m.cc - ca * ca;
        cc = cc_rest > 1e-12 * m.cc ? root(cc_rest) : 0.0;
        ba = ratio(m.ab, aa);
        bc = ratio(m.bc - ba * ca, cc);
        const double bb_rest = m.bb - ba * ba - bc * bc;
        bb = bb_rest > 1e-12 * m.bb ? root(bb_rest) : 0.0;
    }
};

/// Trapezoidal rule over a standard normal: exponentially accurate for smooth integrands.
class GaussianMean {
  public:
    explicit GaussianMean(double step) : step_(step), reach_(static_cast<int>(reach / step)) {
        for (int i = -reach_; i <= reach_; ++i)
            density_.push_back(normal_density(i * step));
    }
    /// Of f. An axis that is not there is one point.
    template <class F>
    double operator()(bool present, const F& f) const {
        if (!present)
            return f(0.0);
        double sum = 0;
        for (int i = -reach_; i <= reach_; ++i)
            sum += density_[static_cast<std::size_t>(i + reach_)] * f(i * step_);
        return sum * step_;
    }

  private:
    static constexpr double reach = 7.5; ///< deviations
    double step_;
    int reach_;
    std::vector<double> density_;
};

/// Average over all strains of g(mean, deviation) where, given two of a, b, c, threshold - J is
/// normal: J is linear in a and in b. The wider of these two is the one left to g.
template <class G>
double mean_over_strains(double threshold, const StrainMoments& moments, const G& g) {
    StrainMoments m = moments;
    if (m.aa > m.bb) {
        std::swap(m.aa, m.bb);
        std::swap(m.ac, m.bc);
    }
    const Cholesky l(m);
    // Fine: where all waves run one oblique way, g has a kink.
    static const GaussianMean over(0.0625);
    return over(l.aa > 0, [&](double p) {
        const double a = l.aa * p;
        return over(l.cc > 0, [&](double q) {
            const double c = l.ca * p + l.cc * q;
            const double u = threshold - (1 + a) * (1 + l.ba * p + l.bc * q) + c * c;
            return g(u, std::abs(1 + a) * l.bb);
        });
    });
}

double mean_breaking(double threshold, double bias, const StrainMoments& moments) {
    return mean_over_strains(threshold, moments, [bias](double u, double s) {
        return parabola_excess(u, s, 0.0, bias);
    });
}

double mean_conditional_breaking(double threshold, double bias, const StrainMoments& own,
                                 const OthersShape& others) {
    const Cholesky l(own);
    static const GaussianMean over(0.375);
    return over(l.aa > 0, [&](double p) {
        return over(l.cc > 0, [&](double q) {
            return over(l.bb > 0, [&](double r) {
                return conditional_breaking(threshold, bias, others, l.aa * p,
                                            l.ba * p + l.bc * q + l.bb * r, l.ca * p + l.cc * q);
            });
        });
    });
}

} // namespace

StrainMoments& StrainMoments::operator+=(const StrainMoments& other) {
    aa += other.aa;
    bb += other.bb;
    cc += other.cc;
    ab += other.ab;
    ac += other.ac;
    bc += other.bc;
    return *this;
}

StrainMoments strain_moments(const CascadeModes& modes, const Choppiness& choppiness) {
    const int size = modes.spec.size;
    const double step = modes.spec.wavenumber_step_radpm();
    const double lx = choppiness.x;
    const double ly = choppiness.y;
    const double lxy = std::sqrt(lx * ly);
    StrainMoments sum;
    std::size_t i = 0;
    for (int iy = 0; iy < size; ++iy)
        for (int ix = 0; ix < size; ++ix, ++i) {
            const double variance = 2.0 * std::norm(modes.h0[i]);
            if (variance == 0.0)
                continue;
            const double kx = step * signed_index(ix, size);
            const double ky = step * signed_index(iy, size);
            const double k = std::hypot(kx, ky);
            const double over_k = modes.displacement_over_k(k);
            const double a = lx * kx * kx * over_k;
            const double b = ly * ky * ky * over_k;
            const double c = lxy * kx * ky * over_k;
            sum += {variance * a * a, variance * b * b, variance * c * c,
                    variance * a * b, variance * a * c, variance * b * c};
        }
    return sum;
}

double mean_shortfall(double threshold, const StrainMoments& moments) {
    return mean_breaking(threshold, 0.0, moments);
}

double breaking_share(double threshold, const StrainMoments& moments) {
    return mean_over_strains(threshold, moments, [](double u, double s) {
        return s > 0 ? normal_share(u / s) : (u > 0 ? 1.0 : 0.0);
    });
}

OthersShape others_shape(const StrainMoments& m) {
    OthersShape shape;
    shape.variance = m.aa + m.bb + 2 * m.ab;
    if (!(shape.variance > 0))
        return {};
    shape.difference = (m.aa - m.bb) / shape.variance;
    shape.shear = (m.ac + m.bc) / shape.variance;
    shape.difference_rest =
        m.aa + m.bb - 2 * m.ab - shape.difference * shape.difference * shape.variance;
    shape.shear_rest = m.cc - shape.shear * shape.shear * shape.variance;
    shape.cross_rest = m.ac - m.bc - shape.difference * shape.shear * shape.variance;
    return shape;
}

double conditional_breaking(double threshold, double bias, const OthersShape& o, double a, double b,
                            double c) {
    const double difference = a - b;
    const double mean = threshold - (1 + a) * (1 + b) + c * c;
    const double slope = 0.5 * (2 + a + b - o.difference * difference - 4 * o.shear * c);
    const double curvature =
        0.25 * (1 - o.difference * o.difference - 4 * o.shear * o.shear) * o.variance;
    // Variance of J that T' does not carry.
    const double rest = 0.25 * difference * difference * o.difference_rest +
                        4 * c * c * o.shear_rest + 2 * difference * c * o.cross_rest +
                        0.125 * o.difference_rest * o.difference_rest +
                        2 * o.shear_rest * o.shear_rest + o.cross_rest * o.cross_rest;
    const double width = std::sqrt(std::max(slope * slope * o.variance + rest, 0.0));
    return parabola_excess(mean, width, curvature, bias);
}

namespace {

/// gain tau; without history what breaks now counts for a second.
double coverage_per_breaking(const FoamModel& model) {
    return model.gain_per_s * (model.decay_s > 0 ? model.decay_s : 1.0);
}

std::vector<StrainMoments> moments_of(const Realization& sea) {
    std::vector<StrainMoments> own;
    for (const CascadeModes& modes : sea.cascades)
        own.push_back(strain_moments(modes, sea.choppiness));
    return own;
}

StrainMoments sum_of(const std::vector<StrainMoments>& parts) {
    StrainMoments total;
    for (const StrainMoments& part : parts)
        total += part;
    return total;
}

/// The threshold at which breaking has this mean, -1 .. 1, which grows with the threshold; the nearer
/// end where none does. Right to 1e-5 of the mean, whose logarithm is nearly a parabola of the threshold: false
/// position by Illinois' rule (Dowell and Jarratt 1971), which ends in a jump as well.
double threshold_of(double wanted_mean, double bias, const StrainMoments& moments) {
    struct End {
        double threshold;
        double off; ///< its mean over the one wanted, logarithm; where nothing breaks -infinity
    };
    const auto at = [&](double threshold) {
        return End{threshold, std::log(mean_breaking(threshold, bias, moments) / wanted_mean)};
    };
    End low = at(-1.0), high = at(1.0);
    if (!(high.off > 0))
        return high.threshold;
    if (!(low.off < 0))
        return low.threshold;
    double middle = 0;
    bool was_low = false;
    for (int looks = 0; looks < 60; ++looks) {
        middle = 0.5 * (low.threshold + high.threshold);
        if (std::isfinite(low.off))
            middle =
                high.threshold - high.off * (high.threshold - low.threshold) / (high.off - low.off);
        const End found = at(middle);
        if (std::abs(found.off) <= 1e-5)
            break;
        const bool is_low = found.off < 0;
        (is_low ? low : high) = found;
        if (looks > 0 && is_low == was_low) // the other end stays for the second time
            (is_low ? high : low).off *= 0.5;
        was_low = is_low;
    }
    return middle;
}

std::shared_ptr<FoamLaw> law_of(const Realization& sea, const FoamModel& model, double threshold,
                                bool foam) {
    SEAWAY_CHECK(model.decay_s >= 0 && model.gain_per_s >= 0 && std::isfinite(model.decay_s),
                 "a scene's foam model is finite and not negative");
    auto law = std::make_shared<FoamLaw>();
    law->model = model;
    law->threshold = threshold;
    law->choppiness = sea.choppiness;
    law->loop_period_us = sea.loop_period_us;
    const std::vector<StrainMoments> own = moments_of(sea);
    const double mean =
        foam ? coverage_per_breaking(model) * mean_breaking(threshold, model.bias, sum_of(own))
             : 0.0;
    law->mean_coverage = mean >= foam_mean_min ? std::min(mean, foam_mean_max) : 0.0;
    for (std::size_t c = 0; c < own.size(); ++c) {
        StrainMoments others;
        for (std::size_t other = 0; other < own.size(); ++other)
            if (other != c)
                others += own[other];
        FoamLaw::Cascade cascade;
        cascade.others = others_shape(others);
        if (!law->calm())
            cascade.mean_breaking =
                cascade.others.variance > 0
                    ? mean_conditional_breaking(threshold, model.bias, own[c], cascade.others)
                    : mean_breaking(threshold, model.bias, own[c]);
        law->cascades.push_back(cascade);
    }
    return law;
}

} // namespace

FoamLawPtr make_foam_law(const Realization& sea, const FoamModel& model) {
    SEAWAY_CHECK(model.threshold.has_value(), "a threshold that is to be found needs the scene");
    return law_of(sea, model, *model.threshold, true);
}

FoamLawPtr make_foam_law(const Scene& scene, const Realization& sea) {
    const FoamModel& model = scene.foam;
    if (model.threshold)
        return make_foam_law(sea, model);
    ObservedFoam observed{foam_wind(scene.sea), 0.0};
    observed.share = whitecap_share(observed.wind.speed_10m_mps);
    const double factor = coverage_per_breaking(model);
    const bool foam = observed.share >= foam_mean_min && factor > 0;
    const double threshold =
        foam ? threshold_of(observed.share / factor, model.bias, sum_of(moments_of(sea))) : -1.0;
    std::shared_ptr<FoamLaw> law = law_of(sea, model, threshold, foam);
    law->observed = observed;
    return law;
}

namespace {

bool out_of_reach(const FoamLaw& law) {
    return law.observed && std::abs(law.mean_coverage - law.observed->share) >
                               0.01 * law.observed->share + foam_mean_min;
}

} // namespace

FoamLawPtr foam_law_of(const Scene& scene, const Realization& sea) {
    return has_foam(scene.effects) ? make_foam_law(scene, sea) : nullptr;
}

std::vector<std::string> foam_warnings(const FoamLawPtr& foam_law) {
    if (!foam_law || !out_of_reach(*foam_law))
        return {};
    const FoamLaw& law = *foam_law;
    return {fmt::format("foam covers {} where {:.3g} % are observed {}: no threshold of -1 .. 1 "
                        "gives that with this gain and decay",
                        law.mean_coverage < 1 ? fmt::format("{:.3g} %", 100.0 * law.mean_coverage)
                                              : "all of it",
                        100.0 * law.observed->share, describe(law.observed->wind))};
}

std::string describe(const FoamLaw& law) {
    std::string out = law.calm() ? std::string("no foam")
                                 : fmt::format("mean coverage {:.3g} %, threshold {:.4g}",
                                               100.0 * law.mean_coverage, law.threshold);
    if (law.observed) {
        const ObservedFoam& observed = *law.observed;
        out += fmt::format("; observed is {:.3g} % {}", 100.0 * observed.share,
                           describe(observed.wind));
        if (out_of_reach(law))
            out += "; no threshold of -1 .. 1 gives that with this gain and decay";
    }
    if (law.mean_coverage > 1)
        out += "; all of the sea is white";
    return out;
}

Scene with_threshold(Scene scene, const FoamLaw& law) {
    if (!law.calm())
        scene.foam.threshold = law.threshold;
    return scene;
}

} // namespace seaway::sea
