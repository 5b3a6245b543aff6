// SPDX-License-Identifier: Apache-2.0
#include "client/view/debug_views.h"

#include <algorithm>

namespace seaway::client {

namespace {

using enum DebugSource;
using enum DebugViewInfo::Cascades;

constexpr int map_mip_max = 10; ///< of 1024 nodes a side

const Scale signed_1{&signed_palette, -1, 1};
const Scale grey_1{&grey_palette, 0, 1};
const Scale heights{&signed_palette, -0.5, 0.5, Spacing::linear, ScaleOf::significant_height};
const Scale tens{&cyclic_palette, 0, 10, Spacing::repeated};
const Scale jacobians{&grey_palette, 0, 2};
const Scale roughnesses{&heat_palette, 0, 0.4};
const Scale light_seen{&grey_palette, 0, 1, Spacing::root, ScaleOf::largest};
const Scale amplitudes{&even_palette, 1e-6, 1, Spacing::logarithmic, ScaleOf::largest};
const Scale angles{&cyclic_palette, -3.14159265, 3.14159265};
const Scale to_largest{&even_palette, 0, 1, Spacing::linear, ScaleOf::largest};

const std::array<DebugViewInfo, debug_views> view_rows{{
    {DebugView::final, "final", light, "the picture; EXR: radiance, kcd/m2"},
    {DebugView::height, "height", sea, "height above the mean sea", {{{"height", "m", heights}}}},
    {DebugView::place,
     "place",
     sea,
     "undisplaced place east and north of the camera, height above the mean sea",
     {{{"x", "m", tens}, {"y", "m", tens}, {"z", "m", tens}}},
     true},
    {DebugView::normal,
     "normal",
     sea,
     "unit normal, filtered over the pixel: east, north, up",
     {{{"x", "", signed_1}, {"y", "", signed_1}, {"z", "", signed_1}}},
     true},
    {DebugView::slope,
     "slope",
     sea,
     "slope of the surface, east and north",
     {{{"x", "", signed_1}, {"y", "", signed_1}}},
     true,
     all_or_one},
    {DebugView::jacobian,
     "jacobian",
     sea,
     "determinant of the summed gradients; below 0 the surface folds",
     {{{"J", "", jacobians}}},
     false,
     all_or_one,
     -1,
     true},
    {DebugView::roughness,
     "roughness",
     sea,
     "rms slope of the waves that the pixel does not resolve",
     {{{"rms slope", "", roughnesses}}},
     false,
     all_or_one},
    {DebugView::foam,
     "foam",
     sea,
     "share of the pixel that is white; of one cascade what its history says alone",
     {{{"share", "", grey_1}}},
     false,
     all_or_one},
    {DebugView::cascade,
     "cascade",
     sea,
     "slopes of one cascade alone, undisplaced: cascade:0 is the longest tile",
     {{{"x", "", signed_1}, {"y", "", signed_1}}},
     true,
     one},
    {DebugView::grid,
     "grid",
     sea,
     "every 16th row and column of the mesh",
     {{{"line", "", grey_1}}}},
    {DebugView::displacement,
     "displacement",
     sea,
     "how far waves move a point: east, north, up",
     {{{"x", "m", heights}, {"y", "m", heights}, {"z", "m", heights}}},
     true,
     all_or_one},
    {DebugView::gradient,
     "gradient",
     sea,
     "derivatives of the displacement, choppiness included: east by east, north by north, east by "
     "north",
     {{{"xx", "", signed_1}, {"yy", "", signed_1}, {"xy", "", signed_1}}},
     true,
     all_or_one},
    {DebugView::reflected,
     "reflected",
     sea,
     "unit direction that the middle facet of the pixel mirrors: east, north, up",
     {{{"x", "", signed_1}, {"y", "", signed_1}, {"z", "", signed_1}}},
     true},
    {DebugView::density,
     "density",
     sea,
     "pixels of the picture that a cell of the mesh takes",
     {{{"area", "px a cell", {&even_palette, 0.1, 1000, Spacing::logarithmic}}}}},
    {DebugView::wireframe,
     "wireframe",
     sea,
     "edges of the mesh's triangles; grey where they are closer than pixels",
     {{{"edge", "", grey_1}}}},
    {DebugView::age,
     "age",
     sea,
     "time since the keyframe before, to the one after, and between both; of all cascades in "
     "strips, the longest "
     "tile on the left",
     {{{"since", "ms", to_largest}, {"until", "ms", to_largest}, {"interval", "ms", to_largest}}},
     false,
     all_or_one},
    {DebugView::bound,
     "bound",
     sea,
     "stated bound on the error of the height; red: the surface folds, or may for all that maps "
     "say",
     {{{"error", "m", to_largest}}}},
    {DebugView::map_displacement,
     "map_displacement",
     map,
     "displacement of a cascade before choppiness: east, north, up",
     {{{"x", "m", heights}, {"y", "m", heights}, {"z", "m", heights}}},
     true,
     one,
     map_mip_max},
    {DebugView::map_slope,
     "map_slope",
     map,
     "slope of a cascade, east and north",
     {{{"x", "", signed_1}, {"y", "", signed_1}}},
     true,
     one,
     map_mip_max},
    {DebugView::map_gradient,
     "map_gradient",
     map,
     "derivatives of a cascade's displacement, before choppiness",
     {{{"xx", "", signed_1}, {"yy", "", signed_1}, {"xy", "", signed_1}}},
     true,
     one,
     map_mip_max},
    {DebugView::map_jacobian,
     "map_jacobian",
     map,
     "determinant of a cascade alone; below 0 it folds",
     {{{"J", "", jacobians}}},
     false,
     one,
     map_mip_max,
     true},
    {DebugView::map_roughness,
     "map_roughness",
     map,
     "rms slope within a texel: 0 at level 0",
     {{{"rms slope", "", roughnesses}}},
     false,
     one,
     map_mip_max},
    {DebugView::map_foam,
     "map_foam",
     map,
     "share that has broken, by a cascade's history",
     {{{"share", "", grey_1}}},
     false,
     one,
     map_mip_max},
    {DebugView::sky_eye,
     "sky_eye",
     DebugSource::table,
     "what the eye sees above its horizon, without discs and clouds; below it the source of the "
     "air's light",
     {{{"red", "kcd/m2", light_seen},
       {"green", "kcd/m2", light_seen},
       {"blue", "kcd/m2", light_seen}}},
     true},
    {DebugView::sky_sea,
     "sky_sea",
     DebugSource::table,
     "what waves mirror: all around a point of the sea; levels are blurred by 0, 0.04, 0.08 .. "
     "0.64 rad",
     {{{"red", "kcd/m2", light_seen},
       {"green", "kcd/m2", light_seen},
       {"blue", "kcd/m2", light_seen}}},
     true,
     none,
     shaders::sky_mips - 1},
    {DebugView::sky_transmittance,
     "sky_transmittance",
     DebugSource::table,
     "share of light that is left on the way out of the air",
     {{{"red", "", grey_1}, {"green", "", grey_1}, {"blue", "", grey_1}}},
     true},
    {DebugView::sky_scattering,
     "sky_scattering",
     DebugSource::table,
     "light that was scattered more than once, under a sun of 1 klx",
     {{{"red", "kcd/m2", light_seen},
       {"green", "kcd/m2", light_seen},
       {"blue", "kcd/m2", light_seen}}},
     true},
    {DebugView::h0,
     "h0",
     DebugSource::table,
     "amplitudes that the sea is realised with, k = 0 in the middle",
     {{{"magnitude", "m", amplitudes}, {"phase", "rad", angles}}},
     false,
     one},
    {DebugView::h,
     "h",
     DebugSource::table,
     "amplitudes at this time, both ways of travel, k = 0 in the middle",
     {{{"magnitude", "m", amplitudes}, {"phase", "rad", angles}}},
     false,
     one},
}};

} // namespace

std::span<const DebugViewInfo, debug_views> debug_view_table() {
    return view_rows;
}

const DebugViewInfo& info(DebugView view) {
    return view_rows[static_cast<std::size_t>(view)];
}

int DebugViewInfo::channel_count() const {
    return static_cast<int>(std::count_if(channels.begin(), channels.end(),
                                          [](const DebugChannel& c) { return !c.name.empty(); }));
}

bool DebugViewInfo::takes(DebugKey key) const {
    if (source == DebugSource::light)
        return false;
    switch (key) {
    case DebugKey::cascade:
        return cascades != Cascades::none;
    case DebugKey::mip:
        return mip_max >= 0;
    case DebugKey::channel:
        return channel_count() > 1;
    case DebugKey::bias:
        return channels[0].scale.spacing != Spacing::logarithmic;
    case DebugKey::gain:
    case DebugKey::flip:
    case DebugKey::legend:
        break;
    }
    return true;
}

int shown_cascade(const DebugChoice& choice, int cascades) {
    const bool one_alone = info(choice.view).cascades == DebugViewInfo::Cascades::one;
    const int wanted = one_alone ? std::max(choice.cascade, 0) : choice.cascade;
    return std::min(wanted, cascades - 1);
}

} // namespace seaway::client
