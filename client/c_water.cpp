// SPDX-License-Identifier: Apache-2.0
// The C interface for engines over Client: water at points and below them, of the waves that count (seaway_engine.h).
#include <cmath>

#include "client/c_api.h"
#include "protocol/limits.h"

using namespace seaway;
using namespace seaway::client;
using namespace seaway::client::c;

namespace {

/// What the struct began with; all that follows may be missing.
constexpr std::size_t looking_least = offsetof(seaway_looking, min_wavelength_m);

} // namespace

Result<Looking> seaway::client::c::looking_of(const seaway_looking* looking) {
    SEAWAY_TRY_LET(const seaway_looking given, sized(looking, looking_least, "seaway_looking"));
    SEAWAY_TRY(in_range("seaway_looking.min_wavelength_m", given.min_wavelength_m, 0,
                        protocol::limits::position_m_max));
    Looking some{.min_wavelength_m = given.min_wavelength_m};
    if (given.cascades != 0)
        some.cascades = given.cascades;
    return some;
}

namespace {

void put_below(const Below& found, seaway_below* below, std::size_t stride) {
    Out<seaway_below> out(below, stride);
    for (std::size_t i = 0; i < found.answers.size(); ++i) {
        seaway_below one{};
        put({&found.answers[i], 1}, &one.surface);
        for (int axis = 0; axis < 3; ++axis)
            one.velocity_mps[axis] = found.water[i].velocity_mps[axis];
        one.pressure_m2ps2 = found.water[i].pressure_m2ps2;
        out.put(one);
    }
}

/// `find` gets points, depths and which waves count.
template <class Find>
seaway_code below_of(const char* call, const seaway_client* client, const seaway_looking* looking,
                     const seaway_point* points, const double* z_m, size_t count,
                     seaway_below* below, size_t stride, const Find& find) {
    return guarded([&]() -> Result<void> {
        SEAWAY_TRY(points_given(call, client, points, count, below, "below"));
        if (count > 0 && !z_m)
            return bad(fmt::format("{}: z_m must not be null", call));
        SEAWAY_TRY_LET(const Looking some, looking_of(looking));
        SEAWAY_TRY(stride_fits(stride, call, "seaway_below"));
        for (std::size_t i = 0; i < count; ++i)
            // What is no number is answered as such.
            if (std::isfinite(z_m[i]) && std::abs(z_m[i]) > protocol::limits::position_m_max)
                return bad(fmt::format("{}: z_m[{}] is {}, allowed are {} to {}", call, i, z_m[i],
                                       -protocol::limits::position_m_max,
                                       protocol::limits::position_m_max));
        SEAWAY_TRY_LET(const Below found,
                       find(as_points(points, count), std::span(z_m, count), some));
        put_below(found, below, stride);
        return {};
    });
}

} // namespace

seaway_code seaway_sample_water(const seaway_client* client, const seaway_looking* looking,
                                const seaway_point* points, size_t count, seaway_water* water,
                                size_t stride) {
    return guarded([&]() -> Result<void> {
        SEAWAY_TRY(points_given("seaway_sample_water", client, points, count, water, "water"));
        SEAWAY_TRY_LET(const Looking some, looking_of(looking));
        SEAWAY_TRY(stride_fits(stride, "seaway_sample_water", "seaway_water"));
        SEAWAY_TRY_LET(const std::vector<Water> found,
                       client->client->look(as_points(points, count), some));
        Out<seaway_water> out(water, stride);
        for (const Water& from : found) {
            seaway_water one{};
            put({&from.answer, 1}, &one.answer);
            one.displacement_m[0] = from.displacement_m[0];
            one.displacement_m[1] = from.displacement_m[1];
            one.displacement_error_m = from.displacement_error_m;
            one.jacobian = from.jacobian;
            one.foam = from.foam;
            out.put(one);
        }
        return {};
    });
}

seaway_code seaway_sample_below(const seaway_client* client, const seaway_looking* looking,
                                const seaway_point* points, const double* z_m, size_t count,
                                seaway_below* below, size_t stride) {
    return below_of("seaway_sample_below", client, looking, points, z_m, count, below, stride,
                    [&](auto asked, auto depths, const Looking& some) {
                        return client->client->below(asked, depths, some);
                    });
}

seaway_code seaway_query_below(seaway_client* client, const seaway_looking* looking,
                               const seaway_point* points, const double* z_m, size_t count,
                               double timeout_s, seaway_below* below, size_t stride) {
    return below_of("seaway_query_below", client, looking, points, z_m, count, below, stride,
                    [&](auto asked, auto depths, const Looking& some) -> Result<Below> {
                        SEAWAY_TRY_LET(const double patience_s,
                                       patience("seaway_query_below: timeout_s", timeout_s));
                        return client->client->ask_below(asked, depths, {true, patience_s, some});
                    });
}

seaway_code seaway_query_some(seaway_client* client, const seaway_looking* looking,
                              const seaway_point* points, size_t count, int exact, double timeout_s,
                              seaway_answer* answers) {
    return guarded([&]() -> Result<void> {
        SEAWAY_TRY(points_given("seaway_query_some", client, points, count, answers, "answers"));
        SEAWAY_TRY_LET(const double patience_s,
                       patience("seaway_query_some: timeout_s", timeout_s));
        SEAWAY_TRY_LET(const Looking some, looking_of(looking));
        SEAWAY_TRY_LET(
            const std::vector<sea::Answer> found,
            client->client->ask(as_points(points, count), {exact != 0, patience_s, some}));
        put(found, answers);
        return {};
    });
}
