// SPDX-License-Identifier: Apache-2.0
// FetchJob: what one fetch, or the start of a subscription, brings: encoded keyframe by keyframe as it comes, and
// given back once, whole or as the reason why not. Comes from the host on any thread, is encoded on the
// encode thread, and ends on either.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <vector>

#include "server/host/host.h"
#include "server/net/core.h"
#include "server/publish/encoder.h"

namespace seaway::server {

/// Keyframes, and the fields that each of them holds.
struct FetchedTiles {
    std::vector<EncodedKeyframePtr> keyframes;
    sea::FieldSet fields;
    std::vector<protocol::SharedBytes> sea_states = {}; ///< of their epochs
};

/// Refusals: more than one session may be sent; what nobody has read yet fills its share of the memory.
Error tiles_too_large(std::size_t bytes_max);
Error no_room_for(std::string_view what);

class FetchJob : public std::enable_shared_from_this<FetchJob> {
  public:
    using GiveBack = std::function<void(Result<FetchedTiles>)>;

    /// `start`: of a subscription, whose tiles are the stream's.
    FetchJob(std::weak_ptr<Core> core, sea::FieldSet wanted, bool start, const Asker& session,
             GiveBack give_back);

    /// One that is lost, for want of memory, has ended too.
    ~FetchJob();

    /// Gone with the session, or once the fetch has ended for another reason.
    const Asker& asker() const { return asker_; }

    /// Host's answer, on any thread: encoding is for the encode thread.
    void bring(Result<FetchedPart> fetched);

  private:
    struct Part {
        FetchedPart fetched;
        std::size_t done = 0;
    };

    bool encode(Part& part, Encoder& encoder);
    Room* streamed_room() const;
    Result<void> take(const EncodedKeyframePtr& one, sea::FieldSet follows);
    Result<void> keep(const EncodedKeyframePtr& one, sea::FieldSet follows);
    /// Here, because a sea that nobody has kept is made anew for it, which the network's thread would wait for.
    void keep_sea_state(std::uint32_t epoch);
    void end(Result<FetchedTiles> encoded);

    const std::weak_ptr<Core> core_;
    const sea::FieldSet wanted_;
    const bool start_;
    std::shared_ptr<const void> wanted_here_ = std::make_shared<char>();
    const Asker asker_;
    const GiveBack give_back_;
    std::atomic<bool> ended_ = false;
    FetchedTiles encoded_; ///< of the encode thread
    std::size_t bytes_ = 0;
};

} // namespace seaway::server
