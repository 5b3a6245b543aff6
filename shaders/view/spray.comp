#version 460
// SPDX-License-Identifier: Apache-2.0
// Plumes of spray at this moment: client/view/sea/spray.h.
#extension GL_GOOGLE_include_directive : require
#include "view/frame.glsl"
#include "view/gradient_texel.glsl"

layout(local_size_x = view_group) in;
/// [cascade][level][y][x]: Dx, Dy, eta, foam; a GradientTexel, packed.
layout(binding = 1) uniform samplerBuffer displacements;
layout(binding = 2) uniform usamplerBuffer gradients;
/// [plume][2]: local position, radius; velocity as seen, opacity.
layout(std430, binding = 3) writeonly buffer Plumes { vec4 plumes[]; };
layout(push_constant) uniform Push {
    ivec2 base;
    vec2 origin_m;
    int period;
    float moment;
    int slots;
    float wind_mps;
    float crest_mps;
    float strength;
} push;

const int cells = 48;
const float cell_m = 6.0;
const float period_s = 1.6;
const float crest_m = 0.5;    // what breaks is about so wide
const float dragged_s = 0.4;  // until a drop goes with the wind
const float falling_mps = 1.2;

uvec3 shuffled(uvec3 v) { // PCG 3d (Jarzynski and Olano 2020)
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> 16u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return v;
}
vec3 random_of(uvec3 v) { return vec3(shuffled(v) & 0xffffu) / 65535.0; }

/// The sea at an undisplaced place, without what is narrower than a crest that breaks.
struct Crest {
    vec3 displacement;
    float jacobian;
};

Crest crest_at(vec2 at_m) {
    Crest crest = Crest(vec3(0), 1.0);
    vec3 strain = vec3(0);
    for (int c = 0; c < view.cascades; ++c) {
        const ViewCascade tile = view.cascade[c];
        const vec2 place = fract(tile.origin + at_m * tile.maps_per_m);
        const int level = max(int(ceil(log2(crest_m * float(tile.nodes) * tile.maps_per_m))), 0);
        const Around near = texels_around(place, tile.nodes, min(level, last_level(tile.nodes)));
        const int first = tile.gradient_first + texels_above(tile.nodes, min(level, last_level(tile.nodes)));
        for (int i = 0; i < (level < tile.gradient_levels ? 4 : 0); ++i)
            strain += near.weight[i] * unpacked_gradient(texelFetch(gradients, first + near.texel[i])).strain;
        const int coarse = max(int(ceil(log2(crest_m * float(tile.points) * tile.maps_per_m))), 1);
        const int moved = min(coarse, last_level(tile.points));
        const Around around = texels_around(place, tile.points, moved);
        const int start = tile.displacement_first + texels_above(tile.points, moved);
        for (int i = 0; i < (coarse < tile.displacement_levels ? 4 : 0); ++i)
            crest.displacement += around.weight[i] * texelFetch(displacements, start + around.texel[i]).xyz;
    }
    const vec2 lambda = view.choppiness;
    crest.jacobian = (1.0 + lambda.x * strain.x) * (1.0 + lambda.y * strain.y) -
                     lambda.x * lambda.y * strain.z * strain.z;
    return crest;
}

void main() {
    const int n = int(gl_GlobalInvocationID.x);
    if (n >= cells * cells * push.slots)
        return;
    const int slot = n % push.slots;
    const ivec2 cell = ivec2(n / push.slots % cells, n / push.slots / cells);
    const uvec2 world = uvec2(push.base + cell) & 0xffffu;
    const float late = random_of(uvec3(world, 7u * uint(slot))).x;
    const float since = push.moment + late;
    const uint thrown = uint(push.period + int(floor(since))) & 0xffffu;
    const float age = fract(since);
    const float age_s = age * period_s;
    const vec3 random = random_of(uvec3(world.x + 65536u * uint(slot), world.y, thrown));
    const vec2 wind = view.wind_turn;
    // Where the crest that it was thrown from is now.
    const vec2 from_m = push.origin_m + cell_m * (vec2(cell) + random.xy);
    const vec2 crest_now_m = from_m + push.crest_mps * (age_s - 0.5 * period_s) * wind;
    const Crest crest = crest_at(crest_now_m);
    const float breaks = (1.0 - smoothstep(view.foam_threshold - 0.1, view.foam_threshold + 0.15, crest.jacobian)) *
                         smoothstep(0.0, 0.25, crest.displacement.z / max(view.significant_height_m, 0.1));

    const float lag_s = dragged_s * (1.0 - exp(-age_s / dragged_s));
    // Over a crest the wind is faster than further down; it always is faster than the crest.
    const float faster_mps = max(0.9 * push.wind_mps - push.crest_mps, 0.4 * push.wind_mps);
    const float throw_mps = 1.0 + 3.0 * random.z * push.strength;
    const vec2 blown_m = faster_mps * (age_s - lag_s) * wind;
    const float up_m = throw_mps * lag_s * 1.5 - falling_mps * (age_s - lag_s);
    const vec3 d = crest.displacement;
    const vec2 level_m = crest_now_m + view.choppiness * d.xy + blown_m;
    const vec3 position_m = vec3(level_m, d.z + 0.2 + max(up_m, -0.3) - dot(level_m, level_m) * view.curvature_per_m);
    const float radius_m = 0.12 + (0.25 + 0.45 * random.z) * age_s;
    // The grid ends softly, and nothing stands right before the eye.
    const float away_m = distance(position_m, view.camera_m);
    const float edge = (1.0 - smoothstep(0.35, 0.5, length(crest_now_m) / (float(cells) * cell_m))) * smoothstep(4.0, 16.0, away_m);
    const float opacity = (0.35 + 0.45 * push.strength) * breaks * edge * smoothstep(0.0, 0.12, age) * pow(1.0 - age, 1.5);
    plumes[2 * n] = vec4(position_m, radius_m);
    plumes[2 * n + 1] = vec4(wind * (faster_mps + push.crest_mps), throw_mps * 1.5 * exp(-age_s / dragged_s) - falling_mps, opacity);
}
