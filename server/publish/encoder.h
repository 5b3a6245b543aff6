// SPDX-License-Identifier: Apache-2.0
// Encoder: keyframes to complete Tile messages, once for each quality, shared by every session that
// sends them. A keyframe has one number for all sessions, so that the bytes are the same for all.
//
//     Encoder encoder;
//     auto encoded = encoder.encode(*keyframe, codec_error, quality, wanted);
//
// Remembers the newest keyframes, as many as there is room for, so that a new subscriber costs no
// encoding of what has just been streamed. For one thread; what it returns may go to any thread.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "base/result.h"
#include "protocol/messages.h"
#include "sea/surface/maps/keyframe.h"
#include "sea/surface/maps/regrid.h"
#include "server/host/memory.h"

namespace seaway::server {

/// The Tile messages of one field: parts of at most tile_side_max samples a side, row by row.
struct EncodedField {
    sea::Field field;
    float error; ///< bound of the codec, in the field's unit
    std::vector<protocol::SharedBytes> parts;
};

/// A keyframe as messages. Immutable.
struct EncodedKeyframe {
    std::uint64_t number = 0; ///< of (epoch, cascade, time, quality); counts up from 1
    std::uint32_t epoch = 0;
    int cascade = 0;
    sea::TimeUs time_us = 0;
    std::uint8_t quality = 0;
    sea::FieldSet fields;
    std::vector<EncodedField> maps; ///< in table order
    std::size_t bytes = 0;          ///< of all messages
    Room::Place place = {}; ///< among what the stream has still to send, if it is the stream's
};
using EncodedKeyframePtr = std::shared_ptr<const EncodedKeyframe>;

/// Bytes of the messages that carry `fields`.
std::size_t message_bytes(const EncodedKeyframe& keyframe, sea::FieldSet fields);

struct EncoderCounters {
    std::uint64_t fields_encoded = 0;
    std::uint64_t fields_reused = 0; ///< served from memory
    std::uint64_t samples = 0;       ///< encoded
    std::uint64_t bytes = 0;         ///< of the messages made
    double seconds = 0;              ///< spent encoding
};

/// How maps are sent to who takes them compact.
struct CompactTiles {
    int size =
        0; ///< linear ones on a grid of so many points a side, which carries their waves; 0: their own
    sea::FieldSet follows; ///< what tiles say that is not sent, because it follows from them
    sea::CoarserLoss coarser = {}; ///< what tiles say that they miss
};

class Encoder {
  public:
    /// Remembers what `room` has bytes for.
    explicit Encoder(std::shared_ptr<Room> room = Memory().room(MemoryUse::encoded))
        : room_(std::move(room)) {}

    /// Encodes those of `wanted` that the keyframe holds. codec_error: one bound a held field in
    /// table order, 0 for lossless. `compact`: always the same for a quality and cascade. What is made for
    /// the stream has its place in `streamed` for as long as somebody holds it. An error means that
    /// the maps are wrong (not finite): nothing of the keyframe may be sent. About 0.4 ms a field of
    /// 256 x 256; half of that on a grid of 80.
    Result<EncodedKeyframePtr> encode(const sea::Keyframe& keyframe,
                                      std::span<const float> codec_error, std::uint8_t quality,
                                      sea::FieldSet wanted, const CompactTiles& compact = {},
                                      Room* streamed = nullptr);

    const EncoderCounters& counters() const { return counters_; }
    /// Bytes of all remembered messages.
    std::size_t remembered_bytes() const { return room_->held_bytes(); }

  private:
    EncodedKeyframePtr find(const sea::Keyframe& keyframe, std::uint8_t quality) const;
    void remember(EncodedKeyframePtr encoded);
    /// The linear maps of these fields on the smaller grid.
    sea::Keyframe compacted(const sea::Keyframe& keyframe, sea::FieldSet fields, int size);
    /// A map of `keyframe`.
    Result<EncodedField> encode_field(const sea::Keyframe& keyframe, sea::Field field, float error,
                                      std::uint64_t number, const CompactTiles& compact);

    struct Remembered {
        EncodedKeyframePtr keyframe;
        Room::Place place;
    };
    const std::shared_ptr<Room> room_;
    std::deque<Remembered> cache_; ///< newest last
    std::uint64_t next_number_ = 1;
    std::map<std::pair<int, int>, sea::Regrid> regrids_; ///< by sides, from and to
    EncoderCounters counters_;
};

} // namespace seaway::server
