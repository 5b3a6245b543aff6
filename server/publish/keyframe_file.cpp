// SPDX-License-Identifier: Apache-2.0
#include "server/publish/keyframe_file.h"

namespace seaway::server {

KeyframeFilePtr keyframe_file(const EncodedKeyframe& keyframe, const FrameHeaderOf& header_of,
                              Room& streamed) {
    if (!streamed.fits(keyframe.bytes))
        return nullptr;
    auto made = std::make_shared<KeyframeFile>();
    made->differs = keyframe.base != 0;
    protocol::Bytes bytes;
    for (const EncodedField& map : keyframe.maps) {
        std::vector<std::uint64_t>& at = made->at.emplace_back();
        for (const protocol::SharedBytes& part :
             made->differs && !map.differences.empty() ? map.differences : map.parts) {
            at.push_back(bytes.size());
            header_of(part->size(), bytes);
            bytes.insert(bytes.end(), part->begin(), part->end());
        }
        at.push_back(bytes.size());
    }
    made->file = MemoryFile::of(bytes);
    if (made->file == nullptr)
        return nullptr;
    made->place = streamed.take_anyway(bytes.size());
    return made;
}

} // namespace seaway::server
