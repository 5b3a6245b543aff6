// SPDX-License-Identifier: Apache-2.0
// What a sky is made of, and which of it can be kept.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "client/view/sky/environment.h"
#include "client/view/sky/sky.h"
#include "client/view/sky/sky_parts.h"

namespace seaway::client {

namespace {

using std::numbers::pi;

/// A full moon's light is this share of the sun's: magnitudes -12.73 and -26.74 (Allen 1973).
constexpr double moon_share = 1 / 4.02e5;
/// Light of the moon is left out where the sun's is this much more.
constexpr double moon_matters = 1e-3;
/// Of moonlight on the level, what the sky sends to clouds.
constexpr double moon_sky_share = 0.2;
/// A blurred mirror does not show clouds that have drifted less.
constexpr double cloud_step_m = 250;

/// Where the noise of clouds is looked up.
glm::dvec2 origin_of(const glm::dvec2& place_m, const glm::dvec2& period_m) {
    return glm::mod(place_m / period_m, cloud_wrap_periods);
}

/// From where clouds drift.
glm::dvec2 among_clouds(const Eye& eye) {
    return glm::dvec2(eye.east_m, eye.north_m) - eye.cloud_drift_m;
}
glm::dvec2 on_cloud_steps(const Eye& eye) {
    return glm::round(among_clouds(eye) / cloud_step_m) * cloud_step_m;
}

/// Of a disc with this share of the sun's light, normal to its beam.
glm::dvec3 beam_klx(const AirTables& air, double strength, const glm::dvec3& direction,
                    double height_m) {
    return strength *
           sunlight_klx(air.transmittance.to_disc(height_m, direction.z, disc_radius_rad));
}

} // namespace

/// What the last sky was made of.
struct SkyMaker::Kept {
    explicit Kept(int threads) : pool(threads) {}
    ThreadPool pool;
    std::shared_ptr<const std::vector<glm::vec2>> noise;
    Atmosphere medium;
    std::shared_ptr<const AirTables> air;
    glm::dvec3 to_sun{0.0}, to_moon{0.0};
    double moon_over_sun = 0;
    Lit at_sea, at_eye;
    glm::dvec3 clear_irradiance{0.0}; ///< of the sky, under a sun of strength 1
    /// All that the picture is of, besides.
    struct Key {
        Clouds clouds;
        double sun_strength = 0, moon_strength = 0;
        glm::dvec2 origin{0.0};
        bool below = true;
        bool operator==(const Key&) const = default;
    };
    std::optional<Key> key;
    struct {
        std::string path;
        double turn_deg = 0, strength = 0;
        std::shared_ptr<const BlurredDome> sea;
        std::shared_ptr<const Dome> eye;
        glm::dvec3 sky_irradiance{0.0}, sun_klx{0.0}, to_sun{0, 0, 1};
        std::shared_ptr<const std::vector<float>> texels;
    } picture;
    CloudShare cloud_share{1, 1};
    std::pair<Clouds, double> share_of; ///< clouds, and height of the light
    Sky sky;

    std::shared_ptr<const SkyView> view(double height_m, const glm::dvec3& to) {
        return std::make_shared<const SkyView>(*air, height_m, to, pool);
    }
    bool take_medium(const Atmosphere& wanted);
    bool take_sun(const Heavens& heavens, double moon_strength, double sun_strength);
    bool take_eye(double height_m);
    CloudLayer layer_over_sea(const Clouds& clouds, const Sky& out, const glm::dvec2& place_m);
    void make_picture(Sky& out, const CloudLayer& layer, bool below);
    Result<bool> take_environment(const Look& look);
    Sky of_environment(double height_m) const;
};

bool SkyMaker::Kept::take_medium(const Atmosphere& wanted) {
    if (air && medium == wanted)
        return false;
    air = std::make_shared<const AirTables>(wanted, pool);
    medium = wanted;
    return true;
}

bool SkyMaker::Kept::take_sun(const Heavens& heavens, double moon_strength, double sun_strength) {
    const double share = sun_strength > 0 ? moon_strength / sun_strength : 0;
    if (at_sea.sun && to_sun == heavens.to_sun && to_moon == heavens.to_moon &&
        moon_over_sun == share)
        return false;
    to_sun = heavens.to_sun;
    to_moon = heavens.to_moon;
    moon_over_sun = share;
    at_sea.sun = view(SkyView::height_min_m, to_sun);
    clear_irradiance = level_irradiance(at_sea.sun->dome());
    const double moonlight = luminance_of(beam_klx(*air, share, to_moon, 0));
    const bool matters = moonlight > moon_matters * luminance_of(clear_irradiance);
    at_sea.moon = matters ? view(SkyView::height_min_m, to_moon) : nullptr;
    return true;
}

bool SkyMaker::Kept::take_eye(double height_m) {
    if (at_eye.sun && at_eye.sun->height_m() == height_m)
        return false;
    at_eye.sun = view(height_m, to_sun);
    at_eye.moon = at_sea.moon ? view(height_m, to_moon) : nullptr;
    return true;
}

CloudLayer SkyMaker::Kept::layer_over_sea(const Clouds& clouds, const Sky& out,
                                          const glm::dvec2& place_m) {
    CloudLayer layer;
    layer.threshold = cloud_threshold(clouds.coverage);
    layer.optical_depth = clouds.optical_depth;
    layer.period_m = clouds.size_m * cloud_periods;
    layer.curvature_per_m = 0.5 / medium.planet_radius_m;
    layer.height_m = clouds.base_m;
    layer.origin = origin_of(place_m, layer.period_m);
    const bool moonlit = out.to_light_ == to_moon;
    layer.to_light = out.to_light_;
    layer.light = beam_klx(*air, moonlit ? out.moon_strength_ : out.sun_strength_, out.to_light_,
                           clouds.base_m);
    layer.sky = out.sun_strength_ * clear_irradiance + pi * airglow;
    if (moonlit)
        layer.sky += layer.light * (moon_sky_share * std::max(out.to_light_.z, 0.0));
    if (clouds.coverage <= 0)
        return layer;
    if (share_of != std::pair(clouds, out.to_light_.z)) {
        cloud_share = mean_cloud_share(layer, *noise);
        share_of = {clouds, out.to_light_.z};
    }
    layer.sunlit = cloud_share.straight;
    // Half of what a scatterer there sees is cloud, half is dark sea.
    layer.shaded = (layer.light * std::max(out.to_light_.z, 0.2) + layer.sky) *
                   (0.5 * medium.aerosol_albedo * cloud_share.diffuse / pi);
    return layer;
}

void SkyMaker::Kept::make_picture(Sky& out, const CloudLayer& layer, bool below) {
    at_sea.sun_strength = at_eye.sun_strength = out.sun_strength_;
    at_sea.moon_strength = at_eye.moon_strength = out.moon_strength_;
    Dome sea = with_clouds(clear_dome(at_sea, *air, layer, true, pool), layer, *noise, *air, pool);
    out.sky_irradiance_ = level_irradiance(sea);
    lay_sea(sea, out.sky_irradiance_ + out.light_ * std::max(out.to_light_.z, 0.0), pool);
    out.sea_ = std::make_shared<const BlurredDome>(std::move(sea), pool);
    out.eye_dome_ = std::make_shared<const Dome>(clear_dome(at_eye, *air, layer, below, pool));
    out.texels_ =
        std::make_shared<const std::vector<float>>(picture_of(*out.sea_, *out.eye_dome_, *noise));
}

/// True: tables are new.
Result<bool> SkyMaker::Kept::take_environment(const Look& look) {
    if (picture.texels && picture.path == look.environment &&
        picture.turn_deg == look.environment_turn_deg && picture.strength == look.sun_strength)
        return false;
    SEAWAY_TRY_LET(EnvironmentPicture read, read_environment(look.environment));
    Environment made = environment_of(std::move(read), look.environment_turn_deg, pool);
    for (glm::vec3& texel : made.sky.texels())
        texel *= static_cast<float>(look.sun_strength);
    picture.path = look.environment;
    picture.turn_deg = look.environment_turn_deg;
    picture.strength = look.sun_strength;
    picture.to_sun = made.to_sun;
    picture.sun_klx = look.sun_strength * made.sun_klx;
    picture.sky_irradiance = level_irradiance(made.sky);
    Dome sea = made.sky;
    lay_sea(sea, picture.sky_irradiance + picture.sun_klx * std::max(made.to_sun.z, 0.0), pool);
    picture.sea = std::make_shared<const BlurredDome>(std::move(sea), pool);
    picture.texels =
        std::make_shared<const std::vector<float>>(picture_of(*picture.sea, made.sky, *noise));
    picture.eye = std::make_shared<const Dome>(std::move(made.sky));
    return true;
}

Sky SkyMaker::Kept::of_environment(double height_m) const {
    Sky out;
    out.heavens_.to_sun = out.to_light_ = picture.to_sun;
    out.heavens_.to_moon = {0, 0, -1};
    out.air_ = air;
    out.noise_ = noise;
    out.sea_ = picture.sea;
    // The picture's horizon is that of the eye, however high it is.
    Dome eye(picture.eye->columns(), picture.eye->rows(), picture.eye->azimuth_rad(),
             dip_rad(medium, height_m));
    eye.texels() = picture.eye->texels();
    out.eye_dome_ = std::make_shared<const Dome>(std::move(eye));
    out.texels_ = picture.texels;
    out.sun_ = out.light_ = picture.sun_klx;
    out.picture_sun_ = picture.sun_klx;
    out.sky_irradiance_ = picture.sky_irradiance;
    return out;
}

SkyMaker::SkyMaker(int threads) : kept_(std::make_unique<Kept>(threads)) {
    kept_->noise = std::make_shared<const std::vector<glm::vec2>>(
        cloud_noise(shaders::sky_columns, shaders::sky_rows, kept_->pool));
}
SkyMaker::~SkyMaker() = default;

void SkyMaker::forget_environment() {
    kept_->picture = {};
}

Result<Sky> SkyMaker::make(const Look& look, const Heavens& heavens, const Eye& eye) {
    Kept& kept = *kept_;
    Sky out;
    out.heavens_ = heavens;
    out.eye_ = eye;
    out.noise_ = kept.noise;
    out.sun_strength_ = look.sun_strength / (heavens.sun_distance_au * heavens.sun_distance_au);
    out.moon_strength_ = out.sun_strength_ * moon_share * moon_brightness(heavens.moon_phase_rad);

    const bool new_medium = kept.take_medium(look.air);
    counts_.medium += new_medium;
    if (new_medium)
        kept.at_sea = kept.at_eye = {};
    if (!look.environment.empty()) {
        SEAWAY_TRY_LET(const bool new_tables, kept.take_environment(look));
        counts_.picture += new_tables;
        return kept.of_environment(eye.height_m).seen_from(look, eye);
    }
    const bool new_sun = kept.take_sun(heavens, out.moon_strength_, out.sun_strength_);
    if (new_sun)
        kept.at_eye = {};
    const bool new_eye = kept.take_eye(height_on_ladder_m(eye.height_m));
    out.air_ = kept.air;

    const glm::dvec3 sun = beam_klx(*kept.air, out.sun_strength_, heavens.to_sun, 0);
    const glm::dvec3 moon = beam_klx(*kept.air, out.moon_strength_, heavens.to_moon, 0);
    const bool moonlit = luminance_of(moon) > luminance_of(sun);
    out.to_light_ = moonlit ? heavens.to_moon : heavens.to_sun;
    CloudLayer layer = kept.layer_over_sea(look.clouds, out, on_cloud_steps(eye));
    out.sun_ = sun * layer.sunlit;
    out.light_ = (moonlit ? moon : sun) * layer.sunlit;

    const bool below = eye.height_m<look.clouds.base_m, cloudy = look.clouds.coverage> 0;
    const Kept::Key key{look.clouds, out.sun_strength_, out.moon_strength_,
                        cloudy ? layer.origin : glm::dvec2(0), below || !cloudy};
    const bool new_picture = new_eye || kept.key != key;
    if (new_picture) {
        kept.make_picture(out, layer, below);
    } else {
        out.sky_irradiance_ = kept.sky.sky_irradiance_;
        out.sea_ = kept.sky.sea_;
        out.eye_dome_ = kept.sky.eye_dome_;
        out.texels_ = kept.sky.texels_;
    }
    kept.key = key;
    counts_.sun += new_sun;
    counts_.eye += new_eye;
    counts_.picture += new_picture;
    out.clouds_ = layer;
    kept.sky = out;
    return out.seen_from(look, eye);
}

Eye eye_on_steps(const Look& look, const Eye& eye) {
    Eye out{.height_m = height_on_ladder_m(eye.height_m)};
    if (look.clouds.coverage > 0) {
        const glm::dvec2 place_m = on_cloud_steps(eye);
        out.east_m = place_m.x;
        out.north_m = place_m.y;
    }
    return out;
}

Sky Sky::seen_from(const Look& look, const Eye& eye) const {
    Sky out = *this;
    out.eye_ = eye;
    out.clouds_.height_m = look.clouds.base_m - eye.height_m;
    out.clouds_.origin = origin_of(among_clouds(eye), clouds_.period_m);
    return out;
}

bool may_be_mixed(const Sky& from, const Sky& to) {
    const double turned =
        std::remainder(to.sea_->sharp().azimuth_rad() - from.sea_->sharp().azimuth_rad(), 2 * pi);
    return from.texels_ != to.texels_ && std::abs(turned) < 2 * pi / shaders::sky_columns;
}

Sky mixed(const Sky& from, const Sky& to, double share) {
    Sky out = to;
    const auto mix = [&](auto& value, const auto& before) {
        value = glm::mix(before, value, share);
    };
    mix(out.heavens_.to_sun, from.heavens_.to_sun);
    out.heavens_.to_sun = glm::normalize(out.heavens_.to_sun);
    mix(out.sun_, from.sun_);
    mix(out.light_, from.light_);
    mix(out.sky_irradiance_, from.sky_irradiance_);
    mix(out.clouds_.light, from.clouds_.light);
    mix(out.clouds_.sky, from.clouds_.sky);
    mix(out.clouds_.shaded, from.clouds_.shaded);
    auto texels = std::make_shared<std::vector<float>>(to.texels_->size());
    const auto weight = static_cast<float>(share);
    std::transform(from.texels_->begin(), from.texels_->end(), to.texels_->begin(), texels->begin(),
                   [weight](float a, float b) { return a + weight * (b - a); });
    out.texels_ = std::move(texels);
    return out;
}

} // namespace seaway::client
