// SPDX-License-Identifier: Apache-2.0
// OpenEXR files as skies.
#include <algorithm>
#include <cmath>
#include <exception>
#include <mutex>
#include <numbers>
#include <vector>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <fmt/format.h>

#include "base/text_file.h"
#include "client/view/sky/environment.h"

namespace seaway::client {

namespace {

/// Of a row or column of the file, what falls into one that is held.
struct Share {
    int to = 0;
    double weight = 0; ///< of what is held there
};
/// What each of `from` pixels along a side is of `to` texels, by the measure of what lies between two edges of the
/// side, which goes from 0 to 1.
template <class Measure>
std::vector<std::vector<Share>> shares(int from, int to, const Measure& measure) {
    std::vector<std::vector<Share>> out(static_cast<std::size_t>(from));
    for (int i = 0; i < from; ++i)
        // Edges are compared as whole numbers: texel j lies in j * from .. (j + 1) * from.
        for (int j = i * to / from; j < to && j * from < (i + 1) * to; ++j) {
            const double size = double(from) * to;
            const double low = std::max(i * to, j * from) / size;
            const double high = std::min((i + 1) * to, (j + 1) * from) / size;
            out[static_cast<std::size_t>(i)].push_back(
                {j, measure(low, high) / measure(j / double(to), (j + 1) / double(to))});
        }
    return out;
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
    return {};
}

Result<EnvironmentPicture> read(const std::string& path) {
    Imf::InputFile file(path.c_str());
    SEAWAY_TRY(check_header(file.header()));
    const Imath::Box2i window = file.header().dataWindow();
    const int width = window.max.x - window.min.x + 1, height = width / 2;
    const int held = std::min(width, environment_width_held);
    EnvironmentPicture out{held, held / 2, {}};
    out.texels.resize(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height));
    // Means by solid angle: what the picture sends is kept.
    const auto columns =
        shares(width, out.width, [](double low, double high) { return high - low; });
    const auto rows = shares(height, out.height, [](double low, double high) {
        return std::cos(std::numbers::pi * low) - std::cos(std::numbers::pi * high);
    });
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
            for (const Share& down : rows[static_cast<std::size_t>(y)])
                for (const Share& across : columns[static_cast<std::size_t>(x)])
                    out.texels[static_cast<std::size_t>(down.to * out.width + across.to)] +=
                        static_cast<float>(down.weight * across.weight) * value;
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
