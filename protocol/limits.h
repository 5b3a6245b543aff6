// SPDX-License-Identifier: Apache-2.0
// Every limit of the wire, by name, with its reason. docs/protocol.md lists them for client
// writers; Welcome tells a client those that it has to respect. Constants only.
#pragma once

#include <cstddef>
#include <cstdint>

#include "sea/surface/answer.h"

namespace seaway::protocol::limits {

// ---- bytes ---------------------------------------------------------------------------------

/// A message from a client. The largest is a Query of `points_per_query_max` points: 96 KiB and its
/// frame. Known before a byte is buffered, so a hostile length costs nothing.
inline constexpr std::size_t client_message_bytes_max = 128 * 1024;

/// A message from the server. The largest is an incompressible tile part (256 KiB and its frame); a
/// reply to 4096 points is 160 KiB.
inline constexpr std::size_t server_message_bytes_max = 512 * 1024;

/// Name and token of a client.
inline constexpr std::size_t hello_text_bytes_max = 1024;

/// The effective scene that SeaState carries: an ordinary scene is 2 KB, measured ones name a file.
inline constexpr std::size_t scene_bytes_max = 128 * 1024;

// ---- FlatBuffers verifier ------------------------------------------------------------------

/// Message, its body, and nothing nested deeper: 2 tables. Room for growth.
inline constexpr std::size_t verifier_depth_max = 8;
inline constexpr std::size_t verifier_tables_max = 32;

// ---- tiles ---------------------------------------------------------------------------------

/// Side of a tile part: 64 Ki samples decode in 0.3 ms, and a reply never waits long behind one.
inline constexpr int tile_side_max = 256;

/// Side of a whole map (sea/basics/cascade.h).
inline constexpr int map_side_max = 2048;

/// Parts of one field of a keyframe: (2048 / 256)^2.
inline constexpr int parts_max = 64;

/// Cascades of one sea: the demand is a 32-bit set, and a scene has 3 to 5.
inline constexpr int cascades_max = 16;

/// Probes of a sea; ours has 16 (sea/basics/probe.h).
inline constexpr std::size_t probes_max = 64;

// ---- spectra -------------------------------------------------------------------------------

/// Blocks of 8 x 8 waves in one chunk: decoded, 256 KiB at most.
inline constexpr std::size_t spectrum_blocks_max = 512;

/// Payload of one chunk: a reply never waits longer behind it.
inline constexpr std::size_t spectrum_chunk_bytes_max = 16 * 1024;

/// All chunks of one sea; a finer spectrum is not granted. Most are below 100 KB.
inline constexpr std::size_t spectrum_bytes_max = 4u * 1024 * 1024;

/// Waves of a sea to come, a session, in sea time; faster where they would not be there by the end of the glide.
inline constexpr double spectrum_bytes_per_s = 1900;

/// Chunks of one sea.
inline constexpr std::uint32_t spectrum_chunks_max = 4096;
/// What may be missed of waves of which none has come yet.
inline constexpr float spectrum_left_m_max = 1e6f;
inline constexpr float spectrum_left_displacement_m_max = 1e9f;
inline constexpr float spectrum_left_slope_max = 1e6f;

/// Spectra at once: of the sea that runs, of the glides that it took over from and the sea that they left, ten together, and of
/// those that were announced.
inline constexpr std::uint32_t spectra_max = 16;
/// Sea states that a server takes a client to know still, of those that it was told last; clients hold more, and so never lack
/// one whose tiles come: twice a timetable.
inline constexpr std::size_t sea_states_told = 64;
inline constexpr std::size_t sea_states_held = 256;

/// Of a sea, each of so many bytes. What a server has to say beyond that it says in its log.
inline constexpr std::size_t warnings_max = 128;
inline constexpr std::size_t warning_bytes_max = 1024;

/// Bound on a slope that a SubscribeSpectrum may wish for: what is as coarse says nothing.
inline constexpr float slope_error_max = 10.0f;

// ---- requests ------------------------------------------------------------------------------

/// Points a Query: the reply stays under one tile in size; batching, not transport, decides
/// throughput, and above 1024 points a batch there is nothing left to win.
inline constexpr std::uint32_t points_per_query_max = 4096;

/// Points of an exact Query: each costs a search by direct sums. Three cascades of 256: 0.03 ms in a gale, 0.2
/// to 4 in a sea that folds; of 1024: 0.4 ms in a gale, 10 in a sea that folds, where a full batch holds a core
/// for 2.5 s, 1.4 s in a tangle of sheets. It is worked on 5 ms, or one point, at a time.
inline constexpr std::uint32_t exact_points_per_query_max = 256;

/// Sea times and positions that a client may ask about, either side of 0 (sea/basics/time.h,
/// sea/surface/answer.h say why).
inline constexpr std::int64_t time_us_max = sea::time_us_max;
inline constexpr double position_m_max = sea::position_max_m;

/// Bound on height that a Subscribe or Fetch may wish for, m: no sea is higher.
inline constexpr float error_m_max = 1e6f;

/// The lowest rate of keyframes and the smallest maps that a Subscribe may ask for: what is less says nothing of most seas.
inline constexpr float rate_hz_min = 1.0f;
inline constexpr float rate_hz_max = 1000.0f;
inline constexpr int size_min = 32;

/// Times a Fetch: two keyframes of every cascade for each.
inline constexpr std::uint32_t times_per_fetch_max = 8;

/// Queries of one session that the simulation has not answered: enough to hide the round trip.
inline constexpr int queries_in_flight_max = 16;

/// Fetches (and starts of subscriptions) of one session whose tiles are not all sent: what they
/// hold is the largest thing a session can make the server keep. Raw keyframes are held for all
/// sessions together, in a share of the one budget (server/host/memory.h).
inline constexpr int fetches_in_flight_max = 2;

/// Values that a Change may set, and what each may hold; its scene has what is left of a message.
inline constexpr std::size_t values_per_change_max = 64;
inline constexpr std::size_t change_value_bytes_max = 1024;
inline constexpr std::size_t change_scene_bytes_max = 120 * 1024;

/// What a server says to an administrator, JSON.
inline constexpr std::size_t administered_bytes_max = 256 * 1024;

/// Protocol versions that a Hello may list.
inline constexpr std::size_t versions_per_hello_max = 16;

// ---- sending -------------------------------------------------------------------------------

/// Grid points a side of maps that are predicted, at most: what both sides keep for that, and what it costs, has a bound.
inline constexpr int predicted_size_max = 512;

/// Keyframes of a cascade that wait for a session as steps to the newest, at most.
inline constexpr std::size_t steps_waiting_max = 16;

/// Streamed keyframes that a session may leave unacknowledged: 1 is for the newest picture, 2 hides
/// the round trip, 8 is for long fat links with many cascades.
inline constexpr int credit_min = 1;
inline constexpr int credit_default = 2;
inline constexpr int credit_max = 8;

/// Keyframes that one Ack may name, one in its `keyframe`, the others in `also`: all that a window holds, and one that
/// was fetched.
inline constexpr std::uint32_t keyframes_per_ack_max = 1 + credit_max;

/// Replies that wait for a session, by count and by bytes. From there on the session is not read
/// from, so that only the queries already in flight can add to them.
inline constexpr std::size_t replies_waiting_max = 64;
inline constexpr std::size_t replies_bytes_max = 1024 * 1024;

/// Durable messages (sea states, paces) that wait for a session; one more closes it as too slow. More than a newcomer is told at
/// once of a dense timetable that runs fast; they are the same bytes for all.
inline constexpr std::size_t durable_waiting_max = sea_states_told;

/// For how long a GoAway may ask a client to stay away: an hour.
inline constexpr std::uint32_t retry_after_ms_max = 3'600'000;
/// A server that has been unsure of its sea for longer has been so for this long: a day.
inline constexpr std::int64_t unsure_us_max = 86'400'000'000;

/// Bytes of fetched tiles that wait for a session; a fetch that does not fit is refused.
inline constexpr std::size_t fetch_bytes_max = 32u * 1024 * 1024;

} // namespace seaway::protocol::limits
