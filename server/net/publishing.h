// SPDX-License-Identifier: Apache-2.0
// Publishing: a keyframe on its way from the simulation to the sessions that were granted it.
#pragma once

#include <memory>

#include "server/net/core.h"

namespace seaway::server {

/// Has it encoded, on the thread for that, and delivered, on the io thread. Left out and counted where that thread is too far
/// behind. Any thread.
void publish_keyframe(const std::shared_ptr<Core>& core, KeyframeTiles tiles);

} // namespace seaway::server
