// SPDX-License-Identifier: Apache-2.0
#include "client/rebuilt/waves_of.h"

namespace seaway::client {

RebuiltSeaPtr WavesOf::end() const {
    return made ? made : received ? received->sea() : nullptr;
}

GlideEnds WavesOf::ends() const {
    GlideEnds ends;
    for (const WavesOf* one = this; one != nullptr; one = one->before.get()) {
        ends.push_back(one->end());
        if (!ends.back())
            return {};
    }
    return ends;
}

} // namespace seaway::client
