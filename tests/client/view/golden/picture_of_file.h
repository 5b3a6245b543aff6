// SPDX-License-Identifier: Apache-2.0
// A picture as seaway-view wrote it.
#pragma once

#include <string>

#include <png.h>

#include "client/view/picture.h"

namespace seaway::tests {

/// Of a PNG file; nothing where there is none.
inline client::ShownPicture read_picture(const std::string& path) {
    client::ShownPicture picture;
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    if (!png_image_begin_read_from_file(&image, path.c_str()))
        return picture;
    image.format = PNG_FORMAT_RGBA;
    picture.rgba.resize(PNG_IMAGE_SIZE(image));
    if (png_image_finish_read(&image, nullptr, picture.rgba.data(), 0, nullptr)) {
        picture.width = static_cast<int>(image.width);
        picture.height = static_cast<int>(image.height);
    }
    return picture;
}

} // namespace seaway::tests
