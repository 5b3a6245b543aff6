// SPDX-License-Identifier: Apache-2.0
#include "tools/exr/exr_map.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <exception>
#include <fstream>

#include <fmt/format.h>

#include "base/whole_file.h"

// The library's headers are not clean under our warnings.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
#pragma GCC diagnostic ignored "-Wshadow"
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfStringAttribute.h>
#pragma GCC diagnostic pop

namespace seaway::exr {

namespace {

Imf::Compression imf(ExrCompression compression) {
    switch (compression) {
    case ExrCompression::none:
        return Imf::NO_COMPRESSION;
    case ExrCompression::rle:
        return Imf::RLE_COMPRESSION;
    case ExrCompression::zip:
        return Imf::ZIP_COMPRESSION;
    case ExrCompression::piz:
        return Imf::PIZ_COMPRESSION;
    }
    return Imf::NO_COMPRESSION;
}

Imf::Header header(const ExrMap& map) {
    Imf::Header header(map.width, map.height);
    header.compression() = imf(map.compression);
    for (const auto& [name, value] : map.attributes)
        if (const double* number = std::get_if<double>(&value))
            header.insert(name, Imf::DoubleAttribute(*number));
        else
            header.insert(name, Imf::StringAttribute(std::get<std::string>(value)));
    for (const ExrChannel& channel : map.channels)
        header.channels().insert(channel.name, Imf::Channel(map.half ? Imf::HALF : Imf::FLOAT));
    return header;
}

/// Rounded to half; empty if a value does not fit.
std::vector<half> halves(std::span<const float> values) {
    std::vector<half> rounded(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
        rounded[i] = half(values[i]);
        if (!rounded[i].isFinite())
            return {};
    }
    return rounded;
}

/// The rows of a map in the other order.
template <class T>
std::vector<T> upside_down(std::span<const T> values, std::size_t width) {
    std::vector<T> turned;
    turned.reserve(values.size());
    for (std::size_t row = values.size() / width; row-- > 0;)
        turned.insert(turned.end(), values.begin() + static_cast<std::ptrdiff_t>(row * width),
                      values.begin() + static_cast<std::ptrdiff_t>((row + 1) * width));
    return turned;
}

Result<void> write_pixels(const std::string& path, const ExrMap& map) {
    const auto width = static_cast<std::size_t>(map.width);
    const auto height = static_cast<std::size_t>(map.height);
    Imf::FrameBuffer pixels;
    std::vector<std::vector<float>> turned(map.channels.size());
    std::vector<std::vector<half>> rounded(map.channels.size());
    for (std::size_t c = 0; c < map.channels.size(); ++c) {
        const std::string& name = map.channels[c].name;
        std::span<const float> values = map.channels[c].values;
        SEAWAY_CHECK(values.size() == width * height, "a channel has the size of its map");
        if (map.upside_down)
            values = turned[c] = upside_down(values, width);
        if (!map.half) { // the library wants char*, and reads
            auto* base = const_cast<char*>(reinterpret_cast<const char*>(values.data()));
            pixels.insert(name, Imf::Slice(Imf::FLOAT, base, sizeof(float), sizeof(float) * width));
            continue;
        }
        rounded[c] = halves(values);
        if (rounded[c].empty())
            return Error{fmt::format(
                "a value of {} is beyond 65504 and does not fit into half; bake floats", name)};
        auto* base = reinterpret_cast<char*>(rounded[c].data());
        pixels.insert(name, Imf::Slice(Imf::HALF, base, sizeof(half), sizeof(half) * width));
    }
    errno = 0;
    std::ofstream file(path, std::ios::binary);
    if (file) {
        Imf::StdOFStream stream(file, path.c_str());
        Imf::OutputFile out(stream, header(map));
        out.setFrameBuffer(pixels);
        out.writePixels(map.height);
    }
    // The library says nothing of what it writes last.
    file.close();
    if (!file)
        return Error{errno != 0 ? std::strerror(errno) : "it does not fit"};
    return {};
}

} // namespace

Result<ExrCompression> exr_compression(std::string_view name) {
    if (name == "none")
        return ExrCompression::none;
    if (name == "rle")
        return ExrCompression::rle;
    if (name == "zip")
        return ExrCompression::zip;
    if (name == "piz")
        return ExrCompression::piz;
    return Error{fmt::format("--compression '{}': one of none, rle, zip, piz", name)};
}

Result<void> write_exr(const std::string& path, const ExrMap& map) {
    const auto write = [&](const std::string& beside) -> Result<void> {
        try {
            return write_pixels(beside, map);
        } catch (const std::exception& error) { // the library's
            return Error{error.what()};
        }
    };
    const Result<void> written = write_whole_file(path, write);
    return written ? written : Error{fmt::format("{}: {}", path, written.error().message)};
}

} // namespace seaway::exr
