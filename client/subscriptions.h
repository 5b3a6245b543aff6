// SPDX-License-Identifier: Apache-2.0
// What a client is subscribed to, as it is asked for again after an outage.
#pragma once

#include "protocol/messages.h"

namespace seaway::client {

struct Subscription {
    protocol::TileWish wish;
    int credit;
    double timeout_s;
};

struct SpectrumSubscription {
    protocol::SpectrumWish wish;
    double timeout_s;
};

} // namespace seaway::client
