// SPDX-License-Identifier: Apache-2.0
// The sky, from the tables that the CPU has made (client/view/sky/sky.h). What water and the picture see of
// it are sky_radiance, sky_behind, through_air, and where clouds are, light_place and below_clouds.
const float pi = 3.14159265;

/// Column and row of a direction in a table, 0 .. 1: rows are dense at the horizon, nothing is mixed across it.
vec2 dome_place(vec3 direction, float dip) {
    const float above = asin(clamp(direction.z, -1.0, 1.0)) + dip;
    const float range = 0.5 * pi + (above < 0.0 ? -dip : dip);
    const float half_rows = 0.5 * float(sky_rows);
    const float row = sqrt(min(abs(above) / range, 1.0)) * (half_rows - 1.0);
    const float turn = atan(direction.y, direction.x) - view.sky.azimuth_rad;
    return vec2(turn / (2.0 * pi),
                (half_rows + (above < 0.0 ? -0.5 - row : 0.5 + row)) / float(sky_rows));
}

/// What arrives at a point of the sea from around a direction: the sky with its clouds, and below the horizon
/// what the sea shows there. blur: standard deviation of the lobe of directions, rad an axis; 0 sharp.
vec3 sky_radiance(vec3 direction, float blur) {
    const float share = blur / 0.04;
    float level = clamp(share < 1.0 ? share : 1.0 + log2(share), 0.0, float(sky_mips - 1));
    if (view.between_levels == 0)
        level = round(level); // one level is looked up, not two
    vec2 at = dome_place(direction, 0.0);
    // Rows do not repeat as columns do.
    const float edge = 0.5 * exp2(ceil(level)) / float(sky_rows);
    at.y = clamp(at.y, edge, 1.0 - edge);
    return textureLod(sky_map, vec3(at, sky_layer_sea), level).rgb;
}

/// Share of light that the air lets through, towards a point near the sea or at a cloud.
vec3 air_left(float distance_m, vec3 direction) {
    const vec4 nodes = vec4(0.0694318442, 0.3300094782, 0.6699905218, 0.9305681558);
    const vec4 weights = 2.0 * nodes * vec4(0.1739274226, 0.3260725774, 0.3260725774, 0.1739274226);
    const vec4 share = nodes * nodes;
    const vec4 t = distance_m * (direction.z < 0.0 ? 1.0 - share : share);
    const float bend = view.sky.curvature_per_m * (1.0 - direction.z * direction.z);
    const vec4 h = max(view.camera_m.z + t * (direction.z + bend * t), vec4(0));
    const float rayleigh = dot(weights, exp(-h / view.sky.rayleigh_scale_m));
    const float aerosol = dot(weights, exp(-h / view.sky.aerosol_scale_m));
    return exp(-distance_m * (rayleigh * view.sky.rayleigh_per_m + aerosol * view.sky.aerosol_per_m));
}

/// Of the air's light on the way to the sea.
vec3 air_source(vec3 direction) {
    vec2 at = dome_place(direction, view.sky.dip_rad);
    at.y = min(at.y, 0.5 - 0.5 / float(sky_rows)); // it lies below the horizon
    return textureLod(sky_map, vec3(at, sky_layer_eye), 0.0).rgb;
}

/// A colour at a distance as the eye sees it through the air. Unit direction.
vec3 through_air(vec3 colour, float distance_m, vec3 direction) {
    return mix(air_source(direction), colour, air_left(distance_m, direction));
}

// Clouds: client/view/sky/clouds.cpp has the same formula.
float cloud_depth(vec2 at, float lod) {
    const float pattern = textureLod(sky_map, vec3(at, sky_layer_cloud), lod).r;
    const float detail = textureLod(sky_map, vec3(at * cloud_detail_scale, sky_layer_cloud), lod + 2.0).g;
    const float region = textureLod(sky_map, vec3(at * cloud_region_scale, sky_layer_cloud), max(lod - 1.9, 0.0)).r;
    const float above = pattern + cloud_detail_share * (detail - 0.5) + cloud_region_share * (region - 0.5) - view.sky.cloud_threshold;
    const float share = clamp(above / cloud_softness, 0.0, 1.0);
    return view.sky.cloud_depth * share * share; // thin at their edges
}

float henyey(float g, float cosine) {
    const float base = 1.0 + g * g - 2.0 * g * cosine;
    return (1.0 - g * g) / (4.0 * pi * base * sqrt(base));
}

/// The layer of clouds where a ray meets it, before a colour that is seen through all of the air; share of what lies behind
/// the layer that is left in w. `under`: square of the cosine at which it is met; source: of the air's light before it.
vec4 clouds_met(vec3 clear, vec3 source, vec3 direction, float rise, float under) {
    const float cosine = sqrt(under);
    const float distance_m = 2.0 * abs(view.sky.cloud_height_m) / (abs(direction.z) + cosine);
    const vec2 at = view.sky.cloud_origin + direction.xy * distance_m * view.sky.cloud_per_m;
    const float footprint = distance_m * view.pixel_rad / max(cosine, 0.05);
    const float lod = max(log2(footprint * view.sky.cloud_per_m.x * float(sky_columns)), 0.0);
    const float depth = cloud_depth(at, lod);
    const float mu = max(view.sky.to_light.z, 0.2);
    const vec2 aside = view.sky.to_light.xy * (cloud_thickness_m / mu) * view.sky.cloud_per_m;
    const float shade = clamp((1.0 + cloud_diffuse_loss * depth) /
                              (1.0 + cloud_diffuse_loss * cloud_depth(at + aside, lod)), 0.5, 1.6);
    const float passing = 1.0 / (1.0 + cloud_diffuse_loss * depth);
    const float along = exp(-depth / max(cosine, 0.05));
    const float left = rise > 0.0 ? along : passing;
    const float diffuse = exp(-cloud_mean_slant * depth); // what falls on the level
    const vec3 beam = view.sky.cloud_light * mu * (passing - exp(-depth / mu)) * shade;
    const vec3 sky = view.sky.cloud_sky * (passing - diffuse);
    const float angle = dot(direction, view.sky.to_light);
    const float lobes = cloud_forward_share * henyey(cloud_forward, angle) +
                        (1.0 - cloud_forward_share) * henyey(cloud_backward, angle);
    // Seen aslant a thin cloud is brighter, as it hides more.
    const vec3 passed = (beam * mix(1.0 / pi, lobes / mu, exp(-cloud_straight_loss * depth)) + sky / pi) *
                        ((1.0 - along) / max(1.0 - diffuse, 1e-6));
    const vec3 returned = (view.sky.cloud_light * mu * shade + view.sky.cloud_sky) *
                          ((1.0 - passing) / pi);
    const vec3 radiance = rise > 0.0 ? passed : returned;
    // The air before the clouds.
    const vec3 through = air_left(distance_m, direction);
    return vec4(clear * left + through * radiance + (1.0 - left) * (1.0 - through) * source, left);
}

/// Light of sun or moon at the point of the sea that is lit, normal to the beam, klx; its mean under all clouds until
/// light_place() has said where that is.
vec3 beam_klx = view.sun_irradiance_klx;

/// Patches of light: clouds let the beam through here and hold it there. Where a pixel is as large as a cloud the mean is
/// left. client/view/sky/clouds.cpp has the same formula.
void light_place(vec2 place_m, float pixel_m) {
#ifndef SEAWAY_CLEAR
    for (int once = 0; once < int(view.sky.cloud_patches > 0.0); ++once) {
        const float height_m = view.sky.cloud_height_m + view.camera_m.z;
        const float rise = height_m * 4.0 * view.sky.curvature_per_m;
        const float s = view.sky.to_light.z;
        const float distance_m = 2.0 * height_m / (s + sqrt(s * s + rise));
        const vec2 at = view.sky.cloud_origin +
                        (place_m + view.sky.to_light.xy * distance_m) * view.sky.cloud_per_m;
        const float lod = max(log2(pixel_m * view.sky.cloud_per_m.x * float(sky_columns)), 0.0);
        const float share = exp(-cloud_depth(at, lod) / max(s, 0.2)) * view.sky.cloud_patches;
        beam_klx *= mix(share, 1.0, smoothstep(2.0, 5.0, lod));
    }
#endif
}

/// Devices without a GPU take both sides of every branch, and a good part of a loop that nobody is in: what is dear and
/// seldom seen - clouds, stars, discs - stands in loops that are run once or not at all, and is left out of shaders for
/// skies without clouds (SEAWAY_CLEAR) and of pictures where no disc nor star stands (SEAWAY_PLAIN).
vec4 clouds_before(vec3 clear, vec3 source, vec3 direction) {
    const float rise = view.sky.cloud_height_m * 4.0 * view.sky.curvature_per_m;
    const float under = direction.z * direction.z + rise;
    const bool met = view.sky.cloud_threshold <= 1.5 && under > 0.0 && (rise > 0.0) == (direction.z >= 0.0);
    vec4 seen = vec4(clear, 1);
    for (int once = 0; once < int(met); ++once)
        seen = clouds_met(clear, source, direction, rise, under);
    return seen;
}

/// The sea under clouds that the eye looks down on.
vec3 below_clouds(vec3 seen, vec3 direction) {
#ifdef SEAWAY_CLEAR
    return seen;
#else
    return clouds_before(seen, air_source(direction), direction).rgb;
#endif
}

uint star_hash(uvec3 cell) { // PCG 3d (Jarzynski and Olano 2020), one of three
    cell = cell * 1664525u + 1013904223u;
    cell.x += cell.y * cell.z;
    cell.y += cell.z * cell.x;
    cell.z += cell.x * cell.y;
    cell ^= cell >> 16u;
    cell.x += cell.y * cell.z;
    return cell.x;
}

/// Stars: one in each cell of two grids on a cube around the eye, 9078 in all, their number rising by 10^0.51 a magnitude,
/// 6.5 the faintest. The Bright Star Catalogue has 9096 to 6.5 (Hoffleit 1991), Hipparcos 4968 to 6, 1600 to 5, 511 to 4
/// (OEIS A053406); the law 5050, 1560, 480.
vec3 stars(vec3 direction) {
    const vec3 d = vec3(dot(view.sky.star_x, direction), dot(view.sky.star_y, direction),
                        dot(view.sky.star_z, direction));
    const vec3 size = abs(d);
    const int face = size.x > size.y && size.x > size.z ? 0 : size.y > size.z ? 1 : 2;
    const float along = face == 0 ? d.x : face == 1 ? d.y : d.z;
    const vec2 side = (face == 0 ? d.yz : face == 1 ? d.zx : d.xy) / abs(along);
    const float bend = 1.0 + dot(side, side); // a cube's side is seen aslant
    const float width = 0.7 * view.pixel_rad;
    vec3 sum = vec3(0);
    for (uint grid = 0u; grid < 2u; ++grid) { // one alone is seen to be one
        const float cells = 27.0 + float(grid);
        const vec2 at = (side * 0.5 + 0.5) * cells;
        const uint which = (uint(face) * 2u + (along > 0.0 ? 1u : 0u)) * 2u + grid;
        const uint seed = star_hash(uvec3(uvec2(at), which));
        const vec4 random = vec4(float(seed & 255u) / 255.0, float((seed >> 8u) & 255u) / 255.0,
                                 (float((seed >> 16u) & 4095u) + 0.5) / 4096.0, float(seed >> 28u) / 15.0);
        // Away from the cell's edge, so that no star is cut.
        const vec2 off = (fract(at) - 0.08 - 0.84 * random.xy) * 2.0 / cells;
        const float angle2 = dot(off, off) / (bend * sqrt(bend));
        const float magnitude = 6.5 + log2(random.z) * (0.30103 / 0.51);
        const float klx = view.sky.star_klx * exp2(-1.32877 * magnitude);
        sum += mix(vec3(1.15, 0.97, 0.8), vec3(0.85, 1.0, 1.25), random.w) *
               (klx * exp(-0.5 * angle2 / (width * width)));
    }
    return sum * exp(-view.sky.zenith_depth / max(direction.z, 0.02)) / (2.0 * pi * width * width);
}

/// Discs of sun and moon.
vec3 discs(vec3 direction) {
    const float soft = 0.5 * view.pixel_rad;
    const float radius = view.sky.disc_rad;
    vec3 sum = vec3(0);
    const float off_sun = length(direction - view.sky.to_sun); // exact where it is small
    for (int once = 0; once < int(off_sun < radius + 2.0 * soft); ++once) {
        const float cover = 1.0 - smoothstep(radius - soft, radius + soft, off_sun);
        const float height = clamp(0.5 + 0.5 * (direction.z - view.sky.to_sun.z) / radius, 0.0, 1.0);
        // Limb darkening: a fit to the polynomials of Neckel and Labs 1994 (Solar Physics 153, table 1) at 611, 550
        // and 445 nm, within 1 % but for the last hundredth of the radius.
        const float rim = 1.0 - sqrt(max(1.0 - off_sun * off_sun / (radius * radius), 0.0));
        const vec3 u = vec3(0.425, 0.488, 0.632), v = vec3(0.213, 0.203, 0.174);
        sum += cover * mix(view.sky.sun_low, view.sky.sun_high, height) * (1.0 - rim * (u + v * rim)) /
               (1.0 - u / 3.0 - v / 6.0); // of the disc's mean
    }
    const vec3 off_moon = direction - view.sky.to_moon;
    const float off = length(off_moon);
    for (int once = 0; once < int(off < radius + 2.0 * soft && view.sky.moon.g > 0.0); ++once) {
        const float cover = 1.0 - smoothstep(radius - soft, radius + soft, off);
        const vec3 normal = off_moon / radius -
                            view.sky.to_moon * sqrt(max(1.0 - off * off / (radius * radius), 0.0));
        sum += cover * view.sky.moon * smoothstep(-0.02, 0.05, dot(normal, view.sky.to_sun));
    }
    return sum;
}

/// The sky that the eye sees directly, with all that stands in it.
vec3 sky_behind(vec3 direction) {
    vec2 at = dome_place(direction, view.sky.dip_rad);
    at.y = max(at.y, 0.5 + 0.5 / float(sky_rows));
    const vec3 clear = textureLod(sky_map, vec3(at, sky_layer_eye), 0.0).rgb;
#ifdef SEAWAY_CLEAR
    const vec4 seen = vec4(clear, 1);
#else
    const vec3 held = 1.0 - exp(-view.sky.zenith_depth / max(direction.z, 0.03));
    const vec3 source = mix(view.sky.cloud_shaded, clear / held, view.sky.cloud_sunlit);
    // Below clouds the sky reaches a little below the level, and so do they.
    const float rising = view.sky.cloud_height_m > 0.0 ? max(direction.z, 0.0) : direction.z;
    const vec4 seen = clouds_before(clear, source, vec3(direction.xy, rising));
#endif
    vec3 beyond = vec3(0);
#ifndef SEAWAY_PLAIN
    beyond = discs(direction);
    for (int once = 0; once < int(view.sky.star_klx > 0.0); ++once)
        beyond += stars(direction);
#endif
    return seen.rgb + seen.w * beyond;
}
