// SPDX-License-Identifier: Apache-2.0
#include "server/net/publishing.h"

#include <fmt/format.h>

#include "base/messages.h"
#include "sockets/frame_header.h"

namespace seaway::server {

namespace {

/// From so many on a file for all costs less than a copy for each.
constexpr std::size_t subscribers_for_a_file = 4;

void append_frame_header(std::size_t length, protocol::Bytes& out) {
    const sockets::FrameHeader header(length);
    out.insert(out.end(), header.bytes.begin(), header.bytes.begin() + header.size);
}

void tell_of_left_out(Core& core, std::size_t more) {
    core.counters.keyframes_dropped += more;
    if (const Turns::Clock::time_point now = Turns::Clock::now(); now >= core.tells_of_left_out) {
        core.tells_of_left_out = now + std::chrono::seconds(10);
        core.log(fmt::format("event=keyframes_left_out count={} why=\"the encoder is behind\"",
                             core.counters.keyframes_dropped));
    }
}

} // namespace

void publish_keyframe(const std::shared_ptr<Core>& core, KeyframeTiles tiles) {
    const sea::FieldSet wanted =
        core->host.subscriptions().wanted(tiles.keyframe->cascade, tiles.quality, tiles.follows);
    if (wanted.empty())
        return;
    const std::weak_ptr<Core> weak = core;
    const auto job = [weak, tiles, wanted](Encoder& encoder) {
        const std::shared_ptr<Core> alive = weak.lock();
        if (alive == nullptr)
            return true;
        auto encoded = encoder.encode(*tiles.keyframe, tiles.codec_error, tiles.quality, wanted,
                                      {tiles.compact_size, tiles.follows, tiles.coarser, tiles.law},
                                      alive->memory->room(MemoryUse::streamed).get());
        KeyframeFilePtr file;
        if (encoded && !alive->options.has_tls() &&
            alive->host.subscriptions().size() >= subscribers_for_a_file)
            file = keyframe_file(**encoded, append_frame_header,
                                 *alive->memory->room(MemoryUse::streamed));
        auto sea_state = alive->host.sea_state_message(tiles.keyframe->epoch);
        alive->post([weak, encoded = std::move(encoded), file = std::move(file),
                     sea_state = std::move(sea_state)] {
            const std::shared_ptr<Core> here = weak.lock();
            if (here == nullptr)
                return;
            if (!encoded) {
                ++here->counters.keyframes_wrong;
                return here->log(fmt::format("event=keyframe_refused why={}",
                                             in_quotes(encoded.error().message)));
            }
            ++here->counters.keyframes_published;
            here->deliveries.add({*encoded, file, sea_state});
        });
        return true;
    };
    const std::size_t left_out = core->encoding.submit_streamed(job, tiles);
    if (left_out > 0)
        core->post([core = core.get(), left_out] { tell_of_left_out(*core, left_out); });
}

} // namespace seaway::server
