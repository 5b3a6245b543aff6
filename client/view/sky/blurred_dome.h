// SPDX-License-Identifier: Apache-2.0
// BlurredDome: a Dome and its blurred copies, as mips of one picture.
//
// Level 0 is sharp; level m is the mean over a Gaussian lobe of directions of 0.02 * 2^m rad standard
// deviation an axis, taken over solid angle. A rough mirror looks up the level of its own lobe. Texels of
// a level lie where the sampler of a device expects them, so one look-up serves all levels.
//
// Immutable; thread-safe. 15 ms of CPU, which threads share.
#pragma once

#include <array>

#include "base/thread_pool.h"
#include "client/view/sky/dome.h"
#include "shaders/shared/view.h"

namespace seaway::client {

class BlurredDome {
  public:
    static constexpr int levels = shaders::sky_mips;
    static constexpr double first_blur_rad = 0.04; ///< of level 1

    BlurredDome() = default;
    BlurredDome(Dome sharp, ThreadPool& pool);

    const Dome& sharp() const { return sharp_; }
    /// [row][column], level 0 .. levels-1; sides are halves of those of the level before.
    const std::vector<glm::vec3>& level(int level) const {
        return level == 0 ? sharp_.texels() : blurred_[static_cast<std::size_t>(level - 1)];
    }
    /// blur: standard deviation of the lobe an axis, rad.
    glm::dvec3 sample(const glm::dvec3& direction, double blur_rad) const;

  private:
    glm::dvec3 sample_level(int level, const DomePlace& place) const;
    std::vector<glm::vec3> blur(int level, ThreadPool& pool) const;

    Dome sharp_;
    std::array<std::vector<glm::vec3>, levels - 1> blurred_;
};

} // namespace seaway::client
