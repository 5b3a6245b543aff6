// SPDX-License-Identifier: Apache-2.0
// The waves of the world's seas: who pays for what is made of them.
#include <memory>
#include <utility>
#include <variant>
#include <vector>

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

/// Whose waves a session gets that has those of some.
std::vector<std::uint32_t> epochs_sent(World& world, std::vector<std::uint32_t> has = {}) {
    const SpectrumRequest request{
        .wish = {}, .asker = Asker::who_stays(), .asked = false, .has = std::move(has)};
    const GrantedSpectrum granted = world.spectrum(request).value();
    std::vector<std::uint32_t> epochs;
    for (const EncodedSpectrumPtr& one : granted.spectra)
        epochs.push_back(one->epoch);
    return epochs;
}

/// Ten minutes each, a glide every ten seconds from 100 s on, so that each takes over from the one before.
std::shared_ptr<SeaCourse> course_of_takeovers(int glides) {
    const auto course = SeaCourse::begin(small_scene()).value();
    sea::Scene turned = course->first()->scene;
    for (int i = 0; i < glides; ++i) {
        std::get<sea::WindSea>(turned.sea.systems[0]).wind_speed_10m_mps = 10 + i;
        const sea::TimeUs start_us = 100'000'000 + 10'000'000 * sea::TimeUs{i};
        EXPECT_TRUE(course->add(turned, start_us, start_us + 600'000'000));
    }
    return course;
}

// Naive: the last few of them, with which nobody can do anything; and the seas that were announced give way to those that
// nobody needs.
TEST(World, who_comes_amid_glides_that_took_over_from_one_another_gets_the_waves_of_all) {
    for (const int glides : {1, 2, 5, takeovers_max + 1}) {
        const auto course = course_of_takeovers(glides + 1);
        sea::TimeUs now_us = 100'000'000 + 10'000'000 * (glides - 1) + 5'000'000;
        SeaClock clock(
            0, [&now_us] { return now_us; }, [&now_us] { return now_us; });
        World world(course, clock); // as a server that was started anew in their midst
        std::vector<std::uint32_t>
            wanted; // the one that runs, what it comes from, and the one to come
        for (int i = glides; i > 0; --i)
            wanted.push_back(2 * static_cast<std::uint32_t>(i));
        wanted.push_back(1);
        wanted.push_back(2 * static_cast<std::uint32_t>(glides) + 2);
        EXPECT_EQ(epochs_sent(world), wanted);
        EXPECT_EQ(epochs_sent(world, wanted), std::vector<std::uint32_t>{});
        EXPECT_LE(course->seas_made(), 2u * static_cast<unsigned>(glides) + 2)
            << "each once, whatever it comes from";
        const std::uint64_t made = course->seas_made();
        now_us += 10'000'000;
        (void)world.announce_due();
        std::erase(wanted, wanted.back());
        wanted.insert(wanted.begin(), 2 * static_cast<std::uint32_t>(glides) + 2);
        EXPECT_EQ(epochs_sent(world), wanted);
        EXPECT_EQ(course->seas_made(), made) << "all were there already";
    }
}

// Naive: of a change its glide and the sea that it leads to, which have the same waves, each take one of the places.
TEST(World, of_a_glide_and_the_sea_that_it_leads_to_one_has_the_waves_of_both) {
    const auto course = course_of_takeovers(1);
    for (const auto& [now_s, wanted] : std::vector<std::pair<int, std::vector<std::uint32_t>>>{
             {95, {1, 2}}, {105, {2, 1}}, {695, {2, 1}}, {705, {3}}}) {
        SeaClock clock = stopped_at(1'000'000 * sea::TimeUs{now_s});
        World world(course, clock);
        EXPECT_EQ(epochs_sent(world), wanted) << now_s;
    }
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
