// SPDX-License-Identifier: Apache-2.0
#include "client/view/debug/debug_pictures.h"

#include <fmt/format.h>

namespace seaway::client {

namespace {

/// Keyframes' ages, and levels of maps.
std::vector<std::string> notes_of(const DebugMoment& moment, const DebugChoice& choice) {
    std::vector<std::string> notes;
    const std::vector<CascadeFrame>& cascades = moment.frame.cascades;
    const int shown = shown_cascade(choice, static_cast<int>(cascades.size()));
    if (choice.view == DebugView::age)
        for (std::size_t c = 0; c < cascades.size(); ++c) {
            if (shown >= 0 && shown != static_cast<int>(c))
                continue;
            const auto ms = [](sea::TimeUs us) { return 1e-3 * static_cast<double>(us); };
            notes.push_back(fmt::format("cascade {}: {:.0f} of {:.0f} ms", c,
                                        ms(moment.frame.time_us - cascades[c].before_us()),
                                        ms(cascades[c].after_us() - cascades[c].before_us())));
        }
    return notes;
}

} // namespace

Result<void> check_debug(const DebugChoice& choice, const SeaFrame& frame,
                         const RenderOptions& options) {
    std::vector<int> points;
    for (const CascadeFrame& cascade : frame.cascades)
        points.push_back(cascade.points());
    return check_debug(choice, points, options.quality.nodes_a_point);
}

Result<Picture> DebugPictures::numbers(Renderer& renderer, const DebugMoment& moment,
                                       const Camera& camera, const DebugChoice& choice) {
    SEAWAY_TRY(check_debug(choice, moment.frame, renderer.options()));
    table_ = {};
    if (!is_table(choice))
        return renderer.render(moment.frame, camera, moment.sky, choice);
    SEAWAY_TRY_LET(table_, tables_.table(choice, moment));
    return spread(table_, renderer.drawn_width(), renderer.drawn_height());
}

Display DebugPictures::display(const DebugMoment& moment, const DebugChoice& choice,
                               double exposure) const {
    return {.view = choice.view,
            .exposure = exposure,
            .significant_height_m = moment.frame.significant_height_m,
            .bloom = moment.bloom,
            .colouring = choice.colouring,
            .largest = is_table(choice) ? table_.largest : largest_number(moment.frame, choice)};
}

Result<ShownPicture> DebugPictures::develop(Renderer& renderer, const Picture& numbers,
                                            const DebugMoment& moment, const DebugChoice& choice,
                                            double exposure, bool brief) {
    Result<ShownPicture> shown = renderer.develop(numbers, display(moment, choice, exposure));
    if (shown)
        lay_over(*shown, legend(moment, choice, shown->width, shown->height, brief));
    return shown;
}

Legend DebugPictures::legend(const DebugMoment& moment, const DebugChoice& choice, int width,
                             int height, bool brief) const {
    const int cascades = static_cast<int>(moment.frame.cascades.size());
    LegendText text{.choice = choice,
                    .display = display(moment, choice, 1),
                    .cascade = shown_cascade(choice, cascades),
                    .cascades = cascades,
                    .time_s = sea::seconds_from_us(moment.frame.time_us),
                    .notes = notes_of(moment, choice),
                    .brief = brief};
    if (is_table(choice)) {
        text.flat = true;
        text.area = flat_area(table_.columns, table_.rows, width, height);
        text.across = table_.across;
        text.up = table_.up;
    } else if (info(choice.view).source == DebugSource::map) {
        const double length_m =
            moment.frame.cascades[static_cast<std::size_t>(text.cascade)].spec.length_m;
        text.flat = true;
        text.area = flat_area(1, 1, width, height);
        text.across = fmt::format("0 .. {:.4g} m east", length_m);
        text.up = fmt::format("{:.4g} m north", length_m);
    }
    return make_legend(text, width, height);
}

} // namespace seaway::client
