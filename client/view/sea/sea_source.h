// SPDX-License-Identifier: Apache-2.0
// Where the renderer has its frames from: a connected client, or who makes a sea here (local/).
#pragma once

#include <string>

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

/// For one thread.
class SeaSource {
  public:
    virtual ~SeaSource() = default;
    virtual sea::TimeUs now_us() const = 0;
    /// Blocks until it is there.
    virtual Result<SeaFrame> at(sea::TimeUs time_us) = 0;
    /// The sea of a frame that was made, as TOML; empty: it is not told.
    virtual std::string scene_at(sea::TimeUs time_us) const = 0;
    /// now_us() has been asked for the last time: what later frames need is had as they are made.
    virtual void leave_now() {}
};

/// Of a client that has subscribed to drawn_fields.
class StreamedSource final : public SeaSource {
  public:
    StreamedSource(Client& client, double timeout_s) : client_(client), timeout_s_(timeout_s) {}
    sea::TimeUs now_us() const override { return client_.now_us(); }
    Result<SeaFrame> at(sea::TimeUs time_us) override {
        return sea_frame_at(client_, time_us, timeout_s_);
    }
    std::string scene_at(sea::TimeUs time_us) const override {
        return client_.sea_state(time_us)->scene;
    }
    void leave_now() override { client_.unsubscribe(); }

  private:
    Client& client_;
    double timeout_s_;
};

} // namespace seaway::client
