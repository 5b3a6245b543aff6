// SPDX-License-Identifier: Apache-2.0
// Probes and spectra there and back, and out of range.
#include <limits>

#include <gtest/gtest.h>

#include "protocol/limits.h"
#include "tests/protocol/sample_messages.h"

namespace seaway::protocol {
namespace {

using tests::read;
using tests::sample;
using tests::some_state;
using wire::Body;

TEST(SpectrumMessages, sixteen_probes_are_less_than_a_kilobyte) {
    SeaStateValues state = some_state();
    state.probes.clear();
    const std::size_t without = sea_state(state).size();
    state.probes.assign(sea::probe_count, {1, 2, 3, 4, 5, 6});
    EXPECT_LE(sea_state(state).size() - without, 1000u);
}

TEST(SpectrumMessages, probes_are_where_seas_are_and_say_numbers) {
    MessageReader reader(Sender::server);
    const auto why = [&](const sea::Probe& probe, double error_m = 1e-6) {
        SeaStateValues state = some_state();
        state.probes[1] = probe;
        state.probe_error_m = error_m;
        const Result<void> fine = check(*read(reader, sea_state(state)));
        return fine ? std::string() : fine.error().message;
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(why({1, 2, 3, 4, 5, 6}), "");
    EXPECT_EQ(why({nan, 2, 3, 4, 5, 6}).find("probes.x_m is nan"), 0u);
    EXPECT_EQ(why({1, -2e9, 3, 4, 5, 6}).find("probes.y_m is"), 0u);
    for (const sea::TimeUs time_us : {limits::time_us_max + 1, -limits::time_us_max - 1})
        EXPECT_EQ(why({1, 2, time_us, 4, 5, 6}).find("probes.time_us is"), 0u);
    EXPECT_EQ(why({1, 2, 3, nan, 5, 6}).find("probes.height_m is"), 0u);
    EXPECT_EQ(why({1, 2, 3, 4, nan, 6}).find("probes.displacement_x_m is"), 0u);
    EXPECT_EQ(why({1, 2, 3, 4, 5, nan}).find("probes.displacement_y_m is"), 0u);
    EXPECT_EQ(why({1, 2, 3, 4, 5, 6}, -1).find("probe_error_m is -1"), 0u);
    SeaStateValues many = some_state();
    many.probes.resize(limits::probes_max + 1);
    EXPECT_EQ(check(*read(reader, sea_state(many))).error().message.find("count of probes is 65"),
              0u);
}

TEST(SpectrumMessages, those_of_a_spectrum_read_back_as_they_were_written) {
    MessageReader of_client(Sender::client), reader(Sender::server);
    const auto* wish =
        read(of_client, sample(Body::SubscribeSpectrum))->body_as_SubscribeSpectrum();
    EXPECT_EQ(wish->slope_error(), 0.005f);
    EXPECT_EQ(wish->fields(), sea::surface_fields.bits());
    const SpectrumGrant granted =
        grant(*read(reader, sample(Body::SpectrumSubscribed))->body_as_SpectrumSubscribed());
    EXPECT_EQ(spectrum_subscribed(11, granted), sample(Body::SpectrumSubscribed));
    EXPECT_EQ(granted.why, "foam is no wave");
    const SpectrumHead begun = head(*read(reader, sample(Body::Spectrum))->body_as_Spectrum());
    EXPECT_EQ(spectrum(begun), sample(Body::Spectrum));
    EXPECT_EQ(begun.steps, (sea::SpectrumSteps{0.0000625, 2.5}));
    EXPECT_EQ(begun.dispersion.depth_m, 95.5);
    const auto* chunk = read(reader, sample(Body::SpectrumChunk))->body_as_SpectrumChunk();
    EXPECT_EQ(chunk->chunk(), 11u);
    EXPECT_EQ(left(*chunk).displacement_m, 0.25);
    EXPECT_EQ(left(*chunk).slope, 0.0625);
}

TEST(SpectrumMessages, what_a_spectrum_says_is_in_range_or_named) {
    MessageReader reader(Sender::server);
    const auto why = [&](const auto& change) {
        SpectrumHead begun = tests::some_spectrum();
        change(begun);
        const Result<void> fine = check(*read(reader, spectrum(begun)));
        return fine ? std::string() : fine.error().message;
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinite = std::numeric_limits<double>::infinity();
    EXPECT_EQ(why([&](SpectrumHead& h) { h.dispersion.depth_m = infinite; }), "");
    EXPECT_EQ(why([&](SpectrumHead& h) { h.dispersion.depth_m = 0; }).find("depth_m"), 0u);
    EXPECT_EQ(why([&](SpectrumHead& h) { h.dispersion.gravity_mps2 = nan; }).find("gravity"), 0u);
    EXPECT_EQ(why([&](SpectrumHead& h) { h.dispersion.surface_tension_m3ps2 = -1; }).find("surf"),
              0u);
    EXPECT_EQ(why([&](SpectrumHead& h) { h.steps.step_m = infinite; }).find("step_m"), 0u);
    EXPECT_EQ(why([&](SpectrumHead& h) { h.steps.length_m = -1; }).find("step_length_m"), 0u);
    EXPECT_EQ(why([&](SpectrumHead& h) { h.loop_period_us = -1; }).find("loop_period_us"), 0u);
    EXPECT_EQ(why([&](SpectrumHead& h) { h.chunks = 4097; }).find("chunks is 4097"), 0u);
    const std::vector<std::uint8_t> long_one(limits::spectrum_chunk_bytes_max + 1);
    EXPECT_EQ(check(*read(reader, spectrum_chunk(1, 0, {}, long_one)))
                  .error()
                  .message.find("count of payload bytes"),
              0u);
    EXPECT_FALSE(check(*read(reader, spectrum_chunk(1, 4096, {}, {long_one.data(), 1}))));
    EXPECT_FALSE(check(*read(reader, spectrum_chunk(1, 0, {}, {}))));
    EXPECT_FALSE(check(*read(reader, spectrum_chunk(1, 0, {nan, 0, 0}, {long_one.data(), 1}))));
}

} // namespace
} // namespace seaway::protocol
