// SPDX-License-Identifier: Apache-2.0
// The sheet of all views.
#include <set>

#include <gmock/gmock.h>

#include "client/view/debug/contact_sheet.h"
#include "tests/client/view/debug/read_label.h"
#include "tests/client/view/renderer_fixture.h"

namespace seaway::client {
namespace {

class SheetTest : public RendererTest {};

TEST_F(SheetTest, every_view_is_on_it_and_has_its_name) {
    SyntheticSea sea(one_wave(0.5, 60, 2));
    const SeaFrame frame = sea.at(2'000'000);
    const Sky& sky = sky_at_hour(12);
    Result<ContactSheet> sheet = ContactSheet::create(*device_, 1703, 1001, 1, {});
    ASSERT_TRUE(sheet) << sheet.error().message;
    const Result<ShownPicture> shown = sheet->draw({frame, sky, ""}, camera_);
    ASSERT_TRUE(shown) << shown.error().message;
    EXPECT_EQ(shown->width, 1703) << "as was asked for";
    EXPECT_EQ(shown->height, 1001);
    const std::vector<DebugChoice> views = sheet_views(1);
    const SheetGrid grid = sheet_grid(views.size(), 1703, 1001);
    std::set<DebugView> seen;
    for (std::size_t i = 0; i < views.size(); ++i) {
        const int place = static_cast<int>(i);
        const std::string label = read_text(*shown, place % grid.columns * grid.cell_width + 2,
                                            place / grid.columns * grid.cell_height + 2, 1);
        EXPECT_THAT(label, testing::StartsWith(debug_text(views[i])));
        const bool untold = views[i].view == DebugView::h0 || views[i].view == DebugView::h;
        EXPECT_EQ(label.ends_with("not told"), untold) << label << ": there is no scene";
        seen.insert(views[i].view);
    }
    EXPECT_EQ(seen.size(), debug_views);
}

TEST_F(SheetTest, what_has_no_room_is_refused) {
    const Result<ContactSheet> small = ContactSheet::create(*device_, 80, 60, 3, {});
    ASSERT_FALSE(small);
    EXPECT_THAT(small.error().message,
                testing::HasSubstr("80 x 60 pixels: each takes at least 16 x 16"));
}

TEST(SheetGrid, holds_all_views_in_cells_as_wide_as_pictures) {
    for (const auto& [width, height] : {std::pair(1920, 1080), {1000, 1000}, {2400, 600}}) {
        const SheetGrid grid = sheet_grid(37, width, height);
        EXPECT_GE(grid.columns * grid.rows, 37);
        EXPECT_LE(grid.columns * grid.cell_width, width);
        EXPECT_LE(grid.rows * grid.cell_height, height);
        EXPECT_NEAR(static_cast<double>(grid.cell_width) / grid.cell_height, 16.0 / 9, 0.4);
    }
}

} // namespace
} // namespace seaway::client
