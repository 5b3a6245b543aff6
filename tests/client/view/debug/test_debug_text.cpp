// SPDX-License-Identifier: Apache-2.0
// How views of numbers are asked for, and what is said where they are asked for wrongly.
#include <gmock/gmock.h>

#include "client/view/debug_views.h"

namespace seaway::client {
namespace {

using testing::HasSubstr;

TEST(DebugText, views_are_found_by_name_and_stand_in_the_order_of_their_numbers) {
    for (const DebugViewInfo& row : debug_view_table()) {
        EXPECT_EQ(&row, &info(row.view)) << row.name;
        const Result<DebugChoice> choice = parse_debug_view(row.name);
        ASSERT_TRUE(choice) << choice.error().message;
        EXPECT_EQ(*choice, DebugChoice{.view = row.view}) << row.name;
        EXPECT_FALSE(row.meaning.empty());
    }
}

TEST(DebugText, what_is_set_is_what_was_written_and_is_written_again) {
    const Result<DebugChoice> all =
        parse_debug_view("map_slope:cascade=1,mip=3,channel=y,gain=4,bias=-0.5,flip=on,legend=off");
    ASSERT_TRUE(all) << all.error().message;
    EXPECT_EQ(*all, (DebugChoice{DebugView::map_slope, 1, 3, {1, 4, -0.5, true}, false}));
    EXPECT_EQ(debug_text(*all),
              "map_slope:cascade=1,mip=3,channel=y,gain=4,bias=-0.5,flip=on,legend=off");
    EXPECT_EQ(parse_debug_view("cascade:2")->cascade, 2) << "a number alone";
    EXPECT_EQ(parse_debug_view("slope:7")->cascade, 7) << "the last of eight";
    EXPECT_EQ(parse_debug_view("slope:cascade=all")->cascade, DebugChoice::unset);
    EXPECT_EQ(parse_debug_view("h0:channel=phase")->colouring.channel, 1);
    EXPECT_EQ(parse_debug_view("height:gain=1e6")->colouring.gain, 1e6);
    EXPECT_EQ(debug_text(*parse_debug_view("cascade:2")), "cascade:cascade=2");
}

TEST(DebugText, a_wrong_key_value_or_range_is_named_with_what_is_allowed) {
    struct Row {
        const char* text;
        std::vector<const char*> said;
    };
    const Row rows[] = {
        {"sea", {"--debug sea: no such view; there are final, height, place", "and all"}},
        {"", {"no such view"}},
        {"normal:1", {"normal has no key '1'", "channel=x|y|z"}},
        {"slope:mip=3",
         {"--debug slope:mip=3: slope has no key 'mip'; its keys are cascade=0..7|all, "
          "channel=x|y, "
          "gain=1e-06..1e+06"}},
        {"cascade:8", {"cascade '8': it is 0..7; keys of cascade: cascade=0..7,"}},
        {"cascade:-1", {"cascade '-1'"}},
        {"cascade:", {"cascade has no key ''"}},
        {"cascade:cascade=all", {"cascade 'all': it is 0..7;"}},
        {"slope:cascade=", {"cascade ''", "0..7|all"}},
        {"slope:cascade=1.5", {"cascade '1.5'"}},
        {"slope:cascade=1,", {"slope has no key ''"}},
        {"slope:gain", {"gain '': it is 1e-06..1e+06"}},
        {"slope:gain=0", {"gain '0'"}},
        {"slope:gain=nan", {"gain 'nan'"}},
        {"slope:gain=2x", {"gain '2x'"}},
        {"slope:gain=1,gain=2", {"gain stands twice"}},
        {"height:bias=2e6", {"bias '2e6': it is -1e+06..1e+06"}},
        {"density:bias=1", {"density has no key 'bias'"}},
        {"height:channel=x", {"height has no key 'channel'"}},
        {"slope:channel=z", {"channel 'z': it is x|y"}},
        {"map_slope:mip=11", {"mip '11': it is 0..10"}},
        {"sky_sea:mip=6", {"mip '6': it is 0..5"}},
        {"slope:flip=1", {"flip '1': it is on|off"}},
        {"slope:legend=no", {"legend 'no': it is on|off"}},
        {"final:gain=2", {"final has no key 'gain'; it has none"}},
    };
    for (const Row& row : rows) {
        const Result<DebugChoice> choice = parse_debug_view(row.text);
        ASSERT_FALSE(choice) << row.text;
        EXPECT_EQ(choice.error().message.find('\n'), std::string::npos) << "one line";
        for (const char* said : row.said)
            EXPECT_THAT(choice.error().message, HasSubstr(said));
    }
}

TEST(DebugText, a_cascade_or_a_level_that_this_sea_does_not_have_is_named) {
    const int points[] = {256, 64};
    const auto said = [&](const char* text) {
        const Result<void> fits = check_debug(*parse_debug_view(text), points, 2);
        return fits ? std::string("fine") : fits.error().message;
    };
    EXPECT_EQ(said("slope"), "fine");
    EXPECT_EQ(said("slope:1"), "fine");
    EXPECT_EQ(said("slope:2"), "--debug slope:cascade=2: cascade 2: this sea has 2, 0..1");
    EXPECT_EQ(said("map_slope:mip=9"), "fine") << "512 nodes";
    EXPECT_EQ(said("map_slope:mip=10"),
              "--debug map_slope:mip=10: mip 10: this map of cascade 0 has "
              "512 x 512 texels, levels 0..9");
    EXPECT_EQ(said("map_displacement:mip=8"), "fine");
    EXPECT_THAT(said("map_displacement:mip=9"), HasSubstr("256 x 256 texels, levels 0..8"));
    EXPECT_THAT(said("map_displacement:cascade=1,mip=7"), HasSubstr("cascade 1 has 64 x 64"));
}

TEST(DebugText, of_all_cascades_or_of_the_longest_tile_where_none_is_named) {
    EXPECT_LT(shown_cascade(*parse_debug_view("slope"), 3), 0);
    EXPECT_EQ(shown_cascade(*parse_debug_view("slope:1"), 3), 1);
    EXPECT_EQ(shown_cascade(*parse_debug_view("cascade"), 3), 0);
    EXPECT_EQ(shown_cascade(*parse_debug_view("map_foam"), 3), 0);
    EXPECT_EQ(shown_cascade(*parse_debug_view("map_foam:2"), 3), 2);
}

} // namespace
} // namespace seaway::client
