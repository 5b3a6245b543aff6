// SPDX-License-Identifier: Apache-2.0
// Encoder: keyframes to complete Tile messages, once for each quality, shared by every session that
// sends them. A keyframe has one number for all sessions, so that the bytes are the same for all.
//
//     Encoder encoder;
//     auto encoded = encoder.encode(*keyframe, codec_error, quality, wanted);
//
// Where a law of waves is given, heights and their rates have a second form, the difference to what follows from the newest
// keyframe of the same sea, cascade and quality (docs/protocol.md, "Predicted maps"): for whoever was sent that one.
//
// Remembers what was used lately, as far as there is room, so that a new subscriber costs no encoding of what has just
// been streamed: a keyframe goes when its stream has gone on by `unused_max` since anybody wanted it.
// For one thread, but for counters(); what it returns may go to any thread.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/result.h"
#include "protocol/messages.h"
#include "sea/surface/maps/keyframe.h"
#include "sea/surface/maps/predictor.h"
#include "sea/surface/maps/regrid.h"
#include "server/host/memory.h"
#include "server/host/quality.h"
#include "server/publish/predicted_noise.h"

namespace seaway::server {

/// The Tile messages of one field: parts of at most tile_side_max samples a side, row by row.
struct EncodedField {
    sea::Field field;
    float error; ///< bound of the codec, in the field's unit
    std::vector<protocol::SharedBytes> parts;
    /// The same for who has the keyframe's `base`; none: there is no such form.
    std::vector<protocol::SharedBytes> differences = {};
};

/// A keyframe as messages. Immutable.
struct EncodedKeyframe {
    std::uint64_t number = 0; ///< of (epoch, cascade, time, quality); counts up from 1
    std::uint32_t epoch = 0;
    int cascade = 0;
    sea::TimeUs time_us = 0;
    Quality quality = 0;
    sea::FieldSet fields;
    sea::FieldSet follows;          ///< what its tiles say that follows from them
    std::uint64_t base = 0;         ///< the keyframe that differences are to; 0: there are none
    std::vector<EncodedField> maps; ///< in table order
    std::size_t bytes = 0;          ///< of all messages, in all forms
    Room::Place place = {}; ///< among what the stream has still to send, if it is the stream's
};
using EncodedKeyframePtr = std::shared_ptr<const EncodedKeyframe>;

/// What takes part in predictions.
inline constexpr sea::FieldSet predicted_fields{sea::Field::height, sea::Field::height_rate};

/// Bytes of the messages that carry `fields`, whole or as differences where it has them.
std::size_t message_bytes(const EncodedKeyframe& keyframe, sea::FieldSet fields,
                          bool differs = false);

/// Which of its maps bring all that was granted, `fields` and `follows`: whatever of it follows from others in one keyframe may
/// be a map in the next, where the sea changes. Empty: it lacks some.
sea::FieldSet maps_that_bring(const EncodedKeyframe& keyframe, sea::FieldSet fields,
                              sea::FieldSet follows);

struct EncoderCounters {
    std::uint64_t fields_encoded = 0;
    std::uint64_t fields_reused = 0;    ///< served from memory
    std::uint64_t fields_predicted = 0; ///< of those encoded: as differences, too
    std::uint64_t samples = 0;          ///< encoded
    std::uint64_t bytes = 0;            ///< of the messages made
    double seconds = 0;                 ///< spent encoding
};

/// How maps are sent to who takes them compact.
struct CompactTiles {
    int size =
        0; ///< linear ones on a grid of so many points a side, which carries their waves; 0: their own
    sea::FieldSet follows; ///< what tiles say that is not sent, because it follows from them
    sea::CoarserLoss coarser = {};        ///< what tiles say that they miss
    std::optional<sea::WaveLaw> law = {}; ///< by which heights are predicted; none: they are not
};

class Encoder {
  public:
    /// Keyframes of one cascade and quality that a new subscriber of a fast stream begins with, and one more: those between
    /// which now lies, and those of the lead (schedule.h) at 20 a second.
    static constexpr std::uint64_t unused_max = 8;

    /// Calls of trim() more for what was streamed: its stream may have ended, or be one of few keyframes.
    static constexpr std::uint64_t streamed_trims = 15;

    /// Remembers what `room` has bytes for at most.
    explicit Encoder(std::shared_ptr<Room> room = Memory().room(MemoryUse::encoded))
        : room_(std::move(room)) {}

    /// Encodes those of `wanted` that the keyframe holds. codec_error: one bound a held field in
    /// table order, 0 for lossless. `compact`: always the same for a quality and cascade. What is made for
    /// the stream has its place in `streamed` for as long as somebody holds it. An error means that
    /// the maps are wrong (not finite): nothing of the keyframe may be sent. About 0.4 ms a field of
    /// 256 x 256; half of that on a grid of 80.
    Result<EncodedKeyframePtr> encode(const sea::Keyframe& keyframe,
                                      std::span<const float> codec_error, Quality quality,
                                      sea::FieldSet wanted, const CompactTiles& compact = {},
                                      Room* streamed = nullptr);

    /// Lets go of what nobody has used since the call before the last one, of the stream later: what was made for fetches has no stream
    /// that goes on.
    void trim();
    /// There is something to trim().
    bool remembers() const { return !cache_.empty() || !bases_.empty(); }

    /// With all that has been returned. Any thread.
    EncoderCounters counters() const;
    /// Bytes of all remembered messages.
    std::size_t remembered_bytes() const { return room_->held_bytes(); }

  private:
    /// What is remembered of it, which is used now.
    EncodedKeyframePtr find(const sea::Keyframe& keyframe, Quality quality);
    void remember(EncodedKeyframePtr encoded);
    /// One more is streamed: what was not used since `unused_max` before it is forgotten, and so are bases of seas
    /// that are over.
    void forget_what_is_over(const sea::Keyframe& next, Quality quality);
    /// The linear maps of these fields on the smaller grid.
    sea::Keyframe compacted(const sea::Keyframe& keyframe, sea::FieldSet fields, int size);
    const sea::Regrid& regrid(int from, int to);

    /// Heights and rates of a keyframe as its receivers have them.
    struct Base {
        std::uint32_t epoch = 0;
        int cascade = 0;
        Quality quality = 0;
        std::uint64_t number = 0;
        sea::TimeUs time_us = 0;
        int size = 0;
        sea::WaveLaw law = {};
        std::vector<float> height, rate;
        PredictedNoise noise;
        Room::Place place;
        std::uint64_t trims = 0; ///< before its last use
    };
    /// From one keyframe of a cascade to the next.
    struct Step {
        std::uint64_t from = 0; ///< what it is predicted from; 0: nothing
        bool regridded = false; ///< receivers bring it to another grid
        NoiseBefore before;     ///< of that, in `bases_`
        PredictedNoise noise;   ///< once both are decoded
        struct Map {
            std::vector<float> expected; ///< [y][x]; none: nothing is
            std::vector<float> decoded;  ///< as receivers will have it
        };
        Map height, rate;

        /// Null: this field takes no part.
        Map* map_of(sea::Field field) {
            return field == sea::Field::height        ? &height
                   : field == sea::Field::height_rate ? &rate
                                                      : nullptr;
        }
    };
    /// None: what is sent takes no part in predictions.
    std::optional<Step> step_to(const sea::Keyframe& sent, Quality quality,
                                const CompactTiles& compact, bool regridded);
    /// What of both maps of a step is lost on the way, which are decoded.
    sea::CodedNoise lost(const sea::Keyframe& sent, Step& step);
    void keep(Step step, const sea::Keyframe& sent, const EncodedKeyframe& as,
              const sea::WaveLaw& law);

    /// A map of `keyframe`. `step`: null, or that in which the keyframe takes part in predictions.
    Result<EncodedField> encode_field(const sea::Keyframe& keyframe, sea::Field field, float error,
                                      std::uint64_t number, const CompactTiles& compact,
                                      Step* step);
    void count(const EncoderCounters& more);
    /// Of 8 cascades of two seas at four qualities.
    static constexpr std::size_t bases_max = 64;
    /// Nothing follows a keyframe that lies so far from what is streamed: its sea is over, nobody reads it, or sea time has gone
    /// back. What is a little newer stays: a newcomer's first keyframes are older than what the stream is at.
    static constexpr sea::TimeUs base_away_us_max = 60'000'000;

    struct Remembered {
        EncodedKeyframePtr keyframe;
        Room::Place place;
        std::uint64_t used = 0;  ///< when so many of its cascade and quality had been streamed
        std::uint64_t trims = 0; ///< before its last use
    };
    const std::shared_ptr<Room> room_;
    std::deque<Remembered> cache_;                              ///< newest last
    std::map<std::pair<int, Quality>, std::uint64_t> streamed_; ///< so many, by cascade and quality
    std::deque<Base> bases_;                                    ///< touched last: at the back
    sea::Predictor predictor_;
    std::uint64_t next_number_ = 1;
    std::uint64_t trims_ = 0;
    std::map<std::pair<int, int>, sea::Regrid> regrids_; ///< by sides, from and to
    mutable std::mutex counting_;                        ///< of what follows
    EncoderCounters counters_;
};

} // namespace seaway::server
