// SPDX-License-Identifier: Apache-2.0
// An OpenEXR file of ours, read back.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
#pragma GCC diagnostic ignored "-Wshadow"
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#pragma GCC diagnostic pop

namespace seaway::testing {

/// One file, read back; values as float whatever they are in the file.
class ExrFile {
  public:
    explicit ExrFile(const std::string& path) : file_(path.c_str()) {}

    int size() const { return file_.header().dataWindow().max.x + 1; }
    Imf::Compression packing() const { return file_.header().compression(); }
    bool has(const std::string& channel) const {
        return file_.header().channels().findChannel(channel) != nullptr;
    }
    Imf::PixelType type(const std::string& channel) const {
        return file_.header().channels().findChannel(channel)->type;
    }
    double number(const std::string& name) const {
        return file_.header().typedAttribute<Imf::DoubleAttribute>(name).value();
    }
    std::string text(const std::string& name) const {
        return file_.header().typedAttribute<Imf::StringAttribute>(name).value();
    }
    std::vector<float> values(const std::string& channel) {
        const auto n = static_cast<std::size_t>(size());
        std::vector<float> pixels(n * n);
        Imf::FrameBuffer buffer;
        buffer.insert(channel, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(pixels.data()),
                                          sizeof(float), sizeof(float) * n));
        file_.setFrameBuffer(buffer);
        file_.readPixels(0, size() - 1);
        return pixels;
    }

  private:
    Imf::InputFile file_;
};

} // namespace seaway::testing
