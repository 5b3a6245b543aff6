// SPDX-License-Identifier: Apache-2.0
#include "client/apps/ctl_ask.h"

#include <chrono>
#include <functional>
#include <future>
#include <random>
#include <thread>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "client/apps/ctl_diff.h"
#include "client/apps/ctl_status.h"
#include "client/link/waiter.h"
#include "sea/scene/weather.h"

namespace seaway::client {
namespace {

using Clock = std::chrono::steady_clock;

/// Some keyframes.
constexpr std::chrono::milliseconds load_is_of{500};

Result<StatusRow> row(const CtlOptions& options, const std::string& url) {
    SEAWAY_TRY_LET(const std::unique_ptr<Connection> connection,
                   connect_as_administrator(options, url));
    SEAWAY_TRY_LET(const std::string before,
                   administered(*connection, {wire::Act::state}, options.timeout_s));
    const Clock::time_point begun = Clock::now();
    SEAWAY_TRY_LET(const std::string sessions,
                   administered(*connection, {wire::Act::sessions}, options.timeout_s));
    std::this_thread::sleep_for(load_is_of);
    SEAWAY_TRY_LET(const std::string state,
                   administered(*connection, {wire::Act::state}, options.timeout_s));
    const std::chrono::duration<double> between = Clock::now() - begun;
    return status_row(url, connection->welcome().server, before, state, between.count(), sessions);
}

Result<std::unique_ptr<Client>> reader_of(const CtlOptions& options, const std::string& url) {
    SEAWAY_TRY_LET(ConnectOptions server, options.connect_options("seaway-ctl"));
    server.url = url;
    return connect_to(server);
}

/// Where its timetable has led to by then; earlier than now: as it came.
Result<std::string> scene_by(std::string text, sea::TimeUs at_us) {
    if (at_us <= 0)
        return text;
    SEAWAY_TRY_LET(const sea::Scene scene, sea::parse_scene(text, "the scene of that change"));
    SEAWAY_TRY_LET(const sea::Scene by_then, sea::weather_by(scene, at_us));
    return by_then.weather.size() == scene.weather.size() ? text : sea::to_toml(by_then);
}

} // namespace

Result<std::unique_ptr<Connection>> connect_as_administrator(const CtlOptions& options,
                                                             const std::string& url) {
    SEAWAY_TRY_LET(ConnectOptions server, options.connect_options("seaway-ctl"));
    server.url = url;
    return connection_to(server);
}

Result<std::string> administered(Connection& connection, const AdminWish& wish, double timeout_s) {
    Waiter waiter;
    connection.administer(wish.act, wish.session, timeout_s, waiter.handler());
    SEAWAY_TRY_LET(const Reply reply, waiter.wait());
    return reply.text;
}

Result<std::string> changed(Connection& connection, const protocol::ChangeWish& wish,
                            double timeout_s) {
    Waiter waiter;
    connection.change(wish, timeout_s, waiter.handler());
    SEAWAY_TRY_LET(const Reply reply, waiter.wait());
    if (wish.pace_permille)
        return fmt::format("{{\"from_s\": {}, \"change\": {}}}\n",
                           sea::seconds_from_us(reply.start_us), reply.change);
    return fmt::format("{{\"epoch\": {}, \"start_s\": {}, \"end_s\": {}, \"change\": {}}}\n",
                       reply.epoch, sea::seconds_from_us(reply.start_us),
                       sea::seconds_from_us(reply.end_us), reply.change);
}

FleetStatus fleet_status(const CtlOptions& options, const StatusWish& wish) {
    std::vector<std::string> urls{options.url};
    urls.insert(urls.end(), wish.others.begin(), wish.others.end());
    FleetStatus status;
    status.table = fmt::format(
        "{:<30} {:<22} {:<6} {:>7} {:>6} {:>9} {:>9} {:>6} {:>5} {:>8} {:>6} {:>9} {:>11} why\n",
        "server", "version", "sea", "changes", "behind", "ahead_ms", "+-_ms", "unheard", "peers",
        "sessions", "cores", "waits_KB", "counted");
    // All at a time: each takes half a second, and longer where a server does not answer.
    std::vector<std::future<Result<StatusRow>>> rows;
    for (const std::string& url : urls)
        rows.push_back(std::async(std::launch::async, row, std::cref(options), url));
    std::size_t silent = 0;
    for (std::size_t i = 0; i < urls.size(); ++i) {
        const std::string& url = urls[i];
        const Result<StatusRow> one = rows[i].get();
        if (!one && ++silent == 1)
            status.none_answers = one.error();
        status.table += one ? one->text : fmt::format("{:<30} {}\n", url, one.error().message);
        status.all_certain = status.all_certain && one && one->certain;
    }
    if (silent < urls.size())
        status.none_answers.reset();
    return status;
}

Result<std::string> rewound(const CtlOptions& options, const RewindWish& wish) {
    SEAWAY_TRY_LET(const std::unique_ptr<Connection> connection,
                   connect_as_administrator(options, options.url));
    SEAWAY_TRY_LET(std::string scene,
                   administered(*connection, {wire::Act::change, wish.change}, options.timeout_s));
    protocol::ChangeWish change;
    SEAWAY_TRY_LET(change.scene, scene_by(std::move(scene), wish.at_us));
    change.over_us = wish.over_us;
    change.at_us = wish.at_us;
    return changed(*connection, change, options.timeout_s);
}

Result<std::string> difference(const CtlOptions& options, const DiffWish& wish) {
    SEAWAY_TRY_LET(const std::unique_ptr<Client> one, reader_of(options, options.url));
    SEAWAY_TRY_LET(const std::unique_ptr<Client> other, reader_of(options, wish.other));
    std::mt19937_64 random(wish.seed);
    std::uniform_real_distribution<double> place(-5000, 5000);
    // What has been made, and what is about to be.
    std::uniform_int_distribution<sea::TimeUs> around(-10'000'000, 1'000'000);
    std::vector<sea::QueryPoint> points;
    for (int i = 0; i < wish.points; ++i)
        points.push_back({place(random), place(random), one->now_us() + around(random)});
    SEAWAY_TRY_LET(const auto a, one->ask(points, {.timeout_s = options.timeout_s}));
    SEAWAY_TRY_LET(const auto b, other->ask(points, {.timeout_s = options.timeout_s}));
    return difference_of(a, b, sea::seconds_from_us(one->now_us() - other->now_us()));
}

} // namespace seaway::client
