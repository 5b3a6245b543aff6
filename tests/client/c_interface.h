// SPDX-License-Identifier: Apache-2.0
// A server whose sea tests of the C interface ask about.
#pragma once

#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "server/net/server.h"
#include "tests/client/wave_sea.h"

namespace seaway {

class CInterface : public ::testing::Test {
  protected:
    tests::WaveSea sea_served;
    std::unique_ptr<server::NetServer> net;
    std::string url;

    void SetUp() override {
        server::NetOptions options;
        options.listen = "127.0.0.1:0";
        auto started = server::NetServer::start(options, sea_served);
        ASSERT_TRUE(started) << started.error().message;
        net = std::move(*started);
        url = net->url();
    }
};

} // namespace seaway
