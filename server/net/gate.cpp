// SPDX-License-Identifier: Apache-2.0
#include "server/net/gate.h"

#include <fmt/format.h>

#include "server/net/tokens.h"

namespace seaway::server {
namespace {

Judgement refuse(Core& core, const Peer& peer, Barred barred, std::string why,
                 std::string_view reason, Bucket::Clock::time_point now) {
    ++core.counters.tokens_refused[std::string(reason)];
    const Crowding kind =
        barred == Barred::too_many_wrong ? Crowding::tokens_not_looked_at : Crowding::wrong_tokens;
    if (const std::uint64_t count = peer.address->turn_away(kind, now))
        core.log(fmt::format("event=token_refused peer={} reason={} count={}", peer.name, reason,
                             count));
    return {.barred = barred, .why = std::move(why)};
}

} // namespace

bool is_open(const Core& core) {
    return core.tokens.client.empty();
}

Judgement judge_token(Core& core, const Peer& peer, std::string_view token,
                      Bucket::Clock::time_point now) {
    const Tokens& tokens = core.tokens;
    if (token.empty() || (tokens.client.empty() && tokens.admin.empty()))
        return {};
    Bucket& wrong = peer.address->wrong_tokens;
    if (const auto wait = wrong.wait_for(1, now); wait.count() > 0) {
        const auto retry = std::chrono::ceil<std::chrono::seconds>(wait);
        Judgement judged =
            refuse(core, peer, Barred::too_many_wrong,
                   fmt::format("too many wrong tokens came from this address; none is looked at "
                               "for the next {} s",
                               retry.count()),
                   "too_many_wrong", now);
        judged.retry_after = retry;
        return judged;
    }
    if (tokens_equal(token, tokens.admin)) {
        if (!peer.unseen())
            return refuse(core, peer, Barred::in_the_clear,
                          "the administrator's token is taken over TLS only, or on this machine "
                          "itself at ws://127.0.0.1",
                          "in_the_clear", now);
        return {.standing = Standing::administrator};
    }
    if (tokens_equal(token, tokens.client))
        return {.standing = Standing::client};
    wrong.take(1, now);
    Judgement judged = refuse(core, peer, Barred::wrong, "token missing or wrong", "wrong", now);
    if (is_open(core))
        judged.barred = std::nullopt;
    return judged;
}

} // namespace seaway::server
