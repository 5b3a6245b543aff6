// SPDX-License-Identifier: Apache-2.0
// Every message there and back; golden bytes; hostile bytes.
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "protocol/limits.h"
#include "protocol/messages.h"
#include "tests/protocol/sample_messages.h"

namespace seaway::protocol {
namespace {

using tests::read;
using tests::sample;
using tests::samples;
using tests::some_state;
using tests::some_tile;
using wire::Body;
using wire::ErrorCode;

TEST(Messages, client_messages_read_back_as_they_were_written) {
    MessageReader reader(Sender::client);
    const auto* hello_back = read(reader, sample(Body::Hello))->body_as_Hello();
    EXPECT_EQ(hello_back->token()->str(), "secret");
    EXPECT_EQ(hello_back->versions()->Get(0), version);
    EXPECT_TRUE(check(*hello_back).has_value());
    const auto* subscribe_back = read(reader, sample(Body::Subscribe))->body_as_Subscribe();
    EXPECT_EQ(subscribe_back->fields(), sea::surface_fields.bits());
    EXPECT_EQ(subscribe_back->credit(), 4);
    EXPECT_TRUE(check(*subscribe_back).has_value());
    EXPECT_TRUE(read(reader, sample(Body::Unsubscribe))->body_as_Unsubscribe());
    EXPECT_EQ(read(reader, sample(Body::Ack))->body_as_Ack()->keyframe(), 1ull << 40);
    const auto* fetch_back = read(reader, sample(Body::Fetch))->body_as_Fetch();
    EXPECT_EQ(fetch_back->times_us()->Get(0), -5);
    EXPECT_TRUE(check(*fetch_back).has_value());
    const auto* query_back = read(reader, sample(Body::Query))->body_as_Query();
    EXPECT_TRUE(query_back->exact());
    EXPECT_EQ(query_back->points()->Get(1)->y_m(), 2e6);
    EXPECT_EQ(query_back->points()->Get(1)->time_us(), -9);
    EXPECT_EQ(query_back->z_m()->Get(0), -3.5);
    EXPECT_EQ(looking(*query_back), (sea::Looking{3u, 2.5}));
    EXPECT_TRUE(check(*query_back).has_value());
    EXPECT_EQ(read(reader, sample(Body::Ping))->body_as_Ping()->client_time_us(), -11);
}

TEST(Messages, server_messages_read_back_as_they_were_written) {
    MessageReader reader(Sender::server);
    EXPECT_EQ(read(reader, sample(Body::Welcome))->body_as_Welcome()->session(), 4u);
    EXPECT_TRUE(check(*read(reader, sample(Body::Welcome))->body_as_Welcome()).has_value());
    const auto* state = read(reader, sample(Body::SeaState))->body_as_SeaState();
    ASSERT_TRUE(check(*state).has_value());
    const SeaStateValues back = values(*state);
    EXPECT_EQ(sea_state(back), sample(Body::SeaState));
    EXPECT_EQ(back.cascades[1].interval_us, 200'000);
    SeaStateValues placed = back;
    placed.cascades[1].placed_alone = placed.cascades[0].stylised = true;
    const Bytes told = sea_state(placed);
    const SeaStateValues heard = values(*read(reader, told)->body_as_SeaState());
    EXPECT_TRUE(heard.cascades[1].placed_alone && heard.cascades[0].stylised);
    EXPECT_FALSE(heard.cascades[0].placed_alone || heard.cascades[1].stylised);
    EXPECT_EQ(back.realised.mean_from_deg, 225);
    EXPECT_EQ(back.warnings.size(), 2u);
    EXPECT_EQ(back.probes, some_state().probes);
    EXPECT_EQ(back.probe_error_m, 1e-6);
    const auto* tile_back = read(reader, sample(Body::Tile))->body_as_Tile();
    ASSERT_TRUE(check(*tile_back).has_value());
    const std::uint8_t payload[] = {1, 2, 3};
    EXPECT_EQ(tile(header(*tile_back), payload), sample(Body::Tile));
    const auto* reply = read(reader, sample(Body::QueryReply))->body_as_QueryReply();
    EXPECT_EQ(answer(*reply->answers()->Get(0)).height_m, 1.25);
    EXPECT_EQ(answer(*reply->answers()->Get(0)).flags, 5u);
    ASSERT_TRUE(check(*reply).has_value());
    EXPECT_EQ(water(*reply->below()->Get(0)).velocity_mps[2], -3);
    EXPECT_EQ(water(*reply->below()->Get(0)).pressure_m2ps2, 9.5);
    EXPECT_EQ(reply->cascades(), 5u);
    EXPECT_FALSE(read(reader, query_reply(9, 3, {}))->body_as_QueryReply()->cascades());
    const std::vector<sea::WaterBelow> too_many(2);
    EXPECT_FALSE(check(
        *read(reader, query_reply(9, 3, tests::some_answers(), too_many))->body_as_QueryReply()));
    EXPECT_EQ(read(reader, sample(Body::FetchDone))->body_as_FetchDone()->keyframes(), 6u);
    EXPECT_EQ(read(reader, sample(Body::Pong))->body_as_Pong()->sea_time_us(), 12);
    EXPECT_EQ(read(reader, sample(Body::Refused))->body_as_Refused()->code(),
              ErrorCode::too_many_points);
    EXPECT_EQ(read(reader, sample(Body::GoAway))->body_as_GoAway()->message()->str(),
              "the server stops");
}

TEST(Messages, a_stated_bound_is_never_narrowed_on_its_way_into_a_float) {
    for (const double bound : {0.1, 0.01, 1.0 / 3, 1e-40, 123.456}) {
        const sea::Answer one[] = {{.error_m = bound}};
        MessageReader reader(Sender::server);
        const Bytes bytes = query_reply(1, 1, one);
        const double back = read(reader, bytes)->body_as_QueryReply()->answers()->Get(0)->error_m();
        EXPECT_GE(back, bound);
        EXPECT_LE(back, bound * (1 + 1e-6) + 1e-44);
    }
}

TEST(Messages,
     every_kind_is_taken_from_its_own_side_with_values_in_range_and_refused_from_the_other) {
    for (const MessageInfo& row : message_table) {
        const Bytes bytes = sample(row.body);
        const bool from_client = row.sender == Sender::client;
        MessageReader own(row.sender), other(from_client ? Sender::server : Sender::client);
        const wire::Message* message = read(own, bytes);
        ASSERT_TRUE(message) << wire::EnumNameBody(row.body);
        EXPECT_EQ(message->body_type(), row.body);
        EXPECT_TRUE(check(*message).has_value()) << wire::EnumNameBody(row.body);
        EXPECT_FALSE(other.read(bytes).has_value()) << wire::EnumNameBody(row.body);
    }
}

// Added at the end: who does not know it reads the rest, and bytes from before it say nothing of it.
TEST(Messages, a_refusal_says_when_to_ask_again_where_that_is_known) {
    MessageReader reader(Sender::server);
    const auto of = [&](const Bytes& bytes) { return read(reader, bytes)->body_as_Refused(); };
    const auto later = refused(9, wire::ErrorCode::too_many_requests, "later", 1500);
    EXPECT_EQ(of(later)->retry_after_ms(), 1500u);
    const auto never = refused(9, wire::ErrorCode::bad_value, "no", 0);
    EXPECT_EQ(of(never)->retry_after_ms(), 0u);
    EXPECT_EQ(of(sample(Body::Refused))->retry_after_ms(), 0u);
}

TEST(Messages, who_is_sent_away_hears_when_to_come_back_where_that_is_known) {
    MessageReader reader(Sender::server);
    const auto of = [&](const Bytes& bytes) { return read(reader, bytes)->body_as_GoAway(); };
    const auto says = [](std::uint32_t wait_ms) {
        return go_away(wire::ErrorCode::shutting_down, "later", wait_ms);
    };
    const Bytes hour = says(limits::retry_after_ms_max);
    EXPECT_EQ(of(hour)->retry_after_ms(), 3'600'000u);
    EXPECT_TRUE(check(*of(hour)));
    const Bytes longer = says(limits::retry_after_ms_max + 1);
    EXPECT_FALSE(check(*of(longer)));
    EXPECT_EQ(of(sample(Body::GoAway))->retry_after_ms(), 0u) << "bytes from before there was one";
}

// Added at the end; a sea of which it says nothing is steady.
TEST(Messages, what_glides_is_on_the_way_from_what_it_was_to_what_the_sea_state_says) {
    MessageReader reader(Sender::server);
    SeaStateValues state = some_state();
    const auto there = [&] { return values(*read(reader, sea_state(state))->body_as_SeaState()); };
    EXPECT_FALSE(there().glide);
    EXPECT_EQ(there().choppiness_x_at(1'000), state.choppiness_x);
    state.start_time_us = 10'000'000;
    state.glide = GlideValues{.end_us = 20'000'000,
                              .choppiness_x = 0.1,
                              .choppiness_y = 2.1,
                              .foam_mean = 0.24,
                              .foam_threshold = -0.25};
    const SeaStateValues read_back = there();
    // Half way half of it, a quarter of the way 0.103515625: 10 x^3 - 15 x^4 + 6 x^5.
    for (const auto& [time_us, share] : {std::pair(0, 0.0),
                                         {10'000'000, 0.0},
                                         {12'500'000, 0.103515625},
                                         {15'000'000, 0.5},
                                         {20'000'000, 1.0},
                                         {30'000'000, 1.0}}) {
        EXPECT_NEAR(read_back.choppiness_x_at(time_us), 0.1 + share * 1.0, 1e-12) << time_us;
        EXPECT_NEAR(read_back.choppiness_y_at(time_us), 2.1 - share * 1.2, 1e-12) << time_us;
        EXPECT_NEAR(read_back.foam_mean_at(time_us), 0.24 - share * 0.2, 1e-12) << time_us;
        EXPECT_NEAR(read_back.foam_threshold_at(time_us), -0.25 + share, 1e-12) << time_us;
    }
    EXPECT_EQ(there().realised_at(12'500'000).hs_m, state.realised.hs_m) << "older servers";
    EXPECT_EQ(there().longest_radpm(1), state.cascades[1].k_lo_radpm) << "older servers";
    state.glide->k_lo_radpm = {0.005, 0.07};
    EXPECT_EQ(there().longest_radpm(0), 0.005);
    EXPECT_EQ(there().longest_radpm(1), 0.07);
    for (const std::vector<double>& wrong :
         {std::vector{0.005}, {0.005, 0.07, 0.5}, {0.005, -1.0}, {std::nan(""), 0.07}}) {
        state.glide->k_lo_radpm = wrong;
        const auto bytes = sea_state(state);
        EXPECT_FALSE(check(*read(reader, bytes)->body_as_SeaState())) << wrong.size();
    }
    state.glide->k_lo_radpm = {};
    state.glide->realised = SeaNumbers{.hs_m = 10.2, .tp_s = 15, .tz_s = 11, .mean_from_deg = 350};
    state.realised.mean_from_deg = 20;
    const SeaNumbers half = there().realised_at(15'000'000);
    EXPECT_NEAR(half.hs_m, 0.5 * (10.2 + state.realised.hs_m), 1e-12);
    EXPECT_NEAR(half.mean_from_deg, 5, 1e-9) << "the shorter way round";
    EXPECT_NEAR(there().highest_hs_m(15'000'000), half.hs_m, 1e-12);
    EXPECT_EQ(there().highest_hs_m(30'000'000), state.realised.hs_m);
    state.glide->realised->hs_m = std::numeric_limits<double>::quiet_NaN();
    const auto no_number = sea_state(state);
    EXPECT_FALSE(check(*read(reader, no_number)->body_as_SeaState())) << "of what is drawn";
    state.glide->realised = {};
    state.glide->end_us = 9'999'999;
    const auto backwards = sea_state(state);
    EXPECT_FALSE(check(*read(reader, backwards)->body_as_SeaState())) << "ends before it begins";
}

TEST(Messages, a_kind_that_is_not_known_is_skipped_from_servers_and_refused_from_clients) {
    flatbuffers::FlatBufferBuilder built;
    const auto body = wire::CreateUnsubscribe(built);
    built.Finish(wire::CreateMessage(built, static_cast<Body>(200), body.Union()),
                 wire::MessageIdentifier());
    const std::span<const std::uint8_t> bytes(built.GetBufferPointer(), built.GetSize());
    MessageReader of_client(Sender::client);
    MessageReader of_server(Sender::server);
    EXPECT_FALSE(of_client.read(bytes).has_value());
    EXPECT_TRUE(of_server.read(bytes).has_value());
}

TEST(Messages, unaligned_bytes_are_read_like_aligned_ones) {
    MessageReader reader(Sender::client);
    for (const Bytes& bytes : samples(Sender::client))
        for (std::size_t shift = 1; shift < 8; ++shift) {
            Bytes shifted(shift);
            shifted.insert(shifted.end(), bytes.begin(), bytes.end());
            const auto message = reader.read(std::span(shifted).subspan(shift));
            ASSERT_TRUE(message.has_value());
            EXPECT_EQ(reinterpret_cast<std::uintptr_t>(*message) % 4, 0u);
        }
}

TEST(Messages, sizes_out_of_range_are_errors) {
    MessageReader reader(Sender::client);
    EXPECT_FALSE(reader.read({}).has_value());
    const Bytes short_one(7);
    EXPECT_FALSE(reader.read(short_one).has_value());
    const Bytes long_one(limits::client_message_bytes_max + 1);
    EXPECT_FALSE(reader.read(long_one).has_value());
}

TEST(Messages, a_message_as_long_as_may_be_is_read_and_one_byte_more_is_not) {
    for (const auto& [sender, bytes_max, message] :
         {std::tuple(Sender::client, limits::client_message_bytes_max, ping(1, 2)),
          std::tuple(Sender::server, limits::server_message_bytes_max, pong(1, 2, 3))}) {
        MessageReader reader(sender);
        Bytes padded = message; // bytes that nothing points at
        padded.resize(bytes_max);
        EXPECT_TRUE(reader.read(padded).has_value());
        padded.push_back(0);
        const auto beyond = reader.read(padded);
        ASSERT_FALSE(beyond.has_value());
        EXPECT_NE(beyond.error().message.find(std::to_string(bytes_max)), std::string::npos);
    }
}

TEST(Messages, the_largest_messages_of_each_side_fit_their_limits) {
    const std::vector<sea::QueryPoint> points(limits::points_per_query_max);
    EXPECT_LE(query(1, points, false).size(), limits::client_message_bytes_max);
    const std::vector<sea::Answer> answers(limits::points_per_query_max);
    EXPECT_LE(query_reply(1, 1, answers).size(), limits::server_message_bytes_max);
    // Incompressible lossless tile: zstd adds at most 1/256 and a header.
    const std::vector<std::uint8_t> payload(256 * 256 * 4 * 257 / 256 + 1024);
    EXPECT_LE(tile(some_tile(), payload).size(), limits::server_message_bytes_max);
    SeaStateValues state = some_state();
    state.scene.assign(limits::scene_bytes_max, 'x');
    EXPECT_LE(sea_state(state).size(), limits::server_message_bytes_max);
}

// What draws the sea is the same at both ends; a type of a later version is the default, and a server that says
// nothing of its water - zeros - has not chosen a black sea floor.
TEST(Messages, water_travels_and_nothing_said_of_it_is_the_default) {
    const auto read_back = [](const SeaStateValues& state) {
        const Bytes bytes = sea_state(state);
        MessageReader reader(Sender::server);
        return values(*(*reader.read(bytes))->body_as_SeaState());
    };
    SeaStateValues state = some_state();
    for (const auto& [name, type] : sea::water_types) {
        state.water.type = type;
        EXPECT_EQ(read_back(state).water, state.water) << name;
    }
    EXPECT_EQ(read_back(state).depth_m, 12.5);
    state.water.type = static_cast<sea::WaterType>(sea::water_types.size());
    EXPECT_EQ(read_back(state).water.type, sea::WaterType::north_sea);
    state.depth_m = 0;
    state.water = {sea::WaterType::north_sea, {0, 0, 0}};
    EXPECT_EQ(read_back(state).water, sea::Water{});
}

TEST(Messages, h6_damaged_messages_are_errors_or_can_be_read_whole) {
    // Structure that passes the verifier may hold any value; check() and every accessor must then
    // be safe (run under the address sanitizer).
    std::mt19937_64 numbers(6);
    int passed = 0;
    const auto attack = [&](Sender sender, const std::vector<Bytes>& messages) {
        MessageReader reader(sender);
        for (const Bytes& bytes : messages) {
            for (std::size_t length = 0; length < bytes.size(); ++length)
                (void)reader.read(std::span(bytes).first(length)).has_value();
            for (int round = 0; round < 4000; ++round) {
                Bytes bad = bytes;
                for (std::uint64_t flips = 1 + numbers() % 4; flips > 0; --flips)
                    bad[numbers() % bad.size()] = static_cast<std::uint8_t>(
                        numbers() % 3 == 0 ? numbers() : numbers() % 4 * 85);
                const auto message = reader.read(bad);
                if (!message)
                    continue;
                ++passed;
                const wire::Message& m = **message;
                if (!check(m))
                    continue;
                if (const auto* state = m.body_as_SeaState(); state) {
                    ASSERT_LE(values(*state).cascades.size(), 16u);
                }
                if (const auto* t = m.body_as_Tile(); t) {
                    ASSERT_LE(t->x0() + t->width(), t->size());
                }
                if (const auto* q = m.body_as_Query(); q && q->points() != nullptr) {
                    ASSERT_LE(q->points()->size(), limits::points_per_query_max);
                }
                if (const auto* f = m.body_as_Fetch(); f) {
                    ASSERT_LE(f->times_us()->size(), limits::times_per_fetch_max);
                }
                if (const auto* h = m.body_as_Hello(); h) {
                    ASSERT_GE(h->versions()->size(), 1u);
                }
            }
        }
    };
    attack(Sender::client, samples(Sender::client));
    attack(Sender::server, samples(Sender::server));
    EXPECT_GT(passed, 1000) << "the attack never got past the verifier";
}

TEST(Messages, values_out_of_range_are_errors_that_name_the_field) {
    MessageReader reader(Sender::client);
    const auto why = [&](const Bytes& bytes) {
        const Result<void> fine = check(*read(reader, bytes));
        return fine ? std::string() : fine.error().message;
    };
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const TileWish wish{.fields = sea::surface_fields};
    EXPECT_NE(why(subscribe(1, {.fields = {}}, 2)).find("fields"), std::string::npos);
    EXPECT_NE(why(subscribe(1, {.fields = sea::surface_fields, .error_m = nan}, 2)).find("error_m"),
              std::string::npos);
    EXPECT_NE(why(subscribe(1, wish, 0)).find("credit is 0, allowed are 1 to 8"),
              std::string::npos);
    EXPECT_NE(why(subscribe(1, wish, 9)).find("credit"), std::string::npos);
    EXPECT_NE(why(fetch(1, {}, wish)).find("times_us"), std::string::npos);
    const std::vector<sea::TimeUs> times(9);
    EXPECT_NE(why(fetch(1, times, wish)).find("times_us is 9, allowed are 1 to 8"),
              std::string::npos);
    const std::vector<sea::QueryPoint> points(257);
    EXPECT_EQ(why(query(1, points, false)), "");
    EXPECT_NE(why(query(1, points, true)).find("points"), std::string::npos);
}

// Naive: a part's height is held against its width, and what lies beyond the map is written there.
TEST(Messages, a_part_lies_within_its_map_whatever_its_shape) {
    MessageReader reader(Sender::server);
    const std::vector<std::uint8_t> payload(1);
    const auto why = [&](int x0, int y0, int width, int height) {
        TileHeader part = some_tile();
        part.size = 32;
        part.x0 = x0;
        part.y0 = y0;
        part.width = width;
        part.height = height;
        const Result<void> fine = check(*read(reader, tile(part, payload)));
        return fine ? std::string() : fine.error().message;
    };
    for (const auto& [width, height] : {std::pair(8, 20), std::pair(20, 8), std::pair(32, 1)}) {
        EXPECT_EQ(why(0, 0, width, height), "");
        EXPECT_EQ(why(32 - width, 32 - height, width, height), "");
        EXPECT_EQ(why(33 - width, 0, width, height).find("x0 is "), 0u);
        EXPECT_EQ(why(0, 33 - height, width, height).find("y0 is "), 0u);
    }
}

TEST(Messages, times_and_places_beyond_their_range_are_errors_that_say_which) {
    MessageReader reader(Sender::client);
    const TileWish wish{.fields = sea::surface_fields};
    const auto ask = [&](const sea::QueryPoint& point) {
        return check(*read(reader, query(1, {&point, 1}, false))->body_as_Query());
    };
    const auto get = [&](sea::TimeUs time_us) {
        return check(*read(reader, fetch(1, {&time_us, 1}, wish))->body_as_Fetch());
    };
    using Times = std::numeric_limits<sea::TimeUs>;
    for (const sea::TimeUs time_us :
         {Times::min(), -limits::time_us_max - 1, limits::time_us_max + 1, Times::max()}) {
        EXPECT_EQ(get(time_us).error().message.find("times_us [0] is "), 0u);
        EXPECT_TRUE(get(time_us).error().is(wire::ErrorCode::bad_value));
        EXPECT_EQ(ask({0, 0, time_us}).error().message.find("points.time_us [0] is "), 0u);
    }
    for (const sea::TimeUs time_us : {-limits::time_us_max, sea::TimeUs{0}, limits::time_us_max}) {
        EXPECT_TRUE(get(time_us));
        EXPECT_TRUE(ask({0, 0, time_us}));
    }
    for (const double far_m : {std::nextafter(limits::position_m_max, 1e300), -1e300}) {
        EXPECT_TRUE(ask({far_m, 0, 0}).error().is(wire::ErrorCode::bad_value));
        EXPECT_EQ(ask({far_m, 0, 0}).error().message.find("points.x_m [0] is "), 0u);
        EXPECT_EQ(ask({0, far_m, 0}).error().message.find("points.y_m [0] is "), 0u);
    }
    EXPECT_TRUE(ask({limits::position_m_max, -limits::position_m_max, 0}));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(ask({nan, std::numeric_limits<double>::infinity(), 0}))
        << "answered, and flagged as no number";
    const std::vector<sea::QueryPoint> many(limits::points_per_query_max + 1);
    EXPECT_TRUE(check(*read(reader, query(1, many, false))->body_as_Query())
                    .error()
                    .is(wire::ErrorCode::too_many_points));
}

TEST(Messages, golden_bytes_are_read_for_ever) {
    // A Ping(request_id 10, client_time_us -11) of protocol version 1, field by field in
    // docs/protocol.md. A change of the wire needs a new golden, never an edited one.
    const Bytes golden = ping(10, -11);
    const std::uint8_t bytes[] = {
        0x14, 0x00, 0x00, 0x00, 0x53, 0x45, 0x41, 0x57, 0x00, 0x00, 0x00, 0x00, 0x08, 0x00,
        0x0c, 0x00, 0x07, 0x00, 0x08, 0x00, 0x08, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x07,
        0x0c, 0x00, 0x00, 0x00, 0x08, 0x00, 0x10, 0x00, 0x04, 0x00, 0x08, 0x00, 0x08, 0x00,
        0x00, 0x00, 0x0a, 0x00, 0x00, 0x00, 0xf5, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff};
    EXPECT_EQ(golden, Bytes(std::begin(bytes), std::end(bytes)));
}

TEST(Messages, codes_have_names_and_close_codes) {
    EXPECT_EQ(name(ErrorCode::too_slow), "too_slow");
    EXPECT_EQ(name(static_cast<ErrorCode>(999)), "unknown");
    EXPECT_EQ(close_code(ErrorCode::none), 1000);
    EXPECT_EQ(close_code(ErrorCode::idle), 4013);
}

} // namespace
} // namespace seaway::protocol
