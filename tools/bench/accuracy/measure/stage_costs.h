// SPDX-License-Identifier: Apache-2.0
// What the stages of a configuration cost on this machine: keyframes by device and size, spline maps by
// size. The cost of any configuration is put together from them, since stages add up.
//
// CPU time of this process, so that other programs do not count; a device's own time beside it.
// Interleaved rounds, medians. For one thread. Some tenths of a second a device.
#pragma once

#include <map>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "base/result.h"
#include "tools/bench/accuracy/measure/metrics.h"
#include "tools/bench/accuracy/seas/configured_sea.h"

namespace seaway::bench {

struct Stage {
    double cpu_ms = 0;    ///< median of the rounds
    double device_ms = 0; ///< by the device's own clock, or wall time where it is this processor
};

class StageCosts {
  public:
    explicit StageCosts(int rounds) : rounds_(rounds) {}

    /// Milliseconds per second of sea, bytes, memory:
    ///   keyframe_cpu_ms_per_s, device_ms_per_s   all keyframes at their intervals
    ///   spline_ms_per_s                          making them ready to be sampled
    ///   encode_ms_per_s, decode_ms_per_s, bytes_per_s   one client's stream, if maps are coded
    ///   memory_mb                                the keyframes around one time
    Result<std::vector<Figure>> figures(const ConfiguredSea& sea, Devices& devices);

    /// One keyframe of this size, and making it ready. Measured once.
    Result<Stage> keyframe(const Configuration& configuration, int size, Devices& devices);
    double spline_ms(int size);

  private:
    using Key =
        std::tuple<std::string, bool, int, bool>; ///< device, design, size, bilinear's fields

    int rounds_;
    std::map<Key, Stage> keyframes_;
    std::map<int, double> splines_;
};

/// Of some rounds.
struct Timed {
    double median = 0, least = 0, most = 0;
};

/// Nanoseconds of one thread an answer, points scattered.
Timed query_ns(const ConfiguredSea& sea, std::span<const sea::QueryPoint> points);

} // namespace seaway::bench
