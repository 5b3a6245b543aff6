// SPDX-License-Identifier: Apache-2.0
// CameraPath: where the camera is over time, smooth between given moments. Immutable; thread-safe.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "client/view/camera.h"

namespace seaway::client {

class CameraPath {
  public:
    /// A camera that stands still.
    explicit CameraPath(const Camera& camera) : keys_{{0, camera}} {}

    /// CSV with the columns t_s, x_m, y_m, z_m, yaw_deg, pitch_deg and, if wanted, fov_deg (width of the picture): a moment a
    /// row, at most 100,000, times growing by 1e-6 s at least and within 1e12 s of 0. What a row does not say is `base`'s. Errors name the line and the range.
    static Result<CameraPath> parse(std::string_view text, const std::string& name,
                                    const Camera& base);

    /// Once around the point of the mean sea that `base` looks at, or one 100 m ahead where it looks above the horizon, in
    /// `duration_s`, looking at it.
    static CameraPath turntable(const Camera& base, double duration_s);

    /// Seconds after the start; before the first moment and after the last it stands still. Through the given moments by
    /// cubics whose slope at each is that between its neighbours (Catmull-Rom); yaw goes the shorter way round. The camera
    /// stays above the sea: never lower than the lower of the moments around.
    Camera at(double t_s) const;

  private:
    struct Key {
        double t_s;
        Camera camera;
    };
    explicit CameraPath(std::vector<Key> keys) : keys_(std::move(keys)) {}
    std::vector<Key> keys_; ///< one at least; yaw unwrapped
};

} // namespace seaway::client
