// SPDX-License-Identifier: Apache-2.0
// The C interface over Client. Every function catches what the library throws: no exception leaves.
#include <algorithm>
#include <cstring>

#include <fmt/format.h>

#include "client/c_api.h"
#include "protocol/limits.h"

using namespace seaway;
using namespace seaway::client;
using namespace seaway::client::c;

namespace {

constexpr double look_back_max_s = 60;

std::string text(const char* given, std::string otherwise) {
    return given ? std::string(given) : std::move(otherwise);
}

seaway_status as_c(const ClientStatus& from) {
    seaway_status to{};
    to.size = sizeof(to);
    to.state = static_cast<uint32_t>(from.state);
    to.attempts = static_cast<uint32_t>(from.attempts);
    to.connections = static_cast<uint32_t>(from.connections);
    to.seas = static_cast<uint32_t>(from.seas);
    to.holds |= from.holds_tiles ? uint32_t{SEAWAY_HOLDS_TILES} : 0u;
    to.holds |= from.holds_waves ? uint32_t{SEAWAY_HOLDS_WAVES} : 0u;
    to.next_attempt_s = from.next_attempt_s;
    to.stale_s = from.stale_s;
    to.held_from_us = from.held_from_us;
    to.held_until_us = from.held_until_us;
    from.reason.copy(to.reason, sizeof(to.reason) - 1);
    return to;
}

ClientEvents events_of(seaway_client& client) {
    ClientEvents events;
    events.on_status = [&client](const ClientStatus& status) {
        client.questions->status_changed();
        const std::scoped_lock lock(client.watch_mutex);
        if (!client.watch)
            return;
        const seaway_status now = as_c(status);
        client.watch(client.user, &now);
    };
    return events;
}

} // namespace

uint32_t seaway_abi_version(void) {
    return SEAWAY_ABI_VERSION;
}

const char* seaway_last_error(void) {
    return last_error.c_str();
}

seaway_code seaway_connect(const char* url, const seaway_connect_options* options,
                           seaway_client** client) {
    return guarded([&]() -> Result<void> {
        if (!url || !client)
            return bad("seaway_connect: url and client must not be null");
        ConnectOptions connect;
        RingLimits limits;
        connect.url = url;
        if (options) {
            SEAWAY_TRY(
                in_range("seaway_connect_options.timeout_s", options->timeout_s, 0, timeout_max_s));
            connect.name = text(options->name, connect.name);
            connect.token = text(options->token, "");
            for (const auto& [what, said] :
                 {std::pair("seaway_connect_options.name", &connect.name),
                  std::pair("seaway_connect_options.token", &connect.token)})
                if (said->size() > protocol::limits::hello_text_bytes_max)
                    return bad(fmt::format("{} has {} bytes: it may have {}", what, said->size(),
                                           protocol::limits::hello_text_bytes_max));
            connect.ca_file = text(options->ca_file, "");
            if (options->timeout_s > 0)
                connect.timeout_s = options->timeout_s;
            SEAWAY_TRY(is_flag("seaway_connect_options.stays_lost", options->stays_lost));
            SEAWAY_TRY(is_flag("seaway_connect_options.threadless", options->threadless));
            connect.threadless = options->threadless == 1;
            connect.stays_lost = options->stays_lost == 1;
            SEAWAY_TRY(in_range("seaway_connect_options.look_back_s", options->look_back_s, 0,
                                look_back_max_s));
            if (options->look_back_s > 0)
                limits.look_back_us = sea::us_from_seconds(options->look_back_s);
        }
        auto made = std::make_unique<seaway_client>();
        SEAWAY_TRY_LET(made->client, Client::connect(connect, events_of(*made), limits));
        *client = made.release();
        return {};
    });
}

void seaway_disconnect(seaway_client* client) {
    (void)guarded([&]() -> Result<void> {
        delete client;
        return {};
    });
}

int seaway_is_connected(const seaway_client* client) {
    return client && client->client->is_open() ? 1 : 0;
}

double seaway_retry_after_s(const seaway_client* client) {
    double after_s = 0;
    (void)guarded([&]() -> Result<void> {
        const std::optional<Error> end = client ? client->client->end() : std::nullopt;
        after_s = end ? end->retry_after_ms / 1000.0 : 0;
        return {};
    });
    return after_s;
}

seaway_code seaway_get_status(const seaway_client* client, seaway_status* status) {
    return guarded([&]() -> Result<void> {
        if (!client)
            return bad("seaway_get_status: client must not be null");
        constexpr std::size_t least = offsetof(seaway_status, attempts);
        return give(as_c(client->client->status()), status, least, "seaway_status");
    });
}

seaway_code seaway_watch_status(seaway_client* client, seaway_status_watch watch, void* user) {
    return guarded([&]() -> Result<void> {
        if (!client)
            return bad("seaway_watch_status: client must not be null");
        const std::scoped_lock lock(client->watch_mutex);
        client->watch = watch;
        client->user = user;
        return {};
    });
}

int64_t seaway_now_us(seaway_client* client) {
    return client ? client->client->now_us() : 0;
}

seaway_code seaway_clock(const seaway_client* client, seaway_clock_status* status) {
    return guarded([&]() -> Result<void> {
        if (!client || !status)
            return bad("seaway_clock: client and status must not be null");
        const ClockStatus clock = client->client->clock();
        *status = {clock.error_us, clock.slew_us, clock.drift_ppm,
                   static_cast<double>(clock.round_trip_us)};
        return {};
    });
}

seaway_code seaway_sea_at(const seaway_client* client, int64_t time_us, seaway_sea* sea) {
    return guarded([&]() -> Result<void> {
        if (!client || !sea)
            return bad("seaway_sea_at: client and sea must not be null");
        const SeaStatePtr state = client->client->sea_state(time_us);
        const protocol::SeaNumbers realised = state->realised_at(time_us);
        *sea = {state->start_time_us,   realised.hs_m,
                realised.tp_s,          realised.tz_s,
                realised.mean_from_deg, state->height_error_m,
                state->epoch,           static_cast<uint32_t>(state->cascades.size())};
        return {};
    });
}

seaway_code seaway_query(seaway_client* client, const seaway_point* points, size_t count, int exact,
                         double timeout_s, seaway_answer* answers) {
    return guarded([&]() -> Result<void> {
        SEAWAY_TRY(points_given("seaway_query", client, points, count, answers, "answers"));
        SEAWAY_TRY_LET(const double patience_s, patience("seaway_query: timeout_s", timeout_s));
        SEAWAY_TRY_LET(const std::vector<sea::Answer> asked,
                       client->client->ask(as_points(points, count), {exact != 0, patience_s}));
        put(asked, answers);
        return {};
    });
}

seaway_code seaway_subscribe(seaway_client* client, const seaway_subscription* subscription) {
    return guarded([&]() -> Result<void> {
        if (!client)
            return bad("seaway_subscribe: client must not be null");
        const seaway_subscription wanted = subscription ? *subscription : seaway_subscription{};
        SEAWAY_TRY_LET(const std::uint32_t credit,
                       credit_of("seaway_subscription.credit", wanted.credit));
        SEAWAY_TRY(in_range("seaway_subscription.error_m", wanted.error_m, 0,
                            protocol::limits::error_m_max));
        SEAWAY_TRY_LET(const double patience_s,
                       patience("seaway_subscription.timeout_s", wanted.timeout_s));
        if (wanted.reserved != 0)
            return bad(
                fmt::format("seaway_subscription.reserved is {}: it must be 0", wanted.reserved));
        if (wanted.rung == SEAWAY_SPECTRUM) {
            const Result<protocol::SpectrumGrant> granted = client->client->subscribe_spectrum(
                {.error_m = wish_of(wanted.error_m)}, patience_s);
            return granted ? Result<void>() : granted.error();
        }
        SEAWAY_TRY_LET(protocol::TileWish wish, tile_limits("seaway_subscription", wanted.error_m,
                                                            wanted.rate_hz_max, wanted.size_max));
        if (wanted.rung != SEAWAY_TILES)
            return bad(fmt::format(
                "seaway_subscription.rung is {}: it must be SEAWAY_TILES or SEAWAY_SPECTRUM",
                wanted.rung));
        wish.fields = sea::surface_fields;
        const Result<Grant> granted =
            client->client->subscribe(wish, static_cast<int>(credit), patience_s);
        return granted ? Result<void>() : granted.error();
    });
}

seaway_code seaway_unsubscribe(seaway_client* client) {
    return guarded([&]() -> Result<void> {
        if (!client)
            return bad("seaway_unsubscribe: client must not be null");
        client->client->unsubscribe();
        client->client->unsubscribe_spectrum();
        return {};
    });
}

seaway_code seaway_hold(seaway_client* client, const int64_t* times_us, size_t count,
                        double timeout_s) {
    return guarded([&]() -> Result<void> {
        if (!client || (count > 0 && !times_us))
            return bad("seaway_hold: client and times_us must not be null");
        SEAWAY_TRY(count_fits("seaway_hold", count));
        SEAWAY_TRY_LET(const double patience_s, patience("seaway_hold: timeout_s", timeout_s));
        return client->client->hold({times_us, count}, patience_s);
    });
}

seaway_code seaway_sample(const seaway_client* client, const seaway_point* points, size_t count,
                          seaway_answer* answers) {
    return guarded([&]() -> Result<void> {
        SEAWAY_TRY(points_given("seaway_sample", client, points, count, answers, "answers"));
        RecycledVector<sea::Answer> sampled(count); // a call that fails writes nothing
        SEAWAY_TRY(client->client->sample_into(as_points(points, count), sampled));
        put(sampled, answers);
        return {};
    });
}
