/* SPDX-License-Identifier: Apache-2.0 */
/* The header and a program that uses it must be plain C. */
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
