// SPDX-License-Identifier: Apache-2.0
// Outbox: what one session has still to send, and in which order. A plain data structure without
// sockets, threads or clocks; bounded whatever the peer does.
//
// Order: replies, then durable messages, then spectra, then tiles (fetched and streamed ones in turn).
// Streamed keyframes are under credit: at most `credit` of them are sent and not acknowledged. One
// that has to wait is replaced by a newer one of its cascade and sea; one that has begun is finished. One that is the
// difference to another is sent as that where the other was the last of its cascade that was, and whole where it was not;
// so those that wait stay, as steps to the newest, while all of them are smaller than the newest whole. They go together, under
// the credit of the newest: who acknowledges late is no further behind than with whole keyframes.
// Durable messages are never dropped: when they do not fit, the session must be closed. Chunks of a spectrum are
// not dropped either, and wait for as long as it takes: they are shared, so that a slow reader costs nothing.
#pragma once

#include <cstdint>
#include <deque>
#include <limits>
#include <span>
#include <vector>

#include "protocol/limits.h"
#include "server/host/encoded_spectrum.h"
#include "server/publish/keyframe_file.h"

namespace seaway::server {

struct OutboxCounters {
    std::uint64_t keyframes_started = 0;
    std::uint64_t keyframes_predicted = 0; ///< of those: as differences to what was sent before
    std::uint64_t keyframes_replaced = 0;  ///< never sent: a newer one took their place
    std::uint64_t keyframes_awaiting_credit = 0; ///< had to wait for an acknowledgement

    OutboxCounters& operator+=(const OutboxCounters& other) {
        keyframes_started += other.keyframes_started;
        keyframes_predicted += other.keyframes_predicted;
        keyframes_replaced += other.keyframes_replaced;
        keyframes_awaiting_credit += other.keyframes_awaiting_credit;
        return *this;
    }
};

class Outbox {
  public:
    /// Replies are bounded by their askers: read no more from the peer while accepts_requests() is
    /// false.
    void push_reply(protocol::SharedBytes message);
    bool accepts_requests() const;

    /// False if the lane is full: close the session, it is too slow.
    [[nodiscard]] bool push_durable(protocol::SharedBytes message);

    /// The tiles of `fields`, then `done`. False, and nothing is kept, if they exceed
    /// limits::fetch_bytes_max together with what waits.
    [[nodiscard]] bool push_fetched(std::span<const EncodedKeyframePtr> keyframes,
                                    sea::FieldSet fields, protocol::SharedBytes done);
    /// Fetches whose `done` has not been handed out.
    int fetches_waiting() const { return fetches_waiting_; }

    /// After those that wait; of two of one sea the later one counts. Of more than limits::spectra_max the
    /// oldest is given up: its sea is over.
    void push_spectrum(EncodedSpectrumPtr spectrum);
    /// The same for one that is needed whole only later: its head now, and the rest as allow_spectra() says, evenly until
    /// then, or by spectrum_bytes_per_s where that is sooner. Until another is pushed: then all of it goes at once.
    void push_paced_spectrum(EncodedSpectrumPtr spectrum, sea::TimeUs now_us);
    /// What has come due of those by this sea time may be handed out.
    void allow_spectra(sea::TimeUs now_us);
    /// One that is not paced.
    bool spectrum_waiting() const;
    /// There is something for allow_spectra().
    bool paces_spectra() const;
    void stop_spectra() { spectra_.clear(); }

    /// `file`: where its messages lie, too, if anywhere.
    void push_keyframe(EncodedKeyframePtr keyframe, sea::FieldSet fields,
                       KeyframeFilePtr file = nullptr);
    /// limits::credit_min .. credit_max.
    void set_credit(int keyframes);
    /// Forgets streamed keyframes that wait. Those begun are finished.
    void stop_stream();
    /// False if the keyframe was not in the window: fetched, or acknowledged before.
    bool acknowledge(std::uint64_t keyframe);

    /// The message to send next, or null if there is none (or no credit for it).
    protocol::SharedBytes next();
    /// Bytes of a file; none: null.
    struct Run {
        KeyframeFilePtr of;
        std::uint64_t begin = 0;
        std::uint64_t end = 0;
    };
    /// Where all that next() has handed out since sent() lies, if it lies in a file, one behind the other.
    const Run& run() const { return run_; }
    std::size_t handed_out() const { return handed_out_; } ///< messages since sent()
    /// All that next() has handed out is gone.
    void sent() {
        being_sent_ = {};
        handed_out_ = 0;
        run_ = {};
    }

    /// Forgets all, but what it has counted: who it was for is gone.
    void clear() noexcept;
    std::size_t bytes_waiting() const;
    std::size_t reply_bytes_waiting() const { return reply_bytes_; }
    /// A keyframe of the stream, and what it holds; number 0: none.
    struct Streamed {
        std::uint64_t number = 0;
        std::size_t bytes = 0;
    };
    /// The oldest one of which something waits or is being sent.
    Streamed oldest_streamed() const;
    bool is_sending_streamed() const { return being_sent_.number != 0; }
    const OutboxCounters& counters() const { return counters_; }

  private:
    /// A keyframe's messages, handed out one by one.
    struct Parcel {
        EncodedKeyframePtr keyframe;
        sea::FieldSet fields;
        protocol::SharedBytes done; ///< or this one message
        KeyframeFilePtr file = nullptr;
        bool differs = false; ///< sent as differences where it has them
        std::size_t map = 0;
        std::size_t part = 0;

        Streamed streamed() const;
        protocol::SharedBytes take(); ///< null when there is nothing left
        Run taken() const;            ///< where that lies
    };

    /// A spectrum's messages, handed out one by one.
    struct SpectrumParcel {
        EncodedSpectrumPtr spectrum;
        std::size_t next = 0;
        std::size_t bytes = 0; ///< handed out
        std::size_t allowed_bytes = std::numeric_limits<std::size_t>::max();
        sea::TimeUs begun_us = 0; ///< of one that is paced
        double bytes_per_s = 0;   ///< 0: at once
    };

    /// Of those that were streamed whole or as differences.
    struct Last {
        std::uint32_t epoch;
        int cascade;
        std::uint64_t number;
    };
    /// Decides the form of what is about to be sent.
    void begin(Parcel& parcel);
    /// Of this cascade and sea; 0: none.
    std::uint64_t last_streamed(const EncodedKeyframe& like) const;
    /// Is it reached by differences, from what was streamed over those that wait, for less than it takes whole?
    bool is_next_step(const EncodedKeyframe& keyframe, sea::FieldSet fields) const;
    /// Takes the place of those of its sea that wait, or of the oldest of other seas where two wait.
    void replace(Parcel parcel);

    protocol::SharedBytes next_message();
    protocol::SharedBytes next_spectrum();
    protocol::SharedBytes take_of(Parcel& parcel);
    protocol::SharedBytes next_fetched();
    protocol::SharedBytes next_streamed();

    std::deque<protocol::SharedBytes> replies_;
    std::size_t reply_bytes_ = 0;
    std::deque<protocol::SharedBytes> durable_;
    std::deque<SpectrumParcel> spectra_;
    std::deque<Parcel> fetched_;
    std::size_t fetched_bytes_ = 0;
    int fetches_waiting_ = 0;
    bool fetched_turn_ = true;
    std::deque<Parcel>
        waiting_;  ///< of a cascade: of each of two seas one, or steps to one; oldest first
    Parcel begun_; ///< streamed keyframe that is being handed out
    std::size_t handed_out_ = 0;     ///< messages since sent()
    Run run_;                        ///< of those
    Run last_run_;                   ///< of the last one
    Streamed being_sent_;            ///< the first one handed out since sent()
    std::deque<Last> last_streamed_; ///< one a cascade of each of two seas, newest last
    std::vector<std::uint64_t> unacknowledged_;
    int credit_ = protocol::limits::credit_default;
    OutboxCounters counters_;
};

} // namespace seaway::server
