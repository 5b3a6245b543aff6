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

/// Of a patch's edge so much is left between the holes of its lace, by the larger bubbles and by the small ones.
const vec2 lace_least = vec2(0.4, 0.6);
/// Slope of foam's own bumps, from side to side.
const float foam_tilt = 1.2;

/// Variance of noise(): of the corners' uniform numbers, 1/12, what smooth weights leave.
const float noise_variance = 0.046;

/// Noise finer than the pixel is worth its mean: how much of a level is seen.
float seen_share(int level, float pixel_m) {
    return clamp(1.5 - 2.0 * pixel_m * exp2(float(level)), 0.0, 1.0);
}

/// What of a pixel is white, and how it looks.
struct Foam {
    float cover;  ///< opacity
    float thick;  ///< 0 the edge of a patch .. 1 its middle
    vec2 tilt;    ///< slope of its own bumps
};

const Foam no_foam = Foam(0.0, 0.0, vec2(0));

/// Rows along the wind where Langmuir's cells gather what floats; the mean stays what it was.
float in_rows_of_wind(float share, vec2 undisplaced_m, float pixel_m) {
    const vec2 turn = view.wind_turn;
    const vec2 downwind = vec2(dot(turn, undisplaced_m), turn.x * undisplaced_m.y - turn.y * undisplaced_m.x);
    const vec2 cells = view.foam_rows_origin + downwind * vec2(view_rows_a_metre_along, view_rows_a_metre_across);
    const float seen = clamp(1.5 - 2.0 * pixel_m * view_rows_a_metre_across, 0.0, 1.0);
    return share + share * (1.0 - share) * view.foam_rows * seen * (2.0 * noise(cells, 0) - 1.0);
}

/// Decaying foam opens into lace: of a patch of which `kept` is left, what lies near the ridges of a noise. `width` is the
/// quantile of |2 noise - 1|, fitted to 400,000 draws within 0.02.
float lace(vec2 at_m, int level, float kept, float pixel_m) {
    const float width = kept * (0.61 + 0.1 * kept) + 0.2 * pow(kept, 12.0);
    const float ridge = abs(2.0 * noise(at_m, level) - 1.0);
    const float soft = clamp(pixel_m * exp2(float(level)), 0.03, 0.15);
    return mix(kept, 1.0 - smoothstep(width - soft, width + soft, ridge), seen_share(level, pixel_m));
}

/// Far away cover is the share itself; near, patches with lace at their edges whose area is the share.
Foam foam_at(float share, vec2 undisplaced_m, float pixel_m) {
    Foam foam = no_foam;
    // A loop, not a branch: see gradients.glsl.
    for (int once = 0; once < int(share >= 0.002); ++once) {
        share = in_rows_of_wind(share, undisplaced_m, pixel_m);
        vec2 at = undisplaced_m + view.foam_noise_origin_m;
        const int coarsest = view.foam_level;
        const int torn = coarsest + 3; // tears the patches' edges
        at += 0.15 * exp2(-float(coarsest)) * vec2(noise(at, torn), noise(at + 37.0, torn));
        float pattern = 0.0;
        float variance = 1e-6;
        float amplitude = 1.0;
        for (int level = coarsest; level <= coarsest + 5; ++level) {
            const float seen = amplitude * seen_share(level, pixel_m);
            pattern += seen * (noise(at, level) - 0.5);
            variance += seen * seen * noise_variance;
            amplitude *= 0.7;
        }
        // Sums of noise are nearly normal: their distribution function (a logistic one) makes them
        // uniform, so that the share of them above 1 - extent is the extent.
        const float uniform_noise = 1.0 / (1.0 + exp(-1.702 * pattern * inversesqrt(variance)));
        // From the middle of a patch to its edge less and less is left: 1 .. least.x least.y. The patch is larger by the
        // mean of that.
        const vec2 least = mix(lace_least, vec2(1), share);
        const float mean = (1.0 + 0.5 * (least.x + least.y) + least.x * least.y) / 3.0;
        const float extent = min(share / mean, 1.0);
        const float inside = (uniform_noise - (1.0 - extent)) / max(extent, 1e-3);
        const float edge = min(0.12, 0.9 * min(extent, 1.0 - extent) + 0.005);
        const float patches = smoothstep(-edge, edge, uniform_noise - (1.0 - extent));
        foam.thick = clamp(inside, 0.0, 1.0);
        const vec2 kept = min(mix(least, vec2(1), foam.thick), 0.999);
        const float open = lace(at, coarsest + 4, kept.x, pixel_m) * lace(at, coarsest + 6, kept.y, pixel_m);
        const float seen = seen_share(coarsest + 1, pixel_m);
        foam.cover = mix(share, patches * open, seen);
        foam.tilt = foam_tilt * seen_share(torn, pixel_m) * (vec2(noise(at + 11.0, torn), noise(at + 71.0, torn)) - 0.5);
    }
    return foam;
}
