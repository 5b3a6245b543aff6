// SPDX-License-Identifier: Apache-2.0
// A texel of the gradients' maps, and how it is packed into one fetch. Half floats lose 0.05 % of a slope; lines
// between nodes, three to six a wave at the shortest, lose a hundred times as much.

struct GradientTexel {
    vec2 slope;    // d eta / d(X, Y)
    vec3 strain;   // d Dx/dX, d Dy/dY, d Dx/dY
    vec3 variance; // of slope within the texel: xx, yy, xy
    float foam;    // over its mean
};

/// Variance as its trace and, in steps of 1/127 of that, (xx - yy) and 2 xy.
uint packed_variance(vec3 v) {
    const float trace = max(v.x + v.y, 0.0);
    const vec2 sides = vec2(v.x - v.y, 2.0 * v.z) / max(trace, 1e-12);
    return packHalf2x16(vec2(trace, 0)) | packSnorm4x8(vec4(0, 0, sides));
}

vec3 unpacked_variance(uint word) {
    const float trace = unpackHalf2x16(word & 0xffffu).x;
    const vec2 sides = unpackSnorm4x8(word).zw;
    return 0.5 * trace * vec3(1.0 + sides.x, 1.0 - sides.x, sides.y);
}

uvec4 packed(GradientTexel t) {
    return uvec4(packHalf2x16(t.slope), packHalf2x16(t.strain.xy), packHalf2x16(vec2(t.strain.z, t.foam)),
                 packed_variance(t.variance));
}

GradientTexel unpacked_gradient(uvec4 words) {
    const vec2 last = unpackHalf2x16(words.z);
    return GradientTexel(unpackHalf2x16(words.x), vec3(unpackHalf2x16(words.y), last.x),
                         unpacked_variance(words.w), last.y);
}

/// Weighted sums. Squares of slope are summed beside slopes: the difference is the variance that a mean has
/// lost, which the shading turns into roughness (LEAN maps, Olano and Baker 2010). It is kept as a difference, so
/// that it is precise where it is small.
struct GradientSum {
    vec2 slope;
    vec3 strain;
    vec3 square;
    float foam;
};

const GradientSum no_gradients = GradientSum(vec2(0), vec3(0), vec3(0), 0.0);

vec3 squares(vec2 slope) { return vec3(slope * slope, slope.x * slope.y); }

void add(inout GradientSum sum, GradientTexel texel, float weight) {
    sum.slope += weight * texel.slope;
    sum.strain += weight * texel.strain;
    sum.square += weight * (texel.variance + squares(texel.slope));
    sum.foam += weight * texel.foam;
}

GradientTexel mean_of(GradientSum sum) {
    vec3 variance = sum.square - squares(sum.slope);
    variance.xy = max(variance.xy, vec2(0));
    return GradientTexel(sum.slope, sum.strain, variance, sum.foam);
}
