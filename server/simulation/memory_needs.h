// SPDX-License-Identifier: Apache-2.0
// What one of the largest things takes that a server makes of a sea, for its budget of memory
// (server/host/memory.h). Pure functions; thread-safe.
#pragma once

#include <cstddef>

#include "server/host/memory.h"
#include "server/simulation/running_sea.h"

namespace seaway::server {

/// Bytes of the two keyframes of each cascade around a time, maps and splines.
std::size_t surface_bytes(const RunningSea& sea);

/// Bytes of a map under way: its surface, one map mixed of two keyframes a cascade, rows ahead.
std::size_t map_bytes(const RunningSea& sea);

MemoryNeeds needs_of(const RunningSea& sea);

} // namespace seaway::server
