// SPDX-License-Identifier: Apache-2.0
// Breaks coverage up into patches of bubbles that ride with the water.

float hash(ivec2 cell, int period) {
    cell = cell & (period - 1); // the period is a power of two
    uint h = uint(cell.x) * 0x8da6b343u + uint(cell.y) * 0xd8163841u;
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
    h = (h ^ (h >> 12)) * 0x297a2d39u;
    return float((h ^ (h >> 15)) & 0xffffffu) / 16777215.0;
}

/// Smooth noise, 0 .. 1, cells of 2^-level metres.
float noise(vec2 at_m, int level) {
    const float frequency = exp2(float(level));
    const vec2 at = at_m * frequency;
    const ivec2 cell = ivec2(floor(at));
    const int period = int(float(view_noise_period_m) * frequency);
    vec2 t = at - vec2(cell);
    t = t * t * (3.0 - 2.0 * t);
    return mix(mix(hash(cell, period), hash(cell + ivec2(1, 0), period), t.x),
               mix(hash(cell + ivec2(0, 1), period), hash(cell + ivec2(1, 1), period), t.x), t.y);
}

/// What of a pixel is white. Far away that is the share itself; near, patches of full cover whose
/// area is the share.
float foam_cover(float share, vec2 undisplaced_m, float distance_m) {
    const float pixel_m = distance_m * view.camera.w;
    if (share < 0.004)
        return 0.0;
    vec2 at = undisplaced_m + view.foam.zw;
    at += 0.6 * vec2(noise(at, 1), noise(at + 37.0, 1)); // tears the patches' edges
    float pattern = 0.0;
    float weight = 0.0;
    float amplitude = 1.0;
    for (int level = 0; level <= 5; ++level) {
        // An octave finer than the pixel is worth its mean.
        const float seen = clamp(1.5 - 2.0 * pixel_m * exp2(float(level)), 0.0, 1.0);
        pattern += amplitude * mix(0.5, seen > 0.0 ? noise(at, level) : 0.5, seen);
        weight += amplitude;
        amplitude *= 0.85;
    }
    // Sums of noise crowd about one half; bubbles thin out towards the edges of a patch.
    const float spread = clamp((pattern / weight - 0.3) / 0.4, 0.0, 1.0);
    const float patches = smoothstep(0.0, 0.45, spread - (1.0 - share));
    return mix(patches, share, clamp(pixel_m * 2.0 - 0.5, 0.0, 1.0));
}
