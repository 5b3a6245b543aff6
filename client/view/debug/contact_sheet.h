// SPDX-License-Identifier: Apache-2.0
// ContactSheet: every view of a moment in one picture, each with its name, in rows and columns. Not thread-safe.
#pragma once

#include "client/view/debug/debug_pictures.h"
#include "client/view/sky/look.h"

namespace seaway::client {

/// What stands on a sheet of a sea of so many cascades: each view as it is by default, phases, and what is of one
/// cascade for each.
std::vector<DebugChoice> sheet_views(int cascades);

/// Rows and columns whose cells are as near to 16 : 9 as can be.
struct SheetGrid {
    int columns = 1, rows = 1;
    int cell_width = 1, cell_height = 1; ///< pixels
};
SheetGrid sheet_grid(std::size_t views, int width, int height);

class ContactSheet {
  public:
    /// For a sea of so many cascades. An error: cells of fewer than 16 pixels a side, or the device.
    static Result<ContactSheet> create(gpu::Device& device, int width, int height, int cascades,
                                       const RenderOptions& options);

    /// Of the look its exposure: where it is metered, by the picture itself. A view that cannot be shown, because the server does not tell its
    /// scene, says so in its place.
    Result<ShownPicture> draw(const DebugMoment& moment, const Camera& camera,
                              const Look& look = {});

  private:
    ContactSheet(Renderer renderer, SheetGrid grid, int width, int height, int cascades)
        : renderer_(std::move(renderer)), grid_(grid), width_(width), height_(height),
          views_(sheet_views(cascades)) {}

    Renderer renderer_; ///< of a cell
    DebugPictures pictures_;
    SheetGrid grid_;
    int width_, height_;
    std::vector<DebugChoice> views_;
};

} // namespace seaway::client
