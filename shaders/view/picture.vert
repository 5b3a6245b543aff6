#version 460
// SPDX-License-Identifier: Apache-2.0
// One triangle over the picture.
#extension GL_GOOGLE_include_directive : require
#include "view/frame.glsl"

layout(location = 0) out vec3 direction;

void main() {
    const vec2 at = vec2(gl_VertexIndex == 1 ? 3.0 : -1.0, gl_VertexIndex == 2 ? 3.0 : -1.0);
    gl_Position = vec4(at, 0, 1);
    direction = (view.local_from_clip * vec4(at, 0, 1)).xyz;
}
