// SPDX-License-Identifier: Apache-2.0
// What the HTTP side says: a function from (method, path) to a page. No sockets.
#pragma once

#include <string>
#include <string_view>

#include "server/net/core.h"

namespace seaway::server {

/// Bulk maps: answered in pieces, not by a Page.
inline constexpr std::string_view map_path = "/v1/map";

struct Page {
    unsigned status = 200;
    std::string content_type = "text/plain; charset=utf-8";
    std::string body = {};
    std::string allow = {}; ///< header of a 405
};

/// With a client token, everything but the stream, whose Hello brings it, and /healthz is for those
/// who bring that one, or the administrator's, as "Authorization: Bearer TOKEN".
bool may_see(const Core& core, std::string_view target, std::string_view authorization);
Page unauthorised();

/// GET and HEAD of /healthz, /metrics, /v1/state, /v1/plan and /; a query string is ignored.
/// /healthz is 200 "ok" or 503. Anything else is 404 or 405 with a sentence.
Page page_for(Core& core, std::string_view method, std::string_view target);

} // namespace seaway::server
