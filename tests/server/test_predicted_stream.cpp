// SPDX-License-Identifier: Apache-2.0
// A real server and clients that follow its stream by differences, from its beginning and from the middle on.
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <system_error>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "client/link/connection.h"
#include "tests/server/net/clients.h"
#include "tests/support/eventually.h"
#include "tests/support/metrics_page.h"
#include "tests/support/server_process.h"

namespace seaway {
namespace {

/// A connection that keeps what it is streamed.
class Follower {
  public:
    explicit Follower(const std::string& url,
                      const protocol::TileWish& wish = {.fields = sea::surface_fields}) {
        client::ConnectionEvents events;
        events.on_keyframe = [this](const client::HeldKeyframePtr& held) {
            const std::scoped_lock lock(mutex_);
            const sea::Keyframe& map = held->keyframe();
            keyframes_[{map.cascade, map.time_us}] = held;
        };
        auto opened = client::Connection::open({.url = url, .timeout_s = 60}, std::move(events));
        EXPECT_TRUE(opened);
        connection_ = std::move(*opened);
        connection_->subscribe(wish, 2, 10, [](const auto&) {});
    }
    using Held = std::map<std::tuple<int, sea::TimeUs>, client::HeldKeyframePtr>;
    Held held() {
        const std::scoped_lock lock(mutex_);
        return keyframes_;
    }
    void wait_for(std::size_t more) {
        const std::size_t enough = held().size() + more;
        EXPECT_TRUE(tests::eventually([&] { return held().size() >= enough; }));
    }
    std::uint64_t unpredicted() const { return connection_->keyframes_unpredicted(); }

  private:
    std::mutex mutex_;
    Held keyframes_;
    std::unique_ptr<client::Connection> connection_;
};

double metric(int port, const std::string& name) {
    return tests::figure_of(tests::ask_http(port, "/metrics", "GET").body, name);
}

TEST(PredictedStream, is_whole_once_for_who_begins_and_for_who_joins_and_both_have_the_same_bits) {
    tests::ServerProcess server(
        {"scenes/north_sea_gale.toml", "--device", "native", "--listen", "127.0.0.1:0"});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    const int port = tests::port_of(url);
    Follower first(url);
    first.wait_for(30);
    Follower joins(url);
    joins.wait_for(40);
    EXPECT_EQ(first.unpredicted() + joins.unpredicted(), 0u);
    int shared = 0;
    const Follower::Held mine = first.held(), theirs = joins.held();
    for (const auto& [at, held] : theirs) {
        const auto other = mine.find(at);
        if (other == mine.end())
            continue;
        ++shared;
        const auto &a = held->keyframe().values, &b = other->second->keyframe().values;
        ASSERT_EQ(a.size(), b.size());
        EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(float)), 0)
            << "cascade " << std::get<0>(at) << " at " << std::get<1>(at);
    }
    EXPECT_GT(shared, 20);
    // Of one page: what is streamed between two would be in one figure alone.
    const std::string page = tests::ask_http(port, "/metrics", "GET").body;
    const auto count = [&](const std::string& name) { return tests::figure_of(page, name); };
    const double predicted = count("seaway_net_keyframes_predicted_total");
    EXPECT_GT(predicted, 40);
    // Three cascades of each are whole once; a machine that is busy may leave keyframes out, also for want of time to make
    // them, and what comes after each such is whole for both.
    EXPECT_LE(count("seaway_net_keyframes_sent_total") - predicted,
              6 + 3 * count("seaway_net_keyframes_replaced_total") +
                  2 * count("seaway_net_keyframes_dropped_total") +
                  2 * count("seaway_keyframes_skipped_total"))
        << page;
}

/// A session that wants all fields of whole or of compact maps, which are encoded for it at its own bound, and acknowledges none.
class WantsItsOwn {
  public:
    WantsItsOwn(int port, float error_m, bool compact) : client_(port) {
        EXPECT_FALSE(client_.connect());
        EXPECT_TRUE(client_.greet());
        EXPECT_FALSE(client_.send(protocol::subscribe(
            1, {.fields = sea::all_fields, .error_m = error_m, .compact = compact}, 1)));
        const wire::Message* granted = client_.receive(wire::Body::Subscribed);
        EXPECT_TRUE(granted);
        granted_m_ = granted != nullptr ? granted->body_as_Subscribed()->error_m() : 0;
        thread_ = std::thread([this] {
            while (client_.receive() != nullptr || client_.error() == std::errc::timed_out)
                continue;
        });
    }
    /// Once its server has ended.
    ~WantsItsOwn() { thread_.join(); }
    WantsItsOwn(const WantsItsOwn&) = delete;
    WantsItsOwn& operator=(const WantsItsOwn&) = delete;
    float granted_m() const { return granted_m_; }

  private:
    tests::Client client_;
    float granted_m_ = 0;
    std::thread thread_;
};

// Naive: a keyframe takes its room anew for each rung, in order, and there is some for five. Who has the rung that is named last, as
// all who are predicted have, is sent nothing as soon as others want all fields, each at a bound of their own.
TEST(PredictedStream, misses_nothing_where_others_want_all_fields_at_bounds_of_their_own) {
    std::vector<std::unique_ptr<WantsItsOwn>> others; // that go when their server has ended
    tests::ServerProcess server(
        {"scenes/north_sea_gale.toml", "--device", "native", "--listen", "127.0.0.1:0"});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    const int port = tests::port_of(url);
    std::set<std::pair<bool, float>> rungs;
    for (const bool compact : {false, true})
        for (const float error_m : {0.01f, 0.02f, 0.04f, 0.08f}) {
            others.push_back(std::make_unique<WantsItsOwn>(port, error_m, compact));
            rungs.emplace(compact, others.back()->granted_m());
        }
    ASSERT_GE(rungs.size(), 6u);
    Follower last(url);
    last.wait_for(1);
    const std::size_t had = last.held().size();
    const double published = metric(port, "seaway_net_keyframes_published_total");
    last.wait_for(40);
    const double all = metric(port, "seaway_net_keyframes_published_total") - published;
    const auto own = static_cast<double>(last.held().size() - had);
    ASSERT_GT(all - own, own) << "the others take theirs";
    EXPECT_GE(own, 0.5 * (all - own) / static_cast<double>(rungs.size()))
        << "of " << all << " that were encoded, of " << rungs.size() << " other kinds";
}

// From where the device made them to the encoder and to answers; a GPU whose memory no processor reads copies each once.
TEST(PredictedStream, of_a_device_whose_memory_is_read_in_place_copies_no_keyframe) {
    tests::ServerProcess server(
        {"scenes/north_sea_gale.toml", "--device", "0", "--listen", "127.0.0.1:0"});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    Follower(url).wait_for(30);
    const int port = tests::port_of(url);
    const double keyframes = metric(port, "seaway_keyframes_total");
    EXPECT_GE(keyframes, 30);
    if (server.log().find("llvmpipe") != std::string::npos) {
        EXPECT_EQ(metric(port, "seaway_keyframes_copied_total"), 0);
    }
}

} // namespace
} // namespace seaway
