// SPDX-License-Identifier: Apache-2.0
// A server behind a bad line (tests/support/fault_proxy.h): lines that break anywhere, flip bits, are slow.
// What happens to one session happens to no other one.
#include "tests/server/net/net_fixture.h"

#include <numeric>

#include "protocol/limits.h"
#include "tests/support/draw.h"
#include "tests/support/fault_proxy.h"
#include "tests/support/metrics_page.h"

namespace seaway::tests {
namespace {

using namespace std::chrono_literals;
using Way = FaultProxy::Way;

class NetFaults : public NetTest {
  protected:
    /// Says what clients say, as far as the line lets it; true: a Ping was answered at the end.
    bool live_through(int at_port) {
        Client client(at_port);
        if (client.connect())
            return false;
        const sea::QueryPoint points[4] = {};
        const sea::TimeUs times[] = {0, 200'000};
        for (const protocol::Bytes& message :
             {protocol::hello("faults", ""), protocol::subscribe(1, heights, 2),
              protocol::query(2, points, false), protocol::fetch(3, times, heights),
              protocol::ping(last_id, 0)})
            if (client.send(message))
                return false;
        while (const wire::Message* message = client.receive(300ms))
            if (const auto* pong = message->body_as_Pong())
                return pong->request_id() == last_id;
        return false;
    }

    /// The neighbour, on a line of its own, is sent what is published and answered.
    void expect_well(Client& neighbour) {
        publish(++published_);
        ASSERT_FALSE(neighbour.send(protocol::ping(4, 0)));
        bool streamed = false;
        bool answered = false;
        while (!streamed || !answered) {
            const wire::Message* message = neighbour.receive();
            ASSERT_NE(message, nullptr);
            answered = answered || message->body_as_Pong() != nullptr;
            const wire::Tile* tile = message->body_as_Tile();
            streamed = streamed || (tile != nullptr && tile->time_us() == published_ * interval_us);
            if (tile != nullptr)
                (void)neighbour.send(protocol::ack(tile->keyframe()));
        }
    }

    /// All sessions but the neighbour's are gone, each for a reason, with what they held.
    void expect_gone() {
        EXPECT_TRUE(eventually([&] { return metric("seaway_net_sessions") == 1; }));
        EXPECT_EQ(metric("seaway_net_subscriptions"), 1);
        EXPECT_EQ(metric("seaway_net_outbox_bytes"), 0);
        EXPECT_TRUE(eventually([&] { return metric("seaway_net_connections") == 2; }));
        double closed = 0;
        for (const auto& [name, value] : read_metrics(get("/metrics").body).values)
            if (name.starts_with("seaway_net_sessions_closed_total"))
                closed += value;
        EXPECT_EQ(closed, metric("seaway_net_sessions_opened_total") - 1);
    }

    static constexpr std::uint32_t last_id = 99;

  private:
    std::int64_t published_ = 1;
};

TEST_F(NetFaults, a_line_that_breaks_anywhere_leaves_no_session_behind) {
    start();
    FaultProxy line(port());
    const auto neighbour = greeted();
    ASSERT_FALSE(neighbour->send(protocol::subscribe(1, heights, 8)));
    Draw draw(11);
    int broken = 0;
    for (int i = 0; i < 60; ++i) {
        // What the client says is some 700 bytes, what it is told some 9000.
        if (i % 2 == 0)
            line.cut_next_after(Way::to_server, draw.below(700));
        else
            line.cut_next_after(Way::to_client, draw.below(9000));
        broken += live_through(line.port()) ? 0 : 1;
        expect_well(*neighbour);
    }
    EXPECT_GT(broken, 20) << "lines have been broken";
    expect_gone();
}

TEST_F(NetFaults, a_flipped_bit_ends_one_session_with_a_reason_or_none) {
    start();
    FaultProxy line(port());
    const auto neighbour = greeted();
    ASSERT_FALSE(neighbour->send(protocol::subscribe(1, heights, 8)));
    Draw draw(12);
    int unharmed = 0;
    for (int i = 0; i < 120; ++i) {
        // Behind the upgrade, where a flip is another request, and often a right one.
        line.flip_next_at(Way::to_server, 200 + draw.below(450),
                          static_cast<unsigned>(draw.below(8)));
        unharmed += live_through(line.port()) ? 1 : 0;
        expect_well(*neighbour);
    }
    expect_gone();
    const MetricsPage page = read_metrics(get("/metrics").body);
    EXPECT_GT(page.values.at("seaway_net_sessions_closed_total{reason=\"bad_message\"}"), 10);
    EXPECT_GT(unharmed, 10) << "where a bit is one of a place, it is a place";
}

/// Frames that are newer than one that has just come, frame by frame; the first few, fetched ones among them, aside.
std::vector<std::int64_t> ages_of(Client& client, const std::atomic<std::int64_t>& newest,
                                  std::chrono::milliseconds pause, int frames) {
    std::vector<std::int64_t> ages;
    while (static_cast<int>(ages.size()) < frames) {
        const wire::Message* message = client.receive();
        if (message == nullptr)
            return {};
        const wire::Tile* tile = message->body_as_Tile();
        if (tile == nullptr)
            continue;
        ages.push_back(newest - tile->time_us() / interval_us);
        const std::uint64_t number = tile->keyframe();
        std::this_thread::sleep_for(pause);
        EXPECT_FALSE(client.send(protocol::ack(number)));
    }
    ages.erase(ages.begin(), ages.begin() + frames / 4);
    std::ranges::sort(ages);
    return ages;
}

/// Half of them, and nearly all: the simulation goes on while another process has the reader's core.
bool are_new(const std::vector<std::int64_t>& ages) {
    return !ages.empty() && ages[ages.size() / 2] <= 3 && ages[ages.size() * 4 / 5] <= 10;
}

// 20 frames a second of some 6 KB; the line holds 64 KB and the kernel several times as much, which is where
// frames grow old that nobody has to acknowledge: 20 and more. RTT is 60 +- 20 ms, an interval 50 ms: what is as
// old as RTT and two intervals has three newer ones. Counted in frames, so that a machine that is slow is slow
// for both.
TEST_F(NetFaults, a_reader_at_half_speed_is_shown_what_is_new) {
    host.size = 96;
    start();
    FaultProxy line(port(), {.delay = 30ms, .jitter = 10ms});
    std::atomic<std::int64_t> newest = 10;
    std::atomic<bool> enough = false;
    std::thread simulation([&] {
        while (!enough) {
            host.newest = newest + 1;
            net->publish(host.keyframe(0, newest + 1, {sea::Field::height}));
            ++newest;
            std::this_thread::sleep_for(50ms);
        }
    });
    const auto reader = [&](double bytes_per_s, std::chrono::milliseconds pause) {
        line.set({.delay = 30ms, .jitter = 10ms, .bytes_per_s = bytes_per_s});
        Client client(line.port());
        EXPECT_FALSE(client.connect());
        EXPECT_TRUE(client.greet());
        EXPECT_FALSE(client.send(protocol::subscribe(1, heights, 1)));
        std::vector<std::int64_t> ages = ages_of(client, newest, pause, 16);
        EXPECT_FALSE(ages.empty()) << "nobody ends it";
        return ages;
    };
    std::vector<std::int64_t> thinks, slow_line;
    // On a crowded machine that may be for longer: one round of three holds.
    for (int round = 0; round < 3 && !are_new(thinks); ++round)
        thinks = reader(0, 100ms);
    const std::string page = get("/metrics").body;
    const double frame_bytes = figure_of(page, "seaway_net_encoded_bytes_total") /
                               figure_of(page, "seaway_net_fields_encoded_total");
    for (int round = 0; round < 3 && !are_new(slow_line); ++round)
        slow_line = reader(frame_bytes / 0.1, 0ms);
    enough = true;
    simulation.join();
    EXPECT_TRUE(are_new(thinks)) << testing::PrintToString(thinks);
    EXPECT_TRUE(are_new(slow_line)) << testing::PrintToString(slow_line);
}

} // namespace
} // namespace seaway::tests
