// SPDX-License-Identifier: Apache-2.0
#include "client/link/reconnect.h"

#include <algorithm>

namespace seaway::client {

ReconnectPauses::seconds ReconnectPauses::next(const Error& why) {
    std::uniform_real_distribution<double> share(0, 1);
    if (why.retry_after_ms > 0)
        return std::chrono::milliseconds(why.retry_after_ms) * (1 + hint_jitter * share(random_));
    const seconds wait = wait_ * (1 + jitter * share(random_));
    wait_ = std::min(2 * wait_, wait_max);
    return wait;
}

} // namespace seaway::client
