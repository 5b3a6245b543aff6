// SPDX-License-Identifier: Apache-2.0
// KeyframeFile: the messages of a keyframe as they go over the line, one behind the other in a file of memory, for
// connections that send what lies there without copying it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "base/memory_file.h"
#include "server/publish/encoder.h"

namespace seaway::server {

struct KeyframeFile {
    std::shared_ptr<const MemoryFile> file;
    bool differs = false; ///< holds differences where the keyframe has them: what most are sent
    /// Where part p of map m begins, with what goes before it; and behind the last part of it, its end.
    std::vector<std::vector<std::uint64_t>> at;
    Room::Place place; ///< of the file, beside that of the keyframe
};
using KeyframeFilePtr = std::shared_ptr<const KeyframeFile>;

/// Appends what goes over the line before a message of so many bytes.
using FrameHeaderOf = std::function<void(std::size_t length, protocol::Bytes& out)>;

/// Null: there is no file for it, and its messages are all there is. Copies each byte once.
KeyframeFilePtr keyframe_file(const EncodedKeyframe& keyframe, const FrameHeaderOf& header_of,
                              Room& streamed);

} // namespace seaway::server
