// SPDX-License-Identifier: Apache-2.0
// Breaks coverage up into patches of bubbles that ride with the water.

float hash(ivec2 cell, int period) {
    cell = cell & (period - 1); // the period is a power of two
    uint h = uint(cell.x) * 0x8da6b343u + uint(cell.y) * 0xd8163841u;
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
    h = (h ^ (h >> 12)) * 0x297a2d39u;
    return float((h ^ (h >> 15)) & 0xffffffu) / 16777215.0;
}

/// Smooth noise, 0 .. 1, cells of 2^-level metres, level -8 and above.
float noise(vec2 at_m, int level) {
    const float frequency = exp2(float(level));
    const vec2 at = at_m * frequency;
    const ivec2 cell = ivec2(floor(at));
    const int period =
        level >= 0 ? view_noise_period_m << level : view_noise_period_m >> -level;
    vec2 t = at - vec2(cell);
    t = t * t * (3.0 - 2.0 * t);
    return mix(mix(hash(cell, period), hash(cell + ivec2(1, 0), period), t.x),
               mix(hash(cell + ivec2(0, 1), period), hash(cell + ivec2(1, 1), period), t.x), t.y);
}

/// Variance of noise(): of the corners' uniform numbers, 1/12, what smooth weights leave.
const float noise_variance = 0.046;

/// Noise finer than the pixel is worth its mean: how much of a level is seen.
float seen_share(int level, float pixel_m) {
    return clamp(1.5 - 2.0 * pixel_m * exp2(float(level)), 0.0, 1.0);
}

/// What of a pixel is white. Far away that is the share itself; near, patches of full cover whose
/// area is the share.
float foam_cover(float share, vec2 undisplaced_m, float pixel_m) {
    vec2 at = undisplaced_m + view.foam_noise_origin_m;
    const int coarsest = view.foam_level;
    // A loop, not a return: see gradients.glsl.
    const bool some = share >= 0.002;
    const int finest = some ? coarsest + 7 : coarsest - 1;
    for (int once = 0; once < int(some); ++once) { // tears the patches' edges
        const int torn = coarsest + 3;
        at += 0.15 * exp2(-float(coarsest)) * vec2(noise(at, torn), noise(at + 37.0, torn));
    }
    float pattern = 0.0;
    float variance = 1e-6;
    float amplitude = 1.0;
    for (int level = coarsest; level <= finest; ++level) {
        const float seen = amplitude * seen_share(level, pixel_m);
        if (seen > 0.0)
            pattern += seen * (noise(at, level) - 0.5);
        variance += seen * seen * noise_variance;
        amplitude *= 0.85;
    }
    // Sums of noise are nearly normal: their distribution function (a logistic one) makes them
    // uniform, so that the share of them above 1 - share is the share.
    const float uniform_noise = 1.0 / (1.0 + exp(-1.702 * pattern * inversesqrt(variance)));
    const float edge = min(0.12, 0.9 * min(share, 1.0 - share) + 0.005);
    const float patches = smoothstep(-edge, edge, uniform_noise - (1.0 - share));
    return !some ? 0.0 : mix(share, patches, seen_share(coarsest + 1, pixel_m));
}
