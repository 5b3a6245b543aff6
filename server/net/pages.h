// SPDX-License-Identifier: Apache-2.0
// What the HTTP side says: a function from (method, path) to a page. No sockets.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "server/net/core.h"
#include "server/net/gate.h"

namespace seaway::server {

/// Bulk maps: answered in pieces, not by a Page.
inline constexpr std::string_view map_path = "/v1/map";
inline constexpr std::string_view map_content_type = "application/vnd.seaway.map";

/// Of any answer: 14 to 18 us of the network's thread on a connection that goes on. 16 000 in a second are an address's share, a
/// quarter of that thread, unless that was changed.
inline constexpr double answer_price_bytes = 8 * 1024;

struct Page {
    unsigned status = 200;
    std::string content_type = "text/plain; charset=utf-8";
    std::string body = {};
    std::string allow = {}; ///< header of a 405
    /// Of a body that HEAD tells of and that is not made.
    std::optional<std::uint64_t> announced_bytes = {};
    int retry_after_s = 0; ///< the same may be asked again after so long; 0: nothing is said
    /// What it takes of its address's share of requests, beside what was sent for it and what it says itself.
    double price_bytes = answer_price_bytes;
};

/// Of a page that is made when it is asked for: a millisecond of the network's thread at most. A thousand in a second are an
/// address's share, unless that was changed.
inline constexpr double page_price_bytes = 128 * 1024;

/// /healthz and /readyz say nothing that is anybody's: no token is looked at there, and where the other pages ask for one /readyz
/// says in general words why not. All of it stands in /v1/state, and where `health_only`.
bool is_for_probers(std::string_view path);

/// With a client token, everything but /healthz, /readyz, the shell of the status page and the stream, whose
/// Hello may bring it, is for those who bring that one, or the administrator's, as "Authorization: Bearer
/// TOKEN". A token that is brought has to be right, also where none is needed. Empty: come in; else why not.
std::optional<Page> keep_out(const Core& core, std::string_view path, const Judgement& judged);

/// 503, with the time after which to come again: of whatever begins while the server stops.
Page stopping_page(const Core& core);

/// GET and HEAD of /healthz, /readyz, /metrics, /v1/state, /v1/plan and /. /healthz is 200 "ok" or 503; /readyz
/// is 200 only where a session would be taken, too. Anything else is 404 or 405 with a sentence; where `health_only`, all but /healthz, /readyz and /metrics.
Page page_for(Core& core, std::string_view method, std::string_view path, bool health_only);

} // namespace seaway::server
