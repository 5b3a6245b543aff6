/* SPDX-License-Identifier: Apache-2.0 */
/* Part of seaway/buoyancy.h: what its functions do. */
#ifndef SEAWAY_CLIENT_BUOYANCY_HULL_H
#define SEAWAY_CLIENT_BUOYANCY_HULL_H

#include "buoyancy.h"

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
 * by now, and in time as its own water rises (the kinematic condition, d eta/dt = w - u . grad eta). */
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
    seaway_add_drag(corner->arm_m, volume_m3 / column_m * share, corner->flow_mps, corner->flow_mps,
                    linear, quadratic, load);
}

static inline void seaway_hull_load(const seaway_hull* hull, const seaway_body* body,
                                    const seaway_point* points, const seaway_answer* answers,
                                    double later_s, seaway_load* load) {
    const seaway_load none = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, 0,
                              0,         0,         0,         {0, 0, 0}, {0, 0, 0}};
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
    for (size_t v = 0; hull->triangle_count == 0 && v < hull->vertex_count; ++v)
        volume_m3 += hull->volumes_m3[v];
    return volume_m3;
}

/* How fast Munk's moment and the body's own turn may take it around, rad/s: its momentum beside the fastest water turns about each
 * axis what is heavier along one of the other two. 0 where it is as heavy along all. */
static inline double seaway_turns_by(const seaway_hull* hull, const seaway_body* body,
                                     const seaway_answer* answers, double step_s) {
    double heaviest = 0, turned_pkgm2 = 0;
    for (int i = 0; i < 3; ++i) {
        const double one = 1 + hull->added_mass[(i + 1) % 3],
                     other = 1 + hull->added_mass[(i + 2) % 3];
        heaviest = fmax(heaviest, one);
        turned_pkgm2 =
            fmax(turned_pkgm2, fabs(1 / one - 1 / other) /
                                   (hull->inertia_kgm2[i] * (1 + hull->added_inertia[i])));
    }
    if (!(turned_pkgm2 > 0))
        return 0;
    double beside_mps = seaway_length(body->velocity_mps); /* of the air */
    for (size_t v = 0; v < hull->vertex_count; ++v) {
        double past_mps[3];
        for (int i = 0; i < 3; ++i)
            past_mps[i] = answers[v].velocity_mps[i] - body->velocity_mps[i];
        beside_mps = fmax(beside_mps, seaway_length(past_mps));
    }
    beside_mps += SEAWAY_GRAVITY_MPS2 * step_s;
    return beside_mps * heaviest * sqrt(turned_pkgm2 * hull->mass_kg) +
           seaway_length(body->angular_velocity_radps);
}

/* Square of an angular frequency that no motion of the hull in still water is above, (rad/s)2: its stiffness is at most that of
 * half of its surface at the far end of its longest arm. */
static inline double seaway_stiffness(const seaway_hull* hull) {
    double half_m2 = 0, arm2_m2 = 0, area_m2[3];
    for (size_t i = 0; i < hull->triangle_count; ++i) {
        seaway_triangle(hull, i, area_m2);
        half_m2 += 0.5 * seaway_length(area_m2);
    }
    for (size_t v = 0; v < hull->vertex_count; ++v) {
        const double* vertex_m = hull->vertices_m + 3 * v;
        arm2_m2 = fmax(arm2_m2, seaway_dot(vertex_m, vertex_m));
        half_m2 += hull->triangle_count == 0 ? hull->volumes_m3[v] / hull->column_m : 0;
    }
    const double stiffness_npm = seaway_density_of(hull) * SEAWAY_GRAVITY_MPS2 * half_m2;
    double softest = stiffness_npm / hull->mass_kg;
    for (int i = 0; i < 3; ++i)
        softest = fmax(softest, stiffness_npm * arm2_m2 / hull->inertia_kgm2[i]);
    return softest;
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

/* How fast the body moves beside the water around its wet parts; in the air, beside still air. */
static inline void seaway_beside_water(const seaway_body* body, const seaway_load* load,
                                       double beside_mps[3]) {
    double turned[3];
    for (int i = 0; i < 3; ++i)
        beside_mps[i] = body->velocity_mps[i];
    if (!(load->wetted_m2 > 0))
        return;
    seaway_cross(body->angular_velocity_radps, load->arm_m3, turned);
    for (int i = 0; i < 3; ++i)
        beside_mps[i] = -(load->flow_m3ps[i] + turned[i]) / load->wetted_m2;
}

/* Of a momentum beside the water that goes another way than the body. */
static inline void seaway_add_munk(const double momentum[3], const double beside_mps[3],
                                   double share, double torque[3]) {
    double munk[3];
    seaway_cross(momentum, beside_mps, munk);
    seaway_add(torque, share, munk);
}

/* One part of a step: the momenta first, by the forces where the body is, then the places by the new velocities, which
 * keeps the energy of waves bounded; the turn goes by what the body's inertia is half of the way, which keeps that of a spin. A body with
 * added mass is heavier along some of its axes: its momentum beside the water lasts while it turns, not its velocity, and pulls it around
 * (Munk's moment, half of it before the turn and half behind, without which turning would make energy of nothing; Lamb, Hydrodynamics, 121). Drag is
 * divided by 1 + twice what it would do within the part, since off the centre what it does along and around may add up: it slows, and
 * never reverses. A weight that drag alone bears sinks faster by that: short steps are right. */
static inline void seaway_part(const seaway_hull* hull, seaway_body* body, const seaway_load* load,
                               double part_s) {
    double mass[3], lighter[3], lazier[3], inertia[3], rows[3][3], turn[3], half[4];
    double beside[3], water[3], pushed[3], momentum[3], force[3], torque[3];
    double least_kg = HUGE_VAL, least_kgm2 = HUGE_VAL;
    for (int i = 0; i < 3; ++i) {
        mass[i] = hull->mass_kg * (1 + hull->added_mass[i]);
        inertia[i] = hull->inertia_kgm2[i] * (1 + hull->added_inertia[i]);
        lighter[i] = 1 / mass[i];
        lazier[i] = 1 / inertia[i];
        least_kg = fmin(least_kg, mass[i]);
        least_kgm2 = fmin(least_kgm2, inertia[i]);
    }
    const double slowed = 1 / (1 + 2 * part_s * load->drag_nspm / least_kg);
    const double calmed = 1 / (1 + 2 * part_s * load->drag_nmsprad / least_kgm2);
    for (int i = 0; i < 3; ++i) {
        force[i] = load->force_n[i] + slowed * load->drag_n[i];
        torque[i] = load->torque_nm[i] + calmed * load->drag_nm[i];
    }
    force[2] -= hull->mass_kg * SEAWAY_GRAVITY_MPS2;
    seaway_rows(body->orientation, rows);
    seaway_beside_water(body, load, beside);
    for (int i = 0; i < 3; ++i)
        water[i] = body->velocity_mps[i] - beside[i];
    seaway_along_axes(rows, mass, beside, pushed);
    seaway_add(pushed, part_s, force);
    seaway_along_axes(rows, lighter, pushed, beside);
    seaway_add_munk(pushed, beside, 0.5, torque);
    for (int i = 0; i < 3; ++i)
        body->velocity_mps[i] = water[i] + beside[i];
    seaway_add(body->position_m, part_s, body->velocity_mps);
    /* Angular momentum is what lasts: a body that spins freely keeps it, at any length of step. */
    seaway_along_axes(rows, inertia, body->angular_velocity_radps, momentum);
    seaway_add(momentum, part_s, torque);
    seaway_along_axes(rows, lazier, momentum, turn);
    for (int i = 0; i < 4; ++i)
        half[i] = body->orientation[i];
    for (int i = 0; i < 3; ++i)
        turn[i] *= 0.5 * part_s;
    seaway_turn(half, turn);
    seaway_rows(half, rows);
    seaway_along_axes(rows, lazier, momentum, turn);
    for (int i = 0; i < 3; ++i)
        turn[i] *= part_s;
    seaway_turn(body->orientation, turn);
    seaway_rows(body->orientation, rows);
    seaway_along_axes(rows, lighter, pushed, beside);
    seaway_add_munk(pushed, beside, 0.5 * part_s, momentum);
    seaway_along_axes(rows, lazier, momentum, body->angular_velocity_radps);
    for (int i = 0; i < 3; ++i)
        body->velocity_mps[i] = water[i] + beside[i];
}

static inline int seaway_is_known(const seaway_answer* water) {
    double sum =
        water->height_m - water->height_m; /* 0; of what is no number or infinite: not a number */
    for (int i = 0; i < 3; ++i)
        sum += (water->normal[i] - water->normal[i]) +
               (water->velocity_mps[i] - water->velocity_mps[i]);
    return sum == 0 && seaway_length(water->normal) > 0;
}

static inline int seaway_is_somewhere(const seaway_body* body) {
    double sum = 0;
    for (int i = 0; i < 3; ++i)
        sum += fabs(body->position_m[i]) + fabs(body->velocity_mps[i]) +
               fabs(body->angular_velocity_radps[i]);
    for (int i = 0; i < 4; ++i)
        sum += fabs(body->orientation[i]);
    return sum < HUGE_VAL;
}

static inline seaway_code seaway_hull_step(const seaway_hull* hull, seaway_body* body,
                                           const seaway_point* points, const seaway_answer* answers,
                                           double step_s) {
    seaway_body moved = *body;
    if (!(step_s >= 0 && step_s <= 1) || seaway_hull_numbers_fault(hull) ||
        seaway_hull_parts_fault(hull))
        return SEAWAY_BAD_ARGUMENT;
    for (size_t v = 0; v < hull->vertex_count; ++v)
        if (!seaway_is_known(&answers[v]) ||
            !(fabs(points[v].x_m) + fabs(points[v].y_m) < HUGE_VAL))
            return SEAWAY_BAD_ARGUMENT;
    /* A quarter of the radian of the fastest motion that can be, an eighth of a turn by added mass, which is less forgiving.
     * Whether a step takes too much follows from the hull alone, not from the weather. */
    double parts = ceil(fmax(step_s * sqrt(seaway_stiffness(hull)) / 0.25, 1));
    if (!(parts <= SEAWAY_PARTS_MAX))
        return SEAWAY_BAD_ARGUMENT;
    const double turns = ceil(step_s * seaway_turns_by(hull, body, answers, step_s) / 0.125);
    parts = fmax(parts, fmin(turns, SEAWAY_PARTS_MAX));
    for (double part = 0; part < parts; ++part) {
        seaway_load load;
        seaway_hull_load(hull, &moved, points, answers, (part + 0.5) * step_s / parts, &load);
        seaway_part(hull, &moved, &load, step_s / parts);
    }
    if (!seaway_is_somewhere(&moved))
        return SEAWAY_BAD_ARGUMENT;
    *body = moved;
    return SEAWAY_OK;
}

#endif
