// SPDX-License-Identifier: Apache-2.0
// Every range of every value that a message carries: its ends pass, what lies just beyond them is an
// error that begins with the name of the value. Nothing else of the message is wrong meanwhile.
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sea/basics/foam_range.h"
#include "tests/protocol/sample_messages.h"

namespace seaway::protocol {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::string why_not(Sender sender, const Bytes& bytes) {
    MessageReader reader(sender);
    const auto message = reader.read(bytes);
    if (!message)
        return message.error().message;
    const Result<void> fine = check(**message);
    if (fine)
        return {};
    EXPECT_TRUE(fine.error().is(wire::ErrorCode::bad_value)) << fine.error().message;
    return fine.error().message;
}

void expect_refused(const std::string& why, const std::string& name) {
    EXPECT_TRUE(why.starts_with(name + " is ")) << name << ": \"" << why << '"';
}

void expect_either(const std::string& why, bool fine, const std::string& name) {
    if (fine)
        EXPECT_EQ(why, "") << name;
    else
        expect_refused(why, name);
}

/// What just lies beyond an end, as a double and as a float.
double below(double end, bool single) {
    return single ? static_cast<double>(std::nextafter(static_cast<float>(end), -INFINITY))
                  : std::nextafter(end, -INFINITY);
}
double above(double end, bool single) {
    return single ? static_cast<double>(std::nextafter(static_cast<float>(end), INFINITY))
                  : std::nextafter(end, INFINITY);
}

/// `message` with a value in it.
void expect_range(const std::string& name, double lo, double hi, bool single,
                  const std::function<std::string(double)>& why) {
    EXPECT_EQ(why(lo), "") << name;
    EXPECT_EQ(why(hi), "") << name;
    expect_refused(why(below(lo, single)), name);
    expect_refused(why(above(hi, single)), name);
    expect_refused(why(nan), name);
}

TEST(MessageLimits, each_number_of_a_sea_state_has_its_own_range) {
    const auto range = [](const std::string& name, double SeaStateValues::*member, double lo,
                          double hi) {
        expect_range(name, lo, hi, false, [member](double value) {
            SeaStateValues state = tests::some_state();
            state.*member = value;
            return why_not(Sender::server, sea_state(state));
        });
    };
    using S = SeaStateValues;
    range("choppiness_x", &S::choppiness_x, -10, 10);
    range("choppiness_y", &S::choppiness_y, -10, 10);
    range("height_error_m", &S::height_error_m, 0, 1e6);
    range("interpolation_error_m", &S::interpolation_error_m, 0, 1e6);
    range("rms_slope", &S::rms_slope, 0, 1e6);
    range("foam_mean", &S::foam_mean, 0, sea::foam_mean_max);
    range("foam_threshold", &S::foam_threshold, -1, 1);
    range("displacement_reach_m", &S::displacement_reach_m, 0, 1e9);
    range("rms_strain", &S::rms_strain, 0, 1e9);
    range("interpolation_displacement_m", &S::interpolation_displacement_m, 0, 1e9);
    range("interpolation_strain", &S::interpolation_strain, 0, 1e9);
    range("single_precision_m", &S::single_precision_m, 0, 1e6);
    range("single_precision_displacement_m", &S::single_precision_displacement_m, 0, 1e9);
}

TEST(MessageLimits, depth_may_be_without_end_and_a_sea_floor_sends_back_a_share_of_light) {
    const auto with_depth = [](double depth_m) {
        SeaStateValues state = tests::some_state();
        state.depth_m = depth_m;
        return why_not(Sender::server, sea_state(state));
    };
    EXPECT_EQ(with_depth(0), "");
    EXPECT_EQ(with_depth(INFINITY), "");
    expect_refused(with_depth(-1e-9), "depth_m");
    expect_refused(with_depth(nan), "depth_m");
    const char* const names[] = {"bottom_red", "bottom_green", "bottom_blue"};
    for (std::size_t i = 0; i < 3; ++i)
        expect_range(names[i], 0, 1, true, [i](double value) {
            SeaStateValues state = tests::some_state();
            state.water.bottom_albedo[i] = value;
            return why_not(Sender::server, sea_state(state));
        });
}

// Of the second cascade: the first one is fine.
TEST(MessageLimits, each_number_of_each_cascade_has_its_own_range) {
    const auto with = [](const std::function<void(SeaStateValues&)>& change) {
        SeaStateValues state = tests::some_state();
        change(state);
        return why_not(Sender::server, sea_state(state));
    };
    const auto range = [&](const std::string& name, double CascadeInfo::*member, double lo,
                           double hi) {
        expect_range(name, lo, hi, false, [&](double value) {
            return with([&](SeaStateValues& state) { state.cascades[1].*member = value; });
        });
    };
    range("length_m", &CascadeInfo::length_m, 1e-3, 1e9);
    range("k_lo_radpm", &CascadeInfo::k_lo_radpm, 0, 1e9);
    range("k_hi_radpm", &CascadeInfo::k_hi_radpm, 0, 1e9);
    for (const auto& [size, fine] : {std::pair(1, true), {2048, true}, {0, false}, {2049, false}}) {
        const std::string why =
            with([size = size](SeaStateValues& state) { state.cascades[1].size = size; });
        expect_either(why, fine, "size");
    }
    for (const auto& [interval_us, fine] :
         {std::pair(1ll, true), {3'600'000'000, true}, {0, false}, {3'600'000'001, false}}) {
        const std::string why =
            with([us = interval_us](SeaStateValues& state) { state.cascades[1].interval_us = us; });
        expect_either(why, fine, "interval_us");
    }
    const auto loss = [&](const std::string& name, sea::MapLoss sea::CascadeLoss::*map,
                          double sea::MapLoss::*member) {
        expect_range(name, 0, 1e9, true, [&](double value) {
            return with([&](SeaStateValues& state) { (state.losses[1].*map).*member = value; });
        });
    };
    loss("time_m", &sea::CascadeLoss::height, &sea::MapLoss::time_m);
    loss("east_m", &sea::CascadeLoss::height, &sea::MapLoss::east_m);
    loss("north_m", &sea::CascadeLoss::height, &sea::MapLoss::north_m);
    loss("displacement_time_m", &sea::CascadeLoss::displacement, &sea::MapLoss::time_m);
    loss("displacement_east_m", &sea::CascadeLoss::displacement, &sea::MapLoss::east_m);
    loss("displacement_north_m", &sea::CascadeLoss::displacement, &sea::MapLoss::north_m);
    const auto counts = [&](std::size_t cascades, std::size_t losses) {
        return with([&](SeaStateValues& state) {
            state.cascades.resize(cascades, state.cascades[0]);
            state.losses.resize(losses, state.losses[0]);
        });
    };
    EXPECT_EQ(counts(16, 16), "");
    EXPECT_EQ(counts(16, 0), "") << "an older server says nothing of them";
    expect_refused(counts(17, 17), "count of cascades");
    expect_refused(counts(3, 2), "count of losses");
    expect_refused(counts(3, 4), "count of losses");
}

TEST(MessageLimits, each_number_of_a_tile_has_its_own_range) {
    const std::vector<std::uint8_t> payload(1);
    const auto why = [&](const std::function<void(TileHeader&)>& change) {
        TileHeader header = tests::some_tile();
        header.size = 2048;
        change(header);
        return why_not(Sender::server, tile(header, payload));
    };
    const auto whole = [&](const std::string& name, int TileHeader::*member, int lo, int hi) {
        const auto at = [&](int value) {
            return why([&](TileHeader& header) {
                header.part = 0;
                header.*member = value;
            });
        };
        EXPECT_EQ(at(lo), "") << name;
        EXPECT_EQ(at(hi), "") << name;
        if (lo > 0) // on the wire they have no sign
            expect_refused(at(lo - 1), name);
        expect_refused(at(hi + 1), name);
    };
    whole("cascade", &TileHeader::cascade, 0, 15);
    const auto alone = [&](int size) { // the map is one point
        return why([&](TileHeader& header) { header = {.size = size, .width = 1, .height = 1}; });
    };
    EXPECT_EQ(alone(1), "");
    EXPECT_EQ(alone(2048), "");
    expect_refused(alone(0), "size");
    expect_refused(alone(2049), "size");
    whole("width", &TileHeader::width, 1, 256);
    whole("height", &TileHeader::height, 1, 256);
    whole("x0", &TileHeader::x0, 0, 2048 - 256);
    whole("y0", &TileHeader::y0, 0, 2048 - 256);
    whole("parts", &TileHeader::parts, 1, 64);
    whole("part", &TileHeader::part, 0, 3); // of four
    const auto field = [&](int number) {
        return why([&](TileHeader& header) { header.field = static_cast<sea::Field>(number); });
    };
    EXPECT_EQ(field(0), "");
    EXPECT_EQ(field(sea::field_count - 1), "");
    expect_refused(field(sea::field_count), "field");
    expect_range("error", 0, 1e6, true, [&](double value) {
        return why([&](TileHeader& header) { header.error = static_cast<float>(value); });
    });
    expect_refused(why_not(Sender::server, tile(tests::some_tile(), {})), "count of payload bytes");
}

TEST(MessageLimits, each_number_of_a_request_has_its_own_range) {
    const auto said = [](std::size_t name, std::size_t token, std::size_t versions) {
        return why_not(Sender::client, hello(std::string(name, 'n'), std::string(token, 't'),
                                             std::vector<std::uint16_t>(versions, 1)));
    };
    EXPECT_EQ(said(0, 0, 1), "");
    EXPECT_EQ(said(1024, 1024, 16), "");
    expect_refused(said(1025, 0, 1), "length of client");
    expect_refused(said(0, 1025, 1), "length of token");
    expect_refused(said(0, 0, 0), "count of versions");
    expect_refused(said(0, 0, 17), "count of versions");
    const std::vector<sea::TimeUs> times(8);
    TileWish wish{.cascades = 1u, .fields = sea::surface_fields};
    expect_range("error_m", 0, 1e6, true, [&](double value) {
        wish.error_m = static_cast<float>(value);
        const std::string why = why_not(Sender::client, subscribe(1, wish, 8));
        EXPECT_EQ(why_not(Sender::client, fetch(1, times, wish)), why);
        EXPECT_EQ(why_not(Sender::server, subscribed(1, wish, 8)), why);
        return why;
    });
    wish.error_m = 0;
    for (const auto& [credit, fine] : {std::pair(1, true), {8, true}, {0, false}, {9, false}}) {
        const std::string why = why_not(Sender::client, subscribe(1, wish, credit));
        EXPECT_EQ(why_not(Sender::server, subscribed(1, wish, credit)), why);
        expect_either(why, fine, "credit");
    }
    const auto acknowledged = [](std::size_t others) {
        return why_not(Sender::client, ack(1, std::vector<std::uint64_t>(others)));
    };
    EXPECT_EQ(acknowledged(0), "");
    EXPECT_EQ(acknowledged(8), "");
    expect_refused(acknowledged(9), "count of also");
    const auto answered = [](std::size_t count) {
        return why_not(Sender::server, query_reply(1, 2, std::vector<sea::Answer>(count)));
    };
    EXPECT_EQ(answered(0), "");
    EXPECT_EQ(answered(4096), "");
    expect_refused(answered(4097), "count of answers");
}

TEST(MessageLimits, of_depths_and_of_the_waves_that_count) {
    const auto asked = [](std::size_t points, const std::vector<double>& z_m, double wave_m = 0) {
        return why_not(Sender::client,
                       query(1, std::vector<sea::QueryPoint>(points), false, {1, wave_m}, z_m));
    };
    EXPECT_EQ(asked(2, {-1e9, nan}), "") << "what is no number is answered, and flagged";
    EXPECT_EQ(asked(2, {1e9, -0.0}), "");
    expect_refused(asked(1, {-1.000001e9}), "z_m [0]");
    expect_refused(asked(2, {0, 1.000001e9}), "z_m [1]");
    expect_refused(asked(3, {-1, -2}), "count of z_m");
    expect_refused(asked(0, {-1}), "count of z_m");
    expect_range("min_wavelength_m", 0, 1e9, false,
                 [&](double value) { return asked(1, {}, value); });
    MessageReader reader(Sender::client);
    const std::vector<double> depths(257);
    const Bytes many = query(1, std::vector<sea::QueryPoint>(257), false, {}, depths);
    const auto message = reader.read(many);
    ASSERT_TRUE(message);
    EXPECT_TRUE(check(**message).error().is(wire::ErrorCode::too_many_points))
        << "depths are exact questions, of which there are 256 at most";
}

TEST(
    Messages,
    how_long_a_server_has_been_unsure_is_said_with_its_time_and_never_less_than_nothing_or_beyond_a_day) {
    const auto heard = [](std::int64_t unsure_us) {
        sea::SeaTime time(7, 8);
        time.unsure_us = unsure_us;
        MessageReader reader(Sender::server), again(Sender::server);
        const Bytes in_pong = pong(1, 2, time), in_welcome = welcome(1, "any", time);
        const sea::SeaTime one = sea_time(*(*reader.read(in_pong))->body_as_Pong());
        const sea::SeaTime other = sea_time(*(*again.read(in_welcome))->body_as_Welcome());
        EXPECT_EQ(one.unsure_us, other.unsure_us);
        EXPECT_EQ(one.sea_us, 7);
        EXPECT_EQ(one.elapsed_us, 8);
        return one.unsure_us;
    };
    EXPECT_EQ(heard(0), 0);
    EXPECT_EQ(heard(2'500'000), 2'500'000);
    EXPECT_EQ(heard(-1), 0);
    EXPECT_EQ(heard(std::numeric_limits<std::int64_t>::min()), 0);
    EXPECT_EQ(heard(std::numeric_limits<std::int64_t>::max()), limits::unsure_us_max);
}

TEST(MessageLimits, a_server_says_times_of_a_sea_alone_since_clocks_add_them_to_each_other) {
    for (const std::int64_t far_us :
         {limits::time_us_max + 1, -limits::time_us_max - 1,
          std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()})
        for (const sea::SeaTime& time : {sea::SeaTime(far_us, 8), sea::SeaTime(7, far_us)}) {
            MessageReader reader(Sender::server), again(Sender::server);
            const Bytes in_pong = pong(1, 2, time), in_welcome = welcome(1, "any", time);
            EXPECT_FALSE(check(*(*reader.read(in_pong))->body_as_Pong())) << far_us;
            EXPECT_FALSE(check(*(*again.read(in_welcome))->body_as_Welcome())) << far_us;
        }
    MessageReader reader(Sender::server);
    const Bytes last = pong(1, 2, sea::SeaTime(limits::time_us_max, -limits::time_us_max));
    EXPECT_TRUE(check(*(*reader.read(last))->body_as_Pong()));
}

TEST(MessageLimits, a_sea_begins_within_all_times_whether_it_glides_or_not) {
    SeaStateValues state = tests::some_state();
    state.glide = {};
    const auto why = [&](sea::TimeUs start_us) {
        state.start_time_us = start_us;
        return why_not(Sender::server, sea_state(state));
    };
    EXPECT_EQ(why(-limits::time_us_max), "");
    for (const sea::TimeUs beyond :
         {-limits::time_us_max - 1, limits::time_us_max + 1,
          std::numeric_limits<sea::TimeUs>::min(), std::numeric_limits<sea::TimeUs>::max()})
        expect_refused(why(beyond), "start_time_us");
}

} // namespace
} // namespace seaway::protocol
