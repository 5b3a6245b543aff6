#version 460
// SPDX-License-Identifier: Apache-2.0
// Drops in the air: white by the sky, bright against the sun. Soft where the sea is just behind.
#extension GL_GOOGLE_include_directive : require
#include "view/frame.glsl"
#include "view/place.glsl"

#ifdef SEAWAY_ONE_SAMPLE
layout(binding = 2) uniform sampler2D geometry;
#else
layout(binding = 2) uniform sampler2DMS geometry;
#endif
layout(location = 0) in vec2 within;
layout(location = 1) in vec3 from_eye_m;
layout(location = 2) flat in vec3 look;
layout(location = 0) out vec4 shown;

void main() {
    const Place behind = unpacked_place(texelFetch(geometry, ivec2(gl_FragCoord.xy), 0));
    const float room_m = shows_sky(behind) ? 1e3 : behind.distance_m - length(from_eye_m);
    const float soft = clamp(room_m / look.y + 0.3, 0.0, 1.0);
    const float r2 = min(dot(within, within), 1.0);
    const float towards = max(dot(normalize(from_eye_m), view.sun_direction), 0.0);
    const vec3 light = view.sky_irradiance_klx / 4.0 + view.sun_irradiance_klx * (0.12 + 0.3 * pow(towards, 8.0));
    // Threads of drops along the way.
    const float threads = 0.6 + 0.4 * sin(9.0 * within.y + 2.0 * sin(3.0 * within.x + look.z) + 1.7 * look.z);
    shown = vec4(light, look.x * soft * threads * (1.0 - r2) * (1.0 - r2));
}
