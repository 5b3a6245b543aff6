// SPDX-License-Identifier: Apache-2.0
// How a Client is asked about points: of its server, and of what it holds.
#pragma once

#include <span>

#include "sea/surface/answer.h"
#include "sea/surface/surface.h"

namespace seaway::client {

struct Asking {
    bool exact = false; ///< direct sum in double precision by the server; slow
    /// For each batch that the points are split into; within it a server that is busy, and says for how long, is asked again.
    double timeout_s = 10;
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
    /// error_m. Three samples instead of one, up to nine of a clock that is far off (sea_motion.h).
    bool of_now = false;
    /// Keyframes that came answer where they cover the time, though there are waves.
    bool keyframes_first = false;
    /// Which waves count.
    sea::Looking looking = {};
    /// Where waves answer, each point by their sum: no maps are made of them (wave_maps.h).
    bool summed = false;

    /// The same of some of its points.
    Sampling of(std::size_t first, std::size_t count) const {
        Sampling some = *this;
        if (!memory.empty())
            some.memory = memory.subspan(first, count);
        if (!terms.empty())
            some.terms = terms.subspan(first, count);
        return some;
    }
    sea::Answering answering(sea::MixedMaps& mixed) const { return {parts, &mixed, memory, terms}; }
};

} // namespace seaway::client
