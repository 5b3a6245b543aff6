// SPDX-License-Identifier: Apache-2.0
// What an eye under water sees: the surface from below, the sea floor, and light that the water scatters before them.
//
// One coefficient K, of daylight going down, stands for all that water takes: what is scattered forward is not lost to what
// is wide. Light scattered from a metre of water is as bright in all directions, s K R Ed / pi. With Ed ~ exp(-K p depth), what
// deep water sends up along a cosine m is s / (1 + p m) of R Ed / pi, and all of it together R Ed where s = p^2 / (2 (p - ln(1 + p))).
// With p = 1 straight up is Q = 2 pi / s = 3.86.

float scattered_evenly() {
    const float p = view.water.down_path;
    return p * p / (2.0 * (p - log(1.0 + p)));
}

/// R: light going up over light going down; of what comes out above the surface (client/view/water_optics.h).
vec3 below_surface(vec3 reflectance) { return reflectance / (0.41 + 0.48 * reflectance); }
/// Of the sea floor, which sends light back evenly.
vec3 floor_albedo(vec3 reflectance) { return reflectance / (0.52 + 0.48 * reflectance); }

/// Daylight on the level at a depth, klx.
vec3 daylight_at(float depth_m) {
    const vec3 down = view.sky_irradiance_klx + beam_klx * max(view.sun_direction.z, 0.0);
    return 0.94 * down * daylight_left(view.water.attenuation_per_m, depth_m);
}

/// Light scattered towards the eye on a way of so many metres from a depth; up: sine of the way's elevation.
vec3 scattered_before(float depth_m, float up, float way_m) {
    const float lost = 1.0 - view.water.down_path * up; // a way up meets brighter water
    const float divisor = abs(lost) < 0.01 ? 0.01 : lost;
    // What the end of the way adds, as the daylight of a depth: one exponential, which does not overflow.
    const vec3 end = daylight_at(depth_m + divisor * way_m / view.water.down_path);
    return scattered_evenly() / pi * below_surface(view.water_reflectance) * (daylight_at(depth_m) - end) / divisor;
}

/// Water and floor, along a direction that is not towards the surface.
vec3 water_along(vec3 direction, float depth_m) {
    const float down = max(-direction.z, 1e-3);
    const float floor_m = min(view.water.depth_m, 1e5); // deep water has none
    const float way_m = max(floor_m - depth_m, 0.0) / down;
    const vec3 floor_light = floor_albedo(view.water.floor_reflectance) * daylight_at(max(floor_m, depth_m)) / pi;
    return scattered_before(depth_m, -down, way_m) + floor_light * exp(-view.water.attenuation_per_m * way_m);
}

/// Share that the surface mirrors down of light from below: Fresnel's equations. Cosines within water and air.
float mirrored_below(float within, float outside) {
    const float across = (water_index * within - outside) / (water_index * within + outside);
    const float along = (water_index * outside - within) / (water_index * outside + within);
    return 0.5 * (across * across + along * along);
}

/// A facet seen from below: the bent sky, brighter by n^2, within Snell's window; beyond it a mirror of the water.
void add_facet_below(inout vec4 sum, vec3 away, vec2 slope, float weight, float blur) {
    const vec3 facet = vec3(-slope, 1.0);
    const float facing = dot(facet, away);
    const vec3 normal = normalize(facet);
    const float within = max(dot(normal, away), 1e-3);
    const vec3 out_of = refract(away, -normal, water_index);
    const bool through = out_of != vec3(0);
    const float mirrored = through ? mirrored_below(within, max(dot(out_of, normal), 0.0)) : 1.0;
    vec3 back = reflect(away, normal);
    back.z = min(back.z, -0.05); // what would go up meets the next wave
    vec3 light = mirrored * water_along(normalize(back), 0.0);
    if (through)
        light += (1.0 - mirrored) * water_index * water_index * mirrored_radiance(out_of, blur);
    sum += max(facing, 0.0) * weight * vec4(light, 1.0);
}

/// The disc through facets that bend it to the eye, nowhere brighter than the disc (see disc_in_slopes).
vec3 sun_through(vec3 away, vec3 normal, vec2 slope, vec3 variance) {
    const vec3 to_sun = view.sun_direction;
    const vec3 bend = water_index * away - to_sun;
    const float strength = max(length(bend), 0.05);
    const vec3 facet = bend / strength;
    const float within = dot(away, facet), outside = dot(to_sun, facet);
    if (to_sun.z <= 0.0 || facet.z < 0.1 || within <= 0.0 || outside <= 0.0)
        return vec3(0);
    variance.xy += vec2(outside / (2.0 * pi * view.sun_disk_per_sr * strength * strength));
    const vec2 offset = -facet.xy / facet.z - slope;
    const float determinant = max(variance.x * variance.y - variance.z * variance.z, 1e-12);
    const float exponent = (variance.y * offset.x * offset.x + variance.x * offset.y * offset.y -
                            2.0 * variance.z * offset.x * offset.y) / determinant;
    const float density = exp(-0.5 * exponent) / (2.0 * pi * sqrt(determinant) * pow(facet.z, 4.0));
    const float a_steradian = density * outside * within / (max(dot(away, normal), 0.05) * strength * strength);
    return beam_klx * (1.0 - mirrored_below(within, outside)) * water_index * water_index *
           min(a_steradian, view.sun_disk_per_sr);
}

/// The surface from below, without the water before it. away: from the eye, unit.
vec3 surface_from_below(Place place, vec3 away) {
    const Footprint area = footprint(place.undisplaced_m, away, place.distance_m);
    light_place(place.undisplaced_m, area.pixel_m);
    Gradients g = gradients_at(area);
    const float white = foam_share(g);
    add_detail(g, area);
    const vec3 scaled = scaled_normal(g);
    const vec3 normal = lit_normal(scaled, away);
    const vec2 slope = -normal.xy / max(normal.z, 0.1);
    const vec2 look = normalize(away.xy + vec2(1e-6, 0));
    const float along = sqrt(max(dot(look * look, g.variance.xy) + 2.0 * look.x * look.y * g.variance.z, 0.0));
    const float across = sqrt(max(g.variance.x + g.variance.y - along * along, 0.0));
    // The rule of reflected_sky, with two points across.
    const float outer = 1.3556262, share = 0.2272;
    const float blur = min(0.3 * along, 1.0);
    vec4 sum = vec4(vec3(0), 1e-6);
    add_facet_below(sum, away, slope, 1.0 - 4.0 * share, blur);
    for (int side = 0; side < 4; ++side) {
        const vec2 step = side < 2 ? along * look : across * vec2(-look.y, look.x);
        add_facet_below(sum, away, slope + (side % 2 == 0 ? outer : -outer) * step, share, blur);
    }
    vec3 colour = sum.rgb / sum.a + sun_through(away, normal, slope, g.variance + vec3(g.within, g.within, 0.0));
    const Foam foam = foam_at(white, place.undisplaced_m, area.pixel_m);
    // A sheet of foam lets through a good third of what falls on it.
    return mix(colour, 0.4 / pi * daylight_at(0.0), foam.cover);
}

vec3 under_water(Place place, vec3 away) {
    const vec3 k = view.water.attenuation_per_m;
    if (!shows_sky(place))
        return surface_from_below(place, away) * exp(-k * place.distance_m) +
               scattered_before(view.eye_depth_m, away.z, place.distance_m);
    if (away.z < 0.02)
        return water_along(away, view.eye_depth_m);
    // Beyond the mesh the surface is level.
    const float way_m = view.eye_depth_m / away.z;
    vec4 level = vec4(vec3(0), 1e-6);
    add_facet_below(level, away, vec2(0), 1.0, 0.1);
    return level.rgb / level.a * exp(-k * way_m) + scattered_before(view.eye_depth_m, away.z, way_m);
}
