// SPDX-License-Identifier: Apache-2.0
// Sky: the light of a moment as the renderer sees it. SkyMaker makes it, and keeps what did not change.
//
//     SkyMaker maker;
//     const Sky sky = maker.make(look, heavens_at_hour(18.2), {.height_m = 12});
//
// Light is in klx and kcd/m2: outside the air the sun gives 128 klx times its strength, which is multiplied
// last, so that all by day is exactly linear in it. A Sky is immutable and thread-safe; copies share tables.
// A maker is for one thread at a time. Cost in CPU, which its threads share: 235 ms for a new medium, 135 for a new sun (190
// with a moon), 85 for another height of the eye, 43 for other clouds, microseconds where nothing is new.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "client/view/sky/blurred_dome.h"
#include "client/view/sky/clouds.h"
#include "client/view/sky/look.h"
#include "client/view/sky/sky_view.h"

namespace seaway::client {

/// Where the sun of the simple day stands at this hour; see heavens_at_hour().
inline glm::dvec3 sun_direction(double time_of_day_h) {
    return heavens_at_hour(time_of_day_h).to_sun;
}

/// The eye, and how far clouds have drifted.
struct Eye {
    double height_m = 10;
    double east_m = 0, north_m = 0;
    glm::dvec2 cloud_drift_m{0.0};
    bool operator==(const Eye&) const = default;
};
/// The eye as tables know it: its height is a rung of height_on_ladder_m(), its place among clouds a step of 250 m.
/// Eyes that share it share tables.
Eye eye_on_steps(const Look& look, const Eye& eye);

class Sky {
  public:
    /// The default look under this sun, without a moon.
    explicit Sky(const glm::dvec3& to_sun, double eye_height_m = 10);

    const glm::dvec3& sun_direction() const { return heavens_.to_sun; }
    /// What arrives of the sun at the sea, normal to the beam, klx.
    const glm::dvec3& sun_irradiance() const { return sun_; }
    /// Sun or moon, whichever sends more, and what arrives of it.
    const glm::dvec3& light_direction() const { return to_light_; }
    const glm::dvec3& light_irradiance() const { return light_; }
    /// Of light_irradiance(), which is the mean below all clouds, at a point of the sea so far east and north of the eye:
    /// patches of light below a patchy sky.
    double beam_over_mean(const glm::dvec2& local_m) const;
    /// What the sky without sun and moon sends to the level, klx.
    const glm::dvec3& sky_irradiance() const { return sky_irradiance_; }

    /// All around a point of the sea, blurred over a lobe of this standard deviation an axis: the sky with
    /// its clouds; below the horizon what the sea shows there.
    glm::dvec3 radiance(const glm::dvec3& direction, double blur_rad = 0) const;
    /// Above the horizon, by azimuth from the sun.
    glm::dvec3 radiance(double elevation_rad, double azimuth_from_sun_rad) const;
    /// What the eye sees above its horizon, without sun, moon and stars.
    glm::dvec3 behind(const glm::dvec3& direction) const;
    /// A colour at a distance as the eye sees it through the air, clouds between left out.
    glm::dvec3 through_air(const glm::dvec3& colour, double distance_m,
                           const glm::dvec3& direction) const;

    /// The sea, as through_air() gives it, under clouds that the eye looks down on.
    glm::dvec3 below_clouds(const glm::dvec3& seen, const glm::dvec3& direction) const;

    /// Radiance of a white sheet that lies on the sea, kcd/m2: the middle of what light there is.
    double white_radiance() const;

    /// For shaders; texels is the same object as long as no table is made anew: [mip][layer][y][x][rgba].
    const std::shared_ptr<const std::vector<float>>& texels() const { return texels_; }
    shaders::SkyValues values() const;
    /// Tables of the medium.
    const AirTables& air() const { return *air_; }

    /// The same light and the same tables, as another eye sees them; exact for eyes on the same steps.
    Sky seen_from(const Look& look, const Eye& eye) const;

    static constexpr double sun_radius_rad = disc_radius_rad;

  private:
    friend class SkyMaker;
    friend bool may_be_mixed(const Sky& from, const Sky& to);
    friend Sky mixed(const Sky& from, const Sky& to, double share);
    Sky() = default;
    glm::dvec3 air_source(const glm::dvec3& direction) const;

    Heavens heavens_;
    Eye eye_;
    std::shared_ptr<const AirTables> air_;
    std::shared_ptr<const BlurredDome> sea_; ///< around a point of the sea
    std::shared_ptr<const Dome> eye_dome_;
    std::shared_ptr<const std::vector<glm::vec2>> noise_;
    std::shared_ptr<const std::vector<float>> texels_;
    CloudLayer clouds_; ///< over the eye
    glm::dvec3 sun_{0.0}, light_{0.0}, sky_irradiance_{0.0}, to_light_{0, 0, 1};
    double sun_strength_ = 1, moon_strength_ = 0; ///< outside the air, of the sun's 128 klx
    std::optional<glm::dvec3> picture_sun_;       ///< of a picture's sky: what its sun sends, klx
};

/// Between one sky and the next, for shaders: 0 .. 1 of the other; what the CPU looks up is the other's. 0.3 ms.
Sky mixed(const Sky& from, const Sky& to, double share);
/// Tables lie over each other: the sun has not turned by a column. False where they are the same.
bool may_be_mixed(const Sky& from, const Sky& to);

class SkyMaker {
  public:
    /// threads: that make tables; 0: `usable_processors()`.
    explicit SkyMaker(int threads = 0);
    ~SkyMaker();
    Result<Sky> make(const Look& look, const Heavens& heavens, const Eye& eye);
    /// A picture is kept by its name; from here on it is read anew.
    void forget_environment();

    /// How often tables were made.
    struct Counts {
        int medium = 0, sun = 0, eye = 0, picture = 0;
        bool operator==(const Counts&) const = default;
    };
    const Counts& counts() const { return counts_; }

  private:
    struct Kept;
    std::unique_ptr<Kept> kept_;
    Counts counts_;
};

} // namespace seaway::client
