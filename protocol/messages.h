// SPDX-License-Identifier: Apache-2.0
// Wire messages: bytes to a verified message, and values to bytes, for both directions. Neither
// server nor client touches FlatBuffers to write; both read through the generated accessors, and
// only after MessageReader::read has said yes.
//
//     MessageReader reader(Sender::client);
//     Result<const wire::Message*> message = reader.read(bytes);
//     if (!message) ...                                  // close the session: bad_message
//     if (const auto* query = (*message)->body_as_Query())
//         if (Result<void> fine = check(*query); !fine) ...   // refuse the request: bad_value
//
// read() proves the structure: nothing read through the accessors is out of bounds. check() proves
// the values of one body: ranges, counts and sizes (message_checks.cpp). Builders are given values
// of our own and do not fail. All functions are thread-safe; a MessageReader is for one thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "protocol/limits.h"
#include "protocol/message_table.h"
#include "protocol/seaway_generated.h"
#include "sea/basics/dispersion.h"
#include "sea/basics/field.h"
#include "sea/basics/glide.h"
#include "sea/basics/pace.h"
#include "sea/basics/probe.h"
#include "sea/basics/time.h"
#include "sea/basics/water_type.h"
#include "sea/basics/wave_block.h"
#include "sea/surface/answer.h"
#include "sea/surface/map_error.h"

namespace seaway::protocol {

/// The version of the protocol that this code speaks; also in the name of the subprotocol.
inline constexpr std::uint16_t version = 1;
inline constexpr std::string_view websocket_subprotocol = "seaway.v1";
inline constexpr std::string_view stream_path = "/v1/stream";

/// One complete wire message.
using Bytes = std::vector<std::uint8_t>;
/// Immutable, shared by all sessions that send it.
using SharedBytes = std::shared_ptr<const Bytes>;

// ---- reading -------------------------------------------------------------------------------

class MessageReader {
  public:
    explicit MessageReader(Sender sender) : sender_(sender) {}

    /// Verifies size, identifier, structure, depth and direction. The message points into `bytes`,
    /// or into a copy kept here where `bytes` is not aligned to 8; it is valid until the next call.
    /// A body kind that this version does not know is an error from a client; from a server it is
    /// returned, to be skipped (Body_NONE is never returned). About 50 ns, 1 us with 1000 points.
    Result<const wire::Message*> read(std::span<const std::uint8_t> bytes);

  private:
    Sender sender_;
    std::vector<std::uint64_t> aligned_;
};

/// Values in range? The message of the error names field, value and range. The first is for a
/// message of any kind; kinds that are not listed have no value that could be wrong.
Result<void> check(const wire::Message& message);
Result<void> check(const wire::Hello& hello);
Result<void> check(const wire::Subscribe& subscribe);
Result<void> check(const wire::Ack& ack);
Result<void> check(const wire::Fetch& fetch);
Result<void> check(const wire::Query& query);
Result<void> check(const wire::Change& change);
Result<void> check(const wire::Administer& administer);
Result<void> check(const wire::Welcome& welcome);
Result<void> check(const wire::SeaState& state);
Result<void> check(const wire::Subscribed& subscribed);
Result<void> check(const wire::Tile& tile);
Result<void> check(const wire::QueryReply& reply);
Result<void> check(const wire::SubscribeSpectrum& subscribe);
Result<void> check(const wire::SpectrumSubscribed& subscribed);
Result<void> check(const wire::Spectrum& spectrum);
Result<void> check(const wire::SpectrumChunk& chunk);
Result<void> check(const wire::Changed& changed);
Result<void> check(const wire::Pace& pace);
Result<void> check(const wire::Pong& pong);
Result<void> check(const wire::GoAway& go_away);

// ---- client to server ----------------------------------------------------------------------

Bytes hello(std::string_view client, std::string_view token,
            std::span<const std::uint16_t> versions = {&version, 1});

/// What a client wants streamed or fetched.
struct TileWish {
    std::uint32_t cascades = sea::all_cascades; ///< bit c: cascade c
    sea::FieldSet fields = {};
    float error_m = 0; ///< wanted bound on height, all parts together; 0: the server chooses
    /// Takes linear maps at the smallest grid that carries their waves, brings them to the cascade's own, and makes
    /// displacements of heights (docs/protocol.md, "Compact maps"). Of a wish only.
    bool compact = false;
    /// Of compact maps takes differences to what follows from earlier ones (docs/protocol.md, "Predicted maps"). Of a wish
    /// for a stream only.
    bool predicted = false;
    /// Keyframes of a cascade a second and grid points a side of a map, at most; 0: any. Of a subscription. Granted: where
    /// that is less than all there is.
    float rate_hz_max = 0;
    int size_max = 0;
};

/// credit: limits::credit_min .. credit_max unacknowledged keyframes.
Bytes subscribe(std::uint32_t request_id, const TileWish& wish, int credit);
/// Of tiles, or of the spectrum.
Bytes unsubscribe(bool spectrum = false);
/// `also`: others that are complete, at most limits::keyframes_per_ack_max with the first; a server whose Welcome does
/// not say that it takes several overlooks them.
Bytes ack(std::uint64_t keyframe, std::span<const std::uint64_t> also = {});
Bytes fetch(std::uint32_t request_id, std::span<const sea::TimeUs> times_us, const TileWish& wish);
/// `z_m`: none, or one a point.
Bytes query(std::uint32_t request_id, std::span<const sea::QueryPoint> points, bool exact,
            const sea::Looking& looking = {}, std::span<const double> z_m = {});
sea::Looking looking(const wire::Query& query);
/// How exactly a client wants the waves, and what it wants to make of them. Bounds of 0: the server chooses.
struct SpectrumWish {
    float error_m = 0;
    float slope_error = 0;
    sea::FieldSet fields = sea::surface_fields;
};
Bytes subscribe_spectrum(std::uint32_t request_id, const SpectrumWish& wish);
Bytes ping(std::uint32_t request_id, std::int64_t client_time_us);

/// A change of the sea. `set`: "path=value" each, or `scene`: TOML, or `pace_permille`: the others empty.
struct ChangeWish {
    std::vector<std::string> set = {};
    std::string scene = {};
    sea::TimeUs over_us = 0;
    sea::TimeUs at_us = 0; ///< past: as soon as can be
    std::optional<int> pace_permille = {};
};
Bytes change(std::uint32_t request_id, const ChangeWish& wish);
Bytes administer(std::uint32_t request_id, wire::Act act, std::uint64_t session);

// ---- server to client ----------------------------------------------------------------------

/// Of a Welcome or Pong.
template <class Told>
sea::SeaTime sea_time(const Told& told) {
    const flatbuffers::Optional<std::int64_t> elapsed_us = told.elapsed_us();
    sea::SeaTime time(told.sea_time_us(), elapsed_us ? *elapsed_us : told.sea_time_us());
    time.unsure_us = std::clamp(told.unsure_us(), std::int64_t{0}, limits::unsure_us_max);
    return time;
}

/// Limits are filled in from protocol/limits.h.
Bytes welcome(std::uint64_t session, std::string_view server, const sea::SeaTime& time);

struct CascadeInfo {
    double length_m = 0;
    int size = 0;
    double k_lo_radpm = 0; ///< of its longest wave: where its band begins, or a wave given by hand
    double k_hi_radpm = 0;
    bool placed_alone = false;    ///< no waves of spectra, those alone that a scene places
    std::int64_t interval_us = 0; ///< between keyframes, which lie at whole multiples of it
    bool stylised = false;        ///< some of its waves are no modes: they move nothing sideways
};

/// Bulk statistics of a sea; names as in `seaway-inspect --format json`.
struct SeaNumbers {
    double hs_m = 0;
    double tp_s = 0;
    double tz_s = 0;
    double tm01_s = 0;
    double mean_from_deg = 0;
    double spread_deg = 0;
    double mss = 0;
};

/// Each on its way from one sea to the next; the bearing the shorter way round.
SeaNumbers glided(const SeaNumbers& from, const SeaNumbers& to, double share);

/// What a sea that glides over to another began with.
struct GlideValues {
    sea::TimeUs end_us = 0;
    double choppiness_x = 1;
    double choppiness_y = 1;
    double foam_mean = 0;
    double foam_threshold = 0;
    std::optional<SeaNumbers> realised = {}; ///< none: a server that does not say
    /// Of the sea that it leads to, from end_us on. Empty from a server that sends none.
    std::vector<sea::Probe> leads_to = {};
    /// Of each cascade: of the longest wave that either sea has. Empty from a server that does not say.
    std::vector<double> k_lo_radpm = {};
};

/// SeaState as a value.
struct SeaStateValues {
    std::uint32_t epoch = 0;
    sea::TimeUs start_time_us = 0; ///< this sea runs from here on
    std::vector<CascadeInfo> cascades = {};
    double choppiness_x = 1;
    double choppiness_y = 1;
    double height_error_m = 0; ///< the budget of the scene
    SeaNumbers requested = {};
    SeaNumbers realised = {};
    double interpolation_error_m = 0; ///< part of every stated bound
    double rms_slope = 0;
    double curvature_per_m =
        0; ///< of the surface at choppiness 0, at most; 0: of a server that says none
    std::string scene = {}; ///< effective scene, TOML
    std::vector<std::string> warnings = {};
    double foam_mean = 0;                    ///< mean coverage; what foam maps are ratios to
    double foam_threshold = 0;               ///< Jacobian below which a crest breaks
    double displacement_reach_m = 0;         ///< no point is moved further, choppiness included
    double rms_strain = 0;                   ///< of the divergence of D, 1
    double interpolation_displacement_m = 0; ///< as interpolation_error_m, of D
    double interpolation_strain = 0;         ///< likewise, of grad D, 1
    /// What those are made of, one a cascade; nothing of it is coded. Empty from a server that says none.
    std::vector<sea::CascadeLoss> losses = {};
    double single_precision_m = 0; ///< part of interpolation_error_m
    double single_precision_displacement_m = 0;
    /// Still depth; 0: of a server that says none, deep.
    double depth_m = 0;
    sea::Water water = {}; ///< a type that this version does not know is the default
    /// By which a sea that was rebuilt can be known again. Empty from a server that sends none.
    std::vector<sea::Probe> probes = {};
    double probe_error_m = 0;
    std::optional<GlideValues> glide = {};     ///< none: the sea is steady
    std::optional<sea::WaveLaw> wave_law = {}; ///< by which keyframes are predicted; none: by none

    // Of a moment: as above, or on the way there.
    double choppiness_x_at(sea::TimeUs time_us) const {
        return glided(&GlideValues::choppiness_x, choppiness_x, time_us);
    }
    double choppiness_y_at(sea::TimeUs time_us) const {
        return glided(&GlideValues::choppiness_y, choppiness_y, time_us);
    }
    double foam_mean_at(sea::TimeUs time_us) const {
        return glided(&GlideValues::foam_mean, foam_mean, time_us);
    }
    double foam_threshold_at(sea::TimeUs time_us) const {
        return glided(&GlideValues::foam_threshold, foam_threshold, time_us);
    }
    /// Hs is at least what it is then: heights of two seas add up to no more than their sum.
    SeaNumbers realised_at(sea::TimeUs time_us) const;
    /// Of this sea from `time_us` on.
    double highest_hs_m(sea::TimeUs time_us) const {
        return std::max(realised_at(time_us).hs_m, realised.hs_m);
    }
    double glided(double GlideValues::*from, double to, sea::TimeUs time_us) const;
    /// Of the longest wave that a cascade has at any time of this epoch: who is too long to feel that one feels none of them.
    double longest_radpm(std::size_t cascade) const {
        return glide && !glide->k_lo_radpm.empty() ? glide->k_lo_radpm[cascade]
                                                   : cascades[cascade].k_lo_radpm;
    }
};
Bytes sea_state(const SeaStateValues& state);
/// The inverse; `state` must have passed check().
SeaStateValues values(const wire::SeaState& state);

/// `why`: in what that is less than the wish; empty: in nothing.
Bytes subscribed(std::uint32_t request_id, const TileWish& grant, int credit,
                 std::string_view why = {});

/// Everything of a Tile message but its payload.
struct TileHeader {
    std::uint64_t keyframe = 0; ///< to acknowledge; one number space for all sessions
    std::uint32_t epoch = 0;
    int cascade = 0;
    sea::Field field = sea::Field::height;
    sea::TimeUs time_us = 0;
    int size = 0; ///< grid points a side of the whole map
    int x0 = 0;   ///< first column of this part
    int y0 = 0;   ///< first row
    int width = 0;
    int height = 0;
    int part = 0;
    int parts = 1;   ///< of this field of the keyframe
    float error = 0; ///< bound that the encoder met, in the field's unit
    /// Fields of this keyframe that follow from this map and are not sent (sea::following).
    sea::FieldSet follows = {};
    /// What it misses beside what the sea says of its maps; interval_us 0: nothing.
    sea::CoarserLoss coarser = {};
    /// Others may be differences to this keyframe; of a tile that is one: the keyframe that it is to. 0: neither.
    std::uint64_t base = 0;
    sea::CodedNoise noise = {}; ///< of the keyframe's heights, in tiles of their rates
};
Bytes tile(const TileHeader& header, std::span<const std::uint8_t> payload);
/// The inverse; `tile` must have passed check().
TileHeader header(const wire::Tile& tile);

/// `below`: none, or one an answer. `cascades`: those that counted, of a query that left some out; none: all did.
Bytes query_reply(std::uint32_t request_id, std::uint32_t epoch,
                  std::span<const sea::Answer> answers, std::span<const sea::WaterBelow> below = {},
                  std::optional<std::uint32_t> cascades = {});
sea::Answer answer(const wire::PointAnswer& answer);
sea::WaterBelow water(const wire::Below& below);

Bytes fetch_done(std::uint32_t request_id, std::uint32_t keyframes, sea::FieldSet fields);
Bytes pong(std::uint32_t request_id, std::int64_t client_time_us, const sea::SeaTime& time);
Bytes pace(const sea::Pace& pace);
sea::Pace pace(const wire::Pace& pace);
/// What a SubscribeSpectrum gets.
struct SpectrumGrant {
    float error_m = 0;
    float slope_error = 0;
    sea::FieldSet fields = {};
    std::uint32_t spectra = 0; ///< that come now
    std::string why = {};      ///< in what this is less than the wish; empty: in nothing
};
Bytes spectrum_subscribed(std::uint32_t request_id, const SpectrumGrant& grant);
/// The inverse; `subscribed` must have passed check().
SpectrumGrant grant(const wire::SpectrumSubscribed& subscribed);

/// Spectrum as a value.
struct SpectrumHead {
    std::uint32_t epoch = 0;
    std::uint32_t chunks = 0;
    std::uint32_t bytes = 0; ///< of all payloads
    sea::SpectrumSteps steps = {};
    sea::Dispersion dispersion = {};
    sea::TimeUs loop_period_us = 0;
};
Bytes spectrum(const SpectrumHead& head);
/// The inverse; `spectrum` must have passed check().
SpectrumHead head(const wire::Spectrum& spectrum);

/// `left`: once this chunk and those before it are there. Stated in floats that are never less.
Bytes spectrum_chunk(std::uint32_t epoch, std::uint32_t chunk, const sea::SpectrumLeft& left,
                     std::span<const std::uint8_t> payload);
sea::SpectrumLeft left(const wire::SpectrumChunk& chunk);

/// `change`: its number in the journal; 0: there is none.
Bytes changed(std::uint32_t request_id, std::uint32_t epoch, sea::TimeUs start_us,
              sea::TimeUs end_us, std::uint32_t change);
Bytes administered(std::uint32_t request_id, std::string_view text);
/// `retry_after_ms`: not worth asking again before; 0: nothing is known.
Bytes refused(std::uint32_t request_id, wire::ErrorCode code, std::string_view message,
              std::uint32_t retry_after_ms = 0);
/// `retry_after_ms`: not to come back before, at most limits::retry_after_ms_max; 0: nothing is known.
Bytes go_away(wire::ErrorCode code, std::string_view message, std::uint32_t retry_after_ms = 0);

/// "bad_message" and so on, as in logs and metrics; "unknown" for codes of later versions.
std::string_view name(wire::ErrorCode code);

/// WebSocket close code of an ended session: 1000 for none, else 4000 + code.
std::uint16_t close_code(wire::ErrorCode code);

} // namespace seaway::protocol
