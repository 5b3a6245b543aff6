// SPDX-License-Identifier: Apache-2.0
#include "server/net/fetch_job.h"

#include <algorithm>
#include <new>
#include <utility>

#include <fmt/format.h>

#include "base/undo.h"
#include "protocol/limits.h"
#include "protocol/messages.h"
#include "server/host/refusal.h"

namespace seaway::server {

namespace limits = protocol::limits;

Error tiles_too_large(std::size_t bytes_max) {
    return {wire::ErrorCode::too_large,
            fmt::format("more than {} bytes of tiles: fetch fewer times or fields", bytes_max)};
}

Error no_room_for(std::string_view what) {
    return busy(fmt::format("{} that nobody has read yet fill the memory there is for "
                            "them, try again later",
                            what));
}

FetchJob::~FetchJob() {
    try {
        Error lost = no_memory();
        lost.message = "this was given up, try again later";
        end(std::move(lost));
    } catch (const std::bad_alloc&) { // the session waits for it until it ends
    }
}

FetchJob::FetchJob(std::weak_ptr<Core> core, sea::FieldSet wanted, bool start, const Asker& session,
                   GiveBack give_back)
    : core_(std::move(core)), wanted_(wanted), start_(start), asker_(session.about(wanted_here_)),
      give_back_(std::move(give_back)), encoded_{{}, wanted} {}

void FetchJob::bring(Result<FetchedPart> fetched) {
    const std::shared_ptr<Core> alive = core_.lock();
    if (alive == nullptr)
        return;
    if (!fetched) // an asker that has not left seems gone once there was no memory to tell it the end
        return end(asker_.gone() ? no_memory() : fetched.error());
    const auto slice = [self = shared_from_this(),
                        part =
                            std::make_shared<Part>(Part{*std::move(fetched)})](Encoder& encoder) {
        try {
            return self->encode(*part, encoder);
        } catch (const std::bad_alloc&) {
            self->end(no_memory());
            return true;
        }
    };
    EncodeWorker& encoding = alive->encoding;
    if (!(start_ ? encoding.submit_start(slice) : encoding.submit_fetched(slice)))
        end(Error{Refusal::busy, "too many fetches wait to be encoded already"});
}

/// EncodeWorker::Job.
bool FetchJob::encode(Part& part, Encoder& encoder) {
    if (asker_.gone())
        return true;
    std::vector<KeyframeTiles>& tiles = part.fetched.tiles;
    if (part.done < tiles.size()) {
        KeyframeTiles& tile = tiles[part.done++];
        const sea::FieldSet follows = tile.follows & wanted_ & sea::following(wanted_);
        Result<EncodedKeyframePtr> one = encoder.encode(
            *tile.keyframe, tile.codec_error, tile.quality, wanted_.without(follows),
            {tile.compact_size, tile.follows, tile.coarser, tile.law}, streamed_room());
        tile.keyframe = nullptr;
        if (const Result<void> taken = one ? take(*one, follows) : one.error(); !taken) {
            encoded_.keyframes.clear(); // and their places
            end(taken.error());
            return true;
        }
    }
    if (part.done < tiles.size())
        return false;
    if (part.fetched.last)
        end(std::move(encoded_));
    return true;
}

/// A start's tiles are the stream's, and shared.
Room* FetchJob::streamed_room() const {
    const std::shared_ptr<Core> alive = start_ ? core_.lock() : nullptr;
    return alive ? alive->memory->room(MemoryUse::streamed).get() : nullptr;
}

Result<void> FetchJob::take(const EncodedKeyframePtr& one, sea::FieldSet follows) {
    bytes_ += message_bytes(*one, wanted_);
    if (bytes_ > limits::fetch_bytes_max)
        return tiles_too_large(limits::fetch_bytes_max);
    if (start_)
        return keep(one, follows);
    const std::shared_ptr<Core> alive = core_.lock();
    const Room::Place place =
        alive ? alive->memory->room(MemoryUse::fetched)->take(message_bytes(*one, wanted_))
              : nullptr;
    if (!place && alive && bytes_ > alive->memory->room(MemoryUse::fetched)->bytes_max())
        return tiles_too_large(alive->memory->room(MemoryUse::fetched)->bytes_max());
    if (!place)
        return no_room_for("fetched tiles");
    return keep(with_place(place, one), follows);
}

Result<void> FetchJob::keep(const EncodedKeyframePtr& one, sea::FieldSet follows) {
    encoded_.fields = encoded_.fields & (one->fields | (follows & sea::following(one->fields)));
    encoded_.keyframes.push_back(one);
    keep_sea_state(one->epoch);
    return {};
}

void FetchJob::keep_sea_state(std::uint32_t epoch) {
    const std::vector<EncodedKeyframePtr>& all = encoded_.keyframes;
    const std::shared_ptr<Core> alive = core_.lock();
    if (!alive || std::ranges::count(all, epoch, &EncodedKeyframe::epoch) > 1)
        return;
    if (protocol::SharedBytes sea_state = alive->host.sea_state_message(epoch))
        encoded_.sea_states.push_back(std::move(sea_state));
}

/// Only the first end that is told counts. Behind one for which there was no memory nothing is worked on any more, and
/// whoever comes next tells it.
void FetchJob::end(Result<FetchedTiles> encoded) {
    if (ended_.exchange(true))
        return;
    Undo told([&] { ended_ = false; });
    wanted_here_ = nullptr;
    give_back_(std::move(encoded));
    told.keep();
}

} // namespace seaway::server
