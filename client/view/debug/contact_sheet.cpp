// SPDX-License-Identifier: Apache-2.0
#include "client/view/debug/contact_sheet.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "client/view/look_file.h"

namespace seaway::client {

namespace {

constexpr int cell_side_min = 16;

void paste(const ShownPicture& cell, ShownPicture& sheet, int left, int top) {
    for (int y = 0; y < cell.height; ++y)
        std::copy_n(&cell.rgba[4 * static_cast<std::size_t>(y * cell.width)], 4 * cell.width,
                    &sheet.rgba[4 * static_cast<std::size_t>((top + y) * sheet.width + left)]);
}

ShownPicture plain(int width, int height) {
    ShownPicture picture{width, height, {}};
    for (int i = 0; i < width * height; ++i)
        for (const double share : {empty_colour.r, empty_colour.g, empty_colour.b, 1.0})
            picture.rgba.push_back(static_cast<std::uint8_t>(std::lround(255 * share)));
    return picture;
}

} // namespace

std::vector<DebugChoice> sheet_views(int cascades) {
    std::vector<DebugChoice> views;
    for (const DebugViewInfo& row : debug_view_table()) {
        DebugChoice view{.view = row.view};
        switch (row.view) {
        case DebugView::foam: // the longest waves leave little
            views.push_back(view);
            view.colouring.gain = 5;
            [[fallthrough]];
        case DebugView::cascade:
            view.colouring.gain = std::max(view.colouring.gain, 3.0);
            for (view.cascade = 0; view.cascade < cascades; ++view.cascade)
                views.push_back(view);
            continue;
        case DebugView::slope:
        case DebugView::gradient:
        case DebugView::map_gradient:
        case DebugView::map_foam:
            view.colouring.gain = 3;
            break;
        case DebugView::map_slope:
            view.colouring.gain = 3;
            views.push_back(view);
            view.mip = 3;
            break;
        case DebugView::map_roughness: // 0 at level 0
            view.mip = 3;
            break;
        case DebugView::sky_sea:
            views.push_back(view);
            view.mip = 3;
            break;
        case DebugView::h0:
        case DebugView::h:
            views.push_back(view);
            view.colouring.channel = 1;
            break;
        default:
            break;
        }
        views.push_back(view);
    }
    return views;
}

SheetGrid sheet_grid(std::size_t views, int width, int height) {
    SheetGrid best;
    double worst = std::numeric_limits<double>::infinity();
    const int count = static_cast<int>(views);
    for (int columns = 1; columns <= count; ++columns) {
        const int rows = (count + columns - 1) / columns;
        const SheetGrid grid{columns, rows, width / columns, height / rows};
        if (grid.cell_width == 0 || grid.cell_height == 0)
            continue;
        const double shape = static_cast<double>(grid.cell_width) / grid.cell_height;
        const double off = std::abs(std::log(shape * 9 / 16));
        if (off < worst) {
            worst = off;
            best = grid;
        }
    }
    return best;
}

Result<ContactSheet> ContactSheet::create(gpu::Device& device, int width, int height, int cascades,
                                          const RenderOptions& options) {
    const SheetGrid grid = sheet_grid(sheet_views(cascades).size(), width, height);
    if (grid.cell_width < cell_side_min || grid.cell_height < cell_side_min)
        return Error{fmt::format("--debug all: {} x {} views in {} x {} pixels: each takes at "
                                 "least {} x {}",
                                 grid.columns, grid.rows, width, height, cell_side_min,
                                 cell_side_min)};
    Result<Renderer> renderer =
        Renderer::create(device, grid.cell_width, grid.cell_height, options);
    if (!renderer)
        return renderer.error();
    return ContactSheet(std::move(*renderer), grid, width, height, cascades);
}

Result<ShownPicture> ContactSheet::draw(const DebugMoment& moment, const Camera& camera,
                                        const Look& look) {
    Camera seen = camera;
    seen.width = grid_.cell_width;
    seen.height = grid_.cell_height;
    ShownPicture sheet = plain(width_, height_);
    for (std::size_t i = 0; i < views_.size(); ++i) {
        const DebugChoice& view = views_[i];
        std::string label = debug_text(view);
        if (view.view == DebugView::final)
            label += fmt::format(", t = {:.3f} s", sea::seconds_from_us(moment.frame.time_us));
        const Result<Picture> numbers = pictures_.numbers(renderer_, moment, seen, view);
        ShownPicture cell = plain(grid_.cell_width, grid_.cell_height);
        if (numbers) {
            const double shown_at =
                exposure_of(look, view.view == DebugView::final
                                      ? metered_exposure(*numbers, moment.sky.white_radiance())
                                      : 1.0);
            SEAWAY_TRY_LET(cell,
                           pictures_.develop(renderer_, *numbers, moment, view, shown_at, true));
        } else if (is_table(view)) {
            label += ": not told";
        } else {
            return numbers.error();
        }
        lay_over(cell, make_label(label, cell.width));
        const int place = static_cast<int>(i);
        paste(cell, sheet, place % grid_.columns * grid_.cell_width,
              place / grid_.columns * grid_.cell_height);
    }
    return sheet;
}

} // namespace seaway::client
