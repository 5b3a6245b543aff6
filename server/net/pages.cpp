// SPDX-License-Identifier: Apache-2.0
#include "server/net/pages.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "server/net/status_page.h"

namespace seaway::server {
namespace {

constexpr const char* json = "application/json";

struct Route {
    std::string_view path;
    bool is_health; ///< served where nothing else is, too
    Page (*make)(Core&);
};

constexpr const char* prometheus = "text/plain; version=0.0.4; charset=utf-8";

Page made(const char* content_type, std::string body) {
    return {.content_type = content_type, .body = std::move(body), .price_bytes = page_price_bytes};
}

constexpr std::string_view readiness_path = "/readyz";

/// For strangers in general words.
Page readiness(const Core& core, bool whole) {
    const Health health = core.host.health();
    if (!health.live)
        return {.status = 503, .body = health.why + "\n"};
    if (core.stopping)
        return stopping_page(core);
    if (!health.ready)
        return {.status = 503, .body = (whole ? health.why : health.in_general) + "\n"};
    // One that has not said Hello makes room.
    return core.takes_a_session() || !core.awaiting_hello.empty()
               ? Page{.body = "ready\n"}
               : Page{.status = 503, .body = "no session is free\n"};
}

const std::array<Route, 8> routes{{
    {"/", false,
     [](Core&) {
         return Page{.content_type = "text/html; charset=utf-8", .body = std::string(status_html)};
     }},
    {status_script_path, false,
     [](Core&) {
         return Page{.content_type = "text/javascript; charset=utf-8",
                     .body = std::string(status_script)};
     }},
    {status_style_path, false,
     [](Core&) {
         return Page{.content_type = "text/css; charset=utf-8", .body = std::string(status_style)};
     }},
    {"/healthz", true,
     [](Core& core) {
         const Health health = core.host.health();
         return health.live ? Page{.body = "ok\n"} : Page{.status = 503, .body = health.why + "\n"};
     }},
    {readiness_path, true, [](Core& core) { return readiness(core, true); }},
    {"/metrics", true,
     [](Core& core) {
         return made(prometheus,
                     core.host.metrics_text() + core.memory->metrics_text() +
                         metrics_text(core.counters, core.gauges(), core.encoding.counters()));
     }},
    {"/v1/state", false, [](Core& core) { return made(json, core.host.state_json()); }},
    {"/v1/plan", false, [](Core& core) { return made(json, core.host.plan_json()); }},
}};

} // namespace

Page stopping_page(const Core& core) {
    const auto retry_after = std::chrono::ceil<std::chrono::seconds>(core.retry_after);
    return {.status = 503,
            .body = "the server stops\n",
            .retry_after_s = static_cast<int>(retry_after.count())};
}

bool is_for_probers(std::string_view path) {
    return path == "/healthz" || path == readiness_path;
}

std::optional<Page> keep_out(const Core& core, std::string_view path, const Judgement& judged) {
    if (judged.barred == Barred::too_many_wrong)
        return Page{.status = 429,
                    .body = judged.why + "\n",
                    .retry_after_s = static_cast<int>(judged.retry_after.count())};
    if (judged.barred == Barred::in_the_clear)
        return Page{.status = 403, .body = judged.why + "\n"};
    constexpr std::array open_paths{protocol::stream_path, std::string_view("/"),
                                    status_script_path, status_style_path};
    const bool needs_none = is_open(core) || is_for_probers(path) ||
                            std::ranges::find(open_paths, path) != open_paths.end();
    if (judged.barred == Barred::wrong || (judged.standing == Standing::stranger && !needs_none))
        return Page{
            .status = 401,
            .body = "a token is needed: \"Authorization: Bearer\" and what the server's token file "
                    "says\n"};
    return std::nullopt;
}

Page page_for(Core& core, std::string_view method, std::string_view path, bool health_only) {
    if (path == protocol::stream_path && !health_only)
        return {.status = 426,
                .body = fmt::format("{} is a WebSocket with subprotocol {}\n", path,
                                    protocol::websocket_subprotocol)};
    const bool reads = method == "GET" || method == "HEAD";
    const auto route = std::find_if(routes.begin(), routes.end(), [&](const Route& known) {
        return known.path == path && (known.is_health || !health_only);
    });
    if (!reads && (route != routes.end() || path == map_path || path == "*"))
        return {.status = 405, .body = "only GET and HEAD are served here\n", .allow = "GET, HEAD"};
    if (path == readiness_path && reads && !health_only && !is_open(core))
        return readiness(core, false);
    if (route != routes.end())
        return route->make(core);
    if (health_only)
        return {.status = 404, .body = "no such page; here are /healthz /readyz /metrics\n"};
    return {.status = 404,
            .body = fmt::format(
                "no such page; there are / /healthz /readyz /metrics /v1/state /v1/plan /v1/map, "
                "and WebSocket at {}\n",
                protocol::stream_path)};
}

} // namespace seaway::server
