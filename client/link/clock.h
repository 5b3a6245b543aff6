// SPDX-License-Identifier: Apache-2.0
// Sea time on a client, from pings (base/clock_filter.h).
#pragma once

#include "base/clock_filter.h"

namespace seaway::client {

using seaway::ClockFilter;
using seaway::ClockStatus;
using seaway::LocalUs;

} // namespace seaway::client
