// SPDX-License-Identifier: Apache-2.0
// J = (1 + lx Dxx)(1 + ly Dyy) - lx ly Dxy^2, for kernels that have the strains at hand: the same bits in each of them.

vec4 jacobian_of(float choppiness_x, float choppiness_y, vec4 strain_xx, vec4 strain_yy, vec4 strain_xy) {
    precise vec4 j = (1.0 + choppiness_x * strain_xx) * (1.0 + choppiness_y * strain_yy) -
        choppiness_x * choppiness_y * strain_xy * strain_xy;
    return j;
}
