// SPDX-License-Identifier: Apache-2.0
// How a Client is asked about points: of its server, and of what it holds.
#pragma once

#include <span>

#include "sea/surface/answer.h"

namespace seaway::client {

struct Asking {
    bool exact = false;        ///< direct sum in double precision by the server; slow
    double timeout_s = 10;     ///< for each batch that the points are split into
    sea::Looking looking = {}; ///< which waves count
};

/// How sample_into() answers.
struct Sampling {
    sea::AnswerParts parts = sea::AnswerParts::all;
    /// One a point, or none (sea/surface/surface.h); used where answers come from keyframes.
    std::span<sea::PointMemory> memory = {};
    /// One a point, filled in, or none: what error_m of the answers is made of.
    std::span<sea::ErrorTerms> terms = {};
    /// The times are meant as those of now_us(), or of moments at a distance from it: what the clock may be off by is part of
    /// error_m. Three samples instead of one.
    bool of_now = false;
    /// Keyframes answer where they cover the time, though there are waves.
    bool keyframes_first = false;
};

} // namespace seaway::client
