// SPDX-License-Identifier: Apache-2.0
// What the shaders of debug views are told (ViewDebug of shaders/shared/view.h).
#include <algorithm>
#include <cmath>
#include <limits>

#include "client/view/debug/flat.h"
#include "client/view/renderer.h"
#include "sea/surface/maps/hermite.h"

namespace seaway::client {

namespace {

float narrowed(double value) {
    return static_cast<float>(value);
}

shaders::vec4 narrowed(const glm::dvec3& colour, double w) {
    return {narrowed(colour.r), narrowed(colour.g), narrowed(colour.b), narrowed(w)};
}

/// Of a sum of what hangs on the place in different ways.
shaders::vec4 parts_of(const sea::MapLoss::AtTime& loss) {
    return {narrowed(loss.time_m2 + loss.cut_m2), narrowed(loss.east_m2), narrowed(loss.north_m2),
            narrowed(loss.coded_m2)};
}

/// Of a slope of 1 in 2, where and when maps are worst.
double worst_bound_m(const SeaFrame& frame) {
    constexpr double slope = 0.5;
    const double sideways = slope * frame.choppiness.largest();
    return sea::largest_height_bound_m(frame.error, sideways, [&](std::size_t c) {
        return sea::seconds_from_us(frame.cascades[c].after_us() - frame.cascades[c].before_us());
    });
}

void set_cascade(shaders::ViewDebug& out, const SeaFrame& frame, std::size_t c) {
    const CascadeFrame& from = frame.cascades[c];
    const sea::TimeUs before_us = from.before_us();
    const sea::TimeUs after_us = from.after_us();
    constexpr double ms_an_us = 1e-3;
    const auto interval_us = static_cast<double>(after_us - before_us);
    out.keyframe_ms[c] = {narrowed(ms_an_us * static_cast<double>(frame.time_us - before_us)),
                          narrowed(ms_an_us * static_cast<double>(after_us - frame.time_us)),
                          narrowed(ms_an_us * interval_us), 0};
    if (c >= frame.error.cascades.size())
        return;
    const double share =
        interval_us > 0 ? static_cast<double>(frame.time_us - before_us) / interval_us : 0;
    const sea::HermiteWeights weights = sea::hermite_weights(before_us, after_us, frame.time_us);
    const sea::CascadeLoss& loss = frame.error.cascades[c];
    out.height_loss[c] = parts_of(loss.height.at(share, weights));
    out.displacement_loss[c] = parts_of(loss.displacement.at(share, weights));
    out.coded_relief[c] = {narrowed(loss.height.coded_relief),
                           narrowed(loss.displacement.coded_relief), 0, 0};
}

} // namespace

FlatArea flat_area(int columns, int rows, int width, int height) {
    const double texel =
        std::min(static_cast<double>(width) / columns, static_cast<double>(height) / rows);
    FlatArea area;
    area.width = std::max(static_cast<int>(std::lround(texel * columns)), 1);
    area.height = std::max(static_cast<int>(std::lround(texel * rows)), 1);
    area.left = (width - area.width) / 2;
    area.top = (height - area.height) / 2;
    return area;
}

double largest_number(const SeaFrame& frame, const DebugChoice& choice) {
    if (choice.view == DebugView::age) {
        sea::TimeUs longest_us = 1;
        for (const CascadeFrame& cascade : frame.cascades)
            longest_us = std::max(longest_us, cascade.after_us() - cascade.before_us());
        return 1e-3 * static_cast<double>(longest_us);
    }
    if (choice.view == DebugView::bound)
        return worst_bound_m(frame);
    return 1;
}

void set_debug_colours(shaders::ViewDebug& out, const Display& display) {
    const DebugViewInfo& row = info(display.view);
    const ShownChannel shown = shown_channel(display);
    const Palette& palette = shown.scale.palette;
    for (std::size_t i = 0; i < static_cast<std::size_t>(palette.count); ++i)
        out.stop[i] = narrowed(palette.stops[i].colour, palette.stops[i].place);
    out.stops = palette.count;
    out.fold = narrowed(fold_colour, 1);
    out.empty = narrowed(empty_colour, 1);
    out.low = narrowed(shown.scale.low);
    out.high = narrowed(shown.scale.high);
    out.spacing = static_cast<int>(shown.scale.spacing);
    out.flip = shown.scale.flip ? 1 : 0;
    out.channel = shown.channel;
    out.fold_below = row.folds ? 0.0f : std::numeric_limits<float>::lowest();
}

void set_debug(shaders::ViewDebug& out, const SeaFrame& frame, const Camera& camera,
               const DebugChoice& choice) {
    for (std::size_t c = 0; c < frame.cascades.size(); ++c)
        set_cascade(out, frame, c);
    const bool flat = info(choice.view).source == DebugSource::map;
    const FlatArea area = flat ? flat_area(1, 1, camera.width, camera.height)
                               : FlatArea{0, 0, camera.width, camera.height};
    out.area = {narrowed(area.left), narrowed(area.top), narrowed(area.width),
                narrowed(area.height)};
    out.mip = choice.mip;
    out.bound_sigmas = narrowed(sea::bound_sigmas);
    out.height_bound_m = narrowed(frame.error.height_bound_m);
    out.displacement_bound_m = narrowed(frame.error.displacement_bound_m);
    out.fold_blur = narrowed(frame.choppiness.largest() * frame.error.strain_bound +
                             frame.error.codec_strain_bound);
}

} // namespace seaway::client
