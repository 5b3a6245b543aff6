// SPDX-License-Identifier: Apache-2.0
// Numbers of the views that no shader draws: tables of the sky, and the spectrum, flat as they are.
//
// The spectrum is realised here from the scene that the server tells: the same scene gives the same amplitudes. That
// takes some 100 ms, once a scene; what is shown of it some milliseconds. Not thread-safe.
#pragma once

#include "client/view/debug/flat.h"
#include "client/view/debug/legend.h"
#include "client/view/sea/sea_frame.h"
#include "client/view/sky/sky.h"
#include "sea/waves/realization.h"

namespace seaway::client {

/// All that a view of numbers may be of.
struct DebugMoment {
    const SeaFrame& frame;
    const Sky& sky;
    const std::string& scene; ///< effective scene, TOML; empty: the server does not tell it
    double bloom = Display{}.bloom;
};

struct FlatTable {
    int columns = 0, rows = 0;
    std::vector<float> rgba; ///< [row][column][4], row 0 below; alpha as of a Picture
    double largest = 1;      ///< Display::largest
    std::string across, up;  ///< what lies at the right edge, and at the upper one
    bool keeps_peaks =
        false; ///< a pixel that holds several texels shows the one with the largest first channel
};

class DebugTables {
  public:
    /// A view whose source is DebugSource::table. Errors: the scene is not told, or says no cascade as this one.
    Result<FlatTable> table(const DebugChoice& choice, const DebugMoment& moment);

  private:
    Result<FlatTable> spectrum(const DebugChoice& choice, const DebugMoment& moment);

    std::string scene_; ///< that is realised
    sea::RealizationPtr sea_;
};

/// The table in a picture, texels as squares; nothing beside it.
Picture spread(const FlatTable& table, int width, int height);

} // namespace seaway::client
