// SPDX-License-Identifier: Apache-2.0
// Pictures of skies that tests write.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfTiledOutputFile.h>

#include "client/view/sky/environment.h"
#include "tests/support/folder.h"

namespace seaway::client {

inline EnvironmentPicture
sky_picture(int width, int height, const std::function<glm::dvec3(const glm::dvec3&)>& radiance) {
    EnvironmentPicture picture{width, height, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            picture.texels.emplace_back(radiance(picture.direction(x, y)));
    return picture;
}

/// As a file of floats; `channels`: names for red, green and blue.
inline std::string sky_file(const std::string& name, const EnvironmentPicture& picture,
                            const std::vector<const char*>& channels = {"R", "G", "B"},
                            bool tiled = false) {
    const std::string path = tests::folder().file(name);
    Imf::Header header(picture.width, picture.height);
    Imf::FrameBuffer frame;
    for (std::size_t c = 0; c < channels.size(); ++c) {
        header.channels().insert(channels[c], Imf::Channel(Imf::FLOAT));
        char* base = const_cast<char*>(
            reinterpret_cast<const char*>(&picture.texels[0][static_cast<int>(c)]));
        frame.insert(channels[c],
                     Imf::Slice(Imf::FLOAT, base, sizeof(glm::vec3),
                                sizeof(glm::vec3) * static_cast<std::size_t>(picture.width)));
    }
    if (tiled) {
        header.setTileDescription(Imf::TileDescription(32, 32));
        Imf::TiledOutputFile file(path.c_str(), header);
        file.setFrameBuffer(frame);
        file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
    } else {
        Imf::OutputFile file(path.c_str(), header);
        file.setFrameBuffer(frame);
        file.writePixels(picture.height);
    }
    return path;
}

} // namespace seaway::client
