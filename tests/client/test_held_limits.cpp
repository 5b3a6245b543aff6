// SPDX-License-Identifier: Apache-2.0
// What a client asks for by what it can hold and by what a server sends at once: more times than
// its ring has room for, tiles too large for one answer, a change of the sea.
#include <chrono>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "client/client.h"
#include "client/link/failure.h"
#include "tests/client/wave_server.h"
#include "tests/support/eventually.h"

namespace seaway::client {
namespace {

using sea::Answer;
using sea::QueryPoint;

/// A server of some sea, and a client of it.
struct Served {
    std::unique_ptr<server::NetServer> net;
    std::unique_ptr<Client> client;

    explicit Served(server::Host& sea, RingLimits limits = {}) : net(tests::serve(sea)) {
        auto connected = Client::connect({.url = net->url(), .timeout_s = 60}, {}, limits);
        EXPECT_TRUE(connected) << connected.error().message;
        client = std::move(*connected);
    }
};

std::vector<QueryPoint> points_at_times(int times, sea::TimeUs apart_us) {
    std::vector<QueryPoint> points;
    for (int i = 0; i < times; ++i)
        points.push_back({3.0 * i, -2.0 * i, i * apart_us + 30'000});
    return points;
}

void expect_true_heights(const tests::WaveSea& sea, std::span<const QueryPoint> points,
                         const Result<std::vector<Answer>>& answers) {
    ASSERT_TRUE(answers) << answers.error().message;
    ASSERT_EQ(answers->size(), points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_EQ((*answers)[i].flags, 0u) << "time " << i;
        EXPECT_LE(std::abs((*answers)[i].height_m - sea.truth(points[i]).height_m),
                  (*answers)[i].error_m)
            << "time " << i;
    }
}

// A ring for 13 keyframes and 7 times: 14 were fetched, and the first time was extrapolated.
TEST(HeldLimits, many_times_are_answered_truly_however_few_keyframes_the_ring_holds) {
    for (const std::size_t room : {4u, 5u, 13u}) {
        tests::WaveSea sea;
        Served link(sea, {.keyframes_per_cascade = room});
        const std::vector<QueryPoint> points = points_at_times(30, 1'000'000);
        expect_true_heights(sea, points, link.client->fetch_and_sample(points, 60));
    }
}

TEST(HeldLimits, what_the_stream_brings_pushes_nothing_out_that_is_being_answered) {
    tests::WaveSea sea;
    Served link(sea, {.keyframes_per_cascade = 4});
    ASSERT_TRUE(link.client->subscribe({.fields = sea::surface_fields}, 8, 60));
    std::atomic<bool> stop = false;
    std::thread publisher([&] {
        for (std::int64_t n = 100'000; !stop; ++n) {
            link.net->publish(sea.keyframe(0, n, sea::surface_fields));
            link.net->publish(sea.keyframe(1, n, sea::surface_fields));
        }
    });
    for (int round = 0; round < 10; ++round) {
        const std::vector<QueryPoint> points = points_at_times(8, 700'000);
        expect_true_heights(sea, points, link.client->fetch_and_sample(points, 60));
    }
    stop = true;
    publisher.join();
}

TEST(HeldLimits, holding_more_never_drops_what_is_asked_for_together) {
    tests::WaveSea sea;
    Served link(sea, {.keyframes_per_cascade = 5});
    const sea::TimeUs first = 1'000'000, second = 2'000'000, third = 3'000'000;
    ASSERT_TRUE(link.client->hold({&first, 1}, 60));
    ASSERT_TRUE(link.client->hold({&second, 1}, 60));
    const sea::TimeUs both[] = {first, third};
    ASSERT_TRUE(link.client->hold(both, 60));
    const QueryPoint points[] = {{1, 2, first}, {3, 4, third}};
    expect_true_heights(sea, points, link.client->sample(points));
}

TEST(HeldLimits, holding_more_times_than_there_is_room_for_is_an_error_that_says_so) {
    tests::WaveSea sea;
    Served link(sea, {.keyframes_per_cascade = 5});
    const sea::TimeUs times[] = {1'000'000, 2'000'000, 3'000'000};
    const Result<void> held = link.client->hold(times, 60);
    ASSERT_FALSE(held);
    EXPECT_EQ(failure_of(held.error()), Failure::bad_argument);
    EXPECT_NE(held.error().message.find("around 2 of them"), std::string::npos)
        << held.error().message;
    EXPECT_EQ(sea.fetches, 0);
}

/// Three cascades of 512 whose tiles cannot be compressed: 6 MiB a keyframe, so the six keyframes
/// around one time are more than the 32 MiB that a server sends at once.
class LargeSea : public tests::WaveSea {
  public:
    static constexpr int size = 512;
    static constexpr sea::TimeUs interval_us = 500'000;
    mutable std::atomic<int> keyframes_made = 0;

    std::vector<server::SharedBytes> sea_state_messages() const override {
        protocol::SeaStateValues state;
        state.epoch = epoch;
        for (const double length_m : {900.0, 170.0, 31.0})
            state.cascades.push_back(
                {.length_m = length_m, .size = size, .interval_us = interval_us});
        state.choppiness_x = state.choppiness_y = 0; // noise would fold everywhere
        state.realised.hs_m = 1;
        return {std::make_shared<const protocol::Bytes>(protocol::sea_state(state))};
    }
    void fetch(server::FetchRequest request, Fetched done) override {
        ++fetches;
        std::vector<server::KeyframeTiles> out;
        for (int cascade = 0; cascade < 3; ++cascade)
            for (const sea::TimeUs time_us : request.times_us)
                for (const std::int64_t n : {time_us / interval_us, time_us / interval_us + 1})
                    if ((request.demand.cascades >> cascade) & 1u)
                        out.push_back(noise(cascade, n, request.demand.fields));
        done(server::FetchedPart{std::move(out)});
    }
    /// In the order of the grid of the first cascade.
    const std::vector<float>& samples() const { return samples_; }

  private:
    server::KeyframeTiles noise(int cascade, std::int64_t n, sea::FieldSet fields) const {
        ++keyframes_made;
        auto made = std::make_shared<sea::Keyframe>();
        made->epoch = epoch;
        made->cascade = cascade;
        made->time_us = n * interval_us;
        made->size = size;
        made->length_m = cascade == 0 ? 900.0 : cascade == 1 ? 170.0 : 31.0;
        made->fields = fields;
        for (const sea::Field field : fields)
            (void)field, made->values.insert(made->values.end(), samples_.begin(), samples_.end());
        return {made, std::vector<float>(static_cast<std::size_t>(fields.size()), 0.0f), 0};
    }
    static std::vector<float> make_samples() {
        std::mt19937_64 random(1);
        std::vector<float> samples(size * size);
        for (float& sample : samples)
            sample = std::bit_cast<float>((static_cast<std::uint32_t>(random()) & 0x83ffffffu) |
                                          0x3c000000u);
        return samples;
    }
    const std::vector<float> samples_ = make_samples();
};

TEST(HeldLimits, tiles_too_large_for_one_answer_are_asked_for_a_cascade_at_a_time) {
    LargeSea sea;
    Served link(sea);
    const std::vector<QueryPoint> points{{0, 0, 0}, {0, 0, 1'000'000}};
    const auto answers = link.client->fetch_and_sample(points, 120);
    ASSERT_TRUE(answers) << answers.error().message;
    for (const Answer& answer : *answers) {
        EXPECT_EQ(answer.flags & sea::answer_extrapolated, 0u);
        // At a grid point of all three cascades and at the time of a keyframe: the sample, within the
        // float arithmetic of the spline.
        EXPECT_NEAR(answer.height_m, 3 * static_cast<double>(sea.samples()[0]), 1e-5);
    }
    // Two times are refused, then one; then come three cascades of each time.
    EXPECT_EQ(sea.fetches, 2 + 2 * 3);
    EXPECT_EQ(sea.keyframes_made, 12 + 6 + 12);
    // What the server was found to take is asked for from now on.
    const QueryPoint later{0, 0, 5'000'000};
    ASSERT_TRUE(link.client->fetch_and_sample({&later, 1}, 120));
    EXPECT_EQ(sea.fetches, 2 + 2 * 3 + 3);
}

/// A large cascade and a small one of which no keyframe is ever sent.
class SilentSea : public tests::WaveSea {
  public:
    static constexpr int large = 1024, small = 64;
    std::vector<std::size_t> times_asked; ///< by request

    std::vector<server::SharedBytes> sea_state_messages() const override {
        protocol::SeaStateValues state;
        state.epoch = epoch;
        state.cascades.push_back({.length_m = 900, .size = large, .interval_us = 500'000});
        state.cascades.push_back({.length_m = 31, .size = small, .interval_us = 500'000});
        return {std::make_shared<const protocol::Bytes>(protocol::sea_state(state))};
    }
    void fetch(server::FetchRequest request, Fetched done) override {
        times_asked.push_back(request.times_us.size());
        done(server::FetchedPart{});
    }
};

std::vector<sea::TimeUs> times_apart(int count) {
    std::vector<sea::TimeUs> times_us;
    for (int i = 0; i < count; ++i)
        times_us.push_back(i * 1'000'000 + 30'000);
    return times_us;
}

// At a byte a sample two keyframes of six fields are 12 MiB of the large cascade around each time: of the
// 32 MiB that a server sends at once two times take 24, three would take 36.
TEST(HeldLimits, as_many_times_are_asked_for_at_once_as_a_server_can_answer) {
    SilentSea sea;
    Served link(sea, {.bytes_per_cascade = std::size_t{16} << 30});
    ASSERT_TRUE(link.client->hold(times_apart(5), 60));
    EXPECT_EQ(sea.times_asked, (std::vector<std::size_t>{2, 2, 1}));
}

TEST(HeldLimits, the_largest_cascade_says_how_many_times_have_room) {
    SilentSea sea;
    Served link(sea, {.bytes_per_cascade =
                          6 * HeldKeyframe::bytes_of(sea::surface_fields, SilentSea::large)});
    EXPECT_TRUE(link.client->hold(times_apart(3), 60)) << "six keyframes";
    const Result<void> held = link.client->hold(times_apart(4), 60);
    ASSERT_FALSE(held);
    EXPECT_NE(held.error().message.find("around 3 of them"), std::string::npos)
        << held.error().message;
}

/// The same waves under another number from `change_us` on, in the middle of an interval.
class ChangingSea : public tests::WaveSea {
  public:
    static constexpr sea::TimeUs change_us = 50'000;

    std::vector<server::SharedBytes> sea_state_messages() const override {
        protocol::MessageReader reader(protocol::Sender::server);
        const auto first = WaveSea::sea_state_messages().front();
        protocol::SeaStateValues state =
            protocol::values(*reader.read(*first).value()->body_as_SeaState());
        state.epoch = epoch + 1;
        state.start_time_us = change_us;
        state.interpolation_error_m += 1; // its maps are worse
        return {first, std::make_shared<const protocol::Bytes>(protocol::sea_state(state))};
    }
    void fetch(server::FetchRequest request, Fetched done) override {
        const std::vector<sea::TimeUs> times_us = request.times_us;
        WaveSea::fetch(std::move(request), [&](Result<server::FetchedPart> made) {
            std::vector<server::KeyframeTiles> out;
            for (const server::KeyframeTiles& tiles : made->tiles)
                for (const sea::TimeUs time_us : times_us) {
                    auto own = std::make_shared<sea::Keyframe>(*tiles.keyframe);
                    own->epoch = time_us < change_us ? epoch : epoch + 1;
                    out.push_back({own, tiles.codec_error, tiles.quality});
                }
            done(server::FetchedPart{std::move(out)});
        });
    }
};

TEST(HeldLimits, times_in_one_interval_on_both_sides_of_a_change_have_keyframes_of_their_own_sea) {
    ChangingSea sea;
    Served link(sea);
    // Connecting waits for the sea of now; that of later is a message of its own, just behind it.
    ASSERT_TRUE(
        tests::eventually([&] { return link.client->sea_state(80'000)->epoch == sea.epoch + 1; }));
    const QueryPoint points[] = {{1, 2, 20'000}, {1, 2, 80'000}};
    const auto answers = link.client->fetch_and_sample(points, 60);
    expect_true_heights(sea, points, answers);
    EXPECT_LT((*answers)[0].error_m, 0.1);
    EXPECT_GT((*answers)[1].error_m, 1) << "sampled of its own sea";
    // Sampled together, too, and back again.
    const sea::TimeUs times_us[] = {20'000, 80'000};
    const Result<void> held = link.client->hold(times_us, 60);
    ASSERT_TRUE(held) << held.error().message;
    const QueryPoint mixed[] = {{1, 2, 20'000}, {1, 2, 80'000}, {3, 2, 20'001}, {3, 2, 20'002}};
    const auto sampled = link.client->sample(mixed);
    ASSERT_TRUE(sampled) << sampled.error().message;
    for (std::size_t i = 0; i < 4; ++i)
        EXPECT_EQ((*sampled)[i].error_m > 1, i == 1) << i << ' ' << (*sampled)[i].error_m;
}

} // namespace
} // namespace seaway::client
