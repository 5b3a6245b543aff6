// SPDX-License-Identifier: Apache-2.0
// Environment: a sky from a picture, instead of one that is computed. OpenEXR, latitude-longitude, linear, in kcd/m2: as
// seaway-view writes radiance; Look::sun_strength multiplies what has another unit.
//
// The picture's middle is the north, its right half the east, its upper edge the zenith. The lower half is not used: the
// sea is drawn.
//
//     const Result<EnvironmentPicture> picture = read_environment("harbour.exr");
//     const Environment sky = environment_of(std::move(*picture), 90);   // turned by a quarter, clockwise
//
// The sun is taken out: a mirror image of it as wide as a texel of the table would be too wide, and its beam has to cast
// glitter as one from a direction. It is what stands out from the sky around it, within 3 degrees of the brightest texel, or 1.5
// texels where they are larger. What is taken out stands in sun_klx, so that sky and sun send as much as the picture.
//
// Pure functions but for the file. Tables of a picture take 0.1 s of CPU, reading it as long as OpenEXR takes.
#pragma once

#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "base/result.h"
#include "base/thread_pool.h"
#include "client/view/sky/dome.h"

namespace seaway::client {

inline constexpr int environment_width_min = 16, environment_width_max = 16384;
/// Wider pictures are held in so many columns, each texel the mean by solid angle of what lies in it.
inline constexpr int environment_width_held = 2048;

struct EnvironmentPicture {
    int width = 0, height = 0;     ///< width is twice the height
    std::vector<glm::vec3> texels; ///< [y][x], row 0 on top

    glm::dvec3 direction(int x, int y) const; ///< of a texel's middle, unturned
    double texel_sr(int y) const;
    /// Of a texel, what lies above the horizon: half of the middle row where the height is odd.
    double upper_sr(int y) const;
};

/// Nothing is allocated before the header is known to be in its limits. Errors are one line that names the file and what of
/// it is wrong: no regular file, no OpenEXR, not twice as wide as high, a side beyond its limits, no R, G and B, a pixel
/// that is not a number from 0, cut short.
Result<EnvironmentPicture> read_environment(const std::string& path);

struct Environment {
    Dome
        sky; ///< sharp, its upper half; the horizon is the picture's. The lower half is its horizon's colour.
    glm::dvec3 to_sun{0, 0, 1};
    glm::dvec3 sun_klx{0.0}; ///< normal to the beam; 0: the picture has no sun
};

/// Light that falls from the upper half on a surface that looks to the zenith, klx.
glm::dvec3 level_light(const EnvironmentPicture& picture);

/// turn_deg: clockwise, seen from above.
Environment environment_of(EnvironmentPicture picture, double turn_deg, ThreadPool& pool);

} // namespace seaway::client
