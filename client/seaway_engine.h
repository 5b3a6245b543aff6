/* SPDX-License-Identifier: Apache-2.0 */
/* Seaway client, C interface for engines: what client/seaway.h has not: a choice of what is streamed, whole maps for
 * textures, foam and displacement at points, waves too short to matter left out, questions without waiting, and what
 * answers come from. Frame, units, threads, memory and errors are as seaway.h says.
 *
 * Structs that begin with `size` carry it: set it to sizeof(the struct), the rest to 0 (SEAWAY_SIZED); more than 4096 is refused. A program that was
 * built with an older header runs with a newer library: what it does not know is as if it were 0, or is not written. A
 * newer program that sets what an older library does not know is told SEAWAY_BAD_ARGUMENT.
 *
 *     seaway_wish wish = SEAWAY_SIZED(seaway_wish);
 *     seaway_grant grant = SEAWAY_SIZED(seaway_grant);
 *     wish.fields = SEAWAY_SURFACE_FIELDS | SEAWAY_BIT(SEAWAY_FOAM);
 *     wish.error_m = 0.05;
 *     if (seaway_subscribe_to(client, &wish, &grant) != SEAWAY_OK)
 *         return complain(seaway_last_error());
 *
 *     seaway_map_wish wanted = SEAWAY_SIZED(seaway_map_wish);
 *     seaway_map map = SEAWAY_SIZED(seaway_map);
 *     wanted.time_us = seaway_now_us(client);        // cascade 0, floats
 *     wanted.channels = 4;                           // x, y, height, nothing
 *     wanted.field[0] = SEAWAY_DISPLACEMENT_X;
 *     wanted.field[1] = SEAWAY_DISPLACEMENT_Y;
 *     wanted.field[2] = SEAWAY_HEIGHT;
 *     wanted.field[3] = SEAWAY_NO_FIELD;
 *     seaway_get_map(client, &wanted, texels, sizeof(texels), &map);
 */
#ifndef SEAWAY_CLIENT_SEAWAY_ENGINE_H
#define SEAWAY_CLIENT_SEAWAY_ENGINE_H

#include "seaway.h" /* beside this file, here and where it is installed */

#ifdef __cplusplus
extern "C" {
#define SEAWAY_SIZED(type)                                                                         \
    ([] {                                                                                          \
        type sized{};                                                                              \
        sized.size = sizeof(type);                                                                 \
        return sized;                                                                              \
    }())
#else
#define SEAWAY_SIZED(type)                                                                         \
    { .size = sizeof(type) }
#endif

/* ---- what is streamed ------------------------------------------------------------------------ */

/* Maps of a cascade. Displacements are those of choppiness 1: seaway_cascade has what to multiply them by. */
enum {
    SEAWAY_HEIGHT = 0,              /* m */
    SEAWAY_DISPLACEMENT_X = 1,      /* m, east */
    SEAWAY_DISPLACEMENT_Y = 2,      /* m, north */
    SEAWAY_HEIGHT_RATE = 3,         /* m/s */
    SEAWAY_DISPLACEMENT_X_RATE = 4, /* m/s */
    SEAWAY_DISPLACEMENT_Y_RATE = 5, /* m/s */
    SEAWAY_SLOPE_X = 6,             /* d height / d x, before points are displaced */
    SEAWAY_SLOPE_Y = 7,
    SEAWAY_STRAIN_XX = 8, /* d displacement x / d x */
    SEAWAY_STRAIN_YY = 9,
    SEAWAY_STRAIN_XY = 10,
    SEAWAY_JACOBIAN = 11, /* of this cascade alone, choppiness included */
    SEAWAY_FOAM = 12, /* ratio to seaway_map.foam_mean, which says how cascades are put together */
    SEAWAY_NO_FIELD = 255 /* of seaway_map_wish: zeros */
};
#define SEAWAY_BIT(field) (UINT32_C(1) << (field))
/* All that sampling needs, and what this library makes slopes, strains and the Jacobian of: no call of it reads those where they
 * were sent, which serves programs that speak the protocol themselves. */
#define SEAWAY_SURFACE_FIELDS UINT32_C(63)

typedef struct seaway_wish {
    uint32_t size;
    uint32_t
        fields; /* sum of SEAWAY_BIT; 0: SEAWAY_SURFACE_FIELDS. With less of these there are no samples, and maps of heights, their
                 * rate and slopes where SEAWAY_HEIGHT and SEAWAY_HEIGHT_RATE are among them; foam has its maps alone, too */
    uint32_t
        cascades; /* bit c: cascade c, 0 the longest waves; 0: all. Of less, sample with seaway_looking.cascades */
    uint32_t
        size_max; /* grid points a side of a map, 32 to 2048; 0: no limit. Cut maps have no foam */
    double error_m; /* wanted bound on height on level water, up to 1e6; 0: the server chooses */
    double
        rate_hz_max;   /* as in seaway_subscription; 0: no limit. SEAWAY_REFUSED: waves need more */
    double timeout_s;  /* up to 86400; 0: 10 */
    uint32_t credit;   /* keyframes under way, 1 .. 8; 0: 2 */
    uint32_t reserved; /* 0 */
} seaway_wish;

typedef struct seaway_grant {
    uint32_t size;
    uint32_t fields;
    uint32_t cascades;
    uint32_t size_max; /* 0: maps are not cut */
    /* Bound on height that these tiles give on level water, all parts together. Answers state their own: on slopes more, as displacements
     * are off, too, and up to a quarter more while a stream begins, until differences to what was sent before have settled (a second). */
    double error_m;
    double rate_hz_max; /* 0: all there are */
    uint32_t credit;
    uint32_t reserved;
    char why[256]; /* in what it is less than the wish, as far as it fits; "": in nothing */
} seaway_grant;

/* seaway_subscribe of SEAWAY_TILES with a choice: it replaces it, and is replaced by it. NULL wish: the defaults; NULL grant: not
 * told. A field, cascade or limit that there is not is SEAWAY_BAD_ARGUMENT by its name; what the server has not is left out
 * of the grant, which says so. Blocks as seaway_subscribe. */
seaway_code seaway_subscribe_to(seaway_client* client, const seaway_wish* wish,
                                seaway_grant* grant);

/* What it gets now: a change of the sea may make it another. While the connection is lost, what it got last. SEAWAY_NOT_HELD: there
 * is none. */
seaway_code seaway_get_grant(const seaway_client* client, seaway_grant* grant);

/* ---- what there is ----------------------------------------------------------------------------- */

/* What answers come from. */
enum {
    SEAWAY_FROM_SERVER = 0,   /* seaway_query alone: nothing is held of that time */
    SEAWAY_FROM_TILES = 1,    /* keyframes */
    SEAWAY_FROM_SPECTRUM = 2, /* waves that the server sent */
    SEAWAY_FROM_PARAMETERS =
        3 /* waves made here from the scene, held against the server's probes */
};

/* Limits and state at one moment. */
typedef struct seaway_state {
    uint32_t size;
    uint32_t state;    /* SEAWAY_CONNECTED to SEAWAY_STOPPED */
    uint32_t source;   /* of the present, SEAWAY_FROM_SERVER to SEAWAY_FROM_PARAMETERS */
    uint32_t seas;     /* as in seaway_status */
    uint32_t epoch;    /* of the sea of now */
    uint32_t cascades; /* of it */
    uint32_t fields;   /* sent by the subscription to tiles, sum of SEAWAY_BIT; 0: there is none */
    uint32_t cascades_sent;    /* likewise, a bit each */
    uint32_t points_max;       /* of a seaway_ask */
    uint32_t exact_points_max; /* of an exact one */
    uint32_t questions;        /* neither taken nor cancelled */
    uint32_t questions_max;
    uint32_t credit_max;
    uint32_t size_min; /* of seaway_wish.size_max */
    uint32_t size_max;
    uint32_t reserved;
    double rate_hz_min; /* of seaway_wish.rate_hz_max */
    double rate_hz_max;
    double place_max_m;  /* coordinates, either side of 0 */
    int64_t time_max_us; /* times, either side of 0 */
    int64_t now_us;
    double error_m; /* seaway_grant's; 0: none is granted */
} seaway_state;

seaway_code seaway_get_state(seaway_client* client, seaway_state* state);

typedef struct seaway_cascade {
    uint32_t size;
    uint32_t grid;   /* points a side of a whole map */
    double length_m; /* of its tile, which repeats */
    double
        longest_wave_m; /* of its band, or one that was given by hand; infinite where nothing bounds it */
    double shortest_wave_m;
    int64_t interval_us; /* between keyframes */
    double choppiness_x; /* of all cascades, at the time asked about */
    double choppiness_y;
} seaway_cascade;

/* One of seaway_state.cascades, from 0 on, of the sea that runs at this time. */
seaway_code seaway_get_cascade(const seaway_client* client, int64_t time_us, uint32_t index,
                               seaway_cascade* cascade);

typedef struct seaway_source {
    uint32_t size;
    uint32_t source; /* SEAWAY_FROM_SERVER to SEAWAY_FROM_PARAMETERS */
    char why[244];   /* in words, as far as it fits */
} seaway_source;

/* What seaway_sample of this time would answer from: parameters before a spectrum before tiles; the same call within the same
 * stated bounds, whichever it is. That of the sea of that time: a sample that goes on with the sea before is flagged. */
seaway_code seaway_get_source(const seaway_client* client, int64_t time_us, seaway_source* source);

/* Makes the sea of this time from its scene: nothing but the scene and the probes came over the line. Of a sea that changes, where
 * it leads, too, and what it begins with. Changes that come later are followed by themselves, on a thread of the library's, from their
 * announcement on, a second or more ahead and ten as a rule; one that cannot be made is answered as if nothing were. Who is threadless or stays lost calls this again once there is another epoch ahead (seaway_sea_at of ten seconds ahead).
 * SEAWAY_NOT_HELD: it cannot be made here, is not the server's by the probes, or changes from what is not known here: seaway_hold a
 * time before the change began, and call it again. Blocks for some tenths of a second, asks nobody. */
seaway_code seaway_rebuild(seaway_client* client, int64_t time_us);

/* ---- at points ----------------------------------------------------------------------------------- */

/* Which waves count. */
typedef struct seaway_looking {
    uint32_t size;
    uint32_t
        cascades; /* bit c: cascade c; 0: all. Where the sea has none of these: SEAWAY_BAD_ARGUMENT */
    /* A hull that is L long does not feel waves that are much shorter. Cascades all of whose waves (seaway_cascade.longest_wave_m) are shorter are left out;
     * shorter waves of a cascade that has longer ones too stay: of the gale, whose first cascade ends at 53 m, 100 leaves 0.63 m rms
     * of waves below 100 m. 0 to 1e9; 0: all waves. error_m is then of the water that is left. */
    double min_wavelength_m;
} seaway_looking;

typedef struct seaway_water {
    seaway_answer answer;
    double displacement_m[2]; /* how far the water here was moved sideways, choppiness included */
    /* Bound on each of the two, to first order; infinite where the surface is about to fold. */
    double displacement_error_m;
    double jacobian; /* area here over area before: below 0 a fold; no bound is stated */
    double
        foam; /* share that is white, 0 to 1; NaN where no foam is held (SEAWAY_FOAM in seaway_wish.fields); SEAWAY_FOAM_LATE: of another time */
} seaway_water;

/* seaway_sample with all that is known of a point. `stride`: bytes from one seaway_water to the next, sizeof(seaway_water): of
 * a newer library no more than that is written. Displacement and Jacobian are NaN where the surface is folded and the
 * sheet of the answer is not found again. From tiles, and from keyframes of waves, some 3 us a point more than seaway_sample, where they are summed two to three times as long as it; allocates. NULL looking: all waves. */
seaway_code seaway_sample_water(const seaway_client* client, const seaway_looking* looking,
                                const seaway_point* points, size_t count, seaway_water* water,
                                size_t stride);

/* The water below the surface above it. */
typedef struct seaway_below {
    seaway_answer surface; /* above the point: height, normal, velocity, bound; flags of both */
    /* Of the water at the point; zero with SEAWAY_DRY. With SEAWAY_VERTICAL_VELOCITY it and the pressure are of the waves alone that have
     * water below them, not of stylised ones: zero where there are no others. */
    double velocity_mps[3];
    /* Dynamic pressure over density: times the water's density it is what presses there beside -density g z, and beside the
     * air. Zero in still water and with SEAWAY_DRY. */
    double pressure_m2ps2;
} seaway_below;

/* The water at points z_m[i] metres up from still water, so mostly below 0, of each of `count` points: velocity and dynamic
 * pressure by linear theory with Wheeler's stretching, which at the surface are seaway_answer's velocity and, without
 * surface tension, g times its height; at the sea floor water moves along it alone. Valid for waves that do not break; first
 * order in steepness, so off by some tenth of a wave's velocity where its steepness is a tenth, and without the drift of second
 * order. No bound is stated. The formulas: docs/physics.md of the source. z_m: -1e9 to 1e9, else SEAWAY_BAD_ARGUMENT.
 * From waves (SEAWAY_SPECTRUM, seaway_rebuild): keyframes alone are SEAWAY_NOT_HELD. At once; some 300 us a point of a gale;
 * allocates. NULL looking: all waves. `stride`: sizeof(seaway_below). */
seaway_code seaway_sample_below(const seaway_client* client, const seaway_looking* looking,
                                const seaway_point* points, const double* z_m, size_t count,
                                seaway_below* below, size_t stride);

/* The same by the server, at any time, as exact as seaway_query's exact answers. Blocks. */
seaway_code seaway_query_below(seaway_client* client, const seaway_looking* looking,
                               const seaway_point* points, const double* z_m, size_t count,
                               double timeout_s, seaway_below* below, size_t stride);

/* seaway_query of the waves that count: cascades that are left out are not made for it. SEAWAY_NOT_UNDERSTOOD: the server is older
 * and has answered for all waves; the answers are not written. */
seaway_code seaway_query_some(seaway_client* client, const seaway_looking* looking,
                              const seaway_point* points, size_t count, int exact, double timeout_s,
                              seaway_answer* answers);

/* Points of hulls, asked about step after step: remembers of each where its water came from, and looks there first. */
typedef struct seaway_probe seaway_probe;

/* For `count` points, 1 to 1000000; 24 bytes each. For one thread at a time, and any client. Error: SEAWAY_BAD_ARGUMENT. */
seaway_code seaway_open_probe(size_t count, seaway_probe** probe);
/* NULL is allowed. */
void seaway_close_probe(seaway_probe* probe);

/* What seaway_sample_as answers, besides height, normal, error and flags. */
enum {
    SEAWAY_WITH_VELOCITY = 0,
    SEAWAY_HEIGHT_ALONE = 1 /* velocity_mps is 0: less is looked up */
};

/* What the times of points are. */
enum {
    /* Sea times, that are what they are: the answer is of that time, and no clock has a part in its error. */
    SEAWAY_STATED_TIMES = 0,
    /* Meant as the present, or as a moment so much before or after it: made of seaway_now_us a short while ago. What that is off by
     * moves the water, so error_m has a part for it: as much as the height differs there at any moment within seaway_clock's error_us and
     * slew_us, at the sea's pace (of stylised waves that run faster than water's a guess). The answer then holds for the sea as it is at
     * that moment on the server. Three samples instead of one; five or nine where the clock is off by more than some 50 ms, 20 in short steep
     * waves. Off by more than a tenth of a peak period the part becomes several times what the water moves, and at last what any sea so high may do. */
    SEAWAY_TIMES_OF_NOW = 1
};

/* What answers, where a client has waves. Points are summed of them, some 60 us each of a gale and more where it is steep, until that
 * has taken as long as keyframes of their time would, which are then made of the waves by who asks: two a cascade at first,
 * later one an interval, 3 to 5 ms each of a gale of 256 x 256. A call makes one, or as many as take it twice as long as its sum, and sums until
 * all are there; who asks meanwhile on another thread is summed for, or waits where that is less. From these many points at
 * once take 0.5 to 1 us each in gentle seas, one alone some, and error_m has what keyframes add to it. Where sums, frame after frame, take
 * less than keyframes of the time that passes, as of one point of a gale 60 times a second, none are made. So what is asked about over
 * and over takes about twice what the cheaper way would, at most, and the water moves from one to the other within error_m. */
enum {
    SEAWAY_WAVES_FIRST = 0, /* waves, and their keyframes, though tiles have come */
    SEAWAY_TILES_FIRST = 1, /* tiles where they cover the time, else as before */
    SEAWAY_WAVES_SUMMED =
        2 /* waves, each point summed: without what keyframes add to the error, whatever it takes */
};

typedef struct seaway_sampling {
    uint32_t size;
    uint32_t parts; /* SEAWAY_WITH_VELOCITY or SEAWAY_HEIGHT_ALONE */
    /* The i-th of the points is its i-th one, in every call; no more points than it has. NULL: nothing is known of them. */
    seaway_probe* probe;
    uint32_t times;                /* SEAWAY_STATED_TIMES or SEAWAY_TIMES_OF_NOW */
    uint32_t from;                 /* SEAWAY_WAVES_FIRST to SEAWAY_WAVES_SUMMED */
    const seaway_looking* looking; /* which waves count; NULL: all */
} seaway_sampling;

/* seaway_sample in other ways; NULL how: as that. With a probe a point that moves little from call to call takes two thirds of
 * the time; answers lie as near to the solution as without one, within a fiftieth of the sea's
 * height error along the surface, but are not the same bits. Any jump is allowed. */
seaway_code seaway_sample_as(const seaway_client* client, const seaway_sampling* how,
                             const seaway_point* points, size_t count, seaway_answer* answers);

/* An answer, and what its error_m is made of: a bound on what each cause alone does to the height. Coding, time and space have nothing to
 * do with each other and are of five standard deviations each: they add up in the square. The rest is added to that:
 *
 *     error_m = sqrt(codec_m^2 + time_m^2 + space_m^2) + inverse_m + rounding_m + clock_m + stale_m
 *
 * SEAWAY_EXTRAPOLATED, SEAWAY_OPEN and SEAWAY_INVALID say of the terms what they say of error_m; of SEAWAY_INVALID they are 0. */
typedef struct seaway_terms {
    seaway_answer answer;
    double
        codec_m; /* rounding of tiles; of waves that are summed what is rounded or missing of them, or tells a made sea from the server's */
    double
        time_m; /* the curve in time between two keyframes; more where they come further apart than the sea says */
    double
        space_m; /* the curve in space between grid points; with waves that maps lack: cut by seaway_wish.size_max, or, of those made of waves, as codec_m says */
    double
        inverse_m; /* the place is met to a tolerance; and a sheet beside that may be the higher one */
    double
        rounding_m; /* single precision. Of a server that does not tell its parts all of its interpolation in time and space */
    double clock_m; /* SEAWAY_TIMES_OF_NOW: the moment is another one; else 0 */
    double stale_m; /* SEAWAY_STALE: the sea may have been changed meanwhile; else 0 */
} seaway_terms;

/* seaway_sample_as with what its errors are made of: the same answers. `stride`: bytes from one seaway_terms to the next,
 * sizeof(seaway_terms). Some tenths more than seaway_sample_as, and as little is allocated. The server's own answers (seaway_query)
 * come without. */
seaway_code seaway_sample_terms(const seaway_client* client, const seaway_sampling* how,
                                const seaway_point* points, size_t count, seaway_terms* terms,
                                size_t stride);

/* ---- whole maps ------------------------------------------------------------------------------------ */

enum { SEAWAY_FLOAT = 0, SEAWAY_HALF = 1 };

typedef struct seaway_map_wish {
    uint32_t size;
    uint32_t cascade;
    int64_t time_us;
    uint32_t type;     /* SEAWAY_FLOAT or SEAWAY_HALF, native byte order */
    uint32_t channels; /* 1 to 4 */
    uint32_t field[4]; /* of each channel: SEAWAY_HEIGHT to SEAWAY_FOAM, or SEAWAY_NO_FIELD */
    size_t row_stride; /* bytes from row to row; 0: rows follow each other */
} seaway_map_wish;

typedef struct seaway_map {
    uint32_t size;
    /* Texels a side. Texel (x, y) is the point (x, y) * length_m / grid before it is displaced; row 0 is south. In the APIs of GPUs its
     * centre lies at (x + 0.5) / grid: there the point X is at u = X / length_m + 0.5 / grid. */
    uint32_t grid;
    double length_m; /* the tile repeats at this length */
    int64_t time_us;
    /* Bound on each texel's height, rounding to half floats included, not on what a filter makes of them between texels; 0 of foam
     * alone. */
    double error_m;
    double displacement_error_m; /* likewise on each displacement, at choppiness 1 */
    uint32_t epoch;
    uint32_t flags; /* SEAWAY_EXTRAPOLATED, SEAWAY_STALE: the bounds are none then */
    size_t bytes;   /* that this wish takes */
    /* Share of the sea that is white at this time, on average. With the ratio r of each cascade's map at an undisplaced point, linear
     * between texels, clamp(foam_mean * (2 product (1 + r) / 2 - 1), 0, 1) is that of the point; 0: there is no foam. */
    double foam_mean;
} seaway_map;

/* One cascade at one time into `texels`, which has room for `bytes`; NULL: `map` alone is filled in. From keyframes that came where they cover the time, else from such as are made of
 * waves; SEAWAY_NOT_HELD without. Foam needs SEAWAY_FOAM in seaway_wish.fields. A sum of all cascades at (x, y) is the
 * undisplaced sea there, which is then moved. Some 2 ms at 256 x 256, 7 more where two keyframes are to be made of a gale's waves, of many stylised ones up to a second. Nothing beyond a row's texels is written. */
seaway_code seaway_get_map(const seaway_client* client, const seaway_map_wish* wish, void* texels,
                           size_t bytes, seaway_map* map);

/* ---- without waiting --------------------------------------------------------------------------------- */

/* Of the surface, with all waves; of the water below, and with a seaway_looking, the server is asked by calls that wait
 * (seaway_query_below, seaway_query_some). An answer is told by seaway_poll alone: seaway_watch_status has no part in it.
 *
 * Asks the server about seaway_state.points_max points at most; at once. `question` gets its number, never 0. SEAWAY_REFUSED:
 * questions_max are open. */
seaway_code seaway_ask(seaway_client* client, const seaway_point* points, size_t count, int exact,
                       double timeout_s, uint64_t* question);

/* Takes what was answered, and ends the question; at once. `count` as it was asked. SEAWAY_PENDING: it is under way. What went
 * wrong with it ends it, too: SEAWAY_LOST, SEAWAY_DEADLINE, SEAWAY_REFUSED. */
seaway_code seaway_take_answers(seaway_client* client, uint64_t question, seaway_answer* answers,
                                size_t count);

/* The answer is not wanted any more. */
seaway_code seaway_cancel(seaway_client* client, uint64_t question);

enum {
    SEAWAY_NOTHING = 0,  /* in this time */
    SEAWAY_ANSWERED = 1, /* `question` can be taken */
    SEAWAY_STATUS = 2    /* seaway_get_status says something else */
};
typedef struct seaway_event {
    uint32_t size;
    uint32_t kind;
    uint64_t question;
} seaway_event;

/* The next thing that happened, in order, for a program without callbacks: waits for one `timeout_s` at most, 0 not at all. The
 * library does its network work on a thread of its own that sleeps when there is none; nothing of the program's runs there. Of a
 * client without threads (seaway_connect_options.threadless) it is done here, in every call:
 *
 *     seaway_connect_options options = {0};
 *     options.threadless = 1;
 *     if (seaway_connect("ws://localhost:9430", &options, &client) != SEAWAY_OK)
 *         return complain(seaway_last_error());
 *     for (;;) {                                     // each frame
 *         seaway_event event = SEAWAY_SIZED(seaway_event);
 *         while (seaway_poll(client, 0, &event) == SEAWAY_OK && event.kind != SEAWAY_NOTHING)
 *             take(&event);                          // SEAWAY_ANSWERED: seaway_take_answers
 *     }
 */
seaway_code seaway_poll(seaway_client* client, double timeout_s, seaway_event* event);

/* A file descriptor that is readable while seaway_poll has something, for poll and epoll: neither read nor close it. Of a client
 * without threads also while there is something to do for it: then one seaway_poll takes it up, though it may have nothing to tell. It
 * ends with the client. -1, and seaway_last_error: there is none, now; poll() waits for nothing then, so give it 50 ms. */
int seaway_poll_descriptor(seaway_client* client);

#ifdef __cplusplus
} /* extern "C" */
#endif

/* These grow at their end alone. */
SEAWAY_HAS_SIZE(seaway_wish, 48);
SEAWAY_HAS_SIZE(seaway_grant, 296);
SEAWAY_HAS_SIZE(seaway_state, 112);
SEAWAY_HAS_SIZE(seaway_cascade, 56);
SEAWAY_HAS_SIZE(seaway_source, 252);
SEAWAY_HAS_SIZE(seaway_looking, 16);
SEAWAY_HAS_SIZE(seaway_water, 112);
SEAWAY_HAS_SIZE(seaway_below, 104);
SEAWAY_HAS_SIZE(seaway_sampling, 32);
SEAWAY_HAS_SIZE(seaway_terms, 128);
SEAWAY_HAS_SIZE(seaway_map_wish, 48);
SEAWAY_HAS_SIZE(seaway_map, 64);
SEAWAY_HAS_SIZE(seaway_event, 16);

#endif
