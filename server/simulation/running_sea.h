// SPDX-License-Identifier: Apache-2.0
// RunningSea: one sea state with everything that is derived from it once: the realised modes, the
// error budget, what may be asked for, and the exact sum. Immutable; share it by pointer.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "sea/basics/field.h"
#include "sea/certificate/certificate.h"
#include "sea/foam/foam_law.h"
#include "sea/scene/scene.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/waves/realization.h"
#include "sea/waves/reference.h"
#include "sea/waves/statistics/moments.h"

namespace seaway::server {

struct RunningSea {
    std::uint32_t epoch;
    sea::Scene scene;
    sea::RealizationPtr realization;
    sea::ErrorBudget budget;
    sea::FieldSet offered; ///< by the scene's effects
    sea::SeaSummary summary;
    sea::DirectSum truth;
    sea::FoamLawPtr foam_law;        ///< null where the scene allows no foam
    sea::CertificatePtr certificate; ///< null where the scene names none

    /// What subscribers and fetches may have: none where the scene answers questions alone.
    sea::FieldSet streamed() const { return scene.accuracy.streams() ? offered : sea::FieldSet{}; }

    /// What a sampler needs of a keyframe of this sea.
    sea::FieldSet sampler_fields() const {
        return sea::FieldSet::from_bits(sea::surface_fields.bits() & offered.bits());
    }
};

using RunningSeaPtr = std::shared_ptr<const RunningSea>;

/// Realises the scene and reads its certificate. An error is one line that names what in the scene
/// cannot be had.
Result<RunningSeaPtr> make_running_sea(const sea::Scene& scene, std::uint32_t epoch);

/// What a user should know of this sea: of its scene, its foam and its certificate.
std::vector<std::string> warnings_of(const RunningSea& sea);

} // namespace seaway::server
