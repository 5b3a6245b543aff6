// SPDX-License-Identifier: Apache-2.0
// One message of every kind, with plausible values that differ from the defaults. The goldens of
// tests/golden were made from these; see the note there before a value is changed.
#pragma once

#include <deque>
#include <utility>

#include <gtest/gtest.h>

#include "protocol/messages.h"

namespace seaway::protocol::tests {

inline SeaStateValues some_state() {
    SeaStateValues state{.epoch = 3,
                         .start_time_us = 12,
                         .cascades = {},
                         .scene = "[sea]\n",
                         .warnings = {"first", ""}};
    state.cascades = {{1021.0, 256, 0.006, 0.19, false, 800'000},
                      {197.0, 256, 0.19, 1.0, false, 200'000}};
    state.choppiness_x = 1.1;
    state.choppiness_y = 0.9;
    state.requested = {.hs_m = 6.5,
                       .tp_s = 11.2,
                       .tz_s = 7.9,
                       .tm01_s = 8.25,
                       .mean_from_deg = 220,
                       .spread_deg = 28,
                       .mss = 0.04};
    state.realised = {.hs_m = 6.4,
                      .tp_s = 11.1,
                      .tz_s = 8,
                      .tm01_s = 8.5,
                      .mean_from_deg = 225,
                      .spread_deg = 30,
                      .mss = 0.03};
    state.height_error_m = 0.01;
    state.interpolation_error_m = 0.003;
    state.rms_slope = 0.1;
    state.foam_mean = 0.04;
    state.foam_threshold = 0.75;
    state.displacement_reach_m = 17.5;
    state.rms_strain = 0.3;
    state.interpolation_displacement_m = 0.02;
    state.interpolation_strain = 0.05;
    state.losses = {{{.time_m = 0.25, .east_m = 0.5, .north_m = 0.75},
                     {.time_m = 1.25, .east_m = 1.5, .north_m = 1.75}},
                    {{.time_m = 2.25, .east_m = 2.5, .north_m = 2.75},
                     {.time_m = 3.25, .east_m = 3.5, .north_m = 3.75}}};
    state.single_precision_m = 0.001;
    state.single_precision_displacement_m = 0.002;
    state.depth_m = 12.5;
    state.water = {sea::WaterType::coastal_3, {0.5, 0.25, 0.125}};
    state.probes = {{-1.5, 2.5, 3'500'000, 4.5, -5.5, 6.5}, {7.5, -8.5, -9, -1.25, 1.5, -1.75}};
    state.probe_error_m = 1e-6;
    return state;
}

inline TileHeader some_tile() {
    return {.keyframe = 77,
            .epoch = 3,
            .cascade = 2,
            .field = sea::Field::slope_y,
            .time_us = -400'000,
            .size = 512,
            .x0 = 256,
            .y0 = 0,
            .width = 256,
            .height = 256,
            .part = 1,
            .parts = 4,
            .error = 0.004f};
}

inline SpectrumGrant some_grant() {
    return {.error_m = 0.01f,
            .slope_error = 0.0025f,
            .fields = sea::surface_fields,
            .spectra = 2,
            .why = "foam is no wave"};
}

inline SpectrumHead some_spectrum() {
    return {.epoch = 3,
            .chunks = 12,
            .bytes = 34567,
            .steps = {0.0000625, 2.5},
            .dispersion = {9.75, 0.0000625, 95.5},
            .loop_period_us = 60'000'000};
}

inline ChangeWish some_change() {
    return {
        .set = {"sea.depth_m=12", "sea.seed=3"}, .scene = "", .over_us = 120'000'000, .at_us = -5};
}

inline std::vector<sea::Answer> some_answers() {
    return {{.height_m = 1.25,
             .normal = {0.1, -0.2, 0.97},
             .velocity_mps = {1.5, -0.5, 0.25},
             .error_m = 0.01,
             .flags = 5}};
}

inline constexpr sea::TimeUs some_times[] = {-5, 1'000'000};
inline constexpr std::uint64_t some_others[] = {7, 1ull << 41};
inline constexpr double some_depths[] = {-3.5, 1.0};
inline constexpr sea::WaterBelow some_waters[] = {{{1, 2, -3}, 9.5}};
inline constexpr sea::QueryPoint some_points[] = {{1.5, -2.5, 7}, {1e6, 2e6, -9}};

/// A message of this kind. No default: a new kind does not compile without its sample.
inline Bytes sample(wire::Body body) {
    using wire::Body;
    const std::uint8_t payload[] = {1, 2, 3};
    const TileWish wish{.cascades = 3u, .fields = sea::surface_fields, .error_m = 0.01f};
    switch (body) {
    case Body::Hello:
        return hello("test 1.0", "secret");
    case Body::Subscribe:
        return subscribe(7, wish, 4);
    case Body::Unsubscribe:
        return unsubscribe();
    case Body::Ack:
        return ack(1ull << 40, some_others);
    case Body::Fetch:
        return fetch(8, some_times, wish);
    case Body::Query:
        return query(9, some_points, true, {3u, 2.5}, some_depths);
    case Body::Ping:
        return ping(10, -11);
    case Body::Welcome:
        return welcome(4, "seaway 0.1.0", 5);
    case Body::SeaState:
        return sea_state(some_state());
    case Body::Subscribed:
        return subscribed(7, {.cascades = 3u, .fields = sea::surface_fields, .error_m = 0.02f}, 4);
    case Body::Tile:
        return tile(some_tile(), payload);
    case Body::QueryReply:
        return query_reply(9, 3, some_answers(), some_waters, 5u);
    case Body::FetchDone:
        return fetch_done(8, 6, sea::surface_fields);
    case Body::Pong:
        return pong(10, -11, 12);
    case Body::Refused:
        return refused(9, wire::ErrorCode::too_many_points, "4097 points");
    case Body::GoAway:
        return go_away(wire::ErrorCode::shutting_down, "the server stops");
    case Body::SubscribeSpectrum:
        return subscribe_spectrum(11, {0.02f, 0.005f, sea::surface_fields});
    case Body::SpectrumSubscribed:
        return spectrum_subscribed(11, some_grant());
    case Body::Spectrum:
        return spectrum(some_spectrum());
    case Body::SpectrumChunk:
        return spectrum_chunk(3, 11, {0.125, 0.25, 0.0625}, payload);
    case Body::Change:
        return change(11, some_change());
    case Body::Administer:
        return administer(12, wire::Act::drop, 77);
    case Body::Changed:
        return changed(11, 4, 5'000'000, 125'000'000, 9);
    case Body::Administered:
        return administered(12, "{}\n");
    case Body::Pace:
        return pace(sea::Pace{7'000'000, 5'000'000, 2'500});
    case Body::NONE:
        break;
    }
    return {};
}

/// The same message with its list copied to the end, `shift` bytes behind a multiple of 8.
inline Bytes with_list_at(const Bytes& message, const flatbuffers::Table& body,
                          flatbuffers::voffset_t field, std::size_t element_bytes,
                          std::size_t shift) {
    // In the table stands the distance to the list: its count, then its values.
    const std::uint8_t* place = body.GetAddressOf(field);
    const auto at = static_cast<std::size_t>(place - message.data());
    Bytes bytes = message;
    const std::size_t from = at + flatbuffers::ReadScalar<flatbuffers::uoffset_t>(place);
    const std::size_t length =
        4 + element_bytes * flatbuffers::ReadScalar<flatbuffers::uoffset_t>(&bytes[from]);
    while (bytes.size() % 8 != (shift + 4) % 8)
        bytes.push_back(0);
    const std::size_t to = bytes.size();
    for (std::size_t i = 0; i < length; ++i)
        bytes.push_back(Bytes::value_type(bytes[from + i]));
    flatbuffers::WriteScalar(&bytes[at], static_cast<flatbuffers::uoffset_t>(to - at));
    return bytes;
}

/// The message in these bytes, which it refers to; null, and a failure, where there is none.
inline const wire::Message* read(MessageReader& reader, const Bytes& bytes) {
    const auto message = reader.read(bytes);
    EXPECT_TRUE(message.has_value()) << (message ? "" : message.error().message);
    return message ? *message : nullptr;
}

/// The same of bytes that nobody else keeps.
inline const wire::Message* read(MessageReader& reader, Bytes&& bytes) {
    static std::deque<Bytes> all;
    return read(reader, all.emplace_back(std::move(bytes)));
}

/// Samples of every kind that this side sends.
inline std::vector<Bytes> samples(Sender sender) {
    std::vector<Bytes> messages;
    for (const MessageInfo& row : message_table)
        if (row.sender == sender)
            messages.push_back(sample(row.body));
    return messages;
}

} // namespace seaway::protocol::tests
