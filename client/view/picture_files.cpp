// SPDX-License-Identifier: Apache-2.0
// The files that a Picture becomes.
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStdIO.h>
#include <png.h>

#include "base/text_file.h"
#include "client/view/picture.h"

namespace seaway::client {

Result<void> write_png(const ShownPicture& picture, const std::string& path) {
    if (const Result<void> file = check_replaceable(path); !file)
        return Error{"cannot write " + path + ": " + file.error().message};
    std::vector<std::uint8_t> bytes; // without alpha
    bytes.reserve(picture.rgba.size() / 4 * 3);
    for (std::size_t i = 0; i < picture.rgba.size(); i += 4)
        bytes.insert(bytes.end(), &picture.rgba[i], &picture.rgba[i + 3]);
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(picture.width);
    image.height = static_cast<png_uint_32>(picture.height);
    image.format = PNG_FORMAT_RGB;
    errno = 0;
    if (png_image_write_to_file(&image, path.c_str(), 0, bytes.data(), 0, nullptr) == 0) {
        const std::string why = errno != 0 ? std::strerror(errno) : image.message;
        png_image_free(&image);
        return Error{"cannot write " + path + ": " + why};
    }
    return {};
}

namespace {

void write_numbers(const Picture& picture, std::ofstream& file, const std::string& path) {
    Imf::Header header(picture.width, picture.height);
    Imf::FrameBuffer frame;
    const char* const names[] = {"R", "G", "B"};
    for (std::size_t c = 0; c < 3; ++c) {
        header.channels().insert(names[c], Imf::Channel(Imf::FLOAT));
        // OpenEXR only reads through this pointer.
        char* base = const_cast<char*>(reinterpret_cast<const char*>(&picture.rgba[c]));
        frame.insert(names[c],
                     Imf::Slice(Imf::FLOAT, base, 4 * sizeof(float),
                                4 * sizeof(float) * static_cast<std::size_t>(picture.width)));
    }
    Imf::StdOFStream stream(file, path.c_str());
    Imf::OutputFile out(stream, header);
    out.setFrameBuffer(frame);
    out.writePixels(picture.height);
}

} // namespace

Result<void> write_exr(const Picture& picture, const std::string& path) {
    if (const Result<void> file = check_replaceable(path); !file)
        return Error{"cannot write " + path + ": " + file.error().message};
    errno = 0;
    std::ofstream file(path, std::ios::binary);
    if (!file)
        return Error{"cannot write " + path + ": " + std::strerror(errno)};
    std::string why;
    try {
        write_numbers(picture, file, path);
    } catch (const std::exception& failure) {
        why = failure.what();
    }
    // The library says nothing of what it writes last.
    file.close();
    if (why.empty() && !file)
        why = errno != 0 ? std::strerror(errno) : "it does not fit";
    if (why.empty())
        return {};
    std::remove(path.c_str());
    return Error{"cannot write " + path + ": " + why};
}

} // namespace seaway::client
