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
constexpr std::size_t sampling_least = sizeof(seaway_sampling);
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

seaway_code seaway_sample_as(const seaway_client* client, const seaway_sampling* how,
                             const seaway_point* points, size_t count, seaway_answer* answers) {
    return guarded([&]() -> Result<void> {
        if (!client || (count > 0 && (!points || !answers)))
            return bad("seaway_sample_as: client, points and answers must not be null");
        SEAWAY_TRY_LET(const seaway_sampling given, sized(how, sampling_least, "seaway_sampling"));
        if (given.parts > SEAWAY_HEIGHT_ALONE)
            return bad(fmt::format("seaway_sampling.parts is {}: it must be 0 or 1", given.parts));
        Sampling some;
        if (given.parts == SEAWAY_HEIGHT_ALONE)
            some.parts = sea::AnswerParts::height;
        if (given.probe) {
            if (count > given.probe->memory.size())
                return bad(fmt::format("seaway_sample_as: {} points, and a probe for {}", count,
                                       given.probe->memory.size()));
            some.memory = std::span(given.probe->memory).first(count);
        }
        RecycledVector<sea::Answer> sampled(count); // a call that fails writes nothing
        SEAWAY_TRY(client->client->sample_into(as_points(points, count), sampled, some));
        put(sampled, answers);
        return {};
    });
}
