// SPDX-License-Identifier: Apache-2.0
#include "client/window/pilot.h"

#include <algorithm>
#include <cmath>

namespace seaway::client {

namespace {

constexpr double orbit_pitch_max_deg = -1; ///< the camera stays above the sea
constexpr double a_notch = 1.25;
constexpr double fast = 10;

double wrapped_deg(double yaw_deg) {
    return yaw_deg - 360 * std::floor(yaw_deg / 360);
}

} // namespace

Pilot::Pilot(const Camera& start) : camera_(start) {}

glm::dvec2 Pilot::ahead_on_the_sea(double far) const {
    const glm::dvec3 ahead = camera_.forward();
    const double along = camera_.z_m * ahead.z < 0
                             ? std::min(camera_.z_m / -ahead.z * std::hypot(ahead.x, ahead.y), far)
                             : far;
    return glm::dvec2(camera_.x_m, camera_.y_m) +
           along * glm::dvec2(std::cos(camera_.azimuth_rad()), std::sin(camera_.azimuth_rad()));
}

void Pilot::choose(CameraMode mode) {
    if (mode == mode_)
        return;
    mode_ = mode;
    if (mode == CameraMode::orbit) {
        centre_m_ = ahead_on_the_sea(distance_max_m / 2);
        const double away = glm::distance(centre_m_, glm::dvec2(camera_.x_m, camera_.y_m));
        distance_m_ = std::clamp(std::hypot(away, camera_.z_m), distance_min_m, distance_max_m);
    } else if (mode == CameraMode::follow) {
        const glm::dvec2 at = ahead_on_the_sea(50);
        float_ = {at.x, at.y, 0};
    }
    place();
}

void Pilot::set_speed(double speed_mps) {
    speed_mps_ = std::clamp(speed_mps, speed_min_mps, speed_max_mps);
}

void Pilot::turn(const Steering& steering) {
    camera_.yaw_deg = wrapped_deg(camera_.yaw_deg - steering.turn_x * camera_.view_deg);
    const double highest = mode_ == CameraMode::orbit ? orbit_pitch_max_deg : pitch_max_deg;
    camera_.pitch_deg =
        std::clamp(camera_.pitch_deg + steering.turn_y * camera_.view_deg, -pitch_max_deg, highest);
}

void Pilot::steer(const Steering& steering, double seconds) {
    turn(steering);
    if (mode_ == CameraMode::orbit)
        distance_m_ = std::clamp(distance_m_ * std::pow(a_notch, -steering.wheel), distance_min_m,
                                 distance_max_m);
    else
        set_speed(speed_mps_ * std::pow(a_notch, steering.wheel));
    if (mode_ == CameraMode::fly)
        fly(steering, seconds);
    else
        place();
}

void Pilot::fly(const Steering& steering, double seconds) {
    const double way_m = speed_mps_ * seconds * (steering.fast ? fast : 1);
    const glm::dvec3 ahead = camera_.forward();
    const double azimuth = camera_.azimuth_rad();
    const glm::dvec3 right(std::sin(azimuth), -std::cos(azimuth), 0);
    const glm::dvec3 move = way_m * (steering.ahead * ahead + steering.right * right +
                                     steering.up * glm::dvec3(0, 0, 1));
    camera_.x_m = std::clamp(camera_.x_m + move.x, -far_m, far_m);
    camera_.y_m = std::clamp(camera_.y_m + move.y, -far_m, far_m);
    camera_.z_m = std::clamp(camera_.z_m + move.z, -depth_max_m, height_max_m);
}

void Pilot::place() {
    if (mode_ == CameraMode::orbit) {
        const glm::dvec3 back = -distance_m_ * camera_.forward();
        camera_.x_m = centre_m_.x + back.x;
        camera_.y_m = centre_m_.y + back.y;
        camera_.z_m = std::clamp(back.z, height_min_m, height_max_m);
    } else if (mode_ == CameraMode::follow) {
        camera_.x_m = float_.x_m;
        camera_.y_m = float_.y_m;
        camera_.z_m = float_.height_m + eye_m;
    }
}

void Pilot::ride(double height_m, const glm::dvec2& horizontal_mps, double seconds) {
    if (mode_ != CameraMode::follow)
        return;
    float_.x_m += horizontal_mps.x * seconds;
    float_.y_m += horizontal_mps.y * seconds;
    float_.height_m = height_m;
    place();
}

void Pilot::stay_above(double surface_m) {
    if (mode_ == CameraMode::orbit)
        camera_.z_m = std::max(camera_.z_m, surface_m + height_min_m);
}

} // namespace seaway::client
