// SPDX-License-Identifier: Apache-2.0
// RunningSea: one sea with everything that is derived from it once: the realised modes, the error budget, what may be
// asked for, and the exact sum. It is steady, or a glide from one sea to another (sea/waves/transition.h).
// Immutable; thread-safe; share it by pointer.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "sea/basics/field.h"
#include "sea/certificate/certificate.h"
#include "sea/foam/foam_glide.h"
#include "sea/foam/foam_law.h"
#include "sea/scene/scene.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/waves/realization.h"
#include "sea/waves/reference.h"
#include "sea/waves/statistics/moments.h"
#include "sea/waves/transition.h"

namespace seaway::server {

/// On the way to a sea.
struct SeaGlide {
    sea::SeaTransition change;
    sea::Choppiness choppiness;                 ///< that it began with
    sea::SeaStatistics realised;                ///< likewise
    double foam_mean = 0;                       ///< likewise
    std::shared_ptr<const sea::FoamGlide> foam; ///< null where the scene allows no foam
};

struct RunningSea {
    std::uint32_t epoch;
    sea::Scene scene; ///< of a glide, as all up to the budget: of where it leads
    sea::RealizationPtr realization;
    sea::ErrorBudget budget; ///< of a glide: holds for each of its moments
    sea::FieldSet offered;   ///< by the scene's effects
    sea::SeaSummary summary;
    std::shared_ptr<const sea::DirectSum> truth;     ///< of `realization`
    sea::FoamLawPtr foam_law;                        ///< null where the scene allows no foam
    sea::CertificatePtr certificate;                 ///< null where the scene names none
    std::shared_ptr<const SeaGlide> glide = nullptr; ///< null: steady

    /// Waves are between those of two seas.
    bool glides_at(sea::TimeUs time_us) const {
        return glide && time_us > glide->change.start_us() && time_us < glide->change.end_us();
    }
    /// The waves of one moment; `realization` for ever where the sea is steady. A glide: about 1 ms a cascade of 256 x 256.
    sea::RealizationPtr waves_at(sea::TimeUs time_us) const {
        return glide ? glide->change.gliding(time_us) : realization;
    }
    /// Their exact sum; a glide, with what it grows by in the rates: about 30 ms.
    std::shared_ptr<const sea::DirectSum> truth_at(sea::TimeUs time_us) const {
        return glide ? std::make_shared<const sea::DirectSum>(waves_at(time_us),
                                                              glide->change.growing_at(time_us))
                     : truth;
    }
    sea::Choppiness choppiness_at(sea::TimeUs time_us) const;
    /// What maps of foam are ratios to; 0 where there is none.
    double foam_mean_at(sea::TimeUs time_us) const;
    /// Null where the scene allows no foam.
    sea::FoamLawPtr foam_law_at(sea::TimeUs time_us) const {
        return glide && glide->foam ? glide->foam->at(time_us) : foam_law;
    }

    /// By which all of its waves run; none: waves that follow no law, or a glide.
    std::optional<sea::WaveLaw> wave_law() const;

    /// What subscribers and fetches may have: none where the scene answers questions alone.
    sea::FieldSet streamed() const { return scene.accuracy.streams() ? offered : sea::FieldSet{}; }

    /// What a sampler needs of a keyframe of this sea.
    sea::FieldSet sampler_fields() const { return sea::surface_fields & offered; }
};

using RunningSeaPtr = std::shared_ptr<const RunningSea>;

/// Realises the scene and reads its certificate. An error is one line that names what in the scene
/// cannot be had; that its waves are beyond what a client takes is one.
Result<RunningSeaPtr> make_running_sea(const sea::Scene& scene, std::uint32_t epoch);

/// The same of a scene that is realised already, and possibly changed since, with this certificate. Reads no file, and refuses
/// nothing: what is beyond what a client takes is told as the most that it takes.
RunningSeaPtr make_running_sea(const sea::Scene& scene, std::uint32_t epoch,
                               sea::RealizationPtr realization, sea::CertificatePtr certificate);

/// Are the waves of this scene ones that a client takes? Those of winds and swells alone on usual grids are. Cost: of others, that
/// of make_running_sea().
Result<void> check_tellable(const sea::Scene& scene);

/// From the waves of `from` at `start_us` to `to`, which is steady and has its own phases; the glide ends in
/// glide->change.after(). Keyframes lie as densely as those of either. An error says why they cannot be joined.
Result<RunningSeaPtr> make_glide(const RunningSea& from, const RunningSea& to, std::uint32_t epoch,
                                 sea::TimeUs start_us, sea::TimeUs end_us);

/// What a user should know of this sea: of its scene, its foam and its certificate.
std::vector<std::string> warnings_of(const RunningSea& sea);

} // namespace seaway::server
