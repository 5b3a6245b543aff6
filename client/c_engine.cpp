// SPDX-License-Identifier: Apache-2.0
// The C interface for engines over Client: what is streamed, what there is, questions (seaway_engine.h).
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/undo.h"
#include "client/c_api.h"
#include "protocol/limits.h"

using namespace seaway;
using namespace seaway::client;
using namespace seaway::client::c;
namespace limits = seaway::protocol::limits;

namespace {

/// What it began with; all that follows may be missing.
constexpr std::size_t wish_least = offsetof(seaway_wish, cascades);

Result<protocol::TileWish> tile_wish(const seaway_wish& wanted, const SeaState& state) {
    if (const uint32_t unknown = wanted.fields & ~sea::all_fields.bits())
        return bad(fmt::format("seaway_wish.fields: there is no field {}; they are 0 to {}",
                               std::countr_zero(unknown), sea::field_count - 1));
    const std::size_t count = state.cascades.size();
    if (const uint32_t beyond = wanted.cascades >> count)
        return bad(fmt::format("seaway_wish.cascades: there is no cascade {}; the sea has {}",
                               count + static_cast<std::size_t>(std::countr_zero(beyond)), count));
    SEAWAY_TRY_LET(protocol::TileWish wish,
                   tile_limits("seaway_wish", wanted.error_m, wanted.rate_hz_max, wanted.size_max));
    wish.fields =
        wanted.fields == 0 ? sea::surface_fields : sea::FieldSet::from_bits(wanted.fields);
    if (wanted.cascades != 0)
        wish.cascades = wanted.cascades;
    return wish;
}

seaway_grant as_c(const Grant& from) {
    seaway_grant to{};
    to.fields = from.fields.bits();
    to.cascades = from.cascades;
    to.size_max = static_cast<uint32_t>(from.size_max);
    to.error_m = static_cast<double>(from.error_m);
    to.rate_hz_max = static_cast<double>(from.rate_hz_max);
    to.credit = static_cast<uint32_t>(from.credit);
    from.why.copy(to.why, sizeof(to.why) - 1);
    return to;
}

/// Of structs that the library alone fills in: the size, and something.
constexpr std::size_t given_least = 2 * sizeof(uint32_t);

template <class Struct>
Result<void> give_out(const Struct& value, Struct* to, const char* name) {
    return give(value, to, given_least, name);
}

seaway_state state_of(seaway_client& client) {
    const Client& inner = *client.client;
    const ClientStatus status = inner.status();
    const Welcome welcome = inner.welcome();
    const std::optional<Grant> grant = inner.grant();
    seaway_state to{};
    to.now_us = client.client->now_us();
    const SeaStatePtr sea = inner.sea_state(to.now_us);
    to.state = static_cast<uint32_t>(status.state);
    to.source = static_cast<uint32_t>(inner.source(to.now_us).source);
    to.seas = static_cast<uint32_t>(status.seas);
    to.epoch = sea->epoch;
    to.cascades = static_cast<uint32_t>(sea->cascades.size());
    if (grant) {
        to.fields = grant->fields.bits();
        to.cascades_sent = grant->cascades;
        to.error_m = static_cast<double>(grant->error_m);
    }
    to.points_max = welcome.points_per_query_max;
    to.exact_points_max = welcome.exact_points_per_query_max;
    to.questions = static_cast<uint32_t>(client.questions->open_count());
    to.questions_max = static_cast<uint32_t>(Questions::open_max);
    to.credit_max = static_cast<uint32_t>(limits::credit_max);
    to.size_min = static_cast<uint32_t>(limits::size_min);
    to.size_max = static_cast<uint32_t>(limits::map_side_max);
    to.rate_hz_min = double{limits::rate_hz_min};
    to.rate_hz_max = double{limits::rate_hz_max};
    to.place_max_m = limits::position_m_max;
    to.time_max_us = limits::time_us_max;
    return to;
}

} // namespace

seaway_code seaway_subscribe_to(seaway_client* client, const seaway_wish* wish,
                                seaway_grant* grant) {
    return guarded([&]() -> Result<void> {
        if (!client)
            return bad("seaway_subscribe_to: client must not be null");
        SEAWAY_TRY_LET(const seaway_wish wanted, sized(wish, wish_least, "seaway_wish"));
        SEAWAY_TRY_LET(const std::uint32_t credit, credit_of("seaway_wish.credit", wanted.credit));
        SEAWAY_TRY_LET(const double patience_s,
                       patience("seaway_wish.timeout_s", wanted.timeout_s));
        if (wanted.reserved != 0)
            return bad(fmt::format("seaway_wish.reserved is {}: it must be 0", wanted.reserved));
        if (grant)
            SEAWAY_TRY(has_room(grant, given_least, "seaway_grant"));
        Client& inner = *client->client;
        SEAWAY_TRY_LET(const protocol::TileWish tiles,
                       tile_wish(wanted, *inner.sea_state(inner.now_us())));
        SEAWAY_TRY_LET(const Grant granted,
                       inner.subscribe(tiles, static_cast<int>(credit), patience_s));
        return grant ? give_out(as_c(granted), grant, "seaway_grant") : Result<void>();
    });
}

seaway_code seaway_get_grant(const seaway_client* client, seaway_grant* grant) {
    return guarded([&]() -> Result<void> {
        if (!client)
            return bad("seaway_get_grant: client must not be null");
        const std::optional<Grant> granted = client->client->grant();
        if (!granted)
            return failed(Failure::not_held, "nothing is granted: subscribe");
        return give_out(as_c(*granted), grant, "seaway_grant");
    });
}

seaway_code seaway_get_state(seaway_client* client, seaway_state* state) {
    return guarded([&]() -> Result<void> {
        if (!client)
            return bad("seaway_get_state: client must not be null");
        return give_out(state_of(*client), state, "seaway_state");
    });
}

seaway_code seaway_get_cascade(const seaway_client* client, int64_t time_us, uint32_t index,
                               seaway_cascade* cascade) {
    return guarded([&]() -> Result<void> {
        if (!client)
            return bad("seaway_get_cascade: client must not be null");
        const SeaStatePtr sea = client->client->sea_state(time_us);
        if (index >= sea->cascades.size())
            return bad(fmt::format("seaway_get_cascade: there is no cascade {}; the sea has {}",
                                   index, sea->cascades.size()));
        const protocol::CascadeInfo& from = sea->cascades[index];
        const double infinite = std::numeric_limits<double>::infinity();
        const auto wave_m = [&](double k) { return k > 0 ? 2 * std::numbers::pi / k : infinite; };
        seaway_cascade to{};
        to.grid = static_cast<uint32_t>(from.size);
        to.length_m = from.length_m;
        to.longest_wave_m = wave_m(sea->longest_radpm(index));
        to.shortest_wave_m = wave_m(from.k_hi_radpm);
        to.interval_us = from.interval_us;
        to.choppiness_x = sea->choppiness_x_at(time_us);
        to.choppiness_y = sea->choppiness_y_at(time_us);
        return give_out(to, cascade, "seaway_cascade");
    });
}

seaway_code seaway_get_source(const seaway_client* client, int64_t time_us, seaway_source* source) {
    return guarded([&]() -> Result<void> {
        if (!client)
            return bad("seaway_get_source: client must not be null");
        SEAWAY_TRY(check_time(time_us));
        const SourceNow from = client->client->source(time_us);
        seaway_source to{};
        to.source = static_cast<uint32_t>(from.source);
        from.why.copy(to.why, sizeof(to.why) - 1);
        return give_out(to, source, "seaway_source");
    });
}

seaway_code seaway_rebuild(seaway_client* client, int64_t time_us) {
    return guarded([&]() -> Result<void> {
        if (!client)
            return bad("seaway_rebuild: client must not be null");
        return client->client->rebuild(time_us);
    });
}

seaway_code seaway_ask(seaway_client* client, const seaway_point* points, size_t count, int exact,
                       double timeout_s, uint64_t* question) {
    return guarded([&]() -> Result<void> {
        if (!client || !points || !question)
            return bad("seaway_ask: client, points and question must not be null");
        SEAWAY_TRY_LET(const double patience_s, patience("seaway_ask: timeout_s", timeout_s));
        const Welcome welcome = client->client->welcome();
        const std::size_t most =
            exact ? welcome.exact_points_per_query_max : welcome.points_per_query_max;
        if (count == 0 || count > most)
            return bad(fmt::format("seaway_ask: count is {}: it must be 1 to {}", count, most));
        const std::optional<std::uint64_t> opened = client->questions->open();
        if (!opened)
            return failed(
                Failure::refused,
                fmt::format("{} questions are open: take or cancel some", Questions::open_max));
        // Nobody would know its number.
        Undo question_open([&] { client->questions->cancel(*opened); });
        SEAWAY_TRY(client->client->ask_async(
            as_points(points, count), {exact != 0, patience_s},
            [questions = client->questions, number = *opened](const Result<Reply>& reply) {
                if (reply)
                    questions->answer(number, reply->answers);
                else
                    questions->answer(number, reply.error());
            }));
        question_open.keep();
        *question = *opened;
        return {};
    });
}

seaway_code seaway_take_answers(seaway_client* client, uint64_t question, seaway_answer* answers,
                                size_t count) {
    bool pending = false;
    const seaway_code code = guarded([&]() -> Result<void> {
        if (!client || !answers)
            return bad("seaway_take_answers: client and answers must not be null");
        const std::optional<Questions::Answers> taken = client->questions->take(question, count);
        pending = !taken;
        if (pending)
            return Error{fmt::format("question {} is under way", question)};
        if (!*taken)
            return taken->error();
        put(**taken, answers);
        return {};
    });
    return pending ? SEAWAY_PENDING : code;
}

seaway_code seaway_cancel(seaway_client* client, uint64_t question) {
    return guarded([&]() -> Result<void> {
        if (!client)
            return bad("seaway_cancel: client must not be null");
        if (!client->questions->cancel(question))
            return bad(
                fmt::format("question {}: there is none, or it was taken or cancelled", question));
        return {};
    });
}

seaway_code seaway_poll(seaway_client* client, double timeout_s, seaway_event* event) {
    return guarded([&]() -> Result<void> {
        if (!client)
            return bad("seaway_poll: client must not be null");
        SEAWAY_TRY(in_range("seaway_poll: timeout_s", timeout_s, 0, timeout_max_s));
        SEAWAY_TRY(has_room(event, sizeof(seaway_event), "seaway_event"));
        double wait_s = timeout_s;
        if (client->client->threadless()) {
            client->client->work_until(
                std::chrono::steady_clock::now() +
                    std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                        std::chrono::duration<double>(timeout_s)),
                [&] { return client->questions->has_event(); });
            wait_s = 0;
        }
        const std::optional<Questions::Event> next = client->questions->next(wait_s);
        seaway_event to{};
        if (next) {
            to.kind = next->kind == Questions::Event::Kind::answered ? uint32_t{SEAWAY_ANSWERED}
                                                                     : uint32_t{SEAWAY_STATUS};
            to.question = next->question;
        }
        return give(to, event, sizeof(seaway_event), "seaway_event");
    });
}

int seaway_poll_descriptor(seaway_client* client) {
    int descriptor = -1;
    (void)guarded([&]() -> Result<void> {
        if (!client)
            return bad("seaway_poll_descriptor: client must not be null");
        SEAWAY_TRY_LET(const int events, client->questions->descriptor());
        descriptor = events;
        if (client->client->threadless()) {
            SEAWAY_TRY_LET(descriptor, client->client->descriptor_with(events));
        }
        return {};
    });
    return descriptor;
}
