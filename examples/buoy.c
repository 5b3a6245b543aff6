/* SPDX-License-Identifier: Apache-2.0 */
/* One buoy in the sea of a running server, as an engine would have it: 60 steps a second, a line each second.
 *
 *     cc -O2 buoy.c $(pkg-config --cflags --libs seaway) -o buoy
 *     ./buoy ws://127.0.0.1:9430 [SECONDS]
 *
 * A barrel 1.2 m high on a chain of its own weight alone: four sample points, columns of a quarter of its volume. */
#define _POSIX_C_SOURCE 200809L
#include <seaway/buoyancy.h>

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define STEPS_A_SECOND 60

static const double places_m[12] = {0.3, 0.3, 0, -0.3, 0.3, 0, -0.3, -0.3, 0, 0.3, -0.3, 0};
static const double volumes_m3[4] = {0.34, 0.34, 0.34, 0.34};

static seaway_hull barrel(void) {
    seaway_hull hull = {0};
    hull.mass_kg = 700; /* half of what it can carry */
    hull.inertia_kgm2[0] = hull.inertia_kgm2[1] = 150;
    hull.inertia_kgm2[2] = 130;
    hull.added_mass[0] = hull.added_mass[1] = 1;
    hull.added_mass[2] = 0.5;
    hull.linear_drag = 600;
    hull.quadratic_drag = 1;
    hull.vertices_m = places_m;
    hull.vertex_count = 4;
    hull.volumes_m3 = volumes_m3;
    hull.column_m = 1.2;
    return hull;
}

static int complain(const char* what) {
    const char* why = seaway_last_error(); /* empty where the hull itself takes no such step */
    fprintf(stderr, "buoy: %s%s%s\n", what, *why ? ": " : " is refused", why);
    return 1;
}

static int float_for(seaway_client* sea, double seconds) {
    const seaway_hull hull = barrel();
    const struct timespec pause = {0, 1000000000 / STEPS_A_SECOND};
    seaway_body body = {{0, 0, 0}, {1, 0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    seaway_point points[4];
    seaway_answer water[4];
    int64_t now_us = seaway_now_us(sea);
    printf("time_s,water_m,buoy_m,east_m,north_m,error_m\n");
    for (long step = 0; step < (long)(seconds * STEPS_A_SECOND); ++step) {
        nanosleep(&pause, NULL);
        const int64_t next_us = seaway_now_us(sea);
        if (next_us < now_us) { /* it has become another sea, of an earlier time: no step leads there */
            now_us = next_us;
            continue;
        }
        /* A pause of the program is not made up for in one step. */
        const double step_s = fmin((double)(next_us - now_us) * 1e-6, 0.1);
        const seaway_body then = body; /* at the time of the water */
        const int64_t then_us = now_us;
        const seaway_code code = seaway_hull_ride(&hull, &body, seaway_water_of_client, sea, now_us,
                                                  step_s, points, water);
        now_us = next_us;
        if (code == SEAWAY_NOT_HELD) /* no water yet, or it has just become another sea */
            continue;
        if (code != SEAWAY_OK)
            return complain("a step");
        if (step % STEPS_A_SECOND == 0)
            printf("%.3f,%.3f,%.3f,%.3f,%.3f,%.3f\n", (double)then_us * 1e-6,
                   water[0].height_m, then.position_m[2], then.position_m[0], then.position_m[1],
                   water[0].error_m);
        if (fflush(stdout) != 0) { /* a full disk, or nobody reads on */
            perror("buoy");
            return 1;
        }
    }
    return 0;
}

int main(int argc, char** argv) {
    seaway_client* sea = NULL;
    if (argc < 2) {
        fprintf(stderr, "usage: buoy ws://HOST:PORT [SECONDS]\n");
        return 2;
    }
    if (seaway_connect(argv[1], NULL, &sea) != SEAWAY_OK)
        return complain("no sea");
    int code = seaway_subscribe(sea, NULL) == SEAWAY_OK ? 0 : complain("no tiles");
    if (code == 0)
        code = float_for(sea, argc > 2 ? atof(argv[2]) : 60);
    seaway_disconnect(sea);
    return code;
}
