// SPDX-License-Identifier: Apache-2.0
// DebugPictures: any view, drawn or worked out, as numbers, as bytes with its legend, and all of them on one sheet.
//
//     DebugPictures pictures;
//     const Result<Picture> numbers = pictures.numbers(renderer, moment, camera, choice);
//     const Result<ShownPicture> shown = pictures.develop(renderer, *numbers, moment, choice, exposure);
//
// Not thread-safe.
#pragma once

#include "client/view/debug/tables.h"
#include "client/view/renderer.h"

namespace seaway::client {

class DebugPictures {
  public:
    /// As they are drawn, of the renderer's drawn size. Errors: see check_debug(), DebugTables and Renderer.
    Result<Picture> numbers(Renderer& renderer, const DebugMoment& moment, const Camera& camera,
                            const DebugChoice& choice);
    /// How the numbers that were made last are shown.
    Display display(const DebugMoment& moment, const DebugChoice& choice, double exposure) const;
    /// Bytes with the legend; brief: of one with a label (LegendText::brief).
    Result<ShownPicture> develop(Renderer& renderer, const Picture& numbers,
                                 const DebugMoment& moment, const DebugChoice& choice,
                                 double exposure, bool brief = false);
    /// For a picture of this size.
    Legend legend(const DebugMoment& moment, const DebugChoice& choice, int width, int height,
                  bool brief = false) const;

  private:
    DebugTables tables_;
    FlatTable table_; ///< that was made last; of what is drawn empty
};

/// Are these numbers not drawn, but tables?
inline bool is_table(const DebugChoice& choice) {
    return info(choice.view).source == DebugSource::table;
}

/// An error names a cascade or a level that this sea does not have.
Result<void> check_debug(const DebugChoice& choice, const SeaFrame& frame,
                         const RenderOptions& options);

} // namespace seaway::client
