/* SPDX-License-Identifier: Apache-2.0 */
/* What floats: force and torque of the water on a hull, and a rigid body that rides on it. C99 and C++, a header alone, for
 * any engine or none; of the library it needs seaway_sample only where seaway_water_of_client is used.
 *
 * Frame and units as in seaway.h: x east, y north, z up, metres, seconds, kg, newtons. A hull is given in its own
 * frame: origin in the centre of mass, axes along the principal axes of inertia (x forward, y to port, z up is usual).
 * Other frames of engines: seaway_to_engine, seaway_turn_to_engine, at the end.
 *
 * Physics, and its limits:
 * - Pressure is hydrostatic below the surface as it is: density * g * depth, the surface a straight line between the corners of
 *   a panel, over which it is integrated exactly. In still water force and torque are exact for any attitude; in waves the slope
 *   of the water pushes, too. Panels should be shorter than a quarter of the waves that matter. Pressure does not fade with
 *   depth below waves: theirs at the keel is too large by exp(k draught) - 1, which is 6 % where the draught is a hundredth of the
 *   wavelength, 17 % at a fortieth and 87 % at a tenth.
 * - Drag on each wetted panel, along its normal, by the water's velocity at the surface: linear_drag * v + quadratic_drag * density / 2
 *   * |v| v of the flow v onto it or away from it. The first is that of waves which the hull makes by what moves along its normals; the
 *   second presses on the side that meets the water and sucks on the lee, half of what a blunt body feels each. What slides along
 *   the skin is free: friction is some thousandths of that. Sample points have no normals: both laws act on all of the flow, on the
 *   area of the column from above.
 * - Added mass is a coefficient for each axis, times mass and inertia. All of it is there where the hull displaces half of its mass, and
 *   less as that is less: in the air a body falls and spins as bodies do. What dips in shares its momentum with the water, and what comes
 *   out keeps its velocity. Momentum beside the water is what lasts where a body turns, with Munk's
 *   moment, which takes a slender hull that is under way through the water broadside on, as it does ships: drag at the stern, or a
 *   rudder, holds its course. What waves do to the hull sideways they do to its added mass as well, so that a hull that is small
 *   beside a wave moves with its water (extended Morison: F = (density V + Ma) Du/dt - Ma dv/dt). Upwards they do not: how the water
 *   below speeds up cannot be had from the surface alone. A load has no part in either: it is for bodies without added mass.
 *   The heave of a body that floats is then (m + a33) z'' + b33 z' + c33 z = F, c33 = density g * waterplane (SNAME, Principles of
 *   Naval Architecture III, Motions in Waves), which test Buoyancy holds it against.
 *
 * A step has three parts, so that many hulls ask for their water in one batch:
 *
 *     seaway_hull_points(&hull, &body, seaway_now_us(client), points);   // hull.vertex_count of them
 *     seaway_sample(client, points, hull.vertex_count, answers);         // of all hulls at once
 *     seaway_hull_step(&hull, &body, points, answers, 1.0 / 60);
 *
 * (seaway_sample_as of seaway_engine.h leaves out waves that are too short for the hull) or one, for one hull: seaway_hull_ride. Between samples the water moves on by its own
 * velocity and slope, as is right at choppiness 1; at another the surface rises by w - choppiness * u . slope, which answers do not say, and
 * within a step it is off by the rest. A step divides itself as finely as the hull is stiff and as it turns, and drag is taken implicitly:
 * no step makes a hull unstable, in a hurricane neither. Without any drag nothing takes away what waves push in.
 *
 * Cost: some 0.15 us a panel and part of a step, besides the samples. Nothing is allocated; pure, so safe from any
 * thread. What fails changes nothing and returns SEAWAY_BAD_ARGUMENT (seaway_last_error() knows nothing of what is done
 * here; seaway_hull_fault may); with -ffast-math numbers that are none are not found. */
#ifndef SEAWAY_CLIENT_BUOYANCY_H
#define SEAWAY_CLIENT_BUOYANCY_H

#include "buoyancy_panel.h"
#include "seaway.h"

/* m/s2, what a scene has where it says nothing else. The library does not say what a scene has: for one that says something else,
 * define it before this header is included. kg/m3, sea water at 15 C (ITTC 7.5-02-01-03). */
#ifndef SEAWAY_GRAVITY_MPS2
#define SEAWAY_GRAVITY_MPS2 9.81
#endif
#define SEAWAY_DENSITY_KGPM3 1026.0

/* Pointers are read while a function runs and kept by none. */
typedef struct seaway_hull {
    double mass_kg;
    double inertia_kgm2[3]; /* about the axes of the body */
    double added_mass[3];   /* times mass_kg, along these axes; 0 or more */
    double added_inertia[3];
    double linear_drag; /* N s/m for each m2 that is wet; 0 or more */
    double
        quadratic_drag; /* 0 or more; 0.5 for a blunt box, whose Cd is 1.05; of sample points Cd */
    double density_kgpm3; /* of the water; 0: SEAWAY_DENSITY_KGPM3 */

    /* Corners x, y, z of a closed mesh, or sample points, in the body. */
    const double* vertices_m;
    size_t vertex_count;
    /* Of a mesh: three corners each, anticlockwise from outside. */
    const uint32_t* triangles;
    size_t triangle_count;
    /* Of sample points, which have no triangles: each is the middle of an upright column of this volume and height. */
    const double* volumes_m3;
    double column_m;
} seaway_hull;

typedef struct seaway_body {
    double position_m[3];  /* of the centre of mass */
    double orientation[4]; /* w, x, y, z: from the body's axes to the world's; unit length */
    double velocity_mps[3];
    double angular_velocity_radps[3]; /* in the world */
} seaway_body;

/* Why a hull cannot float; NULL if it can. A mesh has to be closed, its triangles anticlockwise from outside. */
static inline const char* seaway_hull_fault(const seaway_hull* hull);

/* Volume of a closed mesh, or of all columns, m3; 0 of a hull without either. */
static inline double seaway_hull_volume_m3(const seaway_hull* hull);

/* Where the water has to be known: above every vertex. */
static inline void seaway_hull_points(const seaway_hull* hull, const seaway_body* body,
                                      int64_t time_us, seaway_point* points);

/* What the water does to the hull, `later_s` after the time of the answers, which are of `points`. The body may have moved on
 * since. Gravity is no part of it. */
static inline void seaway_hull_load(const seaway_hull* hull, const seaway_body* body,
                                    const seaway_point* points, const seaway_answer* answers,
                                    double later_s, seaway_load* load);

/* Moves the body on by step_s, 0 to 1 s, which starts at the time of the points. SEAWAY_BAD_ARGUMENT: a step outside of that, or one
 * that a hull so stiff takes more than SEAWAY_PARTS_MAX parts for (of a light or slender hull take shorter steps); any number of points, water, hull or
 * body that is none, or from which none follows, a normal of no length, a hull without parts; the body stays where it was. Whether
 * corners of triangles are vertices, seaway_hull_fault alone looks at: ask it once for a hull from elsewhere. */
#define SEAWAY_PARTS_MAX 1000
static inline seaway_code seaway_hull_step(const seaway_hull* hull, seaway_body* body,
                                           const seaway_point* points, const seaway_answer* answers,
                                           double step_s);

/* The water at points, from anywhere. */
typedef seaway_code (*seaway_water_at)(void* context, const seaway_point* points, size_t count,
                                       seaway_answer* answers);

/* A seaway_water_at; its context is a seaway_client*. */
static inline seaway_code seaway_water_of_client(void* client, const seaway_point* points,
                                                 size_t count, seaway_answer* answers) {
#ifdef __cplusplus
    return seaway_sample(static_cast<const seaway_client*>(client), points, count, answers);
#else
    return seaway_sample(client, points, count, answers);
#endif
}

/* Asks for the water and takes one step. `points` and `answers` have room for hull->vertex_count. */
static inline seaway_code seaway_hull_ride(const seaway_hull* hull, seaway_body* body,
                                           seaway_water_at water_at, void* context, int64_t time_us,
                                           double step_s, seaway_point* points,
                                           seaway_answer* answers) {
    seaway_hull_points(hull, body, time_us, points);
    const seaway_code code = water_at(context, points, hull->vertex_count, answers);
    return code == SEAWAY_OK ? seaway_hull_step(hull, body, points, answers, step_s) : code;
}

/* Eight corners and twelve triangles of a box around the origin, for seaway_hull. */
static inline void seaway_box(double length_m, double beam_m, double height_m,
                              double vertices_m[24], uint32_t triangles[36]) {
    static const uint32_t faces[36] = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                       2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
    for (int i = 0; i < 8; ++i) {
        vertices_m[3 * i] = (i & 1 ? 0.5 : -0.5) * length_m;
        vertices_m[3 * i + 1] = (i & 2 ? 0.5 : -0.5) * beam_m;
        vertices_m[3 * i + 2] = (i & 4 ? 0.5 : -0.5) * height_m;
    }
    for (int i = 0; i < 36; ++i)
        triangles[i] = faces[i];
}

/* A mesh from the text of an OBJ file: its v and f lines, other lines are passed over; lines end as anywhere (LF, CR LF, CR). Faces of
 * more corners become fans: of a concave one drag counts what overlaps twice. Corners may be v, v/vt, v//vn, v/vt/vn, and negative
 * as counted from the end. A file without faces is no fault here, but of the hull: seaway_hull_fault. Writes at most as many as there is room for and says how many
 * there are: ask once with no room, then with it. SEAWAY_BAD_ARGUMENT: a number or corner that makes no sense; `line` says where. */
typedef struct seaway_obj {
    double* vertices_m; /* x, y, z each; NULL where there is no room */
    size_t vertex_room;
    size_t vertex_count; /* out */
    uint32_t* triangles; /* three corners each */
    size_t triangle_room;
    size_t triangle_count; /* out */
    size_t line;           /* out: the last one that was looked at, from 1 */
} seaway_obj;
static inline seaway_code seaway_read_obj(const char* text, size_t length, seaway_obj* mesh);

/* ---- frames of engines --------------------------------------------------------------------- */

typedef enum seaway_frame {
    SEAWAY_Y_UP = 0,      /* right-handed, x east, y up, z south: Godot, three.js, glTF */
    SEAWAY_Y_UP_LEFT = 1, /* left-handed, x east, y up, z north: Unity */
    SEAWAY_Z_UP_LEFT =
        2 /* left-handed, x east, y south, z up: Unreal, times 100 for its centimetres */
} seaway_frame;

/* Points, velocities, normals and forces of Seaway in an engine's frame. `out` may be `v`. */
static inline void seaway_to_engine(seaway_frame frame, const double v[3], double out[3]) {
    const double east = v[0], north = v[1], up = v[2];
    out[0] = east;
    out[1] = frame == SEAWAY_Z_UP_LEFT ? -north : up;
    out[2] = frame == SEAWAY_Z_UP_LEFT ? up : frame == SEAWAY_Y_UP ? -north : north;
}

/* The axis of a turn in out[1..3] as a frame of the other hand sees it, beside the turn's w. */
static inline void seaway_mirror_turn(seaway_frame frame, double w, double out[4]) {
    out[0] = w;
    if (frame == SEAWAY_Y_UP)
        return;
    for (int i = 1; i < 4; ++i)
        out[i] = -out[i];
}

/* Turns: an orientation w, x, y, z of a body whose mesh was brought over by seaway_to_engine; with w = 0 an angular velocity or
 * a torque, which a mirror turns round. */
static inline void seaway_turn_to_engine(seaway_frame frame, const double q[4], double out[4]) {
    const double w = q[0];
    seaway_to_engine(frame, q + 1, out + 1);
    seaway_mirror_turn(frame, w, out);
}

/* The way back of seaway_to_engine. */
static inline void seaway_from_engine(seaway_frame frame, const double v[3], double out[3]) {
    const double first = v[1], second = v[2];
    out[0] = v[0];
    out[1] = frame == SEAWAY_Z_UP_LEFT ? -first : frame == SEAWAY_Y_UP ? -second : second;
    out[2] = frame == SEAWAY_Z_UP_LEFT ? second : first;
}

/* The way back of seaway_turn_to_engine. */
static inline void seaway_turn_from_engine(seaway_frame frame, const double q[4], double out[4]) {
    const double w = q[0];
    seaway_from_engine(frame, q + 1, out + 1);
    seaway_mirror_turn(frame, w, out);
}

#include "buoyancy_hull.h"
#include "buoyancy_obj.h"
#include "buoyancy_step.h"

#endif
