#version 460
// SPDX-License-Identifier: Apache-2.0
layout(location = 0) centroid in vec4 place;
layout(location = 0) out vec4 geometry;

void main() {
    geometry = place;
}
