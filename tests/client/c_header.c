/* SPDX-License-Identifier: Apache-2.0 */
/* The headers and a program that uses them must be plain C. */
#include "client/buoyancy.h"
#include "client/seaway.h"

/* The worked example of the header, one frame of it. */
seaway_code one_frame_in_c(const char* url, seaway_answer* water) {
    seaway_client* client = NULL;
    seaway_code code = seaway_connect(url, NULL, &client);
    if (code != SEAWAY_OK)
        return code;
    code = seaway_subscribe(client, NULL);
    if (code == SEAWAY_OK) {
        const seaway_point keel = {12.0, -40.0, seaway_now_us(client)};
        code = seaway_sample(client, &keel, 1, water);
    }
    seaway_disconnect(client);
    return code;
}

/* Likewise of buoyancy.h: a box for one step. */
seaway_code one_step_in_c(seaway_client* client, seaway_body* box) {
    double vertices_m[24];
    uint32_t triangles[36];
    seaway_point points[8];
    seaway_answer answers[8];
    seaway_hull hull = {0};
    seaway_box(4, 2, 1, vertices_m, triangles);
    hull.mass_kg = 4000;
    hull.inertia_kgm2[0] = hull.inertia_kgm2[1] = hull.inertia_kgm2[2] = 5000;
    hull.vertices_m = vertices_m;
    hull.vertex_count = 8;
    hull.triangles = triangles;
    hull.triangle_count = 12;
    return seaway_hull_ride(&hull, box, seaway_water_of_client, client, seaway_now_us(client),
                            1.0 / 60, points, answers);
}
