// SPDX-License-Identifier: Apache-2.0
// The waves of the world's seas: who pays for what is made of them.
#include <memory>

#include <gtest/gtest.h>

#include "server/host/refusal.h"
#include "server/world.h"
#include "tests/server/simulation/simulation_bench.h"
#include "tests/server/stopped_clock.h"
#include "tests/support/metrics_page.h"

namespace seaway::server {
namespace {

// Naive: each accuracy is made for whoever asks, and one session that asks for all of them again and again has the
// thread that makes them for itself.
TEST(World, waves_that_have_to_be_made_are_paid_for_out_of_the_budget_of_who_asks) {
    Bench bench({}, {.rate = 1e-9, .burst_s = 1e-6}); // for one of them, and then never again
    SeaClock clock = stopped_at(0);
    World world(bench.course, clock);
    world.attach(*bench.simulation);
    const auto here = std::make_shared<char>(), there = std::make_shared<char>();
    const SpectrumRequest own{.wish = {}, .asker = Asker(here)};
    SpectrumRequest finer{.wish = {.error_m = 0.01f}, .asker = Asker(here)};
    EXPECT_FALSE(world.held_spectrum(own));
    ASSERT_TRUE(world.spectrum(own));
    const Result<GrantedSpectrum> refused = world.spectrum(finer);
    ASSERT_FALSE(refused);
    EXPECT_TRUE(refused.error().is(Refusal::busy));
    EXPECT_GT(refused.error().retry_after_ms, 0u);
    EXPECT_EQ(bench.simulation->counters().questions_over_budget, 1u);
    const auto made = [&] {
        return tests::read_metrics(world.metrics_text()).values.at("seaway_spectra_made_total");
    };
    EXPECT_EQ(made(), 1);
    EXPECT_TRUE(world.spectrum(own)) << "what is held costs nothing";
    finer.asked = false;
    EXPECT_TRUE(world.spectrum(finer)) << "what it has a right to is not charged";
    EXPECT_EQ(made(), 2);
    EXPECT_TRUE(world.spectrum({.wish = {.error_m = 0.04f}, .asker = Asker(there)}))
        << "nobody else pays for it";
    EXPECT_EQ(made(), 3);
}

TEST(World, waves_of_who_has_gone_and_of_seas_that_he_has_are_not_made) {
    Bench bench;
    SeaClock clock = stopped_at(0);
    World world(bench.course, clock);
    world.attach(*bench.simulation);
    auto here = std::make_shared<char>();
    SpectrumRequest request{.wish = {}, .asker = Asker(here)};
    request.has = {1};
    const Result<GrantedSpectrum> nothing = world.spectrum(request);
    ASSERT_TRUE(nothing);
    EXPECT_TRUE(nothing->spectra.empty());
    ASSERT_TRUE(world.held_spectrum(request));
    request.has.clear();
    here = nullptr;
    const Result<GrantedSpectrum> gone = world.spectrum(request);
    ASSERT_FALSE(gone);
    EXPECT_TRUE(gone.error().is(Refusal::gone));
    EXPECT_EQ(tests::read_metrics(world.metrics_text()).values.at("seaway_spectra_made_total"), 0);
}

} // namespace
} // namespace seaway::server
