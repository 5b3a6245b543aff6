// SPDX-License-Identifier: Apache-2.0
// How far the stream goes ahead of what is asked for, on each thread that works on both: the one that makes keyframes
// (server/simulation/simulation.h) and the one that encodes them (server/net/encode_worker.h).
#pragma once

namespace seaway::server {

/// Slices of keyframes that are due before what was asked for has one: the stream goes first, and one that never
/// catches up still leaves turns to those who ask, a fifth of the thread where slices are as long.
inline constexpr int stream_slices_ahead = 4;

} // namespace seaway::server
