// SPDX-License-Identifier: Apache-2.0
// The gate: what a token makes of who brings it, the same for Authorization and for Hello.token. Of the
// io thread alone.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "server/net/addresses.h"
#include "server/net/core.h"

namespace seaway::server {

enum class Standing { stranger, client, administrator };

/// Why a token was not taken.
enum class Barred {
    wrong,
    too_many_wrong, ///< of its address: not even looked at
    in_the_clear,   ///< the administrator's, over a plain connection from elsewhere
};

struct Judgement {
    Standing standing = Standing::stranger;
    std::optional<Barred> barred;
    std::string why = {}; ///< of `barred`, for the one who brought it
    std::chrono::seconds retry_after{0};
};

/// An empty token is none: a stranger, neither wrong nor counted. Where there is no client token, who
/// brings a wrong one is a stranger too, counted all the same. What is refused is counted and logged;
/// the token itself is never written anywhere.
Judgement judge_token(Core& core, const Peer& peer, std::string_view token,
                      Bucket::Clock::time_point now = Bucket::Clock::now());

/// A stranger may come in.
bool is_open(const Core& core);

} // namespace seaway::server
