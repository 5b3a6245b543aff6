// SPDX-License-Identifier: Apache-2.0
// Which waves a wish gets, and that they are made once.
#include <gtest/gtest.h>

#include "protocol/limits.h"
#include "protocol/messages.h"
#include "protocol/spectrum_codec.h"
#include "sea/scene/scene.h"
#include "sea/waves/quantised_spectrum.h"
#include "sea/waves/spectrum_builder.h"
#include "server/host/quality.h"
#include "server/host/refusal.h"
#include "server/publish/spectrum_store.h"

namespace seaway::server {
namespace {

using sea::Field;
using sea::FieldSet;

SpectrumSource some_waves() {
    constexpr const char* text = R"(
[sea]
seed = 7
[[sea.system]]
type = "wind"
spectrum = "jonswap"
wind_speed_10m_mps = 9.0
from_deg = 250
fetch_m = 40e3
spreading = "hasselmann"
[[cascade]]
length_m = 301.0
size = 64
[[cascade]]
length_m = 43.0
size = 64
)";
    const Result<sea::Scene> scene = sea::parse_scene(text, "some_waves", ".");
    EXPECT_TRUE(scene);
    return {1, std::make_shared<const sea::Realization>(*sea::realize(*scene)),
            scene->sea.dispersion(), 0.02};
}

GrantedSpectrum granted(SpectrumStore& store, const SpectrumSource& sea, double error_m,
                        double slope, FieldSet fields = sea::surface_fields) {
    const Result<GrantedSpectrum> found =
        store.grant(sea, {static_cast<float>(error_m), static_cast<float>(slope), fields});
    EXPECT_TRUE(found) << (found ? "" : found.error().message);
    return found ? *found : GrantedSpectrum{};
}

TEST(SpectrumStore, a_wish_gets_the_coarsest_rung_that_keeps_it_and_says_where_there_is_none) {
    const SpectrumSource sea = some_waves(); // height_error_m = 0.02
    SpectrumStore store;
    const auto expect = [&](double error_m, double slope, double gets_m, double gets_slope,
                            const std::string& why) {
        const GrantedSpectrum grant = granted(store, sea, error_m, slope);
        EXPECT_FLOAT_EQ(grant.error_m, static_cast<float>(gets_m));
        EXPECT_FLOAT_EQ(grant.slope_error, static_cast<float>(gets_slope));
        EXPECT_EQ(grant.why.substr(0, why.size()), why);
        EXPECT_EQ(grant.why.empty(), why.empty()) << grant.why;
    };
    expect(0, 0, 0.02, 0.005, "");
    expect(0.02, 0.005, 0.02, 0.005, "");
    expect(0.0399, 0.0199, 0.02, 0.01, "");
    expect(0.04, 0.02, 0.04, 0.02, "");
    expect(100, 0.05, 0.32, 0.05, "");
    expect(0.019, 0.005, 0.01, 0.005, "");
    expect(0.005, 0.005, 0.005, 0.005, "");
    expect(0.0049, 0.005, 0.005, 0.005, "heights within 0.005 m are the finest");
    EXPECT_GT(granted(store, sea, 0.02, 10).slope_error, 0.01f) << "what heights alone leave";
    expect(0.02, 0.0049, 0.02, 0.005, "slopes within 0.005 are the finest");
}

TEST(SpectrumStore, each_rung_is_made_once_and_forgotten_with_its_sea) {
    const SpectrumSource first = some_waves();
    SpectrumStore store;
    const EncodedSpectrumPtr one = granted(store, first, 0.02, 0.005).spectra.at(0);
    EXPECT_EQ(granted(store, first, 0.03, 0.009).spectra.at(0), one);
    EXPECT_NE(granted(store, first, 0.04, 0.005).spectra.at(0), one);
    SpectrumSource later = first;
    for (later.epoch = first.epoch + 1; later.epoch <= first.epoch + protocol::limits::spectra_max;
         ++later.epoch)
        EXPECT_EQ(granted(store, later, 0, 0).spectra.at(0)->epoch, later.epoch);
    EXPECT_EQ(one.use_count(), 1) << "the store holds as many seas as are sent at once";
}

// ---- the room for them -----------------------------------------------------------------------

/// What a wish gets takes in memory.
std::size_t bytes_of(const SpectrumSource& sea, double error_m, double slope) {
    SpectrumStore store;
    return granted(store, sea, error_m, slope).spectra.at(0)->bytes;
}

TEST(SpectrumStore, holds_what_there_is_room_for_and_lets_go_of_the_oldest_use_first) {
    const SpectrumSource sea = some_waves();
    const std::size_t fine = bytes_of(sea, 0.01, 0.005);
    const auto room = Room::of(2 * fine);
    SpectrumStore store(room);
    const auto ask = [&](double error_m) { (void)granted(store, sea, error_m, 0.005); };
    ask(0.01);
    ask(0.02);
    EXPECT_EQ(store.made_so_far(), 2u);
    EXPECT_EQ(room->held_bytes(), fine + bytes_of(sea, 0.02, 0.005));
    ask(0.01); // the other one is the oldest use now
    ask(0.04);
    EXPECT_EQ(store.made_so_far(), 3u);
    EXPECT_LE(room->held_bytes_most(), room->bytes_max());
    ask(0.01);
    EXPECT_EQ(store.made_so_far(), 3u) << "is held";
    ask(0.02);
    EXPECT_EQ(store.made_so_far(), 4u) << "was let go of, and is made again";
    EXPECT_LE(room->held_bytes_most(), room->bytes_max());
}

// Naive: the store counts what it remembers, and a reader who takes a chunk a minute holds bytes that nobody counts.
TEST(SpectrumStore,
     who_still_has_one_message_to_send_holds_the_room_and_others_are_told_when_to_ask) {
    const SpectrumSource sea = some_waves();
    const auto room = Room::of(bytes_of(sea, 0.01, 0.005) * 3 / 2);
    SpectrumStore store(room);
    EncodedSpectrumPtr slow = granted(store, sea, 0.04, 0.02).spectra.at(0);
    const std::size_t read = slow->bytes;
    EncodedSpectrum::Message last = slow->messages.back();
    slow = nullptr;
    const SpectrumDemand finer{0.01f, 0.005f};
    for (int again = 0; again < 3; ++again) {
        const Result<GrantedSpectrum> refused = store.grant(sea, finer);
        ASSERT_FALSE(refused);
        EXPECT_TRUE(refused.error().is(Refusal::busy));
        EXPECT_EQ(refused.error().retry_after_ms, 1000u);
        EXPECT_NE(refused.error().message.find("waves that others have not read yet"),
                  std::string::npos);
        EXPECT_EQ(room->held_bytes(), read) << "what he has";
        EXPECT_TRUE(store.held(std::span(&sea, 1), {0.04f, 0.02f}))
            << "nothing was let go of in vain";
    }
    EXPECT_EQ(store.made_so_far(), 2u) << "what is known to be too large is not made once more";
    last = nullptr;
    EXPECT_TRUE(store.grant(sea, finer)) << "he has it";
    EXPECT_LE(room->held_bytes_most(), room->bytes_max());
}

TEST(SpectrumStore, where_readers_fill_the_room_a_wish_gets_something_finer_that_is_there) {
    const SpectrumSource sea = some_waves();
    const std::size_t fine = bytes_of(sea, 0.01, 0.005);
    SpectrumStore store(Room::of(fine));
    const EncodedSpectrumPtr read = granted(store, sea, 0.01, 0.005).spectra.at(0);
    const GrantedSpectrum coarse = granted(store, sea, 0.08, 0.02);
    EXPECT_EQ(coarse.spectra.at(0), read);
    EXPECT_LE(coarse.error_m, 0.08f);
    EXPECT_LE(coarse.slope_error, 0.02f);
    EXPECT_FALSE(store.grant(sea, {0.005f, 0.005f})) << "coarser than it was wished";
}

TEST(SpectrumStore, of_several_seas_one_without_room_is_not_left_out_in_silence) {
    std::vector<SpectrumSource> seas(2, some_waves());
    seas[1].epoch = 2;
    const auto room = Room::of(bytes_of(seas[0], 0, 0) * 3 / 2);
    SpectrumStore store(room);
    const Result<GrantedSpectrum> refused = store.grant(seas, {});
    ASSERT_FALSE(refused) << "the first is held for it while the second is made";
    EXPECT_TRUE(refused.error().is(Refusal::busy));
}

TEST(SpectrumStore, what_is_held_is_granted_without_making_and_what_is_not_is_told_before) {
    std::vector<SpectrumSource> seas(2, some_waves());
    seas[1].epoch = 2;
    SpectrumStore store;
    const std::size_t points = 2 * 64 * 64; // of each
    EXPECT_FALSE(store.held(seas, {}));
    EXPECT_EQ(store.points_to_make(seas, {}), 2 * points);
    (void)granted(store, seas[0], 0, 0);
    EXPECT_FALSE(store.held(seas, {})) << "one of them is not";
    EXPECT_EQ(store.points_to_make(seas, {}), points);
    const Result<GrantedSpectrum> both = store.grant(seas, {});
    ASSERT_TRUE(both);
    EXPECT_EQ(store.points_to_make(seas, {}), 0u);
    const std::optional<GrantedSpectrum> held = store.held(seas, {});
    ASSERT_TRUE(held);
    EXPECT_EQ(held->spectra, both->spectra);
    EXPECT_EQ(held->error_m, both->error_m);
    EXPECT_FALSE(store.held(seas, {0.04f, 0.02f}));
    EXPECT_EQ(store.made_so_far(), 2u);
}

TEST(SpectrumStore, several_seas_are_granted_together_and_one_without_waves_is_named) {
    std::vector<SpectrumSource> seas(3, some_waves());
    seas[1].epoch = 2;
    seas[1].height_error_m = 0.04;
    seas[2].epoch = 3;
    auto stylised = std::make_shared<sea::Realization>(*seas[2].waves);
    stylised->cascades[0].sines.emplace_back();
    seas[2].waves = stylised;
    SpectrumStore store;
    const Result<GrantedSpectrum> granted = store.grant(seas, {});
    ASSERT_TRUE(granted);
    ASSERT_EQ(granted->spectra.size(), 2u);
    EXPECT_EQ(granted->spectra[1]->epoch, 2u);
    EXPECT_FLOAT_EQ(granted->error_m, 0.04f) << "of both";
    EXPECT_EQ(granted->why.find("epoch 3: this sea has stylised"), 0u) << granted->why;
    std::swap(seas[0], seas[2]);
    EXPECT_FALSE(store.grant(seas, {})) << "the one that runs";
}

TEST(SpectrumStore, foam_is_named_as_what_does_not_follow_from_waves) {
    SpectrumStore store;
    const SpectrumSource sea = some_waves();
    const GrantedSpectrum grant =
        granted(store, sea, 0, 0, {Field::height, Field::jacobian, Field::foam});
    EXPECT_EQ(grant.fields, (FieldSet{Field::height, Field::jacobian}));
    EXPECT_NE(grant.why.find("foam is a history"), std::string::npos) << grant.why;
}

// Naive: told, and each client takes the first chunk for damage, comes back and is told again.
TEST(SpectrumStore, given_waves_that_are_together_higher_than_a_chunk_can_say_are_refused_by_name) {
    SpectrumSource sea = some_waves();
    for (const double amplitude_m : {4e6, 6e6}) {
        auto waves = std::make_shared<sea::Realization>(*sea.waves);
        waves->cascades[0].given.assign(waves->cascades[0].h0.size(), 0);
        waves->cascades[0].given[1] = 1;
        waves->cascades[0].h0[1] = amplitude_m / 2;
        sea.waves = waves;
        SpectrumStore store;
        const Result<GrantedSpectrum> grant = store.grant(sea, {});
        EXPECT_EQ(grant.has_value(), amplitude_m / 5 < protocol::limits::spectrum_left_m_max);
        if (!grant) {
            EXPECT_TRUE(grant.error().is(Refusal::not_offered));
            EXPECT_EQ(store.points_to_make(std::span(&sea, 1), {}), 0u) << "not tried again";
            const Result<GrantedSpectrum> again = store.grant(sea, {});
            ASSERT_FALSE(again);
            EXPECT_EQ(again.error().message, grant.error().message);
        }
    }
}

TEST(SpectrumStore, stylised_waves_have_no_spectrum_and_are_refused_by_name) {
    SpectrumSource sea = some_waves();
    auto waves = std::make_shared<sea::Realization>(*sea.waves);
    waves->cascades[1].sines.emplace_back();
    sea.waves = waves;
    SpectrumStore store;
    const Result<GrantedSpectrum> refused = store.grant(sea, {});
    ASSERT_FALSE(refused);
    EXPECT_TRUE(refused.error().is(Refusal::not_offered));
    EXPECT_NE(refused.error().message.find("stylised"), std::string::npos);
}

// What travels is what was quantised: messages in order, each within its limit, and what they say is missed is
// what they miss at the end.
TEST(SpectrumStore, its_messages_make_the_sea_within_the_bound_that_was_granted) {
    const SpectrumSource sea = some_waves();
    SpectrumStore store;
    const GrantedSpectrum grant = granted(store, sea, 0, 0);
    const EncodedSpectrum& encoded = *grant.spectra.at(0);
    const wire::Spectrum& first =
        *wire::GetMessage(encoded.messages[0]->data())->body_as_Spectrum();
    ASSERT_TRUE(protocol::check(first));
    const protocol::SpectrumHead head = protocol::head(first);
    EXPECT_EQ(head.epoch, sea.epoch);
    EXPECT_EQ(head.chunks + 1, encoded.messages.size());
    sea::SpectrumFrame frame{.tiles = {},
                             .choppiness = sea.waves->choppiness,
                             .dispersion = head.dispersion,
                             .loop_period_us = head.loop_period_us};
    for (const sea::CascadeModes& modes : sea.waves->cascades)
        frame.tiles.push_back({modes.spec, modes.band});
    sea::SpectrumBuilder builder = *sea::SpectrumBuilder::create(frame, head.steps);
    std::size_t bytes = 0;
    double left_m = 1e9;
    for (std::uint32_t n = 0; n < head.chunks; ++n) {
        const wire::SpectrumChunk& chunk =
            *wire::GetMessage(encoded.messages[n + 1]->data())->body_as_SpectrumChunk();
        ASSERT_TRUE(protocol::check(chunk));
        EXPECT_EQ(chunk.chunk(), n);
        EXPECT_LT(protocol::left(chunk).height_m, left_m);
        left_m = protocol::left(chunk).height_m;
        bytes += chunk.payload()->size();
        const auto blocks =
            protocol::decode_spectrum({chunk.payload()->data(), chunk.payload()->size()});
        ASSERT_TRUE(blocks);
        for (const sea::WaveBlock& block : *blocks)
            ASSERT_TRUE(builder.add(block));
    }
    EXPECT_EQ(bytes, head.bytes);
    double variance = 0;
    for (std::size_t c = 0; c < frame.tiles.size(); ++c)
        for (std::size_t i = 0; i < sea.waves->cascades[c].h0.size(); ++i)
            variance +=
                2 * std::norm(sea.waves->cascades[c].h0[i] - builder.sea().cascades[c].h0[i]);
    EXPECT_NEAR(std::sqrt(variance), left_m, 1e-6 * left_m + 1e-9);
    EXPECT_LE(sea::spectrum_sigmas * left_m, static_cast<double>(grant.error_m));
}

} // namespace
} // namespace seaway::server
