/* SPDX-License-Identifier: Apache-2.0 */
/* Part of seaway/buoyancy.h: how a hull moves on. */
#ifndef SEAWAY_CLIENT_BUOYANCY_STEP_H
#define SEAWAY_CLIENT_BUOYANCY_STEP_H

#include "buoyancy.h"

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

/* What moves along the body's axes and around them: itself and a share of its added mass; and one over each. */
typedef struct seaway_masses {
    double kg[3], kgm2[3];
    double per_kg[3], per_kgm2[3];
} seaway_masses;

static inline seaway_masses seaway_masses_of(const seaway_hull* hull, double share) {
    seaway_masses masses;
    for (int i = 0; i < 3; ++i) {
        masses.kg[i] = hull->mass_kg * (1 + share * hull->added_mass[i]);
        masses.kgm2[i] = hull->inertia_kgm2[i] * (1 + share * hull->added_inertia[i]);
        masses.per_kg[i] = 1 / masses.kg[i];
        masses.per_kgm2[i] = 1 / masses.kgm2[i];
    }
    return masses;
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

/* How fast the body turns and Munk's moment may take it around, rad/s: the momentum beside the water turns about each axis what is
 * heavier along one of the other two. */
static inline double seaway_turns_by(const seaway_masses* masses, const seaway_body* body,
                                     const seaway_load* load) {
    double beside_mps[3], heaviest_kg = 0, turned = 0;
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        heaviest_kg = fmax(heaviest_kg, masses->kg[i]);
        turned = fmax(turned, fabs(masses->per_kg[j] - masses->per_kg[k]) * masses->per_kgm2[i]);
    }
    seaway_beside_water(body, load, beside_mps);
    return heaviest_kg * seaway_length(beside_mps) * sqrt(turned) +
           seaway_length(body->angular_velocity_radps);
}

/* The water that goes along with the hull is pushed by the waves as well: F = (density V + Ma) Du/dt - Ma dv/dt (G. I. Taylor 1928;
 * Newman, Marine Hydrodynamics, chapter 4), and pressure sideways is density V Du/dt. Water that is breaking is pushed no harder than
 * the steepest that does not. */
static inline void seaway_add_diffraction(const seaway_hull* hull, const seaway_masses* masses,
                                          double rows[3][3], const seaway_load* load,
                                          double force_n[3]) {
    const double displaced_kg = seaway_density_of(hull) * load->submerged_m3;
    const double push_n = hypot(load->force_n[0], load->force_n[1]);
    double added_kg[3], pushed[3];
    if (!(displaced_kg > 0 && push_n > 0))
        return;
    const double per_kg = fmin(1 / displaced_kg, SEAWAY_GRAVITY_MPS2 * SEAWAY_SLOPE_MAX / push_n);
    const double water_mps2[3] = {per_kg * load->force_n[0], per_kg * load->force_n[1], 0};
    for (int i = 0; i < 3; ++i)
        added_kg[i] = masses->kg[i] - hull->mass_kg;
    seaway_along_axes(rows, added_kg, water_mps2, pushed);
    seaway_add(force_n, 1, pushed);
}

/* Solves matrix x = right by elimination; of the matrix the half below the diagonal is read. It is a sum of masses and of what is
 * 0 or more along any direction, so that no pivot is below the least mass but by rounding. */
static inline void seaway_solve(double matrix[6][6], const double least[6], double right[6]) {
    for (int i = 0; i < 6; ++i) {
        matrix[i][i] = fmax(matrix[i][i], least[i]);
        for (int j = i + 1; j < 6; ++j) {
            const double times = matrix[j][i] / matrix[i][i];
            for (int k = i + 1; k <= j; ++k)
                matrix[j][k] -= times * matrix[k][i];
            right[j] -= times * right[i];
        }
    }
    for (int i = 5; i >= 0; --i) {
        for (int j = i + 1; j < 6; ++j)
            right[i] -= matrix[j][i] * right[j];
        right[i] /= matrix[i][i];
    }
}

/* From force and torque to how much they change the velocity and the angular velocity within a part of a step. Drag is what it is at
 * the end of it, with its coefficients at the begin: (mass + part * damping) change = part * force. So it takes energy at any strength,
 * and alone it slows by its law (what falls with the square of a speed exactly) and turns nothing back. */
static inline void seaway_push(const seaway_masses* masses, double rows[3][3],
                               const seaway_load* load, double part_s, double force[6]) {
    double matrix[6][6], least[6], along[3], around[3];
    for (int i = 0; i < 3; ++i) {
        const double unit[3] = {i == 0 ? 1.0 : 0.0, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0};
        seaway_along_axes(rows, masses->kg, unit, along);
        seaway_along_axes(rows, masses->kgm2, unit, around);
        least[i] = fmin(fmin(masses->kg[0], masses->kg[1]), masses->kg[2]);
        least[i + 3] = fmin(fmin(masses->kgm2[0], masses->kgm2[1]), masses->kgm2[2]);
        for (int j = 0; j < 3; ++j) {
            matrix[j][i] = along[j] + part_s * load->damping[j][i];
            matrix[j + 3][i] = part_s * load->damping[j + 3][i];
            matrix[j + 3][i + 3] = around[j] + part_s * load->damping[j + 3][i + 3];
        }
    }
    for (int i = 0; i < 6; ++i)
        force[i] *= part_s;
    seaway_solve(matrix, least, force);
}

/* Of a momentum beside the water that goes another way than the body. */
static inline void seaway_add_munk(const double momentum[3], const double beside_mps[3],
                                   double share_s, double spin[3]) {
    double munk[3];
    seaway_cross(momentum, beside_mps, munk);
    seaway_add(spin, share_s, munk);
}

/* Turns a body of this angular momentum, by what its inertia is half of the way: looked for three times, since with that of the first
 * look a spin would creep towards the axis of the least inertia, and gain energy by it. */
static inline void seaway_turn_on(const seaway_masses* masses, const double spin[3], double part_s,
                                  double orientation[4]) {
    double rows[3][3], turn[3], half[4];
    seaway_rows(orientation, rows);
    for (int look = 0; look < 3; ++look) {
        seaway_along_axes(rows, masses->per_kgm2, spin, turn);
        for (int i = 0; i < 3; ++i)
            turn[i] *= 0.5 * part_s;
        for (int i = 0; i < 4; ++i)
            half[i] = orientation[i];
        seaway_turn(half, turn);
        seaway_rows(half, rows);
    }
    seaway_along_axes(rows, masses->per_kgm2, spin, turn);
    for (int i = 0; i < 3; ++i)
        turn[i] *= part_s;
    seaway_turn(orientation, turn);
}

/* Water that the hull begins to take along it has to speed up: momentum is what lasts where it dips in, and where it comes out velocity,
 * since the water gives nothing back (von Karman 1929, the impact on floats). So nothing is made of nothing. */
static inline void seaway_add_dipping(const seaway_hull* hull, double rows[3][3], double grows_ps,
                                      const double beside_mps[3], const double turns_radps[3],
                                      double force[6]) {
    double along_kg[3], around_kgm2[3], along[3], around[3];
    for (int i = 0; i < 3; ++i) {
        along_kg[i] = hull->mass_kg * hull->added_mass[i];
        around_kgm2[i] = hull->inertia_kgm2[i] * hull->added_inertia[i];
    }
    seaway_along_axes(rows, along_kg, beside_mps, along);
    seaway_along_axes(rows, around_kgm2, turns_radps, around);
    seaway_add(force, -grows_ps, along);
    seaway_add(force + 3, -grows_ps, around);
}

/* One part of a step, of what is heavy as at its end and has taken grows_ps of its added mass along in each second of it: the velocities
 * first, by the forces where the body is, then the places by the new velocities, which keeps the energy of waves bounded. While the body
 * turns its momenta last: angular momentum, which keeps the energy of a spin, and that beside the water, which is another velocity
 * wherever the body is heavier along some of its axes and pulls it around (Munk's moment, half of it before the turn and half behind,
 * without which turning would make energy of nothing; Lamb, Hydrodynamics, 121). */
static inline void seaway_part(const seaway_hull* hull, const seaway_masses* masses,
                               double grows_ps, seaway_body* body, const seaway_load* load,
                               double part_s) {
    double rows[3][3], force[6], beside[3], water[3], momentum[3], spin[3];
    seaway_rows(body->orientation, rows);
    seaway_beside_water(body, load, beside);
    for (int i = 0; i < 3; ++i) {
        force[i] = load->force_n[i] + load->drag_n[i];
        force[i + 3] = load->torque_nm[i] + load->drag_nm[i];
        water[i] = body->velocity_mps[i] - beside[i];
    }
    force[2] -= hull->mass_kg * SEAWAY_GRAVITY_MPS2;
    seaway_add_dipping(hull, rows, grows_ps, beside, body->angular_velocity_radps, force);
    seaway_add_diffraction(hull, masses, rows, load, force);
    seaway_push(masses, rows, load, part_s, force);
    seaway_add(beside, 1, force);
    seaway_add(body->angular_velocity_radps, 1, force + 3);
    seaway_along_axes(rows, masses->kg, beside, momentum);
    seaway_along_axes(rows, masses->kgm2, body->angular_velocity_radps, spin);
    seaway_add_munk(momentum, beside, 0.5 * part_s, spin);
    seaway_add(body->position_m, part_s, water);
    seaway_add(body->position_m, part_s, beside);
    seaway_turn_on(masses, spin, part_s, body->orientation);
    seaway_rows(body->orientation, rows);
    seaway_along_axes(rows, masses->per_kg, momentum, beside);
    seaway_add_munk(momentum, beside, 0.5 * part_s, spin);
    seaway_along_axes(rows, masses->per_kgm2, spin, body->angular_velocity_radps);
    for (int i = 0; i < 3; ++i)
        body->velocity_mps[i] = water[i] + beside[i];
}

/* Moves the body on by longest_s, or by less where it turns by more than an eighth of a radian in that or added mass takes it around,
 * which is less forgiving. Returns by how much. Added mass is there as far as the hull displaces half of its mass: all of it where it
 * floats and heaves, none in the air. What spins faster than it could swing takes no water along, nor does what turns too fast for the
 * shortest part: it would dip in and come out with it many times while it rises and sinks once. */
static inline double seaway_advance(const seaway_hull* hull, seaway_body* body,
                                    const seaway_load* load, double longest_s, double shortest_s,
                                    double fastest_radps) {
    const double per_m3 = 2 * seaway_density_of(hull) / hull->mass_kg;
    double share = fmin(fmax(per_m3 * load->submerged_m3, 0), 1);
    seaway_masses masses = seaway_masses_of(hull, share);
    double turns_radps = seaway_turns_by(&masses, body, load);
    const int whirls = seaway_length(body->angular_velocity_radps) > fastest_radps ||
                       turns_radps * shortest_s > 0.125;
    if (whirls)
        turns_radps = seaway_length(body->angular_velocity_radps);
    const double part_s = fmin(longest_s, fmax(0.125 / turns_radps, shortest_s));
    const double grows_ps =
        whirls ? 0 : fmin(fmax(per_m3 * load->dips_m3ps, 0), (1 - share) / part_s);
    share = whirls ? 0 : share + grows_ps * part_s;
    masses = seaway_masses_of(hull, share);
    seaway_part(hull, &masses, grows_ps, body, load, part_s);
    return part_s;
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
    int parts_left = SEAWAY_PARTS_MAX;
    if (!(step_s >= 0 && step_s <= 1) || !seaway_is_somewhere(body) ||
        seaway_hull_numbers_fault(hull) || seaway_hull_parts_fault(hull))
        return SEAWAY_BAD_ARGUMENT;
    for (size_t v = 0; v < hull->vertex_count; ++v)
        if (!seaway_is_known(&answers[v]) ||
            !(fabs(points[v].x_m) + fabs(points[v].y_m) < HUGE_VAL))
            return SEAWAY_BAD_ARGUMENT;
    /* A quarter of the radian of the fastest motion that can be in still water. Whether that is too much follows from the hull alone,
     * not from the weather. */
    const double fastest_radps = sqrt(seaway_stiffness(hull));
    const double shortest_s = step_s / SEAWAY_PARTS_MAX;
    if (!(shortest_s * fastest_radps <= 0.25))
        return SEAWAY_BAD_ARGUMENT;
    for (double left_s = step_s; left_s > 0;) {
        seaway_load load;
        const double part_s = left_s / fmax(ceil(left_s * fastest_radps / 0.25), 1);
        seaway_hull_load(hull, &moved, points, answers, step_s - left_s + 0.5 * part_s, &load);
        left_s -= --parts_left > 0
                      ? seaway_advance(hull, &moved, &load, part_s, shortest_s, fastest_radps)
                      : seaway_advance(hull, &moved, &load, left_s, left_s, fastest_radps);
    }
    if (!seaway_is_somewhere(&moved))
        return SEAWAY_BAD_ARGUMENT;
    *body = moved;
    return SEAWAY_OK;
}

#endif
