// SPDX-License-Identifier: Apache-2.0
// A NetServer in front of a small explicit sea.
#pragma once

#include <atomic>
#include <chrono>
#include <cmath>
#include <map>
#include <mutex>
#include <set>
#include <sstream>
#include <thread>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include "protocol/messages.h"
#include "protocol/tile_codec.h"
#include "server/net/server.h"
#include "tests/server/net/clients.h"
#include "tests/server/simulation/small_sea.h"
#include "tests/support/eventually.h"
#include "tests/support/folder.h"
#include "tests/support/metrics_page.h"

namespace seaway::tests {

/// spdlog's lines while it lives.
class LogCapture {
  public:
    LogCapture() : before_(spdlog::default_logger()) {
        spdlog::set_default_logger(std::make_shared<spdlog::logger>("test", lines_));
    }
    ~LogCapture() { spdlog::set_default_logger(before_); }
    LogCapture(const LogCapture&) = delete;
    LogCapture& operator=(const LogCapture&) = delete;

    /// Lines that contain both.
    std::vector<std::string> lines_with(std::string_view a, std::string_view b = "") const {
        std::vector<std::string> found;
        std::istringstream in(text());
        for (std::string line; std::getline(in, line);)
            if (line.find(a) != std::string::npos && line.find(b) != std::string::npos)
                found.push_back(line);
        return found;
    }
    std::string text() const { return lines_->text(); }

  private:
    /// Read while others write.
    class Lines final : public spdlog::sinks::base_sink<std::mutex> {
      public:
        std::string text() {
            const std::scoped_lock lock(mutex_);
            return text_;
        }

      private:
        void sink_it_(const spdlog::details::log_msg& message) override {
            spdlog::memory_buf_t line;
            formatter_->format(message, line);
            text_.append(line.data(), line.size());
        }
        void flush_() override {}
        std::string text_;
    };
    const std::shared_ptr<Lines> lines_ = std::make_shared<Lines>();
    std::shared_ptr<spdlog::logger> before_;
};

/// Heights of the first cascade.
inline const protocol::TileWish heights{.cascades = 1u, .fields = {sea::Field::height}};

/// The server under test; options that make waiting short.
class NetTest : public ::testing::Test {
  protected:
    NetTest() {
        options.listen = "127.0.0.1:0";
        options.hello_deadline = std::chrono::minutes(5); // a busy machine says hello late
    }
    std::unique_ptr<Client> greeted(std::string_view token = "") {
        auto client = std::make_unique<Client>(port());
        EXPECT_FALSE(client->connect());
        EXPECT_TRUE(client->greet(token));
        return client;
    }
    void start() {
        auto started = server::NetServer::start(options, host);
        ASSERT_TRUE(started.has_value()) << (started ? "" : started.error().message);
        net = std::move(*started);
    }
    int port() const { return net->port(); }

    /// Publishes keyframe n of both cascades.
    void publish(std::int64_t n, sea::FieldSet fields = {sea::Field::height}) {
        host.newest = n;
        for (int cascade = 0; cascade < 2; ++cascade)
            net->publish(host.keyframe(cascade, n, fields));
    }

    HttpAnswer get(const std::string& target, const std::string& method = "GET") {
        return ask_http(port(), target, method);
    }

    /// The value of a metric, -1 if it is not there.
    double metric(const std::string& name) { return figure_of(get("/metrics").body, name); }

    /// The next message refuses this request.
    void expect_refused(Client& client, std::uint32_t request_id, wire::ErrorCode code,
                        std::string_view why) {
        const wire::Message* message = client.receive();
        ASSERT_TRUE(message && message->body_as_Refused());
        EXPECT_EQ(message->body_as_Refused()->request_id(), request_id);
        EXPECT_EQ(message->body_as_Refused()->code(), code);
        EXPECT_NE(message->body_as_Refused()->message()->string_view().find(why), std::string::npos)
            << message->body_as_Refused()->message()->string_view();
    }

    LogCapture log;
    SmallSea host;
    server::NetOptions options;
    std::unique_ptr<server::NetServer> net;
};

} // namespace seaway::tests
