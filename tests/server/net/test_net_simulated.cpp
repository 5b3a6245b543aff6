// SPDX-License-Identifier: Apache-2.0
// Many sessions on a clock and on links of the test's own (simulated/crowd.h): what the server promises holds
// after every step, whatever they do.
//
// SEAWAY_SIMULATED_SEED=N test_net --gtest_filter=NetSimulated.* lives through crowd N alone, which is how a
// crowd that failed is looked at; load_sessions does so with as many as there is time for.
#include <cstdlib>

#include <gtest/gtest.h>

#include "tests/server/net/simulated/crowd.h"

namespace seaway::tests {
namespace {

using simulated::live_through;
using simulated::Outcome;

constexpr std::uint64_t crowds = 30; ///< each some 100 ms

std::vector<std::uint64_t> seeds() {
    if (const char* seed = std::getenv("SEAWAY_SIMULATED_SEED"))
        return {std::strtoull(seed, nullptr, 10)};
    std::vector<std::uint64_t> all;
    for (std::uint64_t seed = 1; seed <= crowds; ++seed)
        all.push_back(seed);
    return all;
}

TEST(NetSimulated, whatever_a_crowd_does_every_promise_is_kept_after_every_step) {
    std::map<std::string, std::uint64_t> seen;
    for (const std::uint64_t seed : seeds()) {
        const Outcome outcome = live_through(seed);
        ASSERT_TRUE(outcome.broken.empty())
            << outcome.broken << "\nSEAWAY_SIMULATED_SEED=" << seed << " lives through it again";
        for (const auto& [what, count] : outcome.seen)
            seen[what] += count;
    }
    // A crowd to which nothing happens keeps every promise.
    for (const char* what : {"Welcome",
                             "SeaState",
                             "Subscribed",
                             "Tile",
                             "QueryReply",
                             "FetchDone",
                             "Pong",
                             "Refused",
                             "streamed keyframe",
                             "Refused too_many_requests",
                             "Refused bad_value",
                             "Refused not_offered",
                             "Refused too_many_points",
                             "Ack of several",
                             "closed bad_value",
                             "closed bad_message",
                             "closed hello_expected",
                             "closed unauthorised",
                             "closed too_slow",
                             "write timeout",
                             "was there to the end"})
        EXPECT_GT(seen[what], 0u) << what;
}

TEST(NetSimulated, a_crowd_is_the_same_to_the_byte_each_time) {
    for (const std::uint64_t seed : {7u, 8u, 9u}) {
        const Outcome once = live_through(seed);
        const Outcome again = live_through(seed);
        EXPECT_EQ(once.digest, again.digest) << seed;
        EXPECT_EQ(once.seen, again.seen) << seed;
    }
    EXPECT_NE(live_through(7).digest, live_through(8).digest);
}

} // namespace
} // namespace seaway::tests
