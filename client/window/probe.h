// SPDX-License-Identifier: Apache-2.0
// Probe: a place on the sea that was clicked, what the client says of it now, and its last minute.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "client/view/camera.h"
#include "client/window/points.h"

namespace seaway::client {

/// Where the ray through a point of the picture (-1 .. 1, y down) first meets the surface, from above or from below,
/// world, m; the earth's curvature included. Nothing: it goes into the sky or the deep, or meets nothing within 20 km.
/// `crest_m`: no crest is higher. A few hundred answers of the surface, a millisecond; several thousand where it grazes the sea to the horizon.
std::optional<glm::dvec2> where_ray_meets(const Points& points, const Camera& camera,
                                          double picture_x, double picture_y, sea::TimeUs time_us,
                                          double crest_m);

/// A world place on the picture, -1 .. 1, y down; nothing if it is behind the camera.
std::optional<glm::dvec2> on_picture(const Camera& camera, double x_m, double y_m, double z_m);

class Probe {
  public:
    static constexpr double trace_s = 60;
    /// Samples lie at whole multiples of this, also those between two frames.
    static constexpr sea::TimeUs step_us = 100'000;
    struct Sample {
        sea::TimeUs time_us;
        float height_m;
    };

    explicit Probe(const glm::dvec2& place_m) : place_m_(place_m) {}

    const glm::dvec2& place_m() const { return place_m_; }
    /// Asks, if the time is covered; times that run backwards are a new trace.
    void read(const Points& points, sea::TimeUs time_us);
    /// The last one that was covered.
    const std::optional<sea::Answer>& answer() const { return answer_; }
    sea::TimeUs time_us() const { return time_us_; } ///< of the answer
    const std::deque<Sample>& trace() const { return trace_; }

  private:
    glm::dvec2 place_m_;
    std::optional<sea::Answer> answer_;
    sea::TimeUs time_us_ = 0;
    std::deque<Sample> trace_;
};

} // namespace seaway::client
