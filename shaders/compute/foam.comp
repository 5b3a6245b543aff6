#version 460
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: Apache-2.0
// Histories of foam, a step each, four points at a time. The law is that of sea/foam/foam_kernel_impl.h, whose
// polynomials these are, with fewer products; server/device/vulkan_check.cpp holds the two together.
#include "shared/synthesis.h"

layout(local_size_x = synthesis_workgroup) in;
layout(constant_id = 0) const uint quads = foam_quads_on_cpu; // of an invocation
layout(binding = 0) uniform samplerBuffer maps;   // strains among them, [y][x / 4] each
layout(binding = 1) uniform usamplerBuffer steps;
layout(binding = 2) uniform samplerBuffer before;  // the histories
layout(binding = 3, std430) writeonly buffer Histories {
    vec4 histories[];
};
layout(binding = 4, std430) writeonly buffer Foam {
    vec4 foam[];
};
layout(push_constant) uniform Push {
    FoamPush push;
};

FoamStep step_of(uint index) {
    int at = int(index * foam_step_texels);
    vec4 a = uintBitsToFloat(texelFetch(steps, at)), b = uintBitsToFloat(texelFetch(steps, at + 1));
    vec4 c = uintBitsToFloat(texelFetch(steps, at + 2));
    vec4 d = uintBitsToFloat(texelFetch(steps, at + 3));
    uvec4 e = texelFetch(steps, at + 4), f = texelFetch(steps, at + 5);
    return FoamStep(a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w, c.x, c.y, c.z, c.w, d.x, d.y, d.z, d.w,
                    e.x, e.y, e.z, e.w, f.x, f.y, uintBitsToFloat(f.z), f.w);
}

/// phi(t), 0 <= t <= 12.5: 2^n by exponent bits, 2^f by a polynomial.
vec4 normal_density(vec4 t) {
    vec4 power = t * t * (-0.5 * 1.44269504);
    vec4 whole = round(power);
    vec4 f = power - whole;
    vec4 mantissa = 0.39894228 +
        f * (0.27652574 + f * (0.095836914 + f * (0.022142917 + f * (0.0038354538 + f * 0.00053192176))));
    return intBitsToFloat(floatBitsToInt(mantissa) + (ivec4(whole) << 23));
}

vec4 breaking(FoamStep s, vec4 strain_xx, vec4 strain_yy, vec4 strain_xy) {
    vec4 a = s.choppiness_x * strain_xx;
    vec4 b = s.choppiness_y * strain_yy;
    vec4 c = s.choppiness_xy * strain_xy;
    vec4 c2 = c * c;
    vec4 difference = a - b;
    vec4 top = (s.threshold + s.curvature) - (1.0 + a) * (1.0 + b) + c2;
    vec4 slope = 1.0 + (0.5 - 0.5 * s.difference) * a + (0.5 + 0.5 * s.difference) * b -
        (0.5 * s.shear) * c;
    vec4 rest = difference * (difference * s.difference_rest + c * s.cross_rest) +
        (c2 * s.shear_rest + s.constant_rest);
    vec4 variance = max(slope * slope * s.variance + rest, 0.0);
    vec4 discriminant = variance + (4.0 * s.curvature) * top;
    vec4 width = sqrt(variance);
    vec4 root = 2.0 * top / (width + sqrt(max(discriminant, 0.0)));
    vec4 t = min(abs(root), 12.5);
    vec4 k = 1.0 / (1.0 + 0.3 * t);
    vec4 linear = k *
        (0.089911076 + k * (0.18241227 + k * (0.22002899 + k * (0.40581092 + k * (-0.24083353 +
         k * (0.97683328 + k * (-0.85622522 + k * 0.22206299)))))));
    vec4 square =
        0.60501906 + k * (0.51664481 + k * (1.05656121 + k * (-1.7316443 + k * (3.97410573 +
         k * (-4.41947001 + k * 1.25209079)))));
    bvec4 above = greaterThan(root, vec4(0.0));
    vec4 density = normal_density(t) * k;
    vec4 bent = s.curvature * square;
    vec4 excess = density * (width * linear + mix(-bent, bent, above)) +
        mix(vec4(0.0), top - s.curvature, above);
    vec4 all = max(excess, 0.0);
    if (s.bias != 0.0) {
        vec4 beyond = density * (square - t * linear);
        all += s.bias * mix(beyond, 1.0 - beyond, above);
    }
    return mix(vec4(0.0), all, greaterThan(discriminant, vec4(0.0)));
}

/// Less than this is nothing; keeps denormal numbers out.
vec4 flushed(vec4 ratio) {
    return mix(vec4(0.0), ratio, greaterThanEqual(ratio, vec4(1e-6)));
}

void main() {
    FoamStep s = step_of(push.first_step + gl_WorkGroupID.z);
    uint first =
        gl_WorkGroupID.x * (synthesis_workgroup * quads) + gl_LocalInvocationID.x;
    for (uint i = 0u; i < quads; ++i) {
        uint quad = first + i * synthesis_workgroup;
        vec4 ratio = texelFetch(before, int(s.history + quad)) * s.remains + s.added;
        if ((s.flags & foam_looks) != 0u)
            ratio += s.source * breaking(s, texelFetch(maps, int(s.strain_xx + quad)),
                                         texelFetch(maps, int(s.strain_yy + quad)),
                                         texelFetch(maps, int(s.strain_xy + quad)));
        ratio = flushed(ratio);
        if ((s.flags & foam_keeps) != 0u)
            histories[s.history + quad] = ratio;
        if ((s.flags & foam_shows) != 0u)
            foam[s.shown + quad] = s.departure == 1.0 ? ratio : 1.0 + s.departure * (ratio - 1.0);
    }
}
