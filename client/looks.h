// SPDX-License-Identifier: Apache-2.0
// What engines ask of a sea beside heights: where answers come from, the water at a point with its displacement, Jacobian
// and foam, waves that are too short left out, whole maps. Client has the calls; here are their words and their arithmetic.
//
// Pure; thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/held/keyframe_ring.h"
#include "client/link/connection.h"
#include "sea/surface/inverse.h"

namespace seaway::client {

enum class AnswersFrom { server = 0, tiles = 1, spectrum = 2, parameters = 3 };

struct SourceNow {
    AnswersFrom source = AnswersFrom::server;
    std::string why;
};

using sea::Looking;
/// The cascades of a sea that are left.
std::uint32_t felt_cascades(const SeaState& state, const Looking& looking);

/// Fails where cascades were chosen and the sea has none of them: that is a mistake, and no flat sea.
Result<void> check_cascades(const SeaState& state, const Looking& looking);

/// Of a sea of which nothing is felt. `terms`: one a point, or none.
void lie_flat(std::span<const sea::QueryPoint> points, std::span<sea::Answer> answers,
              std::span<sea::ErrorTerms> terms);

struct Water {
    sea::Answer answer;
    double displacement_m[2] = {0, 0};
    double displacement_error_m = 0; ///< bound on each, to first order; infinite next to a fold
    double jacobian = 1;
    double foam = 0; ///< share that is white; NaN where none is held
    bool foam_late =
        false; ///< and so the answer is flagged, once it is known how stale it is itself
};

/// The water at depths, one of each a point.
struct Below {
    std::vector<sea::Answer> answers; ///< the surface above
    std::vector<sea::WaterBelow> water;
};

/// What of the water follows from its waves: needs `water.answer`. Displacement and Jacobian are NaN where the sheet of the
/// answer is not found. `blur_m`: bound on what lambda D is off by. Where the water lay before it was moved; nothing: not found.
std::optional<sea::Vec2> put_movement(const sea::QueryPoint& point,
                                      const sea::InverseOptions& options,
                                      sea::LagrangianField field, double blur_m, Water& water);

/// The foam maps of one moment.
class HeldFoam {
  public:
    HeldFoam(const SeaState& state, const KeyframeRing& ring, sea::TimeUs time_us);
    /// By the rule of docs/foam.md, at an undisplaced place. NaN: nothing is held.
    double at(sea::Vec2 place_m) const;
    /// What is held is of another time, some of it.
    bool is_beyond() const { return beyond_; }

  private:
    std::vector<KeyframePair> pairs_;
    bool beyond_ = false;
    sea::TimeUs time_us_;
    double mean_;
};

/// The ratio of a foam map at an undisplaced place: linear in space and time.
double foam_ratio(const KeyframePair& pair, sea::TimeUs time_us, sea::Vec2 place_m);

/// A cascade at one time, at its grid points.
struct CascadeMap {
    std::uint32_t epoch = 0;
    int size = 0;
    double length_m = 0;
    double error_m = 0;              ///< bound on each height; 0 where nothing but foam is told
    double displacement_error_m = 0; ///< and on each component of D
    double foam_mean = 0;            ///< what ratios of foam are to, then
    std::uint32_t flags = 0;         ///< answer_extrapolated, answer_stale: they are none
    std::vector<float> values;       ///< [y][x][channel]
};

} // namespace seaway::client
