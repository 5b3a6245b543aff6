// SPDX-License-Identifier: Apache-2.0
// The cubic B-spline that queries are answered from (sea/surface/maps/spline_map.h): weights of four
// neighbouring coefficients at fraction t between the middle two, and their derivatives by t.

vec4 spline_weights(float t) {
    const float u = 1.0 - t;
    const vec2 cubes = vec2(u * u * u, t * t * t);
    return vec4(cubes.x, 4.0 - 6.0 * t * t + 3.0 * cubes.y, 4.0 - 6.0 * u * u + 3.0 * cubes.x,
                cubes.y) / 6.0;
}

vec4 spline_slopes(float t) {
    const float u = 1.0 - t;
    return vec4(-0.5 * u * u, t * (1.5 * t - 2.0), u * (2.0 - 1.5 * u), 0.5 * t * t);
}
