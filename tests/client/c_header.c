/* SPDX-License-Identifier: Apache-2.0 */
/* The headers and a program that uses them must be plain C. */
#include "client/buoyancy.h"
#include "client/seaway.h"
#include "client/seaway_engine.h"

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

/* The worked example of seaway_engine.h. */
seaway_code one_map_in_c(seaway_client* client, float* texels, size_t bytes, seaway_map* map) {
    seaway_wish wish = SEAWAY_SIZED(seaway_wish);
    seaway_grant grant = SEAWAY_SIZED(seaway_grant);
    seaway_map_wish wanted = SEAWAY_SIZED(seaway_map_wish);
    seaway_code code;
    wish.fields = SEAWAY_SURFACE_FIELDS | SEAWAY_BIT(SEAWAY_FOAM);
    wish.error_m = 0.05;
    code = seaway_subscribe_to(client, &wish, &grant);
    if (code != SEAWAY_OK)
        return code;
    wanted.time_us = seaway_now_us(client);
    wanted.channels = 4;
    wanted.field[0] = SEAWAY_DISPLACEMENT_X;
    wanted.field[1] = SEAWAY_DISPLACEMENT_Y;
    wanted.field[2] = SEAWAY_HEIGHT;
    wanted.field[3] = SEAWAY_NO_FIELD;
    return seaway_get_map(client, &wanted, texels, bytes, map);
}

/* The worked example of a program without threads, until a question of its own is answered. */
seaway_code one_answer_without_threads_in_c(const char* url, seaway_answer* water) {
    seaway_client* client = NULL;
    seaway_connect_options options = {0};
    uint64_t question = 0;
    seaway_code code;
    options.threadless = 1;
    code = seaway_connect(url, &options, &client);
    if (code != SEAWAY_OK)
        return code;
    {
        const seaway_point keel = {12.0, -40.0, seaway_now_us(client)};
        code = seaway_ask(client, &keel, 1, 0, 0, &question);
    }
    while (code == SEAWAY_OK || code == SEAWAY_PENDING) { /* each frame */
        seaway_event event = SEAWAY_SIZED(seaway_event);
        while (seaway_poll(client, 0, &event) == SEAWAY_OK && event.kind != SEAWAY_NOTHING)
            ;
        code = seaway_take_answers(client, question, water, 1);
        if (code == SEAWAY_OK)
            break;
    }
    seaway_disconnect(client);
    return code;
}

/* A question whose answer is taken later: as a loop of frames does it. */
seaway_code one_question_in_c(seaway_client* client, seaway_answer* water) {
    const seaway_point keel = {12.0, -40.0, seaway_now_us(client)};
    seaway_event event = SEAWAY_SIZED(seaway_event);
    uint64_t question = 0;
    seaway_code code = seaway_ask(client, &keel, 1, 0, 0, &question);
    while (code == SEAWAY_OK && !(event.kind == SEAWAY_ANSWERED && event.question == question))
        code = seaway_poll(client, 0.01, &event);
    return code == SEAWAY_OK ? seaway_take_answers(client, question, water, 1) : code;
}
