/* SPDX-License-Identifier: Apache-2.0 */
/* Part of seaway/buoyancy.h: what a hull is, and what the water does to it. */
#ifndef SEAWAY_CLIENT_BUOYANCY_H
#include "buoyancy.h" /* includes this before what stands on it */
#elif !defined(SEAWAY_CLIENT_BUOYANCY_HULL_H)
#define SEAWAY_CLIENT_BUOYANCY_HULL_H

/* Steeper water than this is breaking (a Stokes wave breaks at 30 degrees, slope 0.58): what is straight on from there leads
 * nowhere. */
#define SEAWAY_SLOPE_MAX 1.0

static inline double seaway_density_of(const seaway_hull* hull) {
    return hull->density_kgpm3 > 0 ? hull->density_kgpm3 : SEAWAY_DENSITY_KGPM3;
}

/* Slope of the water along x and y. */
static inline void seaway_slope(const seaway_answer* water, double slope[2]) {
    const double flat = hypot(water->normal[0], water->normal[1]);
    const double scale = flat > SEAWAY_SLOPE_MAX * water->normal[2]
                             ? (flat > 0 ? SEAWAY_SLOPE_MAX / flat : 0)
                             : 1 / water->normal[2];
    slope[0] = -scale * water->normal[0];
    slope[1] = -scale * water->normal[1];
}

/* The corner of a hull in the water. The surface goes on from where it was asked for: by its slope to where the vertex is
 * by now, and in time as its own water rises (the kinematic condition at choppiness 1, d eta/dt = w - u . grad eta). */
static inline void seaway_corner_of(const seaway_body* body, double rows[3][3],
                                    const double vertex_m[3], const seaway_point* point,
                                    const seaway_answer* water, double later_s,
                                    seaway_corner* corner) {
    double slope[2], turning[3];
    seaway_slope(water, slope);
    seaway_to_world(rows, vertex_m, corner->arm_m);
    const double x_m = body->position_m[0] + corner->arm_m[0] - point->x_m;
    const double y_m = body->position_m[1] + corner->arm_m[1] - point->y_m;
    const double rises_mps = water->velocity_mps[2] - water->velocity_mps[0] * slope[0] -
                             water->velocity_mps[1] * slope[1];
    corner->depth_m = water->height_m + slope[0] * x_m + slope[1] * y_m + rises_mps * later_s -
                      (body->position_m[2] + corner->arm_m[2]);
    seaway_cross(body->angular_velocity_radps, corner->arm_m, turning);
    for (int i = 0; i < 3; ++i)
        corner->flow_mps[i] = water->velocity_mps[i] - body->velocity_mps[i] - turning[i];
}

static inline void seaway_add_column(const seaway_corner* corner, const seaway_answer* water,
                                     double volume_m3, double column_m, double weight_npm3,
                                     double linear, double quadratic, seaway_load* load) {
    const double share = fmin(fmax(0.5 + corner->depth_m / column_m, 0), 1);
    double slope[2], torque[3];
    seaway_slope(water, slope);
    const double lift_n = weight_npm3 * volume_m3 * share;
    const double force[3] = {-slope[0] * lift_n, -slope[1] * lift_n, lift_n};
    seaway_cross(corner->arm_m, force, torque);
    seaway_add(load->force_n, 1, force);
    seaway_add(load->torque_nm, 1, torque);
    load->submerged_m3 += volume_m3 * share;
    if (share > 0 && share < 1) /* by how fast the water rises along it */
        load->dips_m3ps +=
            volume_m3 / column_m *
            (corner->flow_mps[2] - slope[0] * corner->flow_mps[0] - slope[1] * corner->flow_mps[1]);
    const double area_m2 = volume_m3 / column_m * share;
    const double drag_nspm = area_m2 * (linear + quadratic * seaway_length(corner->flow_mps));
    for (int i = 0; i < 3; ++i) {
        const double along[3] = {i == 0 ? 1.0 : 0.0, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0};
        seaway_add_drag(corner->arm_m, along, corner->flow_mps[i], drag_nspm, load);
    }
    seaway_add_wetted(corner->arm_m, area_m2, corner->flow_mps, load);
}

static inline void seaway_hull_load(const seaway_hull* hull, const seaway_body* body,
                                    const seaway_point* points, const seaway_answer* answers,
                                    double later_s, seaway_load* load) {
    static const seaway_load none = {{0}, {0}, {0}, {0}, {{0}}, 0, 0, 0, {0}, {0}};
    const double density = seaway_density_of(hull);
    const double weight_npm3 = density * SEAWAY_GRAVITY_MPS2;
    const double quadratic = 0.5 * density * hull->quadratic_drag;
    double rows[3][3];
    seaway_corner corners[3];
    seaway_rows(body->orientation, rows);
    *load = none;
    for (size_t i = 0; i < hull->triangle_count; ++i) {
        for (size_t j = 0; j < 3; ++j) {
            const size_t v = hull->triangles[3 * i + j];
            seaway_corner_of(body, rows, hull->vertices_m + 3 * v, &points[v], &answers[v], later_s,
                             &corners[j]);
        }
        seaway_add_panel(corners, weight_npm3, hull->linear_drag, quadratic, load);
    }
    for (size_t v = 0; hull->triangle_count == 0 && v < hull->vertex_count; ++v) {
        seaway_corner_of(body, rows, hull->vertices_m + 3 * v, &points[v], &answers[v], later_s,
                         &corners[0]);
        seaway_add_column(&corners[0], &answers[v], hull->volumes_m3[v], hull->column_m,
                          weight_npm3, hull->linear_drag, quadratic, load);
    }
}

static inline void seaway_hull_points(const seaway_hull* hull, const seaway_body* body,
                                      int64_t time_us, seaway_point* points) {
    double rows[3][3], arm_m[3];
    seaway_rows(body->orientation, rows);
    for (size_t v = 0; v < hull->vertex_count; ++v) {
        seaway_to_world(rows, hull->vertices_m + 3 * v, arm_m);
        points[v].x_m = body->position_m[0] + arm_m[0];
        points[v].y_m = body->position_m[1] + arm_m[1];
        points[v].time_us = time_us;
    }
}

/* Area vector and volume (from the origin) of a triangle of the mesh. */
static inline double seaway_triangle(const seaway_hull* hull, size_t triangle, double area_m2[3]) {
    const double* corner[3];
    double ab[3], ac[3];
    for (size_t j = 0; j < 3; ++j) {
        const size_t v = hull->triangles[3 * triangle + j];
        corner[j] = hull->vertices_m + 3 * v;
    }
    for (int i = 0; i < 3; ++i) {
        ab[i] = corner[1][i] - corner[0][i];
        ac[i] = corner[2][i] - corner[0][i];
    }
    seaway_cross(ab, ac, area_m2);
    for (int i = 0; i < 3; ++i)
        area_m2[i] *= 0.5;
    return seaway_dot(corner[0], area_m2) / 3;
}

static inline double seaway_hull_volume_m3(const seaway_hull* hull) {
    double volume_m3 = 0, area_m2[3];
    for (size_t i = 0; i < hull->triangle_count; ++i)
        volume_m3 += seaway_triangle(hull, i, area_m2);
    for (size_t v = 0; hull->triangle_count == 0 && hull->volumes_m3 && v < hull->vertex_count; ++v)
        volume_m3 += hull->volumes_m3[v];
    return volume_m3;
}

static inline const char* seaway_hull_numbers_fault(const seaway_hull* hull) {
    const double positive[4] = {hull->mass_kg, hull->inertia_kgm2[0], hull->inertia_kgm2[1],
                                hull->inertia_kgm2[2]};
    const double at_least_0[9] = {
        hull->added_mass[0],    hull->added_mass[1],    hull->added_mass[2],
        hull->added_inertia[0], hull->added_inertia[1], hull->added_inertia[2],
        hull->linear_drag,      hull->quadratic_drag,   hull->density_kgpm3};
    for (int i = 0; i < 4; ++i)
        if (!(positive[i] > 0 && positive[i] < HUGE_VAL))
            return "mass and inertia must be above 0";
    for (int i = 0; i < 9; ++i)
        if (!(at_least_0[i] >= 0 && at_least_0[i] < HUGE_VAL))
            return "added mass, drag and density must be 0 or more";
    if (hull->vertex_count == 0 || !hull->vertices_m)
        return "it has no vertices";
    for (size_t i = 0; i < 3 * hull->vertex_count; ++i)
        if (!(fabs(hull->vertices_m[i]) < HUGE_VAL))
            return "a vertex is not a number";
    return NULL;
}

static inline const char* seaway_hull_parts_fault(const seaway_hull* hull) {
    if (hull->triangle_count == 0 &&
        (!hull->volumes_m3 || !(hull->column_m > 0 && hull->column_m < HUGE_VAL)))
        return "it has neither triangles nor volumes and a height of columns";
    for (size_t v = 0; hull->triangle_count == 0 && v < hull->vertex_count; ++v)
        if (!(hull->volumes_m3[v] >= 0 && hull->volumes_m3[v] < HUGE_VAL))
            return "a volume must be 0 or more";
    if (hull->triangle_count > 0 && !hull->triangles)
        return "it has no triangles";
    return NULL;
}

/* Over a closed surface the integral of dA is 0, and that of arm dA the volume along the diagonal and 0 beside it. Holes that
 * face each other leave the first as it is, and no two leave the second; three such pairs that are alike may. Corners need not be
 * shared, so edges prove nothing. The arms are from a corner of the mesh: what is far from the origin is closed as well. */
static inline int seaway_is_closed(const seaway_hull* hull) {
    const size_t first = hull->triangles[0];
    const double* near_m = hull->vertices_m + 3 * first;
    double open_m2[3] = {0, 0, 0}, surface_m2 = 0, around_m3 = 0, area_m2[3], arm_m[3];
    double moment_m3[3][3] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    for (size_t i = 0; i < hull->triangle_count; ++i) {
        seaway_triangle(hull, i, area_m2);
        for (int axis = 0; axis < 3; ++axis)
            arm_m[axis] = -near_m[axis];
        for (size_t j = 0; j < 3; ++j) {
            const size_t v = hull->triangles[3 * i + j];
            seaway_add(arm_m, 1.0 / 3, hull->vertices_m + 3 * v);
        }
        for (int axis = 0; axis < 3; ++axis)
            seaway_add(moment_m3[axis], arm_m[axis], area_m2);
        seaway_add(open_m2, 1, area_m2);
        surface_m2 += seaway_length(area_m2);
        around_m3 += seaway_length(arm_m) * seaway_length(area_m2);
    }
    const double volume_m3 = (moment_m3[0][0] + moment_m3[1][1] + moment_m3[2][2]) / 3;
    int closed = seaway_length(open_m2) <= 1e-6 * surface_m2;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            closed = closed && fabs(moment_m3[i][j] - (i == j ? volume_m3 : 0)) <= 1e-6 * around_m3;
    return closed;
}

static inline const char* seaway_hull_fault(const seaway_hull* hull) {
    const char* fault = seaway_hull_numbers_fault(hull);
    if (!fault)
        fault = seaway_hull_parts_fault(hull);
    if (fault)
        return fault;
    for (size_t i = 0; i < 3 * hull->triangle_count; ++i)
        if (hull->triangles[i] >= hull->vertex_count)
            return "a triangle has a corner that is no vertex";
    if (hull->triangle_count > 0 && !seaway_is_closed(hull))
        return "the mesh is not closed";
    if (!(seaway_hull_volume_m3(hull) > 0))
        return "it has no volume: triangles are anticlockwise from outside";
    return NULL;
}

#endif
