/* SPDX-License-Identifier: Apache-2.0 */
/* Part of seaway/buoyancy.h: vectors, turns, and what water does to one panel of a hull. Pure; no allocation.
 * Metres, newtons, kg; vectors are double[3], turns are unit quaternions w, x, y, z. */
#ifndef SEAWAY_CLIENT_BUOYANCY_PANEL_H
#define SEAWAY_CLIENT_BUOYANCY_PANEL_H

#include <math.h>
#include <stddef.h>

static inline double seaway_dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline double seaway_length(const double a[3]) {
    return sqrt(seaway_dot(a, a));
}

static inline void seaway_cross(const double a[3], const double b[3], double out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* out += scale * a */
static inline void seaway_add(double out[3], double scale, const double a[3]) {
    for (int i = 0; i < 3; ++i)
        out[i] += scale * a[i];
}

/* The rows of the matrix that turns a vector of the body into one of the world. */
static inline void seaway_rows(const double q[4], double rows[3][3]) {
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    const double matrix[3][3] = {
        {1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
        {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
        {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            rows[i][j] = matrix[i][j];
}

static inline void seaway_to_world(double rows[3][3], const double body[3], double world[3]) {
    for (int i = 0; i < 3; ++i)
        world[i] = seaway_dot(rows[i], body);
}

/* out = scale of each axis of the body times a world vector: a tensor that is diagonal in the body. */
static inline void seaway_along_axes(double rows[3][3], const double scale[3],
                                     const double world[3], double out[3]) {
    double body[3];
    for (int j = 0; j < 3; ++j)
        body[j] =
            scale[j] * (rows[0][j] * world[0] + rows[1][j] * world[1] + rows[2][j] * world[2]);
    seaway_to_world(rows, body, out);
}

/* Turns q by the rotation vector `turn`, rad, in the world; stays of unit length. */
static inline void seaway_turn(double q[4], const double turn[3]) {
    const double angle = seaway_length(turn);
    const double over = angle > 1e-9 ? sin(0.5 * angle) / angle : 0.5;
    const double r[4] = {cos(0.5 * angle), over * turn[0], over * turn[1], over * turn[2]};
    const double p[4] = {q[0], q[1], q[2], q[3]};
    q[0] = r[0] * p[0] - r[1] * p[1] - r[2] * p[2] - r[3] * p[3];
    q[1] = r[0] * p[1] + r[1] * p[0] + r[2] * p[3] - r[3] * p[2];
    q[2] = r[0] * p[2] - r[1] * p[3] + r[2] * p[0] + r[3] * p[1];
    q[3] = r[0] * p[3] + r[1] * p[2] - r[2] * p[1] + r[3] * p[0];
    const double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int i = 0; i < 4; ++i)
        q[i] /= length;
}

/* What the water does to a body: about its centre of mass, in the world. */
typedef struct seaway_load {
    double force_n[3];   /* of pressure */
    double torque_nm[3]; /* of pressure */
    double drag_n[3];    /* force of drag */
    double drag_nm[3];   /* torque of drag */
    /* What drag takes for each m/s (columns 0 to 2) and rad/s (3 to 5): of force (rows 0 to 2) and torque. Symmetric;
     * only the half below the diagonal is filled in. */
    double damping[6][6];
    double submerged_m3; /* volume below the surface */
    double dips_m3ps;    /* how fast that grows as the hull moves through its water */
    double wetted_m2;    /* area below it; of sample points that of their columns */
    double flow_m3ps[3]; /* of how fast the water moves past that area, the integral */
    double arm_m3[3];    /* likewise of its arm from the centre of mass */
} seaway_load;

/* A corner of a panel: place from the centre of mass, how deep it is (above the water: negative), and how fast the
 * water there moves past the hull. All in the world. */
typedef struct seaway_corner {
    double arm_m[3];
    double depth_m;
    double flow_mps[3];
} seaway_corner;

static inline seaway_corner seaway_between(const seaway_corner* a, const seaway_corner* b,
                                           double share) {
    seaway_corner c;
    for (int i = 0; i < 3; ++i) {
        c.arm_m[i] = a->arm_m[i] + share * (b->arm_m[i] - a->arm_m[i]);
        c.flow_mps[i] = a->flow_mps[i] + share * (b->flow_mps[i] - a->flow_mps[i]);
    }
    c.depth_m = a->depth_m + share * (b->depth_m - a->depth_m);
    return c;
}

/* Drag at an arm along one direction, against the flow along it. */
static inline void seaway_add_drag(const double arm_m[3], const double along[3], double flow_mps,
                                   double drag_nspm, seaway_load* load) {
    double moves[6];
    seaway_cross(arm_m, along, moves + 3);
    for (int i = 0; i < 3; ++i)
        moves[i] = along[i];
    seaway_add(load->drag_n, drag_nspm * flow_mps, moves);
    seaway_add(load->drag_nm, drag_nspm * flow_mps, moves + 3);
    for (int i = 0; i < 6; ++i)
        for (int j = 0; j <= i; ++j)
            load->damping[i][j] += drag_nspm * moves[i] * moves[j];
}

static inline void seaway_add_wetted(const double arm_m[3], double area_m2,
                                     const double flow_mps[3], seaway_load* load) {
    load->wetted_m2 += area_m2;
    seaway_add(load->flow_m3ps, area_m2, flow_mps);
    seaway_add(load->arm_m3, area_m2, arm_m);
}

/* A triangle that is under water, its corners anticlockwise from outside. Pressure `weight` times depth is linear on it, so
 * force and torque are exact: of barycentric coordinates the integral of a square is A/6 and of a product A/12. Drag stands in
 * the middles of the edges, a third of the area each, which is as exact for the linear law. */
static inline void seaway_wet_triangle(const seaway_corner corners[3], double weight_npm3,
                                       double linear, double quadratic, seaway_load* load) {
    const seaway_corner *a = &corners[0], *b = &corners[1], *c = &corners[2];
    double ab[3], ac[3], normal[3], normal_m2[3], lever[3], torque[3];
    for (int i = 0; i < 3; ++i) {
        ab[i] = b->arm_m[i] - a->arm_m[i];
        ac[i] = c->arm_m[i] - a->arm_m[i];
    }
    seaway_cross(ab, ac, normal_m2);
    for (int i = 0; i < 3; ++i)
        normal_m2[i] *= 0.5;
    const double area_m2 = seaway_length(normal_m2);
    if (!(area_m2 > 0))
        return;
    const double depths_m = a->depth_m + b->depth_m + c->depth_m;
    for (int i = 0; i < 3; ++i) {
        lever[i] = (a->arm_m[i] * (depths_m + a->depth_m) + b->arm_m[i] * (depths_m + b->depth_m) +
                    c->arm_m[i] * (depths_m + c->depth_m)) /
                   12;
        normal[i] = normal_m2[i] / area_m2;
    }
    seaway_add(load->force_n, -weight_npm3 * depths_m / 3, normal_m2);
    seaway_cross(lever, normal_m2, torque);
    seaway_add(load->torque_nm, -weight_npm3, torque);
    load->submerged_m3 -= normal_m2[2] * depths_m / 3;
    for (int i = 0; i < 3; ++i) {
        const seaway_corner middle = seaway_between(&corners[i], &corners[(i + 1) % 3], 0.5);
        const double onto_mps = seaway_dot(middle.flow_mps, normal);
        seaway_add_drag(middle.arm_m, normal, onto_mps,
                        area_m2 / 3 * (linear + quadratic * fabs(onto_mps)), load);
        load->dips_m3ps -= area_m2 / 3 * onto_mps;
        seaway_add_wetted(middle.arm_m, area_m2 / 3, middle.flow_mps, load);
    }
}

/* Any triangle: what is below the water of it. */
static inline void seaway_add_panel(const seaway_corner corners[3], double weight_npm3,
                                    double linear, double quadratic, seaway_load* load) {
    seaway_corner wet[4];
    int count = 0;
    for (int i = 0; i < 3; ++i) {
        const seaway_corner* here = &corners[i];
        const seaway_corner* next = &corners[(i + 1) % 3];
        if (here->depth_m > 0)
            wet[count++] = *here;
        if ((here->depth_m > 0) != (next->depth_m > 0)) {
            wet[count] =
                seaway_between(here, next, here->depth_m / (here->depth_m - next->depth_m));
            wet[count++].depth_m = 0;
        }
    }
    for (int i = 2; i < count; ++i) {
        const seaway_corner fan[3] = {wet[0], wet[i - 1], wet[i]};
        seaway_wet_triangle(fan, weight_npm3, linear, quadratic, load);
    }
}

#endif
