// SPDX-License-Identifier: Apache-2.0
// What is said of coarser maps: wishes, grants, tiles; and of what rounding left of maps.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "protocol/limits.h"
#include "tests/protocol/sample_messages.h"

namespace seaway::protocol {
namespace {

using tests::read;
using tests::some_tile;

// Naive: a field that says nothing is written all the same, and every tile of those who never asked grows by it.
TEST(CoarserMessages, what_coarser_maps_miss_travels_and_nothing_of_it_where_they_miss_nothing) {
    MessageReader reader(Sender::server);
    const std::vector<std::uint8_t> payload{1};
    TileHeader header = some_tile();
    const std::size_t plain = tile(header, payload).size();
    EXPECT_EQ(read(reader, tile(header, payload))->body_as_Tile()->coarser(), nullptr);
    header.coarser = {640'000, 0.25, 0.125, 0.5, 0.75, 2.0};
    const Bytes told = tile(header, payload);
    EXPECT_GE(told.size(), plain + 32);
    const wire::Tile& back = *read(reader, told)->body_as_Tile();
    EXPECT_TRUE(check(back));
    EXPECT_EQ(protocol::header(back).coarser, header.coarser);
    header.coarser.cut_m = 1e10;
    const Result<void> fine = check(*read(reader, tile(header, payload)));
    ASSERT_FALSE(fine);
    EXPECT_NE(fine.error().message.find("coarser.cut_m"), std::string::npos);
    const TileWish grant{.cascades = 3u, .fields = sea::surface_fields, .error_m = 0.02f};
    const Bytes old = subscribed(7, grant, 4);
    TileWish less = grant;
    less.rate_hz_max = 2.5f;
    less.size_max = 64;
    const Bytes with_less = subscribed(7, less, 4, "why not");
    const wire::Subscribed& said = *read(reader, with_less)->body_as_Subscribed();
    EXPECT_EQ(said.why()->str(), "why not");
    EXPECT_EQ(said.limits()->rate_hz(), 2.5f);
    EXPECT_EQ(said.limits()->size(), 64u);
    const wire::Subscribed& nothing = *read(reader, old)->body_as_Subscribed();
    EXPECT_EQ(nothing.why(), nullptr);
    EXPECT_EQ(nothing.limits(), nullptr);
}

TEST(CoarserMessages, what_rounding_left_travels_as_a_bound_and_nothing_of_it_where_nobody_says) {
    MessageReader reader(Sender::server);
    const std::vector<std::uint8_t> payload{1};
    TileHeader header = some_tile();
    EXPECT_EQ(read(reader, tile(header, payload))->body_as_Tile()->noise(), nullptr);
    header.noise = {header.keyframe, 76, -640'000, 0.1, 0.3};
    const Bytes told = tile(header, payload);
    const wire::Tile& back = *read(reader, told)->body_as_Tile();
    EXPECT_TRUE(check(back));
    const sea::CodedNoise noise = protocol::header(back).noise;
    EXPECT_EQ(noise.number, header.keyframe);
    EXPECT_EQ(noise.before, 76u);
    EXPECT_EQ(noise.before_us, -640'000);
    EXPECT_GE(noise.at_m, 0.1);
    EXPECT_GE(noise.between_m, 0.3);
    EXPECT_LT(noise.between_m, 0.3000001);
    const auto why = [&](const sea::CodedNoise& wrong) {
        header.noise = wrong;
        const Result<void> fine = check(*read(reader, tile(header, payload)));
        return fine ? std::string() : fine.error().message;
    };
    EXPECT_NE(why({1, 0, 0, 1e7, 0}).find("noise.at_m"), std::string::npos);
    EXPECT_NE(why({1, 0, 0, 1, -1}).find("noise.between_m"), std::string::npos);
    EXPECT_NE(why({1, 0, 0, 1, std::nan("")}).find("noise.between_m"), std::string::npos);
    EXPECT_NE(why({1, 0, limits::time_us_max + 1, 1, 1}).find("noise.before_us"),
              std::string::npos);
}

TEST(CoarserMessages, limits_out_of_range_are_errors_that_name_the_field) {
    MessageReader reader(Sender::client);
    const TileWish wish{.fields = sea::surface_fields};
    const auto why = [&](const Bytes& bytes) {
        const Result<void> fine = check(*read(reader, bytes));
        return fine ? std::string() : fine.error().message;
    };
    const auto limited = [&](float rate_hz_max, int size_max) {
        TileWish less = wish;
        less.rate_hz_max = rate_hz_max;
        less.size_max = size_max;
        return why(subscribe(1, less, 2));
    };
    EXPECT_EQ(limited(1.0f, 32), "");
    EXPECT_EQ(limited(1000.0f, limits::map_side_max), "");
    for (const float rate_hz : {-1.0f, 0.99f, 1000.5f, std::numeric_limits<float>::quiet_NaN()})
        EXPECT_NE(limited(rate_hz, 0).find("allowed are 1 to 1000"), std::string::npos) << rate_hz;
    for (const int size : {1, 31, 2049})
        EXPECT_NE(limited(0, size).find("allowed are 32 to 2048"), std::string::npos) << size;
}

} // namespace
} // namespace seaway::protocol
