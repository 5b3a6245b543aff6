// SPDX-License-Identifier: Apache-2.0
// The C interface where counts are absurd and memory is out.
#include <cstdint>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "client/seaway.hpp"
#include "client/seaway_engine.h"
#include "tests/client/c_interface.h"
#include "tests/support/allocations.h"

namespace seaway {
namespace {

// Naive: a size that wrapped is asked of the heap, whose own words come back.
TEST_F(CInterface, a_count_that_nobody_means_is_refused_by_name) {
    Sea sea(url);
    const seaway_point point{1, 2, 3};
    const double z_m = -1;
    const std::int64_t time_us = 3;
    seaway_answer answer{};
    seaway_terms terms{};
    seaway_water water{};
    seaway_below below{};
    seaway_client* client = sea.handle();
    for (const std::size_t count : {std::size_t{1} << 32, std::size_t{1} << 58, ~std::size_t{0}}) {
        const auto refused = [&](const char* call, seaway_code code) {
            EXPECT_EQ(code, SEAWAY_BAD_ARGUMENT) << call;
            EXPECT_EQ(seaway_last_error(),
                      fmt::format("{}: count is {}: it must be 0 to 4294967295", call, count));
        };
        refused("seaway_query", seaway_query(client, &point, count, 0, 1, &answer));
        refused("seaway_hold", seaway_hold(client, &time_us, count, 1));
        refused("seaway_sample", seaway_sample(client, &point, count, &answer));
        refused("seaway_sample_as", seaway_sample_as(client, nullptr, &point, count, &answer));
        refused("seaway_sample_terms",
                seaway_sample_terms(client, nullptr, &point, count, &terms, sizeof terms));
        refused("seaway_sample_water",
                seaway_sample_water(client, nullptr, &point, count, &water, sizeof water));
        refused("seaway_query_some",
                seaway_query_some(client, nullptr, &point, count, 0, 1, &answer));
        refused("seaway_sample_below",
                seaway_sample_below(client, nullptr, &point, &z_m, count, &below, sizeof below));
        refused("seaway_query_below",
                seaway_query_below(client, nullptr, &point, &z_m, count, 1, &below, sizeof below));
    }
}

// Naive: an exception goes through C. Each of the first hundred allocations of each call finds no memory, once; the call says so or does
// without, and the next one works.
TEST_F(CInterface, without_memory_a_call_fails_with_a_code_and_the_next_one_works) {
    Sea sea(url);
    seaway_client* client = sea.handle();
    const seaway_point point{1, 2, 5'010'000};
    const double z_m = -1;
    sea.hold({point.time_us});
    seaway_subscription waves{};
    waves.rung = SEAWAY_SPECTRUM;
    sea.subscribe(waves);
    seaway_answer answer{};
    seaway_water water{};
    seaway_below below{};
    std::uint64_t question = 0;
    int failed = 0;
    const auto each = [&](const char* name, const auto& call) {
        for (std::size_t after = 0; after < 100; ++after) {
            seaway_code code = SEAWAY_OK;
            {
                const tests::NoMemoryOnce none(after);
                code = call();
            }
            EXPECT_TRUE(code == SEAWAY_OK || code == SEAWAY_INTERNAL)
                << name << ' ' << after << ": " << code << ' ' << seaway_last_error();
            failed += code == SEAWAY_INTERNAL;
            ASSERT_EQ(seaway_sample(client, &point, 1, &answer), SEAWAY_OK) << name << ' ' << after;
        }
        EXPECT_EQ(call(), SEAWAY_OK) << name << ": " << seaway_last_error();
    };
    each("query", [&] { return seaway_query(client, &point, 1, 0, 5, &answer); });
    each("sample", [&] { return seaway_sample(client, &point, 1, &answer); });
    each("water",
         [&] { return seaway_sample_water(client, nullptr, &point, 1, &water, sizeof water); });
    each("below", [&] {
        return seaway_sample_below(client, nullptr, &point, &z_m, 1, &below, sizeof below);
    });
    each("hold", [&] { return seaway_hold(client, &point.time_us, 1, 5); });
    each("ask", [&] {
        const seaway_code code = seaway_ask(client, &point, 1, 0, 5, &question);
        if (code == SEAWAY_OK)
            seaway_cancel(client, question);
        return code;
    });
    EXPECT_GT(failed, 50);
}

} // namespace
} // namespace seaway
