// SPDX-License-Identifier: Apache-2.0
// Looks up the sky that the CPU has computed (client/view/sky.h): square root of elevation by
// azimuth from the sun.
const float pi = 3.14159265;

/// Unit direction; below the horizon is as the horizon. blur: 0 sharp .. 1 the whole sky.
vec3 sky_radiance(vec3 direction, float blur) {
    const float elevation = asin(clamp(direction.z, 0.0, 1.0));
    const vec2 sun = normalize(view.sun_direction.xy + vec2(1e-6, 0));
    const float along = dot(direction.xy, sun) / max(length(direction.xy), 1e-6);
    const float azimuth = acos(clamp(along, -1.0, 1.0));
    const vec2 at = vec2(azimuth / pi, sqrt(elevation / (0.5 * pi)));
    // Texel centres of the first and last row and column lie on the ends of the range.
    const vec2 size = vec2(textureSize(sky_map, 0));
    const vec2 uv = (at * (size - 1.0) + 0.5) / size;
    return textureLod(sky_map, uv, blur * 5.0).rgb;
}

/// The sky that is seen directly: with the disk of the sun.
vec3 sky_behind(vec3 direction) {
    const float off_sun = acos(clamp(dot(direction, view.sun_direction), -1.0, 1.0));
    const float edge = acos(view.sun_disk_cosine);
    const float disk = 1.0 - smoothstep(edge - view.pixel_rad, edge + view.pixel_rad, off_sun);
    return sky_radiance(direction, 0.0) +
           disk * view.sun_irradiance_klx * view.sun_disk_per_sr;
}
