// SPDX-License-Identifier: Apache-2.0
// The sea as it is seen: sky and sun by facets, light from the water body, foam, air.
//
// Facets: slopes within a pixel are Gaussian with the mean and covariance of the filtered maps.
// Mean Fresnel and sun term after Bruneton, Neyret, Holzschuch 2010; the mean reflected sky is a
// quadrature over the slopes that face the eye.

const float reflectance_at_normal = 0.02; // sea water, of n 1.33 to 1.34
const float reflectance_of_waves = 0.06; // the same at 60 degrees: of a wave that a reflected ray meets

float schlick(float cosine) {
    return reflectance_at_normal +
           (1.0 - reflectance_at_normal) * pow(1.0 - clamp(cosine, 0.0, 1.0), 5.0);
}

float mean_fresnel(float cosine, float sigma) {
    return reflectance_at_normal + (1.0 - reflectance_at_normal) *
                                       pow(1.0 - cosine, 5.0 * exp(-2.69 * sigma)) /
                                       (1.0 + 22.7 * pow(sigma, 1.5));
}

/// Diffuse light that comes out of water of this reflectance.
vec3 out_of_water(vec3 reflectance) {
    const vec3 down = view.sky_irradiance_klx + beam_klx * max(view.sun_direction.z, 0.0);
    return reflectance * down / pi;
}

/// Share of daylight that comes down to a depth.
vec3 daylight_left(vec3 attenuation_per_m, float depth_m) {
    return exp(-attenuation_per_m * (view.water.down_path * depth_m));
}

/// Sand lies in patches: its reflectance varies by so much.
const float patches_of_floor = 0.35;

/// Reflectance of the water under a facet: of deep water, or where its floor is seen, R = R_deep + (R_floor - R_deep)
/// exp(-K path) (Maritorena, Morel, Gentili 1994), along the bent ray to the eye and the way of daylight down.
vec3 water_reflectance(vec3 to_eye, vec3 normal, Place place) {
    vec3 reflectance = view.water_reflectance;
    // A loop, not a branch: see gradients.glsl.
    for (int once = 0; once < view.water.floor_seen; ++once) {
        const vec3 ray = refract(-to_eye, normal, 1.0 / water_index);
        const float up_path = 1.0 / max(-ray.z, 0.3);
        const float depth_m = max(view.water.depth_m + place.height_m, 0.0);
        const vec2 at_m = depth_m * up_path * ray.xy - place.distance_m * to_eye.xy + view.foam_noise_origin_m;
        const float pixel_m = place.distance_m * view.pixel_rad / max(to_eye.z, 0.05);
        const float patchy = (noise(at_m, -3) - 0.5) * seen_share(-3, pixel_m) +
                             0.5 * (noise(at_m + 19.0, 0) - 0.5) * seen_share(0, pixel_m);
        const vec3 floor_there = view.water.floor_reflectance * (1.0 + patches_of_floor * patchy);
        const vec3 k = view.water.floor_attenuation_per_m;
        const vec3 left = exp(-k * (depth_m * up_path)) * daylight_left(k, depth_m);
        reflectance = mix(reflectance, floor_there, left);
    }
    return reflectance;
}

/// What a facet mirrors. A ray that goes down meets another wave, which is dark: it mirrors little of the sky above it.
/// Waves hide the sky near the horizon before the ray is level.
vec3 mirrored_radiance(vec3 direction, float blur) {
    const float open = smoothstep(-0.15, 0.05, direction.z);
    const vec3 sky = sky_radiance(normalize(vec3(direction.xy, max(direction.z, 0.0) + 1e-4)), blur);
    const vec3 wave = out_of_water(view.water_reflectance) + reflectance_of_waves * view.sky_irradiance_klx / pi;
    return mix(wave, sky, open);
}

/// Adds what the facet of this slope mirrors; facets that lean towards the eye are seen larger.
void add_facet(inout vec4 sum, vec3 to_eye, vec2 slope, float weight, float blur) {
    const vec3 facet = vec3(-slope, 1.0);
    const float facing = dot(facet, to_eye);
    const vec3 normal = normalize(facet);
    const float seen = facing > 0.0 ? weight * facing * schlick(dot(normal, to_eye)) : 0.0;
    sum += seen * vec4(mirrored_radiance(reflect(-to_eye, normal), blur), 1.0);
}

/// Mean over the slopes within the pixel: three points along the line of sight, and where the eye looks down, so that
/// no direction is special, two across it. The inner points of the Gauss-Hermite rule of five, without the outermost, which
/// weigh 1 %: the bright sky lies near the horizon, and few facets mirror it from further out. Aslant, tilting a facet aside
/// turns what it mirrors by less than twice the tilt: by the eye's height less.
vec3 reflected_sky(vec3 to_eye, vec2 slope, vec3 variance) {
    const vec2 away = normalize(to_eye.xy + vec2(1e-6, 0));
    const vec2 aside = vec2(-away.y, away.x);
    const float sigma = sqrt(max(dot(away * away, variance.xy) + 2.0 * away.x * away.y * variance.z, 1e-6));
    const float across = sqrt(max(variance.x + variance.y - sigma * sigma, 0.0));
    const float down = 1.0 - smoothstep(0.3, 0.6, length(to_eye.xy));
    const float outer = 1.3556262;
    const float blur = min((1.0 - down) * across * min(2.0 * to_eye.z, 1.0) + 0.5 * sigma, 1.0);
    vec4 sum = vec4(vec3(0), 1e-6);
    const float share = 0.2272;
    add_facet(sum, to_eye, slope, 1.0 - 2.0 * share * (1.0 + down), blur);
    add_facet(sum, to_eye, slope - away * sigma * outer, share, blur);
    add_facet(sum, to_eye, slope + away * sigma * outer, share, blur);
    for (int side = 0; side < (down > 0.0 ? 2 : 0); ++side)
        add_facet(sum, to_eye, slope + aside * across * (side == 0 ? outer : -outer), share * down, blur);
    return sum.rgb / sum.a;
}

float smith_lambda(vec3 direction, vec2 slope, vec3 variance) {
    const vec2 along = normalize(direction.xy + vec2(1e-6, 0));
    const float sigma2 = max(dot(along * along, variance.xy) +
                                 2.0 * along.x * along.y * variance.z, 1e-6);
    const float cotangent = direction.z / max(length(direction.xy), 1e-4);
    const float a = max(cotangent / sqrt(2.0 * sigma2), 0.02);
    return a > 1.6 ? 0.0 : (1.0 - 1.259 * a + 0.396 * a * a) / (3.535 * a + 2.181 * a * a);
}

/// Variance of slope that widens the facets' lobe by the disc: the mirror image of a disc of solid angle w is w / (4 cos i) of
/// facets. A normal lobe is as bright in its middle as a disc of 2 pi variances: with w / (8 pi) an axis level water shows
/// the disc's own radiance, and its whole light, on twice its area. Across the plane of incidence facets turn an image by
/// cos i of what they do within.
vec3 disc_in_slopes(vec3 to_eye, vec3 half_way, float incidence) {
    const vec2 within = normalize((to_eye - incidence * half_way).xy + vec2(1e-6, 0));
    const float disc = 1.0 / (8.0 * pi * view.sun_disk_per_sr);
    const float more = disc * (1.0 / (incidence * incidence) - 1.0);
    return vec3(disc + more * within.y * within.y, disc + more * within.x * within.x, -more * within.x * within.y);
}

/// Light of sun or moon that facets mirror. However many lie right, none is brighter than the disc and what water mirrors of it.
vec3 sun_glint(vec3 to_eye, vec3 normal, vec2 slope, vec3 variance) {
    const vec3 to_sun = view.sun_direction;
    if (to_sun.z <= 0.0)
        return vec3(0);
    const vec3 half_way = normalize(to_eye + to_sun);
    if (half_way.z <= 0.01)
        return vec3(0);
    const float incidence = max(dot(to_eye, half_way), 0.05);
    variance += disc_in_slopes(to_eye, half_way, incidence);
    const vec2 offset = -half_way.xy / half_way.z - slope;
    const float determinant =
        max(variance.x * variance.y - variance.z * variance.z, 1e-12);
    const float exponent = (variance.y * offset.x * offset.x + variance.x * offset.y * offset.y -
                            2.0 * variance.z * offset.x * offset.y) / determinant;
    const float density = exp(-0.5 * exponent) / (2.0 * pi * sqrt(determinant));
    const float shadowing =
        1.0 + smith_lambda(to_eye, slope, variance) + smith_lambda(to_sun, slope, variance);
    const float cosine = max(dot(to_eye, normal), 0.02);
    const float a_steradian = density / (4.0 * cosine * pow(half_way.z, 4.0) * shadowing);
    return beam_klx * schlick(incidence) * min(a_steradian, view.sun_disk_per_sr);
}

/// Light that entered the water and comes out again; more where the sun shines through a crest, the more so the thinner
/// it is - where the surface is squeezed to a sharp edge, its Jacobian is small -, and the more squarely the sun meets its far
/// side: the face that is seen then leans away from the sun.
vec3 water_body(vec3 to_eye, vec3 normal, Place place, float jacobian) {
    const vec3 to_sun = view.sun_direction;
    const float crest = smoothstep(0.0, 0.9, place.height_m / max(view.significant_height_m, 0.1));
    const vec2 eye_level = normalize(to_eye.xy + vec2(1e-6, 0));
    const vec2 sun_level = normalize(to_sun.xy + vec2(1e-6, 0));
    const float through = pow(max(0.5 - 0.5 * dot(eye_level, sun_level), 0.0), 3.0);
    const float facing = clamp(1.0 - normal.z + 0.15, 0.0, 1.0);
    const float met = clamp(1.0 - 2.0 * dot(normal.xy, sun_level), 0.0, 2.0);
    const vec3 tint = view.water.crest * (beam_klx * through * met +
                                         0.4 * view.sky_irradiance_klx);
    const float thin = mix(2.0, 0.5, smoothstep(0.3, 1.0, jacobian));
    return out_of_water(water_reflectance(to_eye, normal, place)) + tint * crest * facing * thin;
}

/// Foam scatters as a sheet does, by its own bumps: tilted faces are larger, so their normals are not of unit length, and
/// bumps send back what a sheet would. Wet foam reflects 0.54 of light (Whitlock 1982; Koepke 1984): less at thin edges, and more in the middle, by eye.
vec3 foam_radiance(Foam foam, vec3 normal) {
    const vec3 bumped = normal + vec3(foam.tilt, 0.0);
    const float albedo = mix(0.5, 0.7, foam.thick);
    return albedo / pi * (view.sky_irradiance_klx + beam_klx * max(dot(bumped, view.sun_direction), 0.0));
}

/// Where waves have broken, bubbles in the water send light back before red is swallowed.
vec3 bubbles_below(float white) {
    const vec3 down = view.sky_irradiance_klx + beam_klx * max(view.sun_direction.z, 0.0);
    return 0.25 * min(2.0 * white, 1.0) * view.water.bubbles * down / pi;
}

/// to_eye: unit.
vec3 water_radiance(Place place, vec3 to_eye) {
    const Footprint area = footprint(place.undisplaced_m, to_eye, place.distance_m);
    light_place(place.undisplaced_m, area.pixel_m);
    Gradients g = gradients_at(area);
    const float white = foam_share(g);
    add_detail(g, area);

    const vec3 scaled = scaled_normal(g);
    const vec3 normal = lit_normal(scaled, to_eye);
    const vec2 slope = -normal.xy / max(normal.z, 0.1);

    const vec2 look = normalize(to_eye.xy + vec2(1e-6, 0));
    const float sigma = sqrt(max(dot(look * look, g.variance.xy) +
                                     2.0 * look.x * look.y * g.variance.z, 0.0));
    const float fresnel = mean_fresnel(clamp(dot(normal, to_eye), 0.0, 1.0), sigma);

    vec3 colour = mix(bubbles_below(white) + water_body(to_eye, normal, place, scaled.z),
                      reflected_sky(to_eye, slope, g.variance), fresnel);
    colour += sun_glint(to_eye, normal, slope, g.variance + vec3(g.within, g.within, 0.0));
    const Foam foam = foam_at(white, place.undisplaced_m, area.pixel_m);
    colour = mix(colour, foam_radiance(foam, normal), foam.cover);

    return below_clouds(through_air(colour, place.distance_m, -to_eye), -to_eye);
}
