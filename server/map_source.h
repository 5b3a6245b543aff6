// SPDX-License-Identifier: Apache-2.0
// Bulk maps for the net: parameters to a request, a sea::MapStream to bytes (docs/protocol.md, /v1/map).
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "base/result.h"
#include "sea/surface/height_map.h"
#include "server/host/host.h"

namespace seaway::server {

/// Maps that are made at a time: each takes two threads and some megabytes while it lasts.
inline constexpr int maps_at_once_max = 2;

/// Parameters by name: kind (height), x0_m, y0_m (0), width_m, height_m, columns, rows, t_s (now).
/// An error names the parameter, its value and what is allowed.
Result<sea::MapRequest> read_map_request(const std::map<std::string, std::string>& parameters,
                                         sea::TimeUs now_us);

/// One of maps_at_once_max places, given back when the pointer goes.
using MapPlace = std::shared_ptr<void>;
/// Refusal::busy if none is free.
Result<MapPlace> take_map_place(const std::shared_ptr<std::atomic<int>>& running);

/// Starts to compute. The source keeps `place`.
Result<std::unique_ptr<ByteSource>> start_map(const sea::MapRequest& request,
                                              const sea::Surface& surface, MapPlace place,
                                              std::function<void()> on_ready);

} // namespace seaway::server
