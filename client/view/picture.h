// SPDX-License-Identifier: Apache-2.0
// Picture: linear values as rendered, which EXR keeps, and ShownPicture: what one sees of them, which PNG keeps - lit
// pictures through exposure and a film curve (shaders/view/shown.frag), debug views through their own colours
// (shaders/view/numbers.frag).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "client/view/debug_views.h"
#include "client/view/sky/look.h"
#include "sea/basics/time.h"

namespace seaway::client {

struct Picture {
    int width = 0;
    int height = 0;
    /// [y][x][4], row 0 on top; radiance in kcd/m2 or raw numbers, whose alpha is 0 where there is none, 2 where the
    /// surface folds.
    std::vector<float> rgba;

    const float* pixel(int x, int y) const {
        return &rgba[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                          static_cast<std::size_t>(x))];
    }
};

/// As it is shown: sRGB.
struct ShownPicture {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> rgba; ///< [y][x][4], row 0 on top; alpha is 255
};

/// How numbers become colours.
struct Display {
    DebugView view = DebugView::final;
    double exposure = 1;             ///< final: factor to a picture in which white is 1
    double significant_height_m = 1; ///< scale of heights
    /// final: share of the light that lens and eye scatter (client/view/bloom.h); where the quality has none, and at 0, there
    /// is none.
    double bloom = bloom_default;
    Colouring colouring{};
    double largest = 1; ///< scale of views of which a row says so (ScaleOf::largest)
};

/// What of a view is shown, and on which scale.
struct ShownChannel {
    int channel = 0; ///< below 0: three, as red, green and blue
    ShownScale scale;
};
ShownChannel shown_channel(const Display& display);

/// The factor that a light meter on the sea says: a white sheet there, of this radiance in kcd/m2, becomes 0.9; below
/// the light of twilight (1e-3) less, as eyes see it: 0.3 under a full moon.
double exposure_by_light(double white_radiance);

/// The factor that brings the geometric mean of a lit picture's luminance to middle grey; what is
/// brighter than a white sheet (`white_radiance`, client/view/sky/sky.h) counts as one, so that glint
/// does not blacken the sea. Within a factor of 3 of what a light meter on the sea says: night
/// stays dark.
double metered_exposure(const Picture& picture, double white_radiance);

/// 8 bits sRGB. An error names the path.
Result<void> write_png(const ShownPicture& picture, const std::string& path);

/// What an EXR file says of its picture besides.
struct PictureNotes {
    std::string
        debug; ///< attribute seaway.debug: the view of numbers, in the words of --debug; empty: radiance
    sea::TimeUs time_us = 0; ///< attribute seaway.time_us, as text
};

/// 32-bit floats, channels R, G, B as rendered: not exposed, not mapped; and of a view of numbers A, which says where there is
/// one.
Result<void> write_exr(const Picture& picture, const std::string& path,
                       const PictureNotes& notes = {});

} // namespace seaway::client
