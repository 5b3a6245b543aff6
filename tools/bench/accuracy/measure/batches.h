// SPDX-License-Identifier: Apache-2.0
// K12: what an answer costs by how many are asked for at once. Its error does not depend on that: each
// trial says by how much an answer in a batch differs from the same one alone, which is nothing.
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "tools/bench/accuracy/measure/metrics.h"
#include "tools/bench/accuracy/seas/configured_sea.h"

namespace seaway::bench {

enum class Asked {
    one_thread,
    all_threads, ///< a batch cut into parts, one pool of threads
    socket       ///< one Query message to a server, one connection, one message under way
};

struct Batch {
    int points = 1;
    Asked asked = Asked::one_thread;
};

/// Points scattered over kilometres, all at one time; its maps are held, the exact sum's phases belong to
/// the batch. Wall time, so of a quiet machine: batch_ns, nanoseconds an answer, median of five rounds with
/// the smallest and the largest; batch_ms, of a whole batch; batch_difference_m, largest difference of a
/// height from that of the point alone.
///
/// `server` is the URL of a running server, for Asked::socket: the sea is the server's own. Errors: no
/// such device, no such server.
Result<std::vector<Figure>> measure_batch(const sea::Scene& scene,
                                          const Configuration& configuration, const Batch& batch,
                                          const std::string& server, Devices& devices);

} // namespace seaway::bench
