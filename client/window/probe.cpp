// SPDX-License-Identifier: Apache-2.0
#include "client/window/probe.h"

#include <algorithm>
#include <cmath>

namespace seaway::client {

namespace {

constexpr double far_m = 20e3;
constexpr double step_min_m = 0.02; ///< and a thousandth of the way
constexpr int steps_max = 20'000;
/// Share of the gap to the surface that a step goes: waves are not steeper than this allows but where they break.
constexpr double share_of_gap = 0.4;
constexpr int halvings = 40;

} // namespace

std::optional<glm::dvec2> where_ray_meets(const Points& points, const Camera& camera,
                                          double picture_x, double picture_y, sea::TimeUs time_us,
                                          double crest_m) {
    const glm::dvec3 ray = glm::normalize(camera.ray(picture_x, picture_y));
    const auto place = [&](double way_m) {
        return glm::dvec2(camera.x_m, camera.y_m) + way_m * glm::dvec2(ray.x, ray.y);
    };
    const double across = std::hypot(ray.x, ray.y);
    const auto above_mean_m = [&](double way_m) { // the sea falls away from the level
        const double out_m = way_m * across;
        return camera.z_m + way_m * ray.z + out_m * out_m / (2 * earth_radius_m);
    };
    const auto gap_m = [&](double way_m) {
        const glm::dvec2 at = place(way_m);
        return above_mean_m(way_m) - points.answer({at.x, at.y, time_us}).height_m;
    };
    const double side = gap_m(0) < 0 ? -1 : 1; // of the eye: below the water, or above
    double way_m = 0;
    if (camera.z_m > crest_m && ray.z < 0) // straight lines from here meet no crest before
        way_m = std::max((camera.z_m - crest_m) / -ray.z * 0.999, 0.0);
    double before_m = 0;
    for (int i = 0; i < steps_max && way_m < far_m; ++i) {
        const double gap = side * gap_m(way_m);
        if (gap <= 0 && way_m > 0) {
            double on_this_side = before_m, beyond = way_m;
            for (int n = 0; n < halvings; ++n) {
                const double middle = (on_this_side + beyond) / 2;
                (side * gap_m(middle) > 0 ? on_this_side : beyond) = middle;
            }
            return place(beyond);
        }
        if (side > 0 && above_mean_m(way_m) > crest_m && ray.z >= 0)
            return std::nullopt;
        before_m = way_m;
        way_m += std::max(share_of_gap * gap, step_min_m + 1e-3 * way_m);
    }
    return std::nullopt;
}

std::optional<glm::dvec2> on_picture(const Camera& camera, double x_m, double y_m, double z_m) {
    const glm::dvec2 away(x_m - camera.x_m, y_m - camera.y_m);
    const double drop_m = glm::dot(away, away) / (2 * earth_radius_m);
    const glm::dvec4 clip = camera.clip_from_local() * glm::dvec4(away, z_m - drop_m, 1);
    if (clip.w <= 0)
        return std::nullopt;
    return glm::dvec2(clip.x, clip.y) / clip.w;
}

void Probe::read(const Points& points, sea::TimeUs time_us) {
    if (!points.covers(time_us))
        return;
    const auto answer = [&](sea::TimeUs t_us) {
        return points.answer({place_m_.x, place_m_.y, t_us});
    };
    if (answer_ && time_us < time_us_)
        trace_.clear();
    const sea::TimeUs oldest_us = time_us - sea::us_from_seconds(trace_s);
    sea::TimeUs next_us = time_us - (time_us % step_us + step_us) % step_us; // the last multiple
    if (!trace_.empty())
        next_us = std::max(trace_.back().time_us + step_us, oldest_us);
    for (; next_us <= time_us; next_us += step_us)
        if (points.covers(next_us))
            trace_.push_back({next_us, static_cast<float>(answer(next_us).height_m)});
    while (!trace_.empty() && trace_.front().time_us < oldest_us)
        trace_.pop_front();
    answer_ = answer(time_us);
    time_us_ = time_us;
}

} // namespace seaway::client
