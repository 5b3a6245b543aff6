// SPDX-License-Identifier: Apache-2.0
// Pilot: moves the window's camera by what the user does. Flies, goes round a point, or rides on a float. A value;
// knows no window system.
#pragma once

#include <glm/glm.hpp>

#include "client/view/camera.h"

namespace seaway::client {

enum class CameraMode { fly, orbit, follow };

/// What the user did since the last frame.
struct Steering {
    double ahead = 0, right = 0, up = 0; ///< keys that are held, -1 .. 1
    double turn_x = 0, turn_y = 0;       ///< dragged, shares of the window's width, y down
    double wheel = 0;                    ///< notches, away from the user is positive
    bool fast = false;                   ///< ten times as fast
};

/// What carries the camera of CameraMode::follow: moves with the water at the surface.
struct Float {
    double x_m = 0, y_m = 0; ///< world
    double height_m = 0;     ///< of the surface
};

class Pilot {
  public:
    static constexpr double height_min_m = 0.3; ///< above the surface, but for one that flies
    static constexpr double depth_max_m = -camera_height_min_m;
    static constexpr double height_max_m = 20e3; ///< above the mean sea
    static constexpr double pitch_max_deg = 89;
    static constexpr double speed_min_mps = 0.5, speed_max_mps = 5000;
    static constexpr double distance_min_m = 3, distance_max_m = 20e3;
    static constexpr double eye_m = 1.8; ///< above the float
    static constexpr double far_m = 9e6; ///< from the origin of the world, each way

    explicit Pilot(const Camera& start);

    const Camera& camera() const { return camera_; }
    CameraMode mode() const { return mode_; }
    double speed_mps() const { return speed_mps_; }
    double distance_m() const { return distance_m_; }
    const Float& floating() const { return float_; }

    /// Orbit: round what the middle of the picture shows of the mean sea. Follow: a float there, no further than 50 m.
    void choose(CameraMode mode);
    void set_speed(double speed_mps);
    void steer(const Steering& steering, double seconds);
    /// Follow: what the sea is like at the float; `horizontal_mps`: of its water.
    void ride(double height_m, const glm::dvec2& horizontal_mps, double seconds);
    /// Orbit: the surface below the camera, which stays above it.
    void stay_above(double surface_m);

  private:
    void turn(const Steering& steering);
    void fly(const Steering& steering, double seconds);
    void place();
    /// Where the middle of the picture meets the mean sea, `far` at most.
    glm::dvec2 ahead_on_the_sea(double far) const;

    Camera camera_;
    CameraMode mode_ = CameraMode::fly;
    double speed_mps_ = 10;
    double distance_m_ = 50;
    glm::dvec2 centre_m_{0.0};
    Float float_;
};

} // namespace seaway::client
