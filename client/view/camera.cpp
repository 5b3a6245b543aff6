// SPDX-License-Identifier: Apache-2.0
#include "client/view/camera.h"

#include <cmath>

#include <glm/gtc/matrix_transform.hpp>

namespace seaway::client {

namespace {

constexpr double near_plane_m = 0.1;

double half_width(const Camera& camera) {
    return std::tan(glm::radians(camera.view_deg) / 2);
}

} // namespace

double Camera::azimuth_rad() const {
    return glm::radians(90.0 - yaw_deg);
}

glm::dvec3 Camera::forward() const {
    const double pitch = glm::radians(pitch_deg);
    const double azimuth = azimuth_rad();
    return {std::cos(pitch) * std::cos(azimuth), std::cos(pitch) * std::sin(azimuth),
            std::sin(pitch)};
}

double Camera::pixel_rad() const {
    return 2 * half_width(*this) / width;
}

glm::dvec3 Camera::ray(double picture_x, double picture_y) const {
    const glm::dvec3 ahead = forward();
    const glm::dvec3 right = glm::normalize(glm::cross(ahead, glm::dvec3(0, 0, 1)));
    const glm::dvec3 up = glm::cross(right, ahead);
    const double half = half_width(*this);
    return ahead + right * (picture_x * half) - up * (picture_y * half * height / width);
}

glm::dmat4 Camera::clip_from_local() const {
    const glm::dvec3 eye(0, 0, z_m);
    const glm::dmat4 eye_from_local = glm::lookAt(eye, eye + forward(), glm::dvec3(0, 0, 1));
    const double x_scale = 1 / half_width(*this);
    glm::dmat4 clip_from_eye(0.0);
    clip_from_eye[0][0] = x_scale;
    clip_from_eye[1][1] = -x_scale * width / height;
    clip_from_eye[2][3] = -1;
    clip_from_eye[3][2] = near_plane_m;
    return clip_from_eye * eye_from_local;
}

double horizon_dip_rad(double z_m) {
    return z_m > 0 ? std::acos(earth_radius_m / (earth_radius_m + z_m)) : 0.0;
}

} // namespace seaway::client
