// SPDX-License-Identifier: Apache-2.0
// The summed gradients of the sea at an undisplaced point, filtered over the pixel, and what
// follows from them: normal, Jacobian. Cascades are summed first (a determinant is not additive).

struct Gradients {
    vec2 slope;    ///< d eta / d(X, Y)
    vec3 strain;   ///< d Dx/dX, d Dy/dY, d Dx/dY
    vec3 variance; ///< of slope within the pixel: xx, yy, xy
    float within;  ///< variance of slope from side to side of the pixel, each axis
    float foam;    ///< product over cascades of (1 + foam / its mean) / 2
};

GradientTexel gradient_texel(int at) { return unpacked_gradient(texelFetch(gradients, at)); }

void add_level(inout GradientSum sum, ViewCascade tile, vec2 tile_place, int level, float weight) {
    const Around around = texels_around(tile_place, tile.nodes, level);
    const int first = tile.gradient_first + texels_above(tile.nodes, level);
    for (int i = 0; i < 4; ++i)
        add(sum, gradient_texel(first + around.texel[i]), weight * around.weight[i]);
}

/// The whole tile.
GradientTexel tile_mean(ViewCascade tile) {
    return gradient_texel(tile.gradient_first + texels_above(tile.nodes, last_level(tile.nodes)));
}

/// Bilinear in the levels around `level` and between them.
void add_filtered(inout GradientSum sum, ViewCascade tile, vec2 tile_place, float level, float weight) {
    for (int l = int(floor(level)); l <= int(ceil(level)); ++l)
        add_level(sum, tile, tile_place, l, weight * (1.0 - abs(level - float(l))));
}

/// The part of the sea that a pixel covers: a strip of probes along the line of sight. The shader
/// does this itself because the anisotropic filters of software devices take minutes at grazing
/// angles, and because derivatives across a crest's edge would be of two different waves.
struct Footprint {
    vec2 centre_m;
    vec2 step_m;   ///< from probe to probe
    int probes;
    float width_m; ///< that one probe averages over
    float pixel_m; ///< side of a square of the strip's area
};

const float facing_min = 0.015; ///< crests near the horizon are not seen flatter than this

Footprint footprint(vec2 undisplaced_m, vec3 to_eye, float distance_m) {
    const float width_m = max(distance_m * view.pixel_rad, 1e-4);
    // The long waves tilt the pixel's piece of sea towards the eye or away.
    const ViewCascade tile = view.cascade[0];
    const float last = float(last_level(tile.nodes));
    const float level = clamp(ceil(log2(width_m * float(tile.nodes) * tile.maps_per_m)), 2.0, last);
    GradientSum long_waves = no_gradients;
    add_level(long_waves, tile, tile.origin + undisplaced_m * tile.maps_per_m, int(level), 1.0);
    const float facing =
        max(dot(normalize(vec3(-long_waves.slope, 1)), to_eye), facing_min);
    const float length_m = width_m / facing;
    const int probes = clamp(int(ceil(length_m / width_m)), 1, view.probes);
    const vec2 along = normalize(to_eye.xy + vec2(1e-6, 0)) * length_m / float(probes);
    return Footprint(undisplaced_m, along, probes, max(length_m / float(probes), width_m),
                     sqrt(length_m * width_m));
}

/// Devices without a GPU take both sides of every branch, but leave a loop that nobody is in: what is dear stands in
/// loops that are run once or not at all.
/// Means over the pixel of a tile that lies `origin` and `tile_from_m` from the local frame.
GradientTexel filtered(Footprint area, ViewCascade tile, vec2 origin, mat2 tile_from_m, float tiles_a_metre) {
    float level = max(log2(area.width_m * float(tile.nodes) * tiles_a_metre), 0.0);
    const bool resolved = level < float(tile.gradient_levels);
    if (view.between_levels == 0)
        level = round(level);
    GradientSum sum = no_gradients;
    const int probes = resolved ? area.probes : 0;
    for (int i = 0; i < probes; ++i) {
        const float along = float(i) - 0.5 * float(area.probes - 1);
        add_filtered(sum, tile, origin + tile_from_m * (area.centre_m + along * area.step_m), level,
                     1.0 / float(area.probes));
    }
    if (!resolved)
        add(sum, tile_mean(tile), 1.0);
    return mean_of(sum);
}

GradientTexel gradients_of_cascade(Footprint area, int cascade) {
    const ViewCascade tile = view.cascade[cascade];
    return filtered(area, tile, tile.origin, mat2(tile.maps_per_m), tile.maps_per_m);
}

Gradients gradients_at(Footprint area) {
    Gradients sum = Gradients(vec2(0), vec3(0), vec3(0), 0.0, 1.0);
    for (int c = 0; c < view.cascades; ++c) {
        const GradientTexel one = gradients_of_cascade(area, c);
        sum.slope += one.slope;
        sum.strain += one.strain;
        sum.variance += one.variance;
        sum.foam *= 0.5 * (1.0 + one.foam);
    }
    return sum;
}

/// Of all waves, both axes.
float slope_variance() {
    float sum = 0.0;
    for (int c = 0; c < view.cascades; ++c) {
        const GradientTexel all = tile_mean(view.cascade[c]);
        sum += all.variance.x + all.variance.y;
    }
    return sum;
}

/// Waves shorter than the finest cascade, as a smaller copy of it: in the equilibrium range the
/// variance of slope is the same in every octave, so a copy needs a scale and no new amplitude.
void add_detail(inout Gradients sum, Footprint area) {
    const ViewCascade tile = view.cascade[view.cascades - 1];
    const GradientTexel all = tile_mean(tile);
    sum.variance.xy += vec2(view.detail_slope_share * (all.variance.x + all.variance.y));
    if (view.detail_amplitude == 0.0)
        return;
    const vec2 turn = view.detail_turn;
    const mat2 rotation = mat2(turn.x, turn.y, -turn.y, turn.x);
    const GradientTexel copy =
        filtered(area, tile, view.detail_origin, rotation * view.detail_maps_per_m, view.detail_maps_per_m);
    sum.slope += transpose(rotation) * copy.slope;
    sum.variance.xy += vec2(0.5 * (copy.variance.x + copy.variance.y));
    // Of what the pixel resolves, slopes change across it: three nodes make the shortest wave.
    const float turns = 2.0 / 3.0 * 3.14159265 * area.width_m * view.detail_maps_per_m * float(tile.points);
    const vec2 resolved = max(all.variance.xy - copy.variance.xy, vec2(0));
    sum.within = (resolved.x + resolved.y) * min(turns * turns, 4.0) / 24.0;
}

/// Cross product of the two tangents: exact, and safe where the surface folds. Not unit length;
/// its z is the Jacobian.
vec3 scaled_normal(Gradients g) {
    const vec2 lambda = view.choppiness;
    const vec3 tangent_x = vec3(1 + lambda.x * g.strain.x, lambda.y * g.strain.z, g.slope.x);
    const vec3 tangent_y = vec3(lambda.x * g.strain.z, 1 + lambda.y * g.strain.y, g.slope.y);
    return cross(tangent_x, tangent_y);
}

/// The mean facet of a pixel as it is lit: never turned over, nor away from the eye.
vec3 lit_normal(vec3 scaled, vec3 to_eye) {
    const vec3 normal = normalize(vec3(scaled.xy, max(scaled.z, 0.1)));
    const float facing = dot(normal, to_eye);
    return facing < 0.02 ? normalize(normal + (0.02 - facing) * to_eye) : normal;
}

/// Share of the pixel where the Jacobian is below the threshold. It varies within the pixel with
/// lambda^2 times the variance of slope: for linear waves both are sums of k^2 |h|^2.
float breaking_share(float jacobian, vec3 variance) {
    const float lambda = max(view.choppiness.x, view.choppiness.y);
    const float sigma =
        sqrt(lambda * lambda * (variance.x + variance.y) + view.foam_softness * view.foam_softness);
    return 1.0 / (1.0 + exp(1.702 * (jacobian - view.foam_threshold) / sigma)); // logistic for erf
}

/// Share of the pixel that what has broken lately covers (docs/foam.md).
float history_share(Gradients g) {
    return clamp(view.foam_mean * (2.0 * g.foam - 1.0), 0.0, 1.0);
}

/// What has broken, and where the pixel resolves the waves, what breaks at this moment: of what it
/// does not resolve, the history is the mean. `g` without detail.
float foam_share(Gradients g) {
    if (view.foam_mean <= 0.0)
        return 0.0;
    const float history = history_share(g);
    const float resolved =
        max(1.0 - (g.variance.x + g.variance.y) / max(slope_variance(), 1e-6), 0.0);
    const float breaking = breaking_share(scaled_normal(g).z, g.variance);
    return mix(history, max(history, breaking), resolved * resolved);
}
