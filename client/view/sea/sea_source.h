// SPDX-License-Identifier: Apache-2.0
// From a connected client to what the renderer takes.
#pragma once

#include "base/result.h"
#include "client/client.h"
#include "client/view/sea/sea_frame.h"

namespace seaway::client {

/// What the renderer draws of a sea: subscribe to these.
inline constexpr sea::FieldSet drawn_fields = sea::surface_fields | sea::FieldSet{sea::Field::foam};

/// The sea at a time, from keyframes that the client holds or, where the stream does not cover it,
/// fetches. Blocks for `timeout_s` at most. Not for use in an event of the client.
Result<SeaFrame> sea_frame_at(Client& client, sea::TimeUs time_us, double timeout_s);

/// The same from what the client holds alone: at once. An error (not_held) names the cascade of which nothing is held
/// around this time.
Result<SeaFrame> held_sea_frame(const Client& client, sea::TimeUs time_us);

} // namespace seaway::client
