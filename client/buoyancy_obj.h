/* SPDX-License-Identifier: Apache-2.0 */
/* Part of seaway/buoyancy.h: meshes from OBJ files. Numbers are read here, since those of the C library depend on the
 * user's language. */
#ifndef SEAWAY_CLIENT_BUOYANCY_OBJ_H
#define SEAWAY_CLIENT_BUOYANCY_OBJ_H

#include "buoyancy.h"

/* A line, and where reading it has come to. */
typedef struct seaway_words {
    const char* at;
    const char* end;
} seaway_words;

static inline int seaway_is_digit(const seaway_words* words) {
    return words->at < words->end && *words->at >= '0' && *words->at <= '9';
}

/* Takes the character, if it stands here. */
static inline int seaway_take(seaway_words* words, char character) {
    const int here = words->at < words->end && *words->at == character;
    words->at += here;
    return here;
}

/* Takes blanks; 1 if a word follows: a comment is none. */
static inline int seaway_next_word(seaway_words* words) {
    while (seaway_take(words, ' ') || seaway_take(words, '\t')) {
    }
    return words->at < words->end && *words->at != '#';
}

static inline int seaway_word_ends(const seaway_words* words) {
    return words->at == words->end || *words->at == ' ' || *words->at == '\t' || *words->at == '#';
}

/* A whole number, at most 2^31; 0 if there is none. */
static inline int seaway_take_whole(seaway_words* words, int64_t* value) {
    const int negative = seaway_take(words, '-');
    const char* first = words->at;
    for (*value = 0; seaway_is_digit(words) && *value <= INT32_MAX; ++words->at)
        *value = 10 * *value + (*words->at - '0');
    *value = negative ? -*value : *value;
    return words->at > first && !seaway_is_digit(words);
}

/* -12.5e-3; right to a few units of the last place of a double. */
static inline int seaway_take_number(seaway_words* words, double* value) {
    const int negative = seaway_take(words, '-');
    int digits = 0, tens = 0;
    int64_t exponent = 0;
    *value = 0;
    (void)(negative || seaway_take(words, '+'));
    for (; seaway_is_digit(words); ++words->at, ++digits)
        *value = 10 * *value + (*words->at - '0');
    if (seaway_take(words, '.'))
        for (; seaway_is_digit(words); ++words->at, ++digits, --tens)
            *value = 10 * *value + (*words->at - '0');
    if (seaway_take(words, 'e') || seaway_take(words, 'E')) {
        const int positive = seaway_take(words, '+');
        if (!seaway_take_whole(words, &exponent) || exponent > 400 ||
            exponent < (positive ? 0 : -400))
            return 0;
    }
    for (int64_t i = exponent + tens; i != 0; i += i > 0 ? -1 : 1)
        *value = i > 0 ? *value * 10 : *value / 10;
    *value = negative ? -*value : *value;
    return digits > 0 && digits < 400 && *value > -HUGE_VAL && *value < HUGE_VAL;
}

/* v, v/vt, v//vn, v/vt/vn: the vertex, from 0. */
static inline int seaway_take_corner(seaway_words* words, size_t vertex_count, uint32_t* corner) {
    int64_t number = 0, other = 0;
    const int64_t count =
        vertex_count <= INT32_MAX ? vertex_count : 0; /* no cast: it would be of one language */
    if (!seaway_take_whole(words, &number))
        return 0;
    while (seaway_take(words, '/'))
        (void)seaway_take_whole(words, &other);
    number = number < 0 ? count + number : number - 1;
    *corner = number >= 0 && number < count ? number : 0;
    return number >= 0 && number < count;
}

static inline int seaway_obj_vertex(seaway_words* words, seaway_obj* mesh) {
    double place[3];
    for (int i = 0; i < 3; ++i)
        if (!seaway_next_word(words) || !seaway_take_number(words, &place[i]) ||
            !seaway_word_ends(words))
            return 0;
    for (size_t i = 0; mesh->vertices_m && mesh->vertex_count < mesh->vertex_room && i < 3; ++i)
        mesh->vertices_m[3 * mesh->vertex_count + i] = place[i];
    ++mesh->vertex_count;
    return 1;
}

static inline int seaway_obj_face(seaway_words* words, seaway_obj* mesh) {
    uint32_t fan[3] = {0, 0, 0};
    size_t corners = 0;
    for (; seaway_next_word(words); ++corners) {
        fan[1] = fan[2];
        if (!seaway_take_corner(words, mesh->vertex_count, &fan[2]) || !seaway_word_ends(words))
            return 0;
        if (corners == 0)
            fan[0] = fan[2];
        if (corners < 2)
            continue;
        for (size_t i = 0; mesh->triangles && mesh->triangle_count < mesh->triangle_room && i < 3;
             ++i)
            mesh->triangles[3 * mesh->triangle_count + i] = fan[i];
        ++mesh->triangle_count;
    }
    return corners >= 3;
}

static inline seaway_code seaway_read_obj(const char* text, size_t length, seaway_obj* mesh) {
    const char* end = text + length;
    mesh->vertex_count = mesh->triangle_count = mesh->line = 0;
    if (length >= 3 && text[0] == '\xef' && text[1] == '\xbb' &&
        text[2] == '\xbf') /* some editors' mark */
        text += 3;
    while (text < end) {
        seaway_words words = {text, text};
        while (words.end < end && *words.end != '\n' && *words.end != '\r')
            ++words.end;
        text = words.end + (words.end < end);
        if (text < end && text[-1] == '\r' && *text == '\n')
            ++text;
        ++mesh->line;
        if (!seaway_next_word(&words))
            continue;
        const char kind = *words.at++;
        const int alone = words.at == words.end || *words.at == ' ' || *words.at == '\t';
        const int fine = !alone        ? 1
                         : kind == 'v' ? seaway_obj_vertex(&words, mesh)
                         : kind == 'f' ? seaway_obj_face(&words, mesh)
                                       : 1;
        if (!fine)
            return SEAWAY_BAD_ARGUMENT;
    }
    return SEAWAY_OK;
}

#endif
