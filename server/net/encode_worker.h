// SPDX-License-Identifier: Apache-2.0
// EncodeWorker: the thread that owns the Encoder. Streamed keyframes go before fetched ones, also in
// the middle of a fetch: a large one is encoded slice by slice. Ahead of what waits go stream_slices_ahead of them, then
// one slice of a start or of a fetch, in turns: a stream that never catches up keeps nobody from joining and no fetch from
// its end. Behind a long slice of a fetch the next one waits for as many times its length of the stream; starts do not.
// The lines are bounded: what does not fit is refused to its owner, who counts it. Of what is streamed the rungs with most
// readers go first, and where there is no room what has waited longest goes: sessions with wishes of their own take nothing
// from the others.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

#include "server/host/host.h"
#include "server/host/stream_ahead.h"
#include "server/publish/encoder.h"

namespace seaway::server {

class EncodeWorker {
  public:
    /// Encodes one keyframe a call; true: that was the last.
    using Job = std::function<bool(Encoder&)>;

    /// Rungs of keyframes that wait to be streamed: two keyframes of each of 8 cascades at all rungs that may be in use. A server
    /// that is further behind than that leaves some out.
    static constexpr std::size_t streamed_waiting_max = 16 * (whole_rungs + coarser_rungs_max);
    /// Parts of fetches, and starts of subscriptions, that wait: there is room for as many as all
    /// sessions may have in flight. How much they hold is bounded by who makes them.
    static constexpr std::size_t fetches_waiting_max = 4096;
    static constexpr std::size_t starts_waiting_max = 4096;

    /// Keyframes that wait to be streamed, and what the encoder remembers, have their room in `memory`.
    explicit EncodeWorker(MemoryPtr memory = std::make_shared<Memory>());
    ~EncodeWorker();
    EncodeWorker(const EncodeWorker&) = delete;
    EncodeWorker& operator=(const EncodeWorker&) = delete;

    /// A keyframe that is to be streamed at one of its rungs: those of lower rank go first, of one rung of a cascade those that
    /// came first. The keyframe has its room once, until the last of its rungs is encoded. How many rungs were left out for
    /// want of room, or of a place in the line: all that waits of the keyframes that came first, or this one. Any thread.
    [[nodiscard]] std::size_t submit_streamed(Job job, const KeyframeTiles& tiles = {});
    /// False: full, or stopped. Any thread.
    [[nodiscard]] bool submit_fetched(Job job);
    [[nodiscard]] bool submit_start(Job job);

    /// Drops what waits and joins the thread. Idempotent; not from a job.
    void stop();

    /// With all that its jobs have been told. Any thread.
    EncoderCounters counters() const;

  private:
    struct Waiting {
        Job job;
        sea::KeyframePtr of = nullptr; ///< streamed
        Room::Place place = {};        ///< shared by all rungs of a keyframe
        std::uint64_t arrived = 0;
        Quality quality = 0;
        std::size_t rank = 0;
    };
    using Line = std::deque<Waiting>;

    bool submit(Line& line, std::size_t waiting_max, Job job);
    /// Of the rungs that wait of a keyframe, or the one that is encoded now; null: none.
    const Waiting* another_of(const sea::KeyframePtr& keyframe) const;
    /// What waits of its stream, so that it goes ahead of it: by the rank that the stream has now, if that is lower.
    void bring_forward(const KeyframeTiles& tiles);
    /// All that waits of the keyframe that came first.
    void leave_out_the_oldest(Line& left_out);
    void run();
    /// The line whose turn it is, or null: streamed keyframes, as far as they go ahead, then starts and fetches one by one.
    Line* next_line();
    Waiting take_from(Line& line);
    /// What a slice of this line took of the thread.
    void note_took(const Line& line, double seconds);

    const MemoryPtr memory_;
    mutable std::mutex mutex_;
    std::condition_variable wake_;
    bool stopping_ = false;
    Line streamed_; ///< by rank, then as they came
    std::uint64_t arrived_ = 0;
    const Waiting* encoded_now_ = nullptr;
    Line fetched_;
    Line starts_;
    bool starts_turn_ = true; ///< before fetches
    int ahead_ = 0;     ///< streamed ones that went before others who wait, since the last of these
    double owed_s_ = 0; ///< what streamed ones are to take yet for what that took
    Encoder
        encoder_; ///< of the thread alone but for its counters, and made before it, where what throws is heard
    std::thread thread_;
};

} // namespace seaway::server
