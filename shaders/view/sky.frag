#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require
#include "view/bindings.glsl"
#include "view/sky.glsl"

layout(location = 0) in vec3 direction;
layout(location = 0) out vec4 radiance;

void main() {
    const vec3 d = normalize(direction);
    vec3 colour = sky_radiance(d, 0.0);
    const float off_sun = acos(clamp(dot(d, view.sun_direction.xyz), -1.0, 1.0));
    const float edge = acos(view.sun_direction.w);
    const float disk = 1.0 - smoothstep(edge - view.camera.w, edge + view.camera.w, off_sun);
    colour += disk * view.sun_irradiance.rgb * view.sun_irradiance.w;
    radiance = vec4(colour, 1);
}
