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

/// Parameters by name: kind (height), x0_m, y0_m (0), width_m, height_m, columns, rows, t_s (now).
/// An error names the parameter, its value and what is allowed.
Result<sea::MapRequest> read_map_request(const std::map<std::string, std::string>& parameters,
                                         sea::TimeUs now_us);

/// Of the whole answer, header and rows.
std::uint64_t bytes_of_map(const sea::MapRequest& request);

/// Starts to compute. The source keeps `place`. What its next() finds no memory for (std::bad_alloc) comes with the one after.
Result<std::unique_ptr<ByteSource>> start_map(const sea::MapRequest& request,
                                              const sea::Surface& surface, Room::Place place,
                                              std::function<void()> on_ready);

} // namespace seaway::server
