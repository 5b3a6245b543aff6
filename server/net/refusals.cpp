// SPDX-License-Identifier: Apache-2.0
#include "server/net/refusals.h"

#include "server/host/refusal.h"

namespace seaway::server {

using wire::ErrorCode;

wire::ErrorCode wire_code(const Error& error) {
    if (const auto code = error.kind.as<ErrorCode>())
        return *code;
    const auto refusal = error.kind.as<Refusal>();
    if (!refusal)
        return ErrorCode::internal;
    switch (*refusal) {
    case Refusal::bad_value:
        return ErrorCode::bad_value;
    case Refusal::not_offered:
        return ErrorCode::not_offered;
    case Refusal::busy:
        return ErrorCode::too_many_requests;
    case Refusal::gone:
        break;
    }
    return ErrorCode::internal;
}

unsigned http_status(const Error& error) {
    const auto refusal = error.kind.as<Refusal>();
    if (!refusal)
        return 500;
    switch (*refusal) {
    case Refusal::bad_value:
        return 400;
    case Refusal::not_offered:
        return 404;
    case Refusal::busy:
        return 503;
    case Refusal::gone:
        break;
    }
    return 500;
}

std::uint32_t retry_after_ms(const Error& error) {
    constexpr std::uint32_t some_time_ms = 1000;
    return error.retry_after_ms == 0 && error.is(Refusal::busy) ? some_time_ms
                                                                : error.retry_after_ms;
}

int retry_after_s(const Error& error) {
    return static_cast<int>((std::uint64_t{retry_after_ms(error)} + 999) / 1000);
}

} // namespace seaway::server
