// SPDX-License-Identifier: Apache-2.0
// The client behind a line that flips bits (tests/support/fault_proxy.h): it is told, or the bit was one that nothing
// tells from another one; it is never wrong about what it says is right, and never ends the process.
#include <gtest/gtest.h>

#include "client/client.h"
#include "tests/client/wave_server.h"
#include "tests/support/draw.h"
#include "tests/support/fault_proxy.h"

namespace seaway::client {
namespace {

using sea::QueryPoint;
using tests::Draw;
using tests::FaultProxy;

class LiveFaults : public tests::WaveServer {};

TEST_F(LiveFaults, a_flipped_bit_ends_the_connection_with_a_reason_or_is_no_samples) {
    FaultProxy line(net->port());
    const std::string url = "ws://127.0.0.1:" + std::to_string(line.port());
    const QueryPoint points[] = {{1, 2, 5'050'000}, {-30, 7, 5'150'000}};
    Draw draw(21);
    int ended = 0;
    for (int i = 0; i < 80; ++i) {
        // The upgrade, the announcement of the sea, and some twenty tiles.
        line.flip_next_at(FaultProxy::Way::to_client, draw.below(25'000),
                          static_cast<unsigned>(draw.below(8)));
        const auto client = Client::connect({.url = url, .timeout_s = 1, .stays_lost = true});
        if (!client) {
            EXPECT_FALSE(client.error().message.empty());
            ++ended;
            continue;
        }
        const auto answers = (*client)->fetch_and_sample(points, 1);
        if (answers)
            continue; // of a bit of the sea's description, or of one that was not reached
        EXPECT_FALSE(answers.error().message.empty());
        ended += (*client)->is_open() ? 0 : 1;
        EXPECT_NE((*client)->is_open(), !(*client)->closed_reason().empty());
    }
    EXPECT_GT(ended, 20);
    const auto well = Client::connect({.url = url, .timeout_s = 60, .stays_lost = true});
    ASSERT_TRUE(well) << well.error().message;
    const auto answers = (*well)->fetch_and_sample(points, 60);
    ASSERT_TRUE(answers) << answers.error().message;
    for (std::size_t i = 0; i < std::size(points); ++i)
        EXPECT_NEAR((*answers)[i].height_m, sea.truth(points[i]).height_m, (*answers)[i].error_m);
}

TEST_F(LiveFaults, a_line_that_breaks_anywhere_is_said_and_what_is_held_stays) {
    FaultProxy line(net->port());
    const std::string url = "ws://127.0.0.1:" + std::to_string(line.port());
    const QueryPoint point{1, 2, 5'050'000};
    Draw draw(22);
    int broken = 0;
    for (int i = 0; i < 40; ++i) {
        line.cut_next_after(FaultProxy::Way::to_client, draw.below(25'000));
        const auto client = Client::connect({.url = url, .timeout_s = 5, .stays_lost = true});
        const auto answers = client ? (*client)->fetch_and_sample({&point, 1}, 5)
                                    : Result<std::vector<sea::Answer>>(client.error());
        if (answers) {
            EXPECT_NEAR((*answers)[0].height_m, sea.truth(point).height_m, (*answers)[0].error_m);
            EXPECT_TRUE((*client)->sample({&point, 1})) << "what is held can still be sampled";
        } else {
            EXPECT_FALSE(answers.error().message.empty());
            ++broken;
        }
    }
    EXPECT_GT(broken, 10);
}

} // namespace
} // namespace seaway::client
