/* SPDX-License-Identifier: Apache-2.0 */
/* Seaway client, C interface: heights of a running sea for engines and other languages.
 *
 * Frame and units: x east, y north, z up; metres, seconds, metres a second. Sea time is int64
 * microseconds since the sea's epoch. Points are world points, not displaced.
 *
 * Two ways to ask. seaway_query: the server answers; a round trip. seaway_sample: this process
 * answers from the keyframes that it holds, or from the waves; never asks the network. From keyframes about a microsecond a point and
 * no waiting. From waves a call may make keyframes first, on the caller's thread, some ms once in some tenths of a second, or wait for another thread
 * that makes them (SEAWAY_WAVES_FIRST in client/seaway_engine.h).
 * Both state a bound on the error of every height, and agree within it.
 *
 * Maps for textures, foam, displacements, questions without waiting: client/seaway_engine.h.
 *
 * Threads: every function may be called from any thread at any time, also several at once for one
 * client; only seaway_disconnect must be the last call for its client, made when all others have returned, those that wait too. "Blocks" is said where a
 * call waits for the network. No function keeps a pointer that it is given. Samples take 48 KB of a stack, of a sea of more than four
 * cascades 72. Threads of the
 * library take no signals but of what they do themselves, and those by which runtimes with a garbage collector stop threads (real-time
 * ones, SIGPWR, SIGXCPU). After fork() the child calls nothing for a client of its parent, seaway_disconnect neither; it
 * may connect a new one.
 *
 * Memory: whoever passes an array owns it; counts are of elements, sizes of structs are fixed for
 * this ABI version (checked at compile time below): what is added later has structs of its own, with a size, in seaway_engine.h. seaway_sample from tiles allocates nothing once its thread has sampled as
 * many points as now, 50 000 at most: threads keep what they need, and what comes is made ready as it comes. Where a sea may fold, a
 * thread's first search for other sheets allocates, too, and each that is larger than those before. (A time that more
 * than 6000 points share takes 3 MB of the client's, once; what came before anybody sampled is made ready by a sample.
 * Answers that are summed of waves allocate, and so does making keyframes of them, three or four a cascade of 2.4 MB each at 256 x 256, 38 at 1024 x 1024.)
 *
 * Errors: every function that can fail returns a seaway_code; seaway_last_error() then says why in
 * one line, for the calling thread. Nothing is written to the outputs of a call that failed.
 *
 * A connection that is lost comes back by itself: after waits that grow from 0.5 to 16 s, each up to half as long again by lot, or
 * after as long as the server asked for and some more; what was subscribed to is subscribed to again, tiles and spectrum each for itself: one comes
 * though the other is refused. Meanwhile time goes on, and what is held is sampled:
 * waves at any time; keyframes up to their end, some tenths of a second on, beyond which the sea stands (seaway_sample) and is
 * flagged SEAWAY_EXTRAPOLATED. Where another sea comes back, as of a server without a journal, nothing is held of it for some tenths of a
 * second: SEAWAY_NOT_HELD. Answers of which the server may know more are flagged SEAWAY_STALE. seaway_get_status and
 * seaway_watch_status say how it stands.
 *
 *     seaway_client* client = NULL;
 *     if (seaway_connect("ws://localhost:9430", NULL, &client) != SEAWAY_OK)
 *         return complain(seaway_last_error());
 *     seaway_subscribe(client, NULL);              // tiles flow from now on
 *     for (;;) {                                   // each frame
 *         seaway_point keel = {12.0, -40.0, seaway_now_us(client)};
 *         seaway_answer water;
 *         if (seaway_sample(client, &keel, 1, &water) == SEAWAY_OK)
 *             push_up(water.height_m, water.velocity_mps);
 *     }
 *     seaway_disconnect(client);
 */
#ifndef SEAWAY_CLIENT_SEAWAY_H
#define SEAWAY_CLIENT_SEAWAY_H

#include <stddef.h>
#include <stdint.h>

#if UINTPTR_MAX < UINT64_MAX
#error "Seaway's client library is for 64 bit: no 32-bit program has the structs of its interface"
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Grows with every change that a caller must be rebuilt for, and then, until 1.0, with the minor version of Seaway. */
#define SEAWAY_ABI_VERSION 3
uint32_t seaway_abi_version(void);

typedef enum seaway_code {
    SEAWAY_OK = 0,
    SEAWAY_BAD_ARGUMENT = 1,   /* a null pointer, an address, a value out of range */
    SEAWAY_CANNOT_CONNECT = 2, /* no server there, or not one of ours, or it turned us away */
    SEAWAY_LOST = 3,           /* the connection has ended */
    SEAWAY_REFUSED = 4,        /* the server refused this request */
    /* No reply in time; the connection goes on. What was subscribed to may begin all the same, and is asked for again after a
     * loss: seaway_unsubscribe ends that. */
    SEAWAY_DEADLINE = 5,
    SEAWAY_NOT_HELD =
        6, /* no keyframes around this time: subscribe, seaway_hold, or wait for the server */
    SEAWAY_INTERNAL = 7, /* out of memory, or a bug */
    SEAWAY_PENDING = 8,  /* of seaway_take_answers: no reply yet */
    SEAWAY_NOT_UNDERSTOOD =
        9 /* the server is older than what was asked, and has answered something else */
} seaway_code;

/* Why the last call of this thread failed; "" after none. Valid until its next call. */
const char* seaway_last_error(void);

/* ---- connection ---------------------------------------------------------------------------- */

typedef struct seaway_client seaway_client;

/* Zero or NULL everywhere: the defaults. */
typedef struct seaway_connect_options {
    const char* name;    /* for the server's log; 1024 bytes at most, as the token */
    const char* token;   /* if the server asks for one */
    const char* ca_file; /* certificates (PEM) to trust besides the system's, for wss */
    /* For connecting until the sea is known, and a second more at most; up to 86400, 0: 5. The look-up of the host's name is in it: where
     * a name server does not answer, systems take 5 s for it, so that more is needed. Threadless it takes as long as the system takes. */
    double timeout_s;
    uint32_t stays_lost; /* 1: a connection that has ended does not come back */
    uint32_t threadless; /* 1: the library makes no thread, see below */
    /* How long before now streamed keyframes can still be sampled, 0 to 60; 0: 0.25. What seaway_hold fetches stays
     * besides. Each second costs some 1.6 MB for each keyframe of 256 x 256 that came before anybody sampled, and 2.4 MB for each
     * that is sampled, of a gale 12 and 18 MB. */
    double look_back_s;
} seaway_connect_options;

/* Without threads: all that the library does for this client it does in seaway_poll (client/seaway_engine.h), and in calls that
 * block, on the thread that calls them; what is said to be called on a thread of the library is called there. Everything else is
 * the same. What a program owes: seaway_poll in every frame, or whenever seaway_poll_descriptor is readable, which it is
 * some 20 times a second; no less often than every second, and ten times a second where tiles are sampled. What is not polled for has not come:
 *   - keyframes come some tenths of a second before their time: after 0.2 s without a poll answers from tiles may be SEAWAY_EXTRAPOLATED, those from waves go on;
 *   - seaway_query and other calls that block need nothing; seaway_ask and seaway_unsubscribe are sent, and deadlines of questions pass, in polls;
 *   - after a second the clock is heard less often, and seaway_clock's error_us says so;
 *   - after three, answers are SEAWAY_STALE or SEAWAY_EXTRAPOLATED, until two polls later something is heard again; no answer is wrong without a flag;
 *   - after ten, a server may end the connection; then it comes back, in polls.
 * A poll takes up what has come: some ms for each keyframe of 256 x 256. One of a lost client connects again in steps, none of which waits, but for
 * looking up the name of the host where it is not an address: that takes as long as the system takes for it. Several threads may call; one works at a
 * time, and who waits for something takes its turn, for which it waits 20 ms at most for each before it. Not from seaway_status_watch. */

/* url: ws://HOST:PORT or wss://HOST:PORT. options may be NULL. Blocks. */
seaway_code seaway_connect(const char* url, const seaway_connect_options* options,
                           seaway_client** client);

/* Ends the connection and frees the client. NULL is allowed. Blocks a second at most; threadless, while an attempt to come back looks up
 * the host's name, for as long as the system takes for it. A thread that looks one up is left behind and ends when the system has answered. */
void seaway_disconnect(seaway_client* client);

/* 1 while the connection stands, else 0; seaway_get_status says more. */
int seaway_is_connected(const seaway_client* client);

/* Of a connection that has ended: for how long the server asked its clients to stay away, seconds; 0 where it said
 * nothing, or stands, or client is NULL. For who stays_lost: connect again after once to twice as long, by lot, as all
 * others come, too. */
double seaway_retry_after_s(const seaway_client* client);

/* How a client stands. */
enum {
    /* And all that was subscribed to is, again; or one rung is, and seaway_status.reason says why the other was refused or not
     * answered in time. That is asked for again after waits, until seaway_unsubscribe, which ends both. `holds` says what there is to sample. */
    SEAWAY_CONNECTED = 0,
    SEAWAY_WAITING = 1, /* lost: for the time of the next attempt */
    /* An attempt is under way, or what was subscribed to is not answered yet, or none of it is granted. */
    SEAWAY_CONNECTING = 2,
    SEAWAY_STOPPED =
        3 /* lost for good: wrong token, another protocol, dropped by an administrator, stays_lost */
};
enum {
    /* Keyframes to sample from, of all cascades that are subscribed to or, where nothing is, of all: at every time from
     * held_from_us to held_until_us, around now or else before it if they can be. */
    SEAWAY_HOLDS_TILES = 1,
    SEAWAY_HOLDS_WAVES = 2 /* waves: any time can be sampled */
};

typedef struct seaway_status {
    uint32_t size;        /* given: sizeof(seaway_status); so much of it is filled in */
    uint32_t state;       /* SEAWAY_CONNECTED to SEAWAY_STOPPED */
    uint32_t attempts;    /* since the connection ended */
    uint32_t connections; /* so far */
    /* Different seas so far, from 1 on. The server behind the address may have become another one, of another sea or another
     * time: what was held is dropped then, and seaway_now_us is the time of that sea. It counts, too, where time goes back
     * since a pause, or a slower pace, was not heard of while the connection was lost. */
    uint32_t seas;
    uint32_t holds;        /* sum of SEAWAY_HOLDS_TILES, SEAWAY_HOLDS_WAVES; of the sea of now */
    double next_attempt_s; /* SEAWAY_WAITING: until then; 0 also before it is known */
    double stale_s; /* since the server was heard last, or was sure of its sea; 0 while it is */
    int64_t held_from_us;
    int64_t held_until_us;
    char reason[256]; /* of the last trouble, as far as it fits; "" before any */
} seaway_status;

/* At once. The size must be given; what a newer library knows beyond it is left out. */
seaway_code seaway_get_status(const seaway_client* client, seaway_status* status);

/* Calls `watch(user, status)` whenever state, connections, seas, reason or holds are others, and when stale_s begins and ends, of
 * these latter three within some tenths of a second, on a thread of the library: it must not block, and not call seaway_disconnect or seaway_watch_status. Calls come one after the other; the status
 * is valid during the call. Of a client that is SEAWAY_STOPPED there is nothing more to tell but what seaway_rebuild makes, which is there when that
 * returns. NULL ends it: no call is under way when this returns. One a client. */
typedef void (*seaway_status_watch)(void* user, const seaway_status* status);
seaway_code seaway_watch_status(seaway_client* client, seaway_status_watch watch, void* user);

/* ---- time ---------------------------------------------------------------------------------- */

/* Sea time by the filtered clock: the same on all clients, never runs backwards while seaway_status.seas stays the same.
 * 0 for NULL. */
int64_t seaway_now_us(seaway_client* client);

typedef struct seaway_clock_status {
    /* Bound on the error of the estimate. No part of seaway_sample's error_m, which is of the time that was asked about: of
     * seaway_now_us the water may be that much, and slew_us, further on. Who means the present asks seaway_sample_as with
     * SEAWAY_TIMES_OF_NOW (client/seaway_engine.h): there error_m has it in it. */
    double error_us;
    double slew_us;       /* what seaway_now_us still has to make up */
    double drift_ppm;     /* how much faster than the local clock the sea runs */
    double round_trip_us; /* shortest of the last minute */
} seaway_clock_status;

seaway_code seaway_clock(const seaway_client* client, seaway_clock_status* status);

/* ---- the sea ------------------------------------------------------------------------------- */

/* Bulk statistics of the realised sea, and how good answers can be. While it changes: on the way from those of the sea before to those
 * of the one to come, of which hs_m is no less than it is. */
typedef struct seaway_sea {
    int64_t start_time_us; /* it runs from here on */
    double hs_m;           /* significant wave height */
    double tp_s;           /* peak period; 0: the sea is flat, or stands still */
    double tz_s;           /* mean zero-crossing period */
    double mean_from_deg;  /* nautical bearing that waves come from */
    double height_error_m; /* the error budget of the scene, on level water */
    uint32_t epoch;
    uint32_t cascades;
} seaway_sea;

/* The sea that runs at this time. */
seaway_code seaway_sea_at(const seaway_client* client, int64_t time_us, seaway_sea* sea);

/* ---- answers ------------------------------------------------------------------------------- */

typedef struct seaway_point {
    double x_m;
    double y_m;
    int64_t time_us;
} seaway_point;

enum {
    SEAWAY_FOLDED = 1, /* folds here, or may within the error of the maps: the highest sheet */
    SEAWAY_NOT_CONVERGED = 2, /* error_m covers it */
    SEAWAY_EXTRAPOLATED =
        4, /* outside the keyframes held, of the sea before one that has just begun and has not come yet, or at a time of which it is
              not known which sea ran; error_m is no bound */
    SEAWAY_INVALID = 8, /* a coordinate was not a finite number; the rest is NaN */
    SEAWAY_EXACT = 16,  /* direct sum in double precision */
    /* Velocity's vertical part alone: a sea offered without sideways motion, or stylised waves (of scenes with sines, exponential
     * crests or noise), which move nothing sideways. Where a sea has other waves beside these, the sideways part is of them. */
    SEAWAY_VERTICAL_VELOCITY = 32,
    SEAWAY_OPEN =
        64, /* with SEAWAY_FOLDED: which sheet is the highest is open; error_m is no bound */
    /* Nothing is heard of the server, or it says itself that others may have changed the sea. error_m has grown by what a change to a sea no higher than this one may have made of it
     * since, begun as soon and as fast as it may; it is no bound where the sea was changed to a higher one. */
    SEAWAY_STALE = 128,
    SEAWAY_DRY =
        256, /* of seaway_below: no water there, above the surface or below the sea floor */
    SEAWAY_FOAM_LATE =
        512 /* of seaway_sample_water: foam is that of the nearest keyframe, which is of another time */
};

typedef struct seaway_answer {
    double height_m;
    double normal[3];       /* unit length, z up */
    double velocity_mps[3]; /* of the water at the surface, whatever the choppiness */
    double error_m;         /* bound on the error of height_m; its terms: seaway_sample_terms */
    uint32_t flags;         /* sum of the above */
    uint32_t reserved;      /* 0 */
} seaway_answer;

/* The server answers `count` points, any number, each at its own time, past or future. exact: a
 * direct sum of all waves, slow. timeout_s: for each batch that the points are split into; 0: 10. A server that has no time for one now
 * and says for how long is asked again within that; SEAWAY_REFUSED: it would be too late, or no time helps. Blocks. */
seaway_code seaway_query(seaway_client* client, const seaway_point* points, size_t count, int exact,
                         double timeout_s, seaway_answer* answers);

/* What is sent, and with it what seaway_sample answers from. */
enum {
    SEAWAY_TILES = 0, /* keyframes around now, for as long as the subscription lasts */
    /* The waves of the sea, once: some 60 KB, then nothing while the sea stays as it is. Any time can be sampled,
     * past or future: one point at some 60 us of a gale, many of near times in gentle seas at 0.5 to 1 us each (seaway_engine.h says when); while the sea changes each new time takes some ms more, and 30 to 50
     * whenever more of its waves have come. Who has tiles, too,
     * chooses by seaway_sampling.from. Not of a sea of stylised waves: SEAWAY_REFUSED. */
    SEAWAY_SPECTRUM = 1
};

typedef struct seaway_subscription {
    /* Wanted bound on height on level water, up to 1e6; 0: the server chooses. On slopes answers state more, as displacements
     * are off, too. */
    double error_m;
    uint32_t credit;  /* keyframes under way, 1 .. 8; 0: 2 */
    uint32_t rung;    /* SEAWAY_TILES or SEAWAY_SPECTRUM; one does not end the other */
    double timeout_s; /* up to 86400; 0: 10. A busy server is asked again, as in seaway_query */
    /* Of tiles, for thin lines; what is left out counts in error_m of every answer. 0: no limit. */
    double
        rate_hz_max; /* keyframes of each cascade a second of sea time, 1 to 1000: at pace 10 ten times as many */
    uint32_t size_max; /* grid points a side of a map, 32 to 2048 */
    uint32_t reserved; /* 0 */
} seaway_subscription;

/* Has what is needed for sampling sent from now on; NULL: the defaults. An earlier subscription of the
 * same rung is replaced. Blocks until the present can be sampled; where the server grants tiles and has no room for the
 * keyframes around now, until it says so: then SEAWAY_OK, and the present is SEAWAY_NOT_HELD until later ones have come. */
seaway_code seaway_subscribe(seaway_client* client, const seaway_subscription* subscription);

/* Ends the stream, of both rungs. What is held stays. */
seaway_code seaway_unsubscribe(seaway_client* client);

/* Fetches what is needed to sample at these times, where it is not held. For a few times: the ring
 * that holds keyframes is bounded, the oldest go first; times in more intervals of keyframes than it has room for (24 of maps
 * of 256, 6 of 512, 2 of 1024) are SEAWAY_BAD_ARGUMENT. timeout_s 0: 10; of a server that is busy as in seaway_query. Blocks. */
seaway_code seaway_hold(seaway_client* client, const int64_t* times_us, size_t count,
                        double timeout_s);

/* Answers from what is held; at once. Points of equal times should stand together. Times are 1e18 us either side of 0 at
 * most, and coordinates 1e9 m, beyond which there is no sea: SEAWAY_BAD_ARGUMENT. A time that the
 * keyframes held do not cover is answered as well as can be, flagged SEAWAY_EXTRAPOLATED: beyond them the sea
 * runs on for a quarter of what lies between two of them, and stands. SEAWAY_NOT_HELD if there are none at all, of the
 * sea of that time or, for the first ten seconds of a change, of the one before. From waves
 * it is answered as the sea was told to be: a change is told of an interval of keyframes and a second before it begins, so what is further
 * ahead has not what is decided later, nor rows of a timetable that are still to be told; who needs those seaway_holds the time first. */
seaway_code seaway_sample(const seaway_client* client, const seaway_point* points, size_t count,
                          seaway_answer* answers);

#ifdef __cplusplus
} /* extern "C" */
#endif

/* Held by C++, and by C from 2011 on. */
#if defined(__cplusplus)
#define SEAWAY_HAS_SIZE(type, bytes) static_assert(sizeof(type) == (bytes), #type " is the ABI")
#elif defined(__STDC_VERSION__) && __STDC_VERSION__ >= 201112L
#define SEAWAY_HAS_SIZE(type, bytes) _Static_assert(sizeof(type) == (bytes), #type " is the ABI")
#else
#define SEAWAY_HAS_SIZE(type, bytes) struct seaway_held_by_later_compilers
#endif
SEAWAY_HAS_SIZE(seaway_connect_options, 48);
SEAWAY_HAS_SIZE(seaway_status, 312);
SEAWAY_HAS_SIZE(seaway_clock_status, 32);
SEAWAY_HAS_SIZE(seaway_sea, 56);
SEAWAY_HAS_SIZE(seaway_point, 24);
SEAWAY_HAS_SIZE(seaway_answer, 72);
SEAWAY_HAS_SIZE(seaway_subscription, 40);

#endif
