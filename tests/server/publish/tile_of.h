// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "protocol/messages.h"

namespace seaway::server {

/// The tile in a message that is one. Valid as long as the bytes are.
inline const wire::Tile& tile_of(const protocol::SharedBytes& bytes) {
    return *wire::GetMessage(bytes->data())->body_as_Tile();
}

} // namespace seaway::server
