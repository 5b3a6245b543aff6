// SPDX-License-Identifier: Apache-2.0
// What is answered where points were solved as a block. Normals and bounds are worked out for two points at once: of one alone,
// roots and quotients each wait for the one before.
#include <algorithm>

#include "sea/surface/steepness.h"
#include "sea/surface/surface.h"
#include "sea/surface/surface_at_time.h"

namespace seaway::sea {

namespace {

/// A number of each of two points, side by side: what every machine has registers for. Wider ones are put together in memory where it
/// has none, which takes longer than what they save.
typedef double Two __attribute__((vector_size(16)));

double of_lane(double value, std::size_t) {
    return value;
}
[[gnu::always_inline]] inline double of_lane(const Two& values, std::size_t p) {
    return values[p];
}

/// Of one point of a block.
struct OneLane {
    using Real = double;
    const PointBlock& points;
    std::size_t p;

    static constexpr std::size_t count = 1;
    Real channel(const float (&rows)[PointBlock::size][4], int c) const {
        return static_cast<double>(rows[p][c]);
    }
    Real each(const float (&values)[PointBlock::size]) const {
        return static_cast<double>(values[p]);
    }
    Real each(const double (&values)[PointBlock::size]) const { return values[p]; }
};

/// Of the one at p and the next; what is beyond the last point means nothing.
struct TwoLanes {
    using Real = Two;
    const PointBlock& points;
    std::size_t p;

    static constexpr std::size_t count = 2;
    [[gnu::always_inline]] Real channel(const float (&rows)[PointBlock::size][4], int c) const {
        return Real{rows[p][c], rows[p + 1][c]};
    }
    [[gnu::always_inline]] Real each(const float (&v)[PointBlock::size]) const {
        return Real{v[p], v[p + 1]};
    }
    [[gnu::always_inline]] Real each(const double (&v)[PointBlock::size]) const {
        return Real{v[p], v[p + 1]};
    }
};

} // namespace

/// Heights, normals and bounds. `to` has one answer a point of the block.
template <class Some>
void Surface::tell(const Some& some, const AtTime& then, Answer* const* to) const {
    using spline_channel::height, spline_channel::displacement_x, spline_channel::displacement_y;
    using Real = typename Some::Real;
    const PointBlock& points = some.points;
    const Gradients<Real> gradients{
        some.channel(points.d_dx, height), some.channel(points.d_dy, height),
        some.channel(points.d_dx, displacement_x), some.channel(points.d_dy, displacement_y),
        0.5 * (some.channel(points.d_dy, displacement_x) +
               some.channel(points.d_dx, displacement_y))};
    const Normal<Real> raised = normal_of(gradients, choppiness_);
    const Normal<Real> normal = upright(raised);
    const Real slope = gentle_slope(raised);
    const Real residual_m = some.each(points.residual_m);
    const auto between = [&](std::size_t c) {
        return Between<Real>{between_samples(some.each(points.fraction_x[c])),
                             between_samples(some.each(points.fraction_y[c]))};
    };
    const Real error_m = residual_m * slope + bent_m(error_.curvature_per_m, residual_m, raised.z) +
                         height_bound_m<Real>(between, then, slope * sideways_);
    const std::size_t end = std::min(some.p + some.count, static_cast<std::size_t>(points.count));
    for (std::size_t p = some.p; p < end; ++p) {
        Answer& answer = *to[p];
        answer.height_m = static_cast<double>(points.value[p][height]);
        answer.normal[0] = of_lane(normal.x, p - some.p);
        answer.normal[1] = of_lane(normal.y, p - some.p);
        answer.normal[2] = of_lane(normal.z, p - some.p);
        answer.error_m = of_lane(error_m, p - some.p);
        answer.flags = then.flags;
    }
}

void Surface::gentle(const PointBlock& points, const AtTime* const* then, Answer* const* to) const {
    const auto count = static_cast<std::size_t>(points.count);
    for (std::size_t p = 0; p < count; p += 2)
        if (p + 1 < count && then[p] == then[p + 1])
            tell(TwoLanes{points, p}, *then[p], to);
        else
            for (std::size_t one = p; one < std::min(p + 2, count); ++one)
                tell(OneLane{points, one}, *then[one], to);
}

ErrorTerms Surface::gentle_terms(const PointBlock& points, std::size_t p, const AtTime& then,
                                 const Answer& answer) const {
    const OneLane lane{points, p};
    const double slope = surface_slope(answer);
    ErrorTerms terms = terms_of(
        [&](std::size_t c) {
            return Between<double>{between_samples(lane.each(points.fraction_x[c])),
                                   between_samples(lane.each(points.fraction_y[c]))};
        },
        then, slope * sideways_);
    terms.inverse_m = std::max(answer.error_m - terms.sum_m(), 0.0); // the rest
    return terms;
}

} // namespace seaway::sea
