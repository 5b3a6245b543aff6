// SPDX-License-Identifier: Apache-2.0
#include "server/net/pages.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "server/net/tokens.h"

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
        "<a href=\"/metrics\">metrics</a> <a href=\"/healthz\">health</a></p>"
        "<p>Stream: WebSocket {}, subprotocol {}</p></html>\n",
        SEAWAY_VERSION, core.host.healthy() ? "The sea runs." : "The simulation has failed.",
        sea::seconds_from_us(core.host.sea_time_us()), gauges.sessions, core.options.sessions_max,
        gauges.subscriptions, protocol::stream_path, protocol::websocket_subprotocol);
}

struct Route {
    std::string_view path;
    Page (*make)(Core&);
};

constexpr const char* prometheus = "text/plain; version=0.0.4; charset=utf-8";

const std::array<Route, 5> routes{{
    {"/",
     [](Core& core) {
         return Page{200, "text/html; charset=utf-8", status_page(core), {}};
     }},
    {"/healthz",
     [](Core& core) {
         return core.host.healthy() ? Page{.body = "ok\n"}
                                    : Page{.status = 503, .body = "the simulation has failed\n"};
     }},
    {"/metrics",
     [](Core& core) {
         return Page{200,
                     prometheus,
                     core.host.metrics_text() +
                         metrics_text(core.counters, core.gauges(), core.encoding.counters()),
                     {}};
     }},
    {"/v1/state",
     [](Core& core) {
         return Page{200, json, core.host.state_json(), {}};
     }},
    {"/v1/plan",
     [](Core& core) {
         return Page{200, json, core.host.plan_json(), {}};
     }},
}};

} // namespace

bool may_see(const Core& core, std::string_view target, std::string_view authorization) {
    const std::string_view path = target.substr(0, target.find('?'));
    if (core.client_token.empty() || path == "/healthz" || path == protocol::stream_path)
        return true;
    constexpr std::string_view scheme = "bearer ";
    const bool bearer = authorization.size() > scheme.size() &&
                        std::equal(scheme.begin(), scheme.end(), authorization.begin(),
                                   [](char a, char b) { return a == (b | 0x20); });
    if (!bearer)
        return false;
    const std::string_view token = authorization.substr(scheme.size());
    return tokens_equal(token, core.client_token) || tokens_equal(token, core.admin_token);
}

Page unauthorised() {
    return {.status = 401,
            .body = "a token is needed: \"Authorization: Bearer\" and what the server's token file "
                    "says\n"};
}

Page page_for(Core& core, std::string_view method, std::string_view target) {
    const std::string_view path = target.substr(0, target.find('?'));
    if (path == protocol::stream_path)
        return {.status = 426,
                .body = fmt::format("{} is a WebSocket with subprotocol {}\n", path,
                                    protocol::websocket_subprotocol)};
    const bool reads = method == "GET" || method == "HEAD";
    const auto route = std::find_if(routes.begin(), routes.end(),
                                    [&](const Route& known) { return known.path == path; });
    if (!reads && (route != routes.end() || path == map_path))
        return {.status = 405, .body = "only GET and HEAD are served here\n", .allow = "GET, HEAD"};
    if (route != routes.end())
        return route->make(core);
    return {.status = 404,
            .body = fmt::format(
                "no such page; there are / /healthz /metrics /v1/state /v1/plan /v1/map, "
                "and WebSocket at {}\n",
                protocol::stream_path)};
}

} // namespace seaway::server
