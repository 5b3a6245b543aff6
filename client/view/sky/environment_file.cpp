// SPDX-License-Identifier: Apache-2.0
// OpenEXR files as skies.
#include <algorithm>
#include <cmath>
#include <exception>
#include <mutex>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <fmt/format.h>

#include "base/text_file.h"
#include "client/view/sky/environment.h"

namespace seaway::client {

namespace {

/// Pixels a side of the squares that are averaged: a divisor, so that each holds as many.
int square_of(int width, int height) {
    int side = 1;
    while (side < height &&
           (width / side > environment_width_held || width % side != 0 || height % side != 0))
        ++side;
    return width / side > environment_width_held || width % side != 0 || height % side != 0 ? 0
                                                                                            : side;
}

Result<void> check_header(const Imf::Header& header) {
    const Imath::Box2i data = header.dataWindow(), whole = header.displayWindow();
    const long width = long{data.max.x} - data.min.x + 1,
               height = long{data.max.y} - data.min.y + 1;
    if (data != whole)
        return Error{"holds a part of a picture alone"};
    if (width != 2 * height)
        return Error{fmt::format("is {} x {}: a sky is twice as wide as high", width, height)};
    if (width < environment_width_min || width > environment_width_max)
        return Error{fmt::format("is {} x {}: width is {} .. {}", width, height,
                                 environment_width_min, environment_width_max)};
    for (const char* name : {"R", "G", "B"}) {
        const Imf::Channel* channel = header.channels().findChannel(name);
        if (!channel)
            return Error{fmt::format("has no channel {}: a sky has R, G and B", name)};
        if (channel->xSampling != 1 || channel->ySampling != 1)
            return Error{fmt::format("has channel {} at a lower resolution", name)};
    }
    if (square_of(static_cast<int>(width), static_cast<int>(height)) == 0)
        return Error{fmt::format(
            "is {} x {}: its sides have no common divisor that makes at most {} of its columns",
            width, height, environment_width_held)};
    return {};
}

Result<EnvironmentPicture> read(const std::string& path) {
    Imf::InputFile file(path.c_str());
    SEAWAY_TRY(check_header(file.header()));
    const Imath::Box2i window = file.header().dataWindow();
    const int width = window.max.x - window.min.x + 1, height = width / 2;
    const int square = square_of(width, height);
    EnvironmentPicture out{width / square, height / square, {}};
    out.texels.resize(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height));
    std::vector<glm::vec3> row(static_cast<std::size_t>(width));
    // Where pixel (0, 0) would lie, as OpenEXR counts; all rows are read into the same.
    char* const base = reinterpret_cast<char*>(row.data()) -
                       static_cast<std::ptrdiff_t>(sizeof(glm::vec3)) * window.min.x;
    constexpr const char* names[] = {"R", "G", "B"};
    Imf::FrameBuffer frame;
    for (std::size_t c = 0; c < 3; ++c)
        frame.insert(names[c],
                     Imf::Slice(Imf::FLOAT, base + c * sizeof(float), sizeof(glm::vec3), 0));
    file.setFrameBuffer(frame);
    for (int y = 0; y < height; ++y) {
        file.readPixels(window.min.y + y);
        for (int x = 0; x < width; ++x) {
            const glm::vec3& value = row[static_cast<std::size_t>(x)];
            for (int c = 0; c < 3; ++c)
                if (!std::isfinite(value[c]) || value[c] < 0)
                    return Error{fmt::format("pixel {}, {}: {} is {}; radiance is a number from 0",
                                             x, y, names[c], static_cast<double>(value[c]))};
            out.texels[static_cast<std::size_t>(y / square * out.width + x / square)] +=
                value / static_cast<float>(square * square);
        }
    }
    return out;
}

} // namespace

Result<EnvironmentPicture> read_environment(const std::string& path) {
    // Before a header has been read, OpenEXR allocates by what it says.
    static std::once_flag limited;
    std::call_once(limited, [] {
        Imf::Header::setMaxImageSize(environment_width_max, environment_width_max);
        Imf::Header::setMaxTileSize(environment_width_max, environment_width_max);
    });
    const auto failed = [&](const std::string& why) {
        return Error{"sky picture " + path + ": " + why};
    };
    if (const Result<void> regular = check_regular_file(path); !regular)
        return failed(regular.error().message);
    try {
        Result<EnvironmentPicture> picture = read(path);
        if (!picture)
            return failed(picture.error().message);
        return picture;
    } catch (const std::exception& failure) {
        // Its messages are of several lines now and then.
        std::string why = failure.what();
        std::replace(why.begin(), why.end(), '\n', ' ');
        return failed("cannot be read: " + why);
    }
}

} // namespace seaway::client
