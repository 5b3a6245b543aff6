// SPDX-License-Identifier: Apache-2.0
// From the undisplaced sea to the surface above a world point: solves X + lambda D(X) = x and turns
// the solution into height, normal and velocity.
//
// Damped Newton with the analytic gradient of D from X = x; it converges quadratically wherever the
// surface does not fold (hard cases D2, D4). Where the Jacobian came close to zero on the way, and
// everywhere in a sea that folds often (FoldSearch), the line of strongest compression is scanned
// for further sheets and the highest one is the answer (D3). Flagged answer_folded: several sheets
// were found, or J <= 0 where the surface comes down near the point. Normals from the cross product
// of the two tangents (traps T44, F16).
//
// Thread-safe; allocates nothing. Cost: 3-6 evaluations, about 50 where it scans.
#pragma once

#include <type_traits>

#include "sea/basics/lagrangian_point.h"
#include "sea/surface/answer.h"
#include "sea/waves/realization.h"

namespace seaway::sea {

/// Non-owning reference to a callable (X, Y) -> LagrangianPoint.
class LagrangianField {
  public:
    template <class F>
    requires(!std::is_same_v<std::remove_cvref_t<F>, LagrangianField>)
        LagrangianField(const F& field)
        : object_(&field), call_([](const void* object, double x_m, double y_m) {
              return (*static_cast<const F*>(object))(x_m, y_m);
          }) {}
    LagrangianPoint operator()(double x_m, double y_m) const { return call_(object_, x_m, y_m); }

  private:
    const void* object_;
    LagrangianPoint (*call_)(const void*, double, double);
};

/// Where further sheets of the surface are looked for (hard case D3).
struct FoldSearch {
    double reach_m = 10.0; ///< as far apart as sheets can lie: about the largest displacement
    /// The sea folds so often that no answer goes without the search: what Newton meets on its way
    /// says too little.
    bool always = false;
    bool everywhere = false; ///< the sea is a tangle of sheets: every answer counts as folded
};

/// Folds are common where lambda times the rms slope is above this: on 2 % of a long-crested sea,
/// Phi(-1 / 0.5) (I18).
inline constexpr double folds_common_above = 0.5;
/// And everywhere above this: on a sixth of it.
inline constexpr double folds_everywhere_above = 1.0;

/// Of a sea whose points move `reach_m` sideways at most.
FoldSearch fold_search(double reach_m, const Choppiness& choppiness, double rms_slope);

struct InverseOptions {
    Choppiness choppiness;
    double tolerance_m = 1e-4; ///< residual |X + lambda D(X) - x| that counts as solved
    FoldSearch folds;
};

/// Height, normal, velocity and flags at the point; error_m holds residual * slope alone, the
/// caller adds what its maps cost. A point that is not finite gives NaN and answer_invalid.
Answer surface_at(const QueryPoint& point, const InverseOptions& options, LagrangianField field);

/// The steepness of the answered surface, |grad eta| in world coordinates, capped at 10.
double surface_slope(const Answer& answer);

/// det(I + lambda grad D).
double jacobian(const LagrangianPoint& point, const Choppiness& choppiness);

} // namespace seaway::sea
