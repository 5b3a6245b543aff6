// SPDX-License-Identifier: Apache-2.0
// From a sea to what a client holds of it at a rung, without sockets: the world grants and says how, the encoder makes
// messages, tiles are put together as a client does.
#pragma once

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "client/held/tile_assembly.h"
#include "client/local_surface.h"
#include "protocol/messages.h"
#include "server/device/native_synthesizer.h"
#include "server/publish/encoder.h"
#include "server/simulation/schedule.h"
#include "server/world.h"

namespace seaway::tests {

/// A scene of the repository, or its text.
inline server::RunningSeaPtr sea_of_scene(const std::string& name) {
    const Result<sea::Scene> scene =
        name.find('\n') == std::string::npos
            ? sea::read_scene(std::string(SEAWAY_SOURCE_DIR) + "/scenes/" + name)
            : sea::parse_scene(name, "test", SEAWAY_SOURCE_DIR "/scenes");
    EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
    return *server::make_running_sea(*scene, 1);
}

/// One session at one rung.
class StreamOf {
  public:
    StreamOf(server::RunningSeaPtr sea, const server::Demand& wish)
        : sea_(std::move(sea)), clock_(
                                    0, [] { return sea::TimeUs{0}; }, [] { return 0; }),
          world_(server::steady_course(sea_), clock_), grant_(world_.grant(wish)) {
        EXPECT_TRUE(device_.set_sea(sea_->realization, 1));
        if (grant_.empty())
            return;
        world_.subscriptions().set(1, grant_);
        world_.publish_to([this](server::KeyframeTiles tiles) { take(tiles); });
        protocol::MessageReader reader(protocol::Sender::server);
        const auto message = world_.sea_state_message(1);
        state_ = protocol::values(*(*reader.read(*message))->body_as_SeaState());
    }

    const server::Demand& grant() const { return grant_; }
    const client::SeaState& state() const { return state_; }
    const server::RunningSea& sea() const { return *sea_; }
    std::size_t bytes() const { return bytes_; }
    int largest_side() const { return largest_side_; }
    const std::vector<protocol::Bytes>& messages() const { return messages_; }

    /// The keyframes around a time, as the stream has them.
    void hold(sea::TimeUs time_us) {
        const std::size_t rate = server::rung_of(grant_.quality).rate;
        for (int c = 0; c < static_cast<int>(state_.cascades.size()); ++c) {
            const auto& budget = sea_->budget.cascades[static_cast<std::size_t>(c)];
            const sea::TimeUs interval_us =
                sea::every_for(budget, server::rate_rungs_hz[rate]) * budget.interval_us;
            const sea::TimeUs start_us = server::interval_start(time_us, interval_us);
            for (const sea::TimeUs t_us : {start_us, start_us + interval_us}) {
                const server::KeyframeRequest request{c, t_us, grant_.fields};
                const auto made = device_.synthesize({&request, 1});
                ASSERT_TRUE(made);
                (*made)[0]->epoch = 1;
                world_.on_keyframe((*made)[0], rate);
            }
        }
    }

    Result<client::LocalSurface> surface(sea::TimeUs time_us) const {
        return client::local_surface(state_, ring_, time_us,
                                     sea::surface_fields & (grant_.fields | grant_.follows));
    }

  private:
    void take(const server::KeyframeTiles& tiles) {
        const auto encoded =
            encoder_.encode(*tiles.keyframe, tiles.codec_error, tiles.quality, grant_.fields,
                            {tiles.compact_size, tiles.follows, tiles.coarser});
        ASSERT_TRUE(encoded);
        protocol::MessageReader reader(protocol::Sender::server);
        for (const server::EncodedField& map : (*encoded)->maps)
            for (const protocol::SharedBytes& part : map.parts) {
                const auto message = reader.read(*part);
                ASSERT_TRUE(message);
                const wire::Tile& tile = *(*message)->body_as_Tile();
                ASSERT_TRUE(protocol::check(tile));
                largest_side_ = std::max<int>(largest_side_, tile.size());
                bytes_ += part->size();
                messages_.push_back(*part);
                const auto& cascade = state_.cascades[tile.cascade()];
                const auto added = assembly_.add(
                    protocol::header(tile), {tile.payload()->data(), tile.payload()->size()},
                    cascade, state_.depth_m, grant_.fields | grant_.follows, {});
                ASSERT_TRUE(added) << added.error().message;
                if (added->complete)
                    ring_.insert(added->complete);
            }
    }

    const server::RunningSeaPtr sea_;
    server::SeaClock clock_;
    server::World world_;
    server::NativeSynthesizer device_{1};
    server::Demand grant_;
    client::SeaState state_;
    server::Encoder encoder_;
    client::TileAssembly assembly_;
    client::KeyframeRing ring_;
    std::vector<protocol::Bytes> messages_;
    std::size_t bytes_ = 0;
    int largest_side_ = 0;
};

} // namespace seaway::tests
