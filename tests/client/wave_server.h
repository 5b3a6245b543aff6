// SPDX-License-Identifier: Apache-2.0
// The real net server on loopback, on a free port, over a sea that is known (wave_sea.h).
#pragma once

#include <chrono>
#include <memory>
#include <utility>

#include <gtest/gtest.h>

#include "server/net/server.h"
#include "tests/client/wave_sea.h"

namespace seaway::tests {

/// nullptr, and a failure of the test, if it does not start. The sea outlives it.
inline std::unique_ptr<server::NetServer> serve(server::Host& sea) {
    server::NetOptions options;
    options.listen = "127.0.0.1:0";
    // A machine that is busy with other things is no reason to cut a client off.
    options.write_timeout = options.idle_timeout = options.hello_deadline = std::chrono::minutes(5);
    auto started = server::NetServer::start(options, sea);
    EXPECT_TRUE(started) << started.error().message;
    return started ? *std::move(started) : nullptr;
}

/// Has one for each test.
class WaveServer : public ::testing::Test {
  protected:
    WaveSea sea;
    std::unique_ptr<server::NetServer> net;

    /// Tells all clients of a sea like that which runs, but for its epoch and its beginning.
    void announce(std::uint32_t epoch, sea::TimeUs start_us) {
        const auto first = sea.sea_state_messages().back();
        protocol::SeaStateValues state =
            protocol::values(*wire::GetMessage(first->data())->body_as_SeaState());
        state.epoch = epoch;
        state.start_time_us = start_us;
        net->announce(std::make_shared<const protocol::Bytes>(protocol::sea_state(state)));
    }

    /// The time of the sea and that of a client, read within 0.1 ms, which a busy machine does not always give.
    template <class Client>
    std::pair<sea::TimeUs, sea::TimeUs> both_times(Client& client) const {
        for (;;) {
            const sea::TimeUs truly_us = sea.sea_time_us();
            const sea::TimeUs now_us = client.now_us();
            if (sea.sea_time_us() < truly_us + 100)
                return {truly_us, now_us};
        }
    }

    void SetUp() override {
        net = serve(sea);
        ASSERT_TRUE(net);
    }
};

} // namespace seaway::tests
