// SPDX-License-Identifier: Apache-2.0
// A picture that one of our tools drew.
#pragma once

#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <png.h>

#include "tools/plot/canvas.h"

namespace seaway::testing {

struct Pixels {
    int width = 0, height = 0;
    std::vector<png_byte> rgb;

    /// Of a PNG file.
    explicit Pixels(const std::string& path) {
        png_image image{};
        image.version = PNG_IMAGE_VERSION;
        EXPECT_NE(png_image_begin_read_from_file(&image, path.c_str()), 0) << path;
        image.format = PNG_FORMAT_RGB;
        width = static_cast<int>(image.width);
        height = static_cast<int>(image.height);
        rgb.resize(PNG_IMAGE_SIZE(image));
        EXPECT_NE(png_image_finish_read(&image, nullptr, rgb.data(), 0, nullptr), 0) << path;
    }
    /// From the upper left corner.
    plot::Color at(double x, double y) const {
        const auto i =
            static_cast<std::size_t>(3 * (static_cast<int>(y) * width + static_cast<int>(x)));
        return {rgb.at(i), rgb.at(i + 1), rgb.at(i + 2)};
    }
};

} // namespace seaway::testing
