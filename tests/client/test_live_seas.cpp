// SPDX-License-Identifier: Apache-2.0
// The client against a server whose sea, or whose offer, changes while it is connected, and which it asks
// for much.
#include <atomic>
#include <future>
#include <limits>

#include <gtest/gtest.h>

#include "client/client.h"
#include "client/link/failure.h"
#include "client/link/message_stream.h"
#include "server/host/refusal.h"
#include "tests/client/wave_server.h"

namespace seaway::client {
namespace {

using sea::Field;
using sea::FieldSet;
using tests::eventually;

class LiveSeas : public tests::WaveServer {
  protected:
    std::atomic<int> told = 0; ///< of seas

    std::unique_ptr<Client> connect() {
        auto client = Client::connect({.url = net->url(), .timeout_s = 60},
                                      {.on_sea_state = [this](const SeaStatePtr&) { ++told; }});
        EXPECT_TRUE(client) << (client ? "" : client.error().message);
        return client ? std::move(*client) : nullptr;
    }
    /// Announces a sea and waits until the client knows it.
    void announce(std::uint32_t epoch, sea::TimeUs start_us) {
        const int before = told;
        WaveServer::announce(epoch, start_us);
        ASSERT_TRUE(eventually([&] { return told == before + 1; }));
    }
};

TEST_F(LiveSeas, each_runs_from_its_start_to_the_start_of_the_next_in_whatever_order_they_came) {
    const auto client = connect();
    ASSERT_TRUE(client);
    const auto epoch_at = [&](sea::TimeUs time_us) { return client->sea_state(time_us)->epoch; };
    announce(11, 200);
    announce(10, 100);
    EXPECT_EQ(epoch_at(std::numeric_limits<sea::TimeUs>::min()), 3u) << "before all: the first";
    for (const auto& [time_us, epoch] :
         {std::pair(99, 3u), {100, 10u}, {199, 10u}, {200, 11u}, {1'000'000, 11u}})
        EXPECT_EQ(epoch_at(time_us), epoch) << time_us;
    announce(11, 150); // said again: it starts earlier than was said before
    EXPECT_EQ(epoch_at(149), 10u);
    EXPECT_EQ(epoch_at(150), 11u);
    constexpr auto end = static_cast<std::uint32_t>(12 + protocol::limits::sea_states_held - 3);
    for (std::uint32_t epoch = 12; epoch < end; ++epoch)
        announce(epoch, 100 * epoch);
    EXPECT_EQ(epoch_at(0), 3u) << "so many are known";
    announce(end, 100 * end);
    EXPECT_EQ(epoch_at(0), 10u) << "of one more the furthest from now is forgotten";
    EXPECT_EQ(epoch_at(100 * end - 1), end - 1);
    EXPECT_EQ(epoch_at(100 * end), end);
    constexpr sea::TimeUs century_us = 3'155'760'000'000'000;
    announce(end + 1, century_us);
    EXPECT_EQ(epoch_at(century_us), end) << "and that may be the last one";
    EXPECT_EQ(epoch_at(150), 11u);
}

// Naive: before the first sea that a newcomer is told of ran that one, and its waves have their bound there.
TEST_F(LiveSeas, before_all_that_a_client_was_told_of_waves_have_no_bound) {
    constexpr sea::TimeUs start_us = -60'000'000;
    sea.told_from_us = start_us;
    const auto client = connect();
    ASSERT_TRUE(client);
    ASSERT_TRUE(client->subscribe_spectrum({}, 30));
    for (const auto& [time_us, flags] :
         {std::pair(start_us - 1, unsigned{sea::answer_extrapolated}), {start_us, 0u}}) {
        const sea::QueryPoint point{3, 4, time_us};
        EXPECT_EQ(client->sample({&point, 1}).value()[0].flags, flags);
        EXPECT_EQ(client->look({&point, 1}, {}).value()[0].answer.flags, flags);
        constexpr double deep_m = -5;
        EXPECT_EQ(client->below({&point, 1}, {&deep_m, 1}, {}).value().answers[0].flags, flags);
    }
    // Waves go on without a server, of that time as of any; and each answer of several says what is wrong with it.
    net.reset();
    ASSERT_TRUE(eventually([&] { return client->status().state != LinkState::connected; }));
    const sea::TimeUs later_us = client->now_us() + 60'000'000;
    const sea::QueryPoint both[] = {{3, 4, start_us - 1}, {3, 4, later_us}};
    const double deep_m[] = {-5, -5};
    const auto expect = [&](const std::vector<sea::Answer>& answers) {
        EXPECT_EQ(answers[0].flags, unsigned{sea::answer_extrapolated});
        EXPECT_EQ(answers[1].flags, unsigned{sea::answer_stale});
        EXPECT_GT(answers[1].error_m, 0.1);
    };
    expect(client->sample(both).value());
    expect(client->below(both, deep_m, {}).value().answers);
    const std::vector<Water> water = client->look(both, {}).value();
    expect({water[0].answer, water[1].answer});
}

// Naive: of a sea that was told of and has begun nothing is held, so nothing is answered: a boat stops for a keyframe that is late.
TEST_F(LiveSeas, where_the_keyframes_of_a_sea_are_late_the_one_before_goes_on) {
    const auto client = connect();
    ASSERT_TRUE(client);
    const sea::QueryPoint now{3, 4, sea.sea_time_us()};
    ASSERT_TRUE(client->hold({&now.time_us, 1}, 30));
    const sea::Answer before = client->sample({&now, 1}).value()[0];
    EXPECT_EQ(before.flags, 0u);
    announce(4, now.time_us - 1000);
    ASSERT_EQ(client->sea_state(now.time_us)->epoch, 4u);
    const Result<std::vector<sea::Answer>> after = client->sample({&now, 1});
    ASSERT_TRUE(after) << after.error().message;
    EXPECT_EQ(after->at(0).flags, unsigned{sea::answer_extrapolated});
    EXPECT_EQ(after->at(0).height_m, before.height_m);
    const Result<std::vector<Water>> seen = client->look({&now, 1}, {}); // with all that moves it
    ASSERT_TRUE(seen) << seen.error().message;
    EXPECT_EQ(seen->at(0).answer.flags, unsigned{sea::answer_extrapolated});
    EXPECT_EQ(seen->at(0).answer.height_m, before.height_m);
    EXPECT_TRUE(std::isfinite(seen->at(0).displacement_m[0]));
}

// Naive: before the first pace that it knows others may have held, and of the seconds before a pace a newcomer knows no sea.
TEST_F(LiveSeas, a_first_pace_to_come_makes_nobody_unsure_of_what_runs_before_it) {
    const sea::TimeUs from_us = sea.sea_time_us() + 60'000'000;
    sea.told_pace = sea::Pace{from_us, from_us, 500};
    const auto client = connect();
    ASSERT_TRUE(client);
    EXPECT_TRUE(client->knows_sea_of(client->now_us() - 1000));
    sea.told_pace->sea_us -= 1; // there were others
    const auto late = connect();
    ASSERT_TRUE(late);
    EXPECT_FALSE(late->knows_sea_of(late->now_us() - 1000));
}

// Naive: in order of their starts, one that was to come later takes over from the one that took over from it.
TEST_F(LiveSeas, a_later_one_takes_over_from_those_that_were_to_begin_after_it) {
    const auto client = connect();
    ASSERT_TRUE(client);
    const auto epoch_at = [&](sea::TimeUs time_us) { return client->sea_state(time_us)->epoch; };
    announce(4, 100);
    announce(5, 500);
    announce(6, 300);
    announce(7, 900);
    EXPECT_EQ(epoch_at(299), 4u);
    for (const sea::TimeUs time_us : {300, 500, 899})
        EXPECT_EQ(epoch_at(time_us), 6u) << time_us;
    EXPECT_EQ(epoch_at(900), 7u);
    announce(8, 900);
    EXPECT_EQ(epoch_at(900), 8u);
    announce(
        5, 500); // who comes late is told of no sea that never ran; told all the same, it stays out
    EXPECT_EQ(epoch_at(500), 6u);
}

TEST_F(LiveSeas, what_is_offered_again_is_asked_for_again) {
    const FieldSet with_slope = sea::surface_fields | FieldSet{Field::slope_x};
    sea.offered = sea::surface_fields;
    const auto client = connect();
    ASSERT_TRUE(client);
    const auto held_at = [&](sea::TimeUs time_us) {
        const Result<void> held = client->hold({&time_us, 1}, 10, {Field::slope_x});
        EXPECT_TRUE(held) << held.error().message;
        const auto pair = client->ring().around(0, sea.epoch, time_us, tests::wave_intervals_us[0],
                                                sea::surface_fields);
        return pair ? pair->before->keyframe().fields : FieldSet{};
    };
    EXPECT_EQ(held_at(1'010'000), sea::surface_fields);
    sea.offered = with_slope;
    EXPECT_EQ(held_at(2'010'000), sea::surface_fields) << "known not to be offered";
    const auto grant = client->subscribe({.fields = with_slope}, 2, 60);
    ASSERT_TRUE(grant) << grant.error().message;
    EXPECT_EQ(grant->fields, with_slope);
    EXPECT_EQ(held_at(3'010'000), with_slope);
}

TEST_F(LiveSeas, each_keyframe_is_told_of_once_and_is_held_by_then) {
    std::atomic<const Client*> who = nullptr;
    std::atomic<int> keyframes = 0;
    std::atomic<int> not_held = 0;
    const auto client = Client::connect(
        {.url = net->url(), .timeout_s = 60}, {.on_keyframe = [&](const HeldKeyframePtr& held) {
            const sea::Keyframe& k = held->keyframe();
            const auto pair = who.load()->ring().around(k.cascade, k.epoch, k.time_us, 1, {});
            not_held += !pair || pair->before != held;
            ++keyframes;
        }});
    ASSERT_TRUE(client) << client.error().message;
    who = client->get();
    const sea::TimeUs times_us[] = {1'010'000, 7'770'000};
    ASSERT_TRUE((*client)->hold(times_us, 60));
    EXPECT_EQ(keyframes, 8) << "two around each time, of two cascades";
    EXPECT_EQ(not_held, 0);
}

class RefusingSea : public tests::WaveSea {
  public:
    void query(server::QueryBatch, Queried done) override {
        ++queries;
        done(Error{server::Refusal::not_offered, "never"});
    }
};

// As many batches as are under way at once, and none after the first that is refused for good.
TEST(Asking, ends_with_the_first_batch_that_is_refused) {
    RefusingSea sea;
    const auto net = tests::serve(sea);
    const auto client = Client::connect({.url = net->url(), .timeout_s = 60});
    ASSERT_TRUE(client) << client.error().message;
    const std::size_t batch = (*client)->welcome().points_per_query_max;
    const std::vector<sea::QueryPoint> points(batch * 12);
    const auto answers = (*client)->ask(points, {.timeout_s = 60});
    ASSERT_FALSE(answers);
    EXPECT_EQ(failure_of(answers.error()), Failure::refused);
    EXPECT_LE(sea.queries, 4);
}

// More bytes in all than may wait at a time, and more batches than are sent at once.
TEST_F(LiveSeas, much_that_is_asked_one_after_the_other_is_answered) {
    const auto client = connect();
    ASSERT_TRUE(client);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::size_t batch = client->welcome().points_per_query_max;
    const std::size_t batches =
        MessageStream::waiting_bytes_max / (batch * sizeof(wire::Point)) + 4;
    const std::vector<sea::QueryPoint> points(batch * batches, {nan, 0, 0});
    const auto answers = client->ask(points, {.timeout_s = 60});
    ASSERT_TRUE(answers) << answers.error().message;
    EXPECT_EQ(answers->size(), points.size());
    EXPECT_EQ(sea.queries, static_cast<int>(batches));
    EXPECT_TRUE(client->ask({points.data(), 1}, {.timeout_s = 60}));
}

TEST_F(LiveSeas, a_server_that_closes_is_quoted_with_its_code_and_its_reason) {
    const auto opened = open_websocket(*parse_url(net->url()), {});
    ASSERT_TRUE(opened) << opened.error().message;
    std::atomic<int> heard = 0;
    std::promise<std::string> closed;
    (*opened)->start({[&](std::span<const std::uint8_t>) { ++heard; }, [] {},
                      [&](const std::string& why) { closed.set_value(why); }});
    ASSERT_TRUE((*opened)->send(protocol::hello("small", "")));
    ASSERT_TRUE(eventually([&] { return heard >= 2; }));
    net->stop();
    EXPECT_EQ(closed.get_future().get(),
              "the server closed the connection (code 4010: the server stops)");
}

// What is refused leaves no trace: who has asked for too much may still say little.
TEST_F(LiveSeas, bytes_of_a_message_that_is_refused_take_no_room) {
    const auto url = parse_url(net->url());
    ASSERT_TRUE(url);
    const auto opened = open_websocket(*url, {});
    ASSERT_TRUE(opened) << opened.error().message;
    std::atomic<int> heard = 0;
    (*opened)->start(
        {[&](std::span<const std::uint8_t>) { ++heard; }, [] {}, [](const std::string&) {}});
    for (int i = 0; i < 5; ++i)
        EXPECT_FALSE((*opened)->send(protocol::Bytes(MessageStream::waiting_bytes_max + 1)));
    EXPECT_TRUE((*opened)->send(protocol::hello("small", "")));
    EXPECT_TRUE(eventually([&] { return heard >= 2; })) << "a welcome and a sea";
    (*opened)->close("enough");
    EXPECT_TRUE((*opened)->send(protocol::hello("late", ""))) << "lost, and on_closed says why";
}

} // namespace
} // namespace seaway::client
