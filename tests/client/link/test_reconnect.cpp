// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "client/link/reconnect.h"

namespace seaway::client {
namespace {

Error asks_to_stay_away(std::uint32_t wait_ms) {
    Error why("the server stops");
    why.retry_after_ms = wait_ms;
    return why;
}

TEST(ReconnectPauses, nobody_comes_before_the_time_that_the_server_named_nor_after_twice_of_it) {
    for (const std::uint32_t wait_ms : {1u, 2000u, 3'600'000u})
        for (std::uint64_t seed = 0; seed < 1000; ++seed) {
            const double wait_s = ReconnectPauses(seed).next(asks_to_stay_away(wait_ms)).count();
            EXPECT_GE(wait_s, wait_ms / 1e3);
            EXPECT_LE(wait_s, 2 * wait_ms / 1e3);
        }
}

// Of 1000 that were told 5 s: 200 a second. Numbers in a second are binomial, sigma below 13; five of them.
TEST(ReconnectPauses, a_thousand_clients_come_back_spread_over_their_window) {
    std::vector<int> in_second(5, 0);
    for (int client = 0; client < 1000; ++client) {
        const double wait_s = ReconnectPauses().next(asks_to_stay_away(5000)).count();
        ++in_second.at(std::min<std::size_t>(4, static_cast<std::size_t>(wait_s - 5)));
    }
    for (const int count : in_second)
        EXPECT_NEAR(count, 200, 65);
}

TEST(ReconnectPauses, without_a_word_they_grow_to_sixteen_seconds_and_half_as_much) {
    ReconnectPauses pauses(3);
    const Error lost("the line broke");
    for (const double least_s : {0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 16.0, 16.0}) {
        const double wait_s = pauses.next(lost).count();
        EXPECT_GE(wait_s, least_s);
        EXPECT_LE(wait_s, 1.5 * least_s);
    }
    pauses.connected();
    EXPECT_LE(pauses.next(lost).count(), 0.75) << "it stood meanwhile";
}

TEST(ReconnectPauses, clients_of_a_server_that_was_killed_do_not_come_in_one_instant) {
    std::set<double> waits;
    for (int client = 0; client < 100; ++client)
        waits.insert(ReconnectPauses().next(Error{"the line broke"}).count());
    EXPECT_EQ(waits.size(), 100u);
}

} // namespace
} // namespace seaway::client
