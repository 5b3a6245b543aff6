#version 460
// SPDX-License-Identifier: Apache-2.0
// The sky alone: for pictures without a sea, and around it where a pixel is either.
#extension GL_GOOGLE_include_directive : require
#include "view/bindings.glsl"
#include "view/sky.glsl"

layout(location = 0) in vec3 direction;
layout(location = 0) out vec4 radiance;

void main() {
    radiance = vec4(sky_behind(normalize(direction)), 1);
}
