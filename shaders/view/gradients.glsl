// SPDX-License-Identifier: Apache-2.0
// The summed gradients of the sea at an undisplaced point, filtered over the pixel, and what
// follows from them: normal, Jacobian. Cascades are summed first (a determinant is not additive).

struct Gradients {
    vec2 slope;    ///< d eta / d(X, Y)
    vec3 strain;   ///< d Dx/dX, d Dy/dY, d Dx/dY
    vec3 variance; ///< of slope within the pixel: xx, yy, xy
};

/// The part of the sea that a pixel covers: a strip of probes along the line of sight. The shader
/// does this itself because the anisotropic filters of software devices take minutes at grazing
/// angles, and because derivatives across a crest's edge would be of two different waves.
struct Footprint {
    vec2 centre_m;
    vec2 step_m;   ///< from probe to probe
    int probes;
    float width_m; ///< that one probe averages over
};

const int probes_max = 5;
const float facing_min = 0.015; ///< crests near the horizon are not seen flatter than this

Footprint footprint(vec2 undisplaced_m, vec3 to_eye, float distance_m) {
    const float width_m = max(distance_m * view.pixel_rad, 1e-4);
    // The long waves tilt the pixel's piece of sea towards the eye or away.
    const ViewCascade tile = view.cascade[0];
    const vec3 at = vec3(tile.origin + undisplaced_m * tile.maps_per_m, 0.0);
    const vec2 slope = textureLod(gradient_maps, at, max(log2(width_m / tile.texel_m), 2.0)).xy;
    const float facing = max(dot(normalize(vec3(-slope, 1)), to_eye), facing_min);
    const float length_m = width_m / facing;
    const int probes = clamp(int(ceil(length_m / width_m)), 1, probes_max);
    const vec2 along = normalize(to_eye.xy + vec2(1e-6, 0)) * length_m / float(probes);
    return Footprint(undisplaced_m, along, probes, max(length_m / float(probes), width_m));
}

/// Means over the pixel of gradient and moment maps.
void filtered(Footprint area, vec2 origin, mat2 map_from_m, float texels_a_metre, float layer,
              out vec4 gradient, out vec4 moment) {
    const float level = log2(area.width_m * texels_a_metre);
    gradient = vec4(0);
    moment = vec4(0);
    for (int i = 0; i < area.probes; ++i) {
        const float along = float(i) - 0.5 * float(area.probes - 1);
        const vec3 at = vec3(origin + map_from_m * (area.centre_m + along * area.step_m), layer);
        gradient += textureLod(gradient_maps, at, level);
        moment += textureLod(moment_maps, at, level);
    }
    gradient /= float(area.probes);
    moment /= float(area.probes);
}

Gradients gradients_of_cascade(Footprint area, int cascade) {
    const ViewCascade tile = view.cascade[cascade];
    vec4 gradient, moment;
    filtered(area, tile.origin, mat2(tile.maps_per_m), 1.0 / tile.texel_m, float(cascade), gradient, moment);
    // The filtered square less the square of the filtered: what the pixel does not resolve.
    const vec3 resolved = vec3(gradient.xy * gradient.xy, gradient.x * gradient.y);
    vec3 variance = moment.yzw - resolved;
    variance.xy = max(variance.xy, vec2(0));
    return Gradients(gradient.xy, vec3(gradient.zw, moment.x), variance);
}

Gradients gradients_at(Footprint area) {
    Gradients sum = Gradients(vec2(0), vec3(0), vec3(0));
    for (int c = 0; c < view.cascades; ++c) {
        const Gradients one = gradients_of_cascade(area, c);
        sum.slope += one.slope;
        sum.strain += one.strain;
        sum.variance += one.variance;
    }
    return sum;
}

/// Waves shorter than the finest cascade, as a smaller copy of it: in the equilibrium range the
/// variance of slope is the same in every octave, so a copy needs a scale and no new amplitude.
void add_detail(inout Gradients sum, Footprint area) {
    sum.variance.xy += vec2(view.detail_slope_variance);
    if (view.detail_amplitude == 0.0)
        return;
    const vec2 turn = view.detail_turn;
    const mat2 rotation = mat2(turn.x, turn.y, -turn.y, turn.x);
    vec4 gradient, moment;
    filtered(area, view.detail_origin, rotation * view.detail_maps_per_m,
             view.detail_maps_per_m * float(textureSize(gradient_maps, 0).x), float(view.cascades - 1),
             gradient, moment);
    sum.slope += transpose(rotation) * gradient.xy;
    sum.variance.xy +=
        vec2(0.5 * max(moment.y + moment.z - dot(gradient.xy, gradient.xy), 0.0));
}

/// Cross product of the two tangents: exact, and safe where the surface folds. Not unit length;
/// its z is the Jacobian.
vec3 scaled_normal(Gradients g) {
    const vec2 lambda = view.choppiness;
    const vec3 tangent_x = vec3(1 + lambda.x * g.strain.x, lambda.y * g.strain.z, g.slope.x);
    const vec3 tangent_y = vec3(lambda.x * g.strain.z, 1 + lambda.y * g.strain.y, g.slope.y);
    return cross(tangent_x, tangent_y);
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
float history_share(Footprint area) {
    float together = 2.0;
    for (int c = 0; c < view.cascades; ++c) {
        const ViewCascade tile = view.cascade[c];
        const float level = log2(area.width_m / tile.texel_m);
        float ratio = 0.0;
        for (int i = 0; i < area.probes; ++i) {
            const float along = float(i) - 0.5 * float(area.probes - 1);
            const vec2 at = tile.origin + (area.centre_m + along * area.step_m) * tile.maps_per_m;
            ratio += textureLod(displacement_maps, vec3(at, float(c)), level).w;
        }
        together *= 0.5 * (1.0 + ratio / float(area.probes));
    }
    return clamp(view.foam_mean * (together - 1.0), 0.0, 1.0);
}

/// What has broken, and where the pixel resolves the waves, what breaks at this moment: of what it
/// does not resolve, the history is the mean. `g` without detail.
float foam_share(Footprint area, Gradients g) {
    if (view.foam_mean <= 0.0)
        return 0.0;
    const float history = history_share(area);
    const float resolved =
        max(1.0 - (g.variance.x + g.variance.y) / max(view.slope_variance, 1e-6), 0.0);
    const float breaking = breaking_share(scaled_normal(g).z, g.variance);
    return mix(history, max(history, breaking), resolved * resolved);
}
