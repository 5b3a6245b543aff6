// SPDX-License-Identifier: Apache-2.0
// Waves finer than a pixel: their slopes are those of Gaussian facets, whose moments are known of waves
// that are given. What such a sea mirrors is held against an integral over all facets.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/client/view/renderer_fixture.h"

namespace seaway::client {
namespace {

/// Covariance of slopes.
struct Facets {
    double xx = 0, yy = 0, xy = 0;

    double along(const glm::dvec2& unit) const {
        return unit.x * unit.x * xx + unit.y * unit.y * yy + 2 * unit.x * unit.y * xy;
    }
    double determinant() const { return xx * yy - xy * xy; }
    double density(const glm::dvec2& slope) const {
        const double exponent =
            (yy * slope.x * slope.x - 2 * xy * slope.x * slope.y + xx * slope.y * slope.y) /
            determinant();
        return std::exp(-0.5 * exponent) / (2 * pi * std::sqrt(determinant()));
    }
    void add(double amplitude_m, double kx_radpm, double ky_radpm) {
        const double half = 0.5 * amplitude_m * amplitude_m;
        xx += half * kx_radpm * kx_radpm;
        yy += half * ky_radpm * ky_radpm;
        xy += half * kx_radpm * ky_radpm;
    }
};

double schlick(double cosine) {
    return 0.02 + 0.98 * std::pow(1 - cosine, 5);
}

/// Smith's function of masking for Gaussian slopes, in closed form.
double smith(const glm::dvec3& direction, const Facets& facets) {
    const glm::dvec2 level(direction.x, direction.y);
    const double sigma = std::sqrt(facets.along(level / glm::length(level)));
    const double a = direction.z / glm::length(level) / (std::numbers::sqrt2 * sigma);
    return (std::exp(-a * a) - a * std::sqrt(pi) * std::erfc(a)) / (2 * a * std::sqrt(pi));
}

/// What facets mirror of the disk of the sun: Bruneton, Neyret, Holzschuch 2010, equation 15, its
/// Jacobian and Fresnel term at the facet that mirrors the sun to the eye.
glm::dvec3 glitter(const Sky& sky, const glm::dvec3& to_eye, const Facets& facets) {
    const glm::dvec3 to_sun = sky.sun_direction();
    const glm::dvec3 facet = glm::normalize(to_eye + to_sun);
    const glm::dvec2 slope(-facet.x / facet.z, -facet.y / facet.z);
    return sky.sun_irradiance() * schlick(glm::dot(to_eye, facet)) * facets.density(slope) /
           (4 * to_eye.z * std::pow(facet.z, 4) *
            (1 + smith(to_eye, facets) + smith(to_sun, facets)));
}

glm::dvec3 sky_at(const Sky& sky, const glm::dvec3& direction) {
    return sky.radiance(direction);
}

/// Light that enters the water and comes out again.
glm::dvec3 deep_water(const Sky& sky) {
    return glm::dvec3(0.008, 0.024, 0.026) / pi *
           (sky.sky_irradiance() + sky.sun_irradiance() * sky.sun_direction().z);
}

/// What a facet mirrors: a ray that goes down meets another wave, which mirrors 6 % of the mean sky.
glm::dvec3 mirrored(const Sky& sky, const glm::dvec3& direction) {
    const double t = std::clamp((direction.z + 0.15) / 0.2, 0.0, 1.0);
    const double open = t * t * (3 - 2 * t);
    const glm::dvec3 level =
        glm::normalize(glm::dvec3(direction.x, direction.y, std::max(direction.z, 0.0) + 1e-4));
    return open * sky_at(sky, level) +
           (1 - open) * (deep_water(sky) + 0.06 / pi * sky.sky_irradiance());
}

/// The mean of the sky over all facets that face the eye, by how much of each is seen and what it
/// reflects.
glm::dvec3 mirrored_sky(const Sky& sky, const glm::dvec3& to_eye, const Facets& facets) {
    // Cholesky: slopes of two independent normal numbers.
    const double a = std::sqrt(facets.xx), b = facets.xy / a, c = std::sqrt(facets.yy - b * b);
    glm::dvec3 sum(0);
    double total = 0;
    for (double p = -3.8; p < 4; p += 0.4)
        for (double q = -3.8; q < 4; q += 0.4) {
            const glm::dvec3 facet(-a * p, -b * p - c * q, 1);
            const double seen = glm::dot(facet, to_eye);
            if (seen <= 0)
                continue;
            const glm::dvec3 normal = glm::normalize(facet);
            const double weight =
                std::exp(-0.5 * (p * p + q * q)) * seen * schlick(glm::dot(normal, to_eye));
            const glm::dvec3 away = -to_eye;
            sum += weight * mirrored(sky, away - 2.0 * glm::dot(away, normal) * normal);
            total += weight;
        }
    return sum / total;
}

/// Mean reflectance along the line of sight: the fit of the same article.
double mean_reflectance(const glm::dvec3& to_eye, const Facets& facets) {
    const double sigma = std::sqrt(facets.along(glm::normalize(glm::dvec2(to_eye.x, to_eye.y))));
    return 0.02 + 0.98 * std::pow(1 - to_eye.z, 5 * std::exp(-2.69 * sigma)) /
                      (1 + 22.7 * std::pow(sigma, 1.5));
}

/// All light of waves that no pixel resolves but that of the sun's disk.
glm::dvec3 without_glitter(const Sky& sky, const glm::dvec3& to_eye, const Facets& facets) {
    const double reflected = mean_reflectance(to_eye, facets);
    return (1 - reflected) * deep_water(sky) + reflected * mirrored_sky(sky, to_eye, facets);
}

class FacetsTest : public RendererTest {
  protected:
    /// From 3000 m a pixel covers 14 m and more: every tile of these seas whole.
    FacetsTest() { camera_ = {.z_m = 3000, .pitch_deg = -35, .width = 120, .height = 68}; }
    /// Waves that run obliquely, each in a tile of its own: no moment is like another.
    static sea::Realization ripples() {
        sea::Realization sea = one_wave(0.09, 9, 3, 1);
        sea.cascades[0].band = {0.5, 4.0};
        sea.cascades.push_back(one_wave(0.05, 4, 1, 2).cascades[0]);
        sea.cascades[1].band = {4.0, 20.0};
        return sea;
    }
    static Facets facets_of_ripples() {
        Facets facets{1.4e-6, 1.4e-6}; // the disk of the sun, as the shader has it
        facets.add(0.09, 2 * pi / 9 * 3, 2 * pi / 9 * 1);
        facets.add(0.05, 2 * pi / 4 * 1, 2 * pi / 4 * 2);
        return facets;
    }
    void look_towards_the_sun(const Sky& sky, double off_deg) {
        camera_.yaw_deg =
            90 - std::atan2(sky.sun_direction().y, sky.sun_direction().x) * 180 / pi + off_deg;
    }
    /// Compares where the sun's mirror image is nearly all of the light.
    void expect_glitter(const Picture& picture, const Sky& sky, const Facets& facets) {
        int compared = 0;
        for (int y = 4; y < picture.height; y += 6)
            for (int x = 2; x < picture.width; x += 4) {
                const glm::dvec3 to_eye = -ray(x, y);
                const double glint = glitter(sky, to_eye, facets).g;
                if (glint < 4)
                    continue;
                const double rest = without_glitter(sky, to_eye, facets).g;
                if (glint < 4 * rest)
                    continue;
                ++compared;
                // Smith's function is a fit in the shader, and of the sky, a fifth of the light at
                // most and steep around the sun, three facets stand for all.
                EXPECT_NEAR(static_cast<double>(picture.pixel(x, y)[1]) / (glint + rest), 1, 0.08)
                    << x << ", " << y;
            }
        EXPECT_GT(compared, 10);
    }
};

TEST_F(FacetsTest, the_sun_glitters_by_as_many_facets_as_mirror_it_to_the_eye) {
    SyntheticSea sea(ripples());
    const SeaFrame frame = sea.at(0);
    // The sun 8 degrees high, where facets hide each other from it, and 30.
    for (const double hour : {17.3, 15.0}) {
        const Sky& sky = sky_at_hour(hour);
        look_towards_the_sun(sky, 5);
        expect_glitter(render(frame, sky, DebugView::final, {.air = false, .detail = false}), sky,
                       facets_of_ripples());
    }
}

// The copy of the finest cascade has its variance, evenly over directions; beyond the copy, up to 370
// rad/m, every octave has as much.
TEST_F(FacetsTest, waves_beyond_the_finest_cascade_glitter_too) {
    SyntheticSea sea(ripples());
    const Sky& sky = sky_at_hour(15);
    look_towards_the_sun(sky, -4);
    Facets finest, all = facets_of_ripples();
    finest.add(0.05, 2 * pi / 4 * 1, 2 * pi / 4 * 2);
    const double variance = finest.xx + finest.yy;
    const double beyond = variance / std::log(20.0 / 4) * std::log(370.0 / (20 * 20.0 / 4));
    all.xx += 0.5 * (variance + beyond);
    all.yy += 0.5 * (variance + beyond);
    expect_glitter(render(sea.at(0), sky, DebugView::final, {.air = false}), sky, all);
}

TEST_F(FacetsTest, what_is_mirrored_of_the_sky_is_the_mean_over_all_facets) {
    SyntheticSea sea(ripples());
    const Sky& sky = sky_at_hour(15);
    const Facets facets = facets_of_ripples();
    look_towards_the_sun(sky, 75);
    const Picture picture =
        render(sea.at(0), sky, DebugView::final, {.air = false, .detail = false});
    int compared = 0;
    for (int y = 24; y < picture.height; y += 8) // nearer to the horizon facets hide each other
        for (int x = 4; x < picture.width; x += 16) {
            const glm::dvec3 to_eye = -ray(x, y);
            const glm::dvec3 expected = without_glitter(sky, to_eye, facets);
            if (glitter(sky, to_eye, facets).g > 1e-3 * expected.g)
                continue;
            ++compared;
            for (int c = 0; c < 3; ++c) // three facets and a blurred sky stand for all of them
                EXPECT_NEAR(static_cast<double>(picture.pixel(x, y)[c]) / expected[c], 1, 0.12)
                    << x << ", " << y;
        }
    EXPECT_GT(compared, 20);
}

// Straight below the camera no direction is special: what rough water mirrors there is the mean over its facets, under
// whatever bearing a pixel is seen.
TEST_F(FacetsTest, rough_water_below_has_the_colour_of_its_facets_all_around) {
    SyntheticSea sea(ripples());
    const Sky& sky = sky_at_hour(15);
    const Facets facets = facets_of_ripples();
    camera_ = {.z_m = 3000, .pitch_deg = -89, .view_deg = 30, .width = 64, .height = 64};
    const Picture picture =
        render(sea.at(0), sky, DebugView::final, {.air = false, .detail = false});
    int compared = 0;
    for (int y = 2; y < 64; y += 3)
        for (int x = 2; x < 64; x += 3) {
            const glm::dvec3 to_eye = -ray(x, y);
            const glm::dvec3 expected = without_glitter(sky, to_eye, facets);
            if (glitter(sky, to_eye, facets).g > 1e-2 * expected.g)
                continue;
            ++compared;
            for (int c = 0; c < 3; ++c) // five facets and a blurred sky stand for all of them
                EXPECT_NEAR(static_cast<double>(picture.pixel(x, y)[c]) / expected[c], 1, 0.12)
                    << x << ", " << y;
        }
    EXPECT_GT(compared, 100);
}

TEST_F(FacetsTest, roughness_is_the_root_of_the_variance_along_both_axes) {
    SyntheticSea sea(ripples());
    const Picture picture = render(sea.at(0), sky_at_hour(12), DebugView::roughness);
    const Facets facets = facets_of_ripples();
    for (int x = 3; x < picture.width; x += 20)
        EXPECT_NEAR(static_cast<double>(picture.pixel(x, 50)[0]), std::sqrt(facets.xx + facets.yy),
                    1e-3);
}

// Ripples of 1.2 m on a long wave, 40 m away. On level water a pixel is a metre long and resolves hardly
// any of them; where the long wave tilts towards the eye it is a third of that, and what it resolves is no
// roughness.
TEST_F(FacetsTest, a_face_towards_the_eye_is_seen_more_finely_than_level_water) {
    sea::Realization waves = one_wave(1.6, 100, 4);
    waves.choppiness = {0, 0};
    constexpr double k = 2 * pi / 9.6 * 8, rms = 0.05;
    waves.cascades.push_back(one_wave(rms * std::numbers::sqrt2 / k, 9.6, 8).cascades[0]);
    SyntheticSea sea(waves);
    const SeaFrame frame = sea.at(0);
    const sea::Surface swell({frame.cascades[0].keyframes}, frame.choppiness, {}, {});
    camera_ = {.z_m = 8, .yaw_deg = 270, .pitch_deg = -12, .width = 240, .height = 136};
    const Sky& sky = sky_at_hour(12);
    const Picture place = render(frame, sky, DebugView::place);
    const Picture rough = render(frame, sky, DebugView::roughness);
    double towards = 0;
    int count = 0;
    for (int y = 0; y < place.height; ++y)
        for (int x = 0; x < place.width; x += 3) {
            const auto east = static_cast<double>(place.pixel(x, y)[0]);
            const auto north = static_cast<double>(place.pixel(x, y)[1]);
            if (east < -56 || east > -28 || std::abs(north) > 15)
                continue;
            const double slope = swell.at(east, north, 0).slope_x; // the eye is in the east
            if (slope < -0.3)
                towards += static_cast<double>(rough.pixel(x, y)[0]) / rms, ++count;
        }
    ASSERT_GT(count, 200);
    // With strips as long as those of level water, all of the ripples and some of the swell are rough.
    EXPECT_LT(towards / count, 0.9);
}

// The copy, where pixels resolve it: half as long and turned by 0.37 rad. It has no other picture than
// the light itself.
TEST_F(FacetsTest, a_resolved_copy_of_the_finest_waves_is_turned_with_its_slopes) {
    constexpr double kx = 2 * pi / 32 * 2, ky = 2 * pi / 32 * 1, amplitude_m = 0.5, times = 2;
    sea::Realization waves = one_wave(0, 100, 3);
    waves.choppiness = {0, 0};
    waves.cascades.push_back(one_wave(amplitude_m, 32, 2, 1).cascades[0]);
    waves.cascades[1].band = {100, times * 100}; // nothing beyond the copy: capillary waves begin
    SyntheticSea sea(waves);
    camera_ = {.x_m = 17.3,
               .y_m = -8.1,
               .z_m = 10,
               .yaw_deg = 300,
               .pitch_deg = -50,
               .width = 160,
               .height = 90};
    const Sky& sky = sky_at_hour(9); // in the south-east; the copy is told by the blue of the sky
    const SeaFrame frame = sea.at(0);
    const Picture place = render(frame, sky, DebugView::place);
    const Picture picture = render(frame, sky, DebugView::final, {.air = false});
    const double c = std::cos(0.37), s = std::sin(0.37);
    const auto slope = [&](double x, double y) {
        const double steep = -amplitude_m * std::sin(kx * x + ky * y);
        return glm::dvec2(kx * steep, ky * steep);
    };
    int compared = 0;
    double apart = 0, unturned = 0;
    for (int y = 2; y < picture.height; y += 5)
        for (int x = 2; x < picture.width; x += 5) {
            const float* at = place.pixel(x, y);
            if (at[2] > 0)
                continue; // crests are tinted by light that shines through
            const double east = camera_.x_m + static_cast<double>(at[0]);
            const double north = camera_.y_m + static_cast<double>(at[1]);
            const glm::dvec2 copy =
                slope(times * (c * east - s * north), times * (s * east + c * north));
            const auto light = [&](const glm::dvec2& copied) {
                const glm::dvec2 all = slope(east, north) + copied;
                const glm::dvec3 normal = glm::normalize(glm::dvec3(-all.x, -all.y, 1));
                const glm::dvec3 away = ray(x, y);
                const double cosine = -glm::dot(away, normal), reflected = schlick(cosine);
                return (1 - reflected) * deep_water(sky).b +
                       reflected * mirrored(sky, away + 2 * cosine * normal).b;
            };
            const double found = static_cast<double>(picture.pixel(x, y)[2]);
            apart +=
                std::abs(found / light({c * copy.x + s * copy.y, c * copy.y - s * copy.x}) - 1);
            unturned += std::abs(found / light(copy) - 1);
            ++compared;
        }
    ASSERT_GT(compared, 100);
    EXPECT_LT(apart / compared, 0.01);
    EXPECT_GT(unturned / compared, 0.029) << "a slope that is not turned back is told apart";
}

} // namespace
} // namespace seaway::client
