// SPDX-License-Identifier: Apache-2.0
// The files that a Picture becomes.
#include <cerrno>
#include <cstring>
#include <exception>
#include <fstream>
#include <functional>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <png.h>

#include "base/whole_file.h"
#include "client/view/picture.h"

namespace seaway::client {

namespace {

Result<void> write(const std::string& path,
                   const std::function<Result<void>(const std::string&)>& beside) {
    const Result<void> written = write_whole_file(path, beside);
    return written ? written : Error{"cannot write " + path + ": " + written.error().message};
}

} // namespace

Result<void> write_png(const ShownPicture& picture, const std::string& path) {
    std::vector<std::uint8_t> bytes; // without alpha
    bytes.reserve(picture.rgba.size() / 4 * 3);
    for (std::size_t i = 0; i < picture.rgba.size(); i += 4)
        bytes.insert(bytes.end(), &picture.rgba[i], &picture.rgba[i + 3]);
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(picture.width);
    image.height = static_cast<png_uint_32>(picture.height);
    image.format = PNG_FORMAT_RGB;
    return write(path, [&](const std::string& beside) -> Result<void> {
        errno = 0;
        if (png_image_write_to_file(&image, beside.c_str(), 0, bytes.data(), 0, nullptr) != 0)
            return {};
        const std::string why = errno != 0 ? std::strerror(errno) : image.message;
        png_image_free(&image);
        return Error{why};
    });
}

namespace {

void write_numbers(const Picture& picture, const PictureNotes& notes, std::ofstream& file,
                   const std::string& path) {
    Imf::Header header(picture.width, picture.height);
    header.insert("seaway.time_us", Imf::StringAttribute(std::to_string(notes.time_us)));
    if (!notes.debug.empty())
        header.insert("seaway.debug", Imf::StringAttribute(notes.debug));
    Imf::FrameBuffer frame;
    const char* const names[] = {"R", "G", "B", "A"};
    for (std::size_t c = 0; c < (notes.debug.empty() ? 3 : 4); ++c) {
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

Result<void> write_exr(const Picture& picture, const std::string& path, const PictureNotes& notes) {
    return write(path, [&](const std::string& beside) -> Result<void> {
        errno = 0;
        std::ofstream file(beside, std::ios::binary);
        if (!file)
            return Error{std::strerror(errno)};
        try {
            write_numbers(picture, notes, file, beside);
        } catch (const std::exception& failure) {
            return Error{failure.what()};
        }
        // The library says nothing of what it writes last.
        file.close();
        if (!file)
            return Error{errno != 0 ? std::strerror(errno) : "it does not fit"};
        return {};
    });
}

} // namespace seaway::client
