// SPDX-License-Identifier: Apache-2.0
// CoursePhases: at which phases the waves of a change begin, where they run otherwise than at the beginning of the sea
// (another depth, gravity, surface tension; stylised waves). Phases then hang on all changes before, and are found from
// clocks alone, without amplitudes: some 5 ms a change from the nearest one that is kept. Those of phases_kept changes are,
// spread over the log, 3 MB each at three cascades of 256 x 256.
//
// Thread-safe, but for before(), which is called by one thread at a time.
#pragma once

#include <map>
#include <mutex>
#include <span>
#include <vector>

#include "base/result.h"
#include "sea/scene/scene.h"
#include "sea/waves/realization.h"

namespace seaway::server {

inline constexpr std::size_t phases_kept = 8;

/// A change on the way from known phases to those that are wanted.
struct PhaseStep {
    std::size_t change; ///< its number
    const sea::Scene* scene;
    sea::TimeUs start_us;
    sea::TimeUs end_us;
    bool takes_over; ///< from a glide that has not ended
};

class CoursePhases {
  public:
    /// Clocks of the sea behind this change; null: they are to be found.
    sea::RealizationPtr of(std::size_t change) const;
    /// Clocks of the sea that runs when the last step begins, from those when the first one does. The steps before the last
    /// one are kept.
    Result<sea::RealizationPtr> before(sea::RealizationPtr clocks,
                                       std::span<const PhaseStep> steps);

  private:
    void keep(std::size_t change, sea::RealizationPtr clocks);

    mutable std::mutex mutex_; ///< of what follows
    std::map<std::size_t, sea::RealizationPtr> kept_;
};

/// Of a scene's sea with phases of its own.
Result<sea::RealizationPtr> own_clocks(const sea::Scene& scene);

} // namespace seaway::server
