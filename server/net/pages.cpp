// SPDX-License-Identifier: Apache-2.0
#include "server/net/pages.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace seaway::server {
namespace {

constexpr const char* json = "application/json";

std::string status_page(Core& core) {
    const Gauges gauges = core.gauges();
    return fmt::format(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>Seaway</title>"
        "<h1>Seaway {}</h1><p>{}</p><table>"
        "<tr><td>Sea time<td>{:.1f} s"
        "<tr><td>Sessions<td>{} of {}"
        "<tr><td>Subscriptions<td>{}"
        "</table><p><a href=\"/v1/state\">state</a> <a href=\"/v1/plan\">plan</a> "
        "<a href=\"/metrics\">metrics</a> <a href=\"/healthz\">health</a> <a "
        "href=\"/readyz\">readiness</a></p>"
        "<p>Stream: WebSocket {}, subprotocol {}</p></html>\n",
        SEAWAY_VERSION,
        core.host.health().live ? "The sea runs." : "Out of order: " + core.host.health().why,
        sea::seconds_from_us(core.host.sea_time_us()), gauges.sessions, core.options.sessions_max,
        gauges.subscriptions, protocol::stream_path, protocol::websocket_subprotocol);
}

struct Route {
    std::string_view path;
    bool is_health; ///< served where nothing else is, too
    Page (*make)(Core&);
};

constexpr const char* prometheus = "text/plain; version=0.0.4; charset=utf-8";

const std::array<Route, 6> routes{{
    {"/", false,
     [](Core& core) {
         return Page{200, "text/html; charset=utf-8", status_page(core), {}};
     }},
    {"/healthz", true,
     [](Core& core) {
         const Health health = core.host.health();
         return health.live ? Page{.body = "ok\n"} : Page{.status = 503, .body = health.why + "\n"};
     }},
    {"/readyz", true,
     [](Core& core) {
         const Health health = core.host.health();
         if (!health.live)
             return Page{.status = 503, .body = health.why + "\n"};
         if (core.stopping)
             return stopping_page(core);
         // One that has not said Hello makes room.
         return core.takes_a_session() || !core.awaiting_hello.empty()
                    ? Page{.body = "ready\n"}
                    : Page{.status = 503, .body = "no session is free\n"};
     }},
    {"/metrics", true,
     [](Core& core) {
         return Page{200,
                     prometheus,
                     core.host.metrics_text() + core.memory->metrics_text() +
                         metrics_text(core.counters, core.gauges(), core.encoding.counters()),
                     {}};
     }},
    {"/v1/state", false,
     [](Core& core) {
         return Page{200, json, core.host.state_json(), {}};
     }},
    {"/v1/plan", false,
     [](Core& core) {
         return Page{200, json, core.host.plan_json(), {}};
     }},
}};

} // namespace

Page stopping_page(const Core& core) {
    const auto retry_after = std::chrono::ceil<std::chrono::seconds>(core.retry_after);
    return {.status = 503,
            .body = "the server stops\n",
            .retry_after_s = static_cast<int>(retry_after.count())};
}

std::optional<Page> keep_out(const Core& core, std::string_view path, const Judgement& judged) {
    if (judged.barred == Barred::too_many_wrong)
        return Page{.status = 429,
                    .body = judged.why + "\n",
                    .retry_after_s = static_cast<int>(judged.retry_after.count())};
    if (judged.barred == Barred::in_the_clear)
        return Page{.status = 403, .body = judged.why + "\n"};
    const bool needs_none =
        is_open(core) || path == "/healthz" || path == "/readyz" || path == protocol::stream_path;
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
