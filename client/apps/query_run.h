// SPDX-License-Identifier: Apache-2.0
// What seaway-query does once its options are read.
#pragma once

#include <atomic>
#include <cstdio>
#include <functional>
#include <memory>
#include <random>
#include <span>
#include <vector>

#include "base/result.h"
#include "client/apps/query_options.h"
#include "client/client.h"

namespace seaway::client {

using Connect = std::function<Result<std::unique_ptr<Client>>(ClientEvents)>;

/// Asks once, or repeatedly until `stop` is set; a watch whose connection ends waits for the client to come back and says so
/// on stderr; it ends where that is turned away for good. Rows go to `out`, whole and flushed; where they cannot be
/// written it ends (OutputError).
Result<void> run_query(const Connect& connect, const QueryOptions& options,
                       const std::vector<Place>& places, const std::atomic<bool>& stop,
                       std::FILE* out);

/// When a watch of so many rows a second asks next, of the time since it began: at the first beat that is not over. A slow answer
/// costs beats, and tries in vain cost none.
double next_beat_s(double elapsed_s, double hz);

/// Has what `options` are to be answered from; of the waves of a scene, anew for each sea. `now`: some points are of now.
Result<void> make_ready(Client& client, const QueryOptions& options, bool now);

/// What a benchmark asks about: in each call other random places on 10 km around the origin, now. So no call finds what one
/// before it has left in some memory, and all calls together are of whole keyframe intervals.
class BenchPoints {
  public:
    explicit BenchPoints(int count);
    /// Stays as it is until the next call.
    std::span<const sea::QueryPoint> next(sea::TimeUs now_us);

  private:
    std::mt19937_64 random_{1};
    std::vector<sea::QueryPoint> points_;
};

/// Of BenchPoints: queries one after the other, then several at once, about two seconds each. Local ones, one after the other,
/// of tiles that are streamed, and fetched where they come too late, or of waves.
Result<void> run_bench(Client& client, const QueryOptions& options, const std::atomic<bool>& stop,
                       std::FILE* out);

} // namespace seaway::client
