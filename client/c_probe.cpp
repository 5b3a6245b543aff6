// SPDX-License-Identifier: Apache-2.0
// The C interface for engines over Client: points of hulls, sampled step after step (seaway_engine.h).
#include <vector>

#include <fmt/format.h>

#include "base/recycled.h"
#include "client/c_api.h"

using namespace seaway;
using namespace seaway::client;
using namespace seaway::client::c;

namespace {

/// What the struct began with.
constexpr std::size_t sampling_least = offsetof(seaway_sampling, times);
constexpr std::size_t probe_points_max = 1'000'000;

} // namespace

struct seaway_probe {
    std::vector<sea::PointMemory> memory;
};

seaway_code seaway_open_probe(size_t count, seaway_probe** probe) {
    return guarded([&]() -> Result<void> {
        if (!probe)
            return bad("seaway_open_probe: probe must not be null");
        if (count < 1 || count > probe_points_max)
            return bad(fmt::format("seaway_open_probe: count is {}: it must be 1 to {}", count,
                                   probe_points_max));
        *probe = new seaway_probe{std::vector<sea::PointMemory>(count)};
        return {};
    });
}

void seaway_close_probe(seaway_probe* probe) {
    delete probe;
}

namespace {

/// Answers into memory of the thread: a call that fails writes nothing.
Result<void> sample_as(const seaway_client& client, const seaway_sampling* how,
                       std::span<const sea::QueryPoint> points,
                       RecycledVector<sea::Answer>& answers, std::span<sea::ErrorTerms> terms) {
    SEAWAY_TRY_LET(const seaway_sampling given, sized(how, sampling_least, "seaway_sampling"));
    if (given.parts > SEAWAY_HEIGHT_ALONE)
        return bad(fmt::format("seaway_sampling.parts is {}: it must be 0 or 1", given.parts));
    if (given.times > SEAWAY_TIMES_OF_NOW)
        return bad(fmt::format("seaway_sampling.times is {}: it must be 0 or 1", given.times));
    if (given.from > SEAWAY_WAVES_SUMMED)
        return bad(fmt::format("seaway_sampling.from is {}: it must be 0 to 2", given.from));
    Sampling some;
    SEAWAY_TRY_LET(some.looking, looking_of(given.looking));
    some.terms = terms;
    some.of_now = given.times == SEAWAY_TIMES_OF_NOW;
    some.keyframes_first = given.from == SEAWAY_TILES_FIRST;
    some.summed = given.from == SEAWAY_WAVES_SUMMED;
    if (given.parts == SEAWAY_HEIGHT_ALONE)
        some.parts = sea::AnswerParts::height;
    if (given.probe) {
        if (points.size() > given.probe->memory.size())
            return bad(fmt::format("seaway_sampling: {} points, and a probe for {}", points.size(),
                                   given.probe->memory.size()));
        some.memory = std::span(given.probe->memory).first(points.size());
    }
    answers.resize(points.size());
    return client.client->sample_into(points, answers, some);
}

} // namespace

seaway_code seaway_sample_as(const seaway_client* client, const seaway_sampling* how,
                             const seaway_point* points, size_t count, seaway_answer* answers) {
    return guarded([&]() -> Result<void> {
        SEAWAY_TRY(points_given("seaway_sample_as", client, points, count, answers, "answers"));
        RecycledVector<sea::Answer> sampled;
        SEAWAY_TRY(sample_as(*client, how, as_points(points, count), sampled, {}));
        put(sampled, answers);
        return {};
    });
}

seaway_code seaway_sample_terms(const seaway_client* client, const seaway_sampling* how,
                                const seaway_point* points, size_t count, seaway_terms* terms,
                                size_t stride) {
    return guarded([&]() -> Result<void> {
        SEAWAY_TRY(points_given("seaway_sample_terms", client, points, count, terms, "terms"));
        SEAWAY_TRY(stride_fits(stride, "seaway_sample_terms", "seaway_terms"));
        RecycledVector<sea::Answer> sampled;
        RecycledVector<sea::ErrorTerms> made_of(count);
        SEAWAY_TRY(sample_as(*client, how, as_points(points, count), sampled, made_of));
        Out<seaway_terms> out(terms, stride);
        for (size_t i = 0; i < count; ++i) {
            const sea::ErrorTerms& from = made_of[i];
            seaway_terms one{};
            put({&sampled[i], 1}, &one.answer);
            one.codec_m = from.codec_m;
            one.time_m = from.time_m;
            one.space_m = from.space_m;
            one.inverse_m = from.inverse_m;
            one.rounding_m = from.rounding_m;
            one.clock_m = from.clock_m;
            one.stale_m = from.stale_m;
            out.put(one);
        }
        return {};
    });
}
