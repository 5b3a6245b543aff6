// SPDX-License-Identifier: Apache-2.0
// From the undisplaced sea to the surface above a world point: solves X + lambda D(X) = x and turns
// the solution into height, normal and velocity.
//
// Damped Newton with the analytic gradient of D from X = x; it converges quadratically wherever the
// surface does not fold (hard cases D2, D4). Whether another sheet may lie near is then asked of the
// bounds that come with the field; where it may, all of them are found (sea/surface/sheets.h) and the
// highest one is the answer (D3). Flagged answer_folded: several sheets, or so near the edge of a fold
// that the field's own error leaves open whether there are; answer_open as well: or which is the highest. Normals from the cross product of the two
// tangents (traps T44, F16).
//
// Thread-safe. Cost: 3-6 evaluations; where sheets are looked for 20 to 200 more, and memory.
#pragma once

#include <optional>
#include <type_traits>

#include "sea/basics/lagrangian_point.h"
#include "sea/surface/answer.h"
#include "sea/surface/fold_suspicion.h"
#include "sea/surface/sheets.h"
#include "sea/waves/realization.h"
#include "sea/waves/reference.h"

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

/// Where the direct sum is searched for further sheets (hard case D3). Maps know their own roughness
/// and are searched wherever it says so.
struct FoldSearch {
    double reach_m = 10.0; ///< as far as points move sideways: six standard deviations
    /// The sea folds so often that no answer goes without the search: what Newton meets on its way
    /// says too little.
    bool always = false;
};

/// Folds are common where lambda times the rms strain is above this: on 2 % of a long-crested sea,
/// Phi(-1 / 0.5) (I18). In deep water the rms strain is the rms slope.
inline constexpr double folds_common_above = 0.5;
/// The share of places above which a sea has several sheets, at most. Wherever there are several, one of
/// them is turned over, and turned sheets cover E[max(-J, 0)] of the world. With `squeeze` s, lambda times
/// the rms strain (in deep water the rms slope), that is s phi(1/s) - Phi(-1/s) in a long-crested Gaussian
/// sea, where J = 1 + s z (I18), and less where crests are short.
double folded_share(double squeeze);
/// Above this every exact answer is searched. Below, several sheets stand above one place of 2e7, and
/// only those are overlooked where Newton does not meet the next one.
inline constexpr double folds_searched_above = 0.21;

/// Of a sea whose points move `reach_m` sideways at most. `rms_strain` as in ErrorBudget.
FoldSearch fold_search(double reach_m, const Choppiness& choppiness, double rms_strain);

/// What is known of a field beyond its value at a point.
class SheetBounds : public SheetField {
  public:
    /// Where solutions other than `root` may lie; nothing: there are none. `suspected`: J came close
    /// to zero on the way to it. Without a root: where any solution may lie.
    virtual std::optional<Box> others(Vec2 target, const Vec2* root, bool suspected) = 0;
    virtual double blur_m() const = 0;        ///< error of lambda D
    virtual double strain_blur() const = 0;   ///< error of lambda grad D
    virtual double height_blur_m() const = 0; ///< error of heights
    /// What is solved in the end is no longer wrong by the blur: it settles what the search left open.
    virtual bool newton_decides() const { return false; }
};

/// What a field is off by from the sea that is meant, at any place: bounds. All 0: it is that sea.
struct FieldBlur {
    double height_m = 0;
    double displacement_m = 0; ///< of a component of D
    double strain = 0;         ///< of grad D
};

struct InverseOptions {
    Choppiness choppiness;
    double tolerance_m = 1e-4; ///< residual |X + lambda D(X) - x| that counts as solved
    FoldSearch folds;
    double curvature_per_m =
        0; ///< of the surface at choppiness 0, at most; 0: solved so well that it says nothing
    FieldBlur blur = {}; ///< of a moment: other sheets may lie where it does not tell
};

/// Height, normal, velocity and flags at the point; error_m holds what the residual leaves alone, the
/// caller adds what its maps cost. A point that is not finite gives NaN and answer_invalid.
/// `sheets` knows where other sheets may lie; without it the first one found is the answer, and
/// flagged where J came below fold_suspected_below on the way. `lagrangian` gets the undisplaced place
/// of the answer, `area` the Jacobian there; of what is no point nothing.
Answer surface_at(const QueryPoint& point, const InverseOptions& options, LagrangianField field,
                  SheetBounds* sheets = nullptr, Vec2* lagrangian = nullptr,
                  double* area = nullptr);

/// The exact sum, with all of its sheets (sea/surface/moment_sheets.h).
Answer surface_at(const QueryPoint& point, const InverseOptions& options,
                  const DirectSum::Moment& moment, Vec2* lagrangian = nullptr,
                  double* area = nullptr);

/// What counts as solved of the exact sum, m: a nanometre, and what rounding leaves of places far out. There one step of the
/// place's last digit moves the residual by as many as the surface is squeezed, some in a sea that folds.
double exact_tolerance_m(const QueryPoint& point);

/// Above what is no point: NaN, answer_invalid.
Answer invalid_answer();

/// Height, normal and velocity of what solves the equation; flags and error are nothing yet.
Answer answer_of(const LagrangianPoint& point, const Choppiness& choppiness);

/// The steepness of the answered surface, |grad eta| in world coordinates, capped at 10.
double surface_slope(const Answer& answer);

/// det(I + lambda grad D).
double jacobian(const LagrangianPoint& point, const Choppiness& choppiness);

} // namespace seaway::sea
