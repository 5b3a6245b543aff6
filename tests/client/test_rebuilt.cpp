// SPDX-License-Identifier: Apache-2.0
// A sea that the client makes of what the server announced is the server's, or is refused.
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "client/client.h"
#include "client/link/failure.h"
#include "client/rebuilt/rebuilt_sea.h"
#include "sea/basics/deviations.h"
#include "sea/scene/scene.h"
#include "sea/waves/quantised_spectrum.h"
#include "tests/client/announced_scene.h"
#include "tests/client/wave_server.h"
#include "tests/support/explicit_sea.h"

namespace seaway::client {
namespace {

using protocol::SeaStateValues;
using tests::announced;

std::string refusal_of(const SeaStateValues& state) {
    const Result<RebuiltSeaPtr> made = rebuild_from_scene(state);
    if (made)
        return "";
    EXPECT_EQ(failure_of(made.error()), Failure::not_held);
    return made.error().message;
}

TEST(Rebuilt, from_the_scene_is_the_exact_sum_of_the_sea_at_any_time) {
    const SeaStateValues state = announced();
    const Result<RebuiltSeaPtr> made = rebuild_from_scene(state);
    ASSERT_TRUE(made) << made.error().message;
    const auto waves = tests::announced_waves();
    const sea::DirectSum truth(waves);
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> place(-1e6, 1e6);
    std::uniform_int_distribution<sea::TimeUs> time(-1'000'000'000'000, 1'000'000'000'000'000);
    for (int i = 0; i < 100; ++i) {
        const sea::QueryPoint point{place(random), place(random), time(random)};
        sea::Answer answer;
        (*made)->answer({&point, 1}, {&answer, 1}, {});
        const sea::Answer exact = sea::surface_at(
            point, {waves->choppiness, 1e-9, sea::FoldSearch{}}, truth.at_time(point.time_us));
        EXPECT_LE(std::abs(answer.height_m - exact.height_m), answer.error_m);
        EXPECT_LE(answer.error_m, 1e-5) << "what probes allow, and slopes";
    }
}

TEST(Rebuilt, a_sea_of_another_seed_or_tile_is_refused_by_name) {
    SeaStateValues state = announced();
    const auto at = state.scene.find("seed = 7");
    ASSERT_NE(at, std::string::npos) << state.scene;
    state.scene.replace(at, 8, "seed = 8");
    EXPECT_NE(refusal_of(state).find("probes differ by"), std::string::npos) << refusal_of(state);
    state = announced();
    state.cascades[1].length_m += 1;
    EXPECT_NE(refusal_of(state).find("other tiles"), std::string::npos);
}

TEST(Rebuilt, without_scene_or_probes_nothing_is_believed) {
    SeaStateValues state = announced();
    state.probes.clear();
    EXPECT_NE(refusal_of(state).find("no probes"), std::string::npos);
    state = announced();
    state.scene.clear();
    EXPECT_NE(refusal_of(state).find("no scene"), std::string::npos);
    state.scene = "[sea";
    EXPECT_NE(refusal_of(state).find("the server's scene"), std::string::npos);
}

// A server may be anybody's: its scene opens no file of whoever reads it.
TEST(Rebuilt, a_scene_from_a_server_names_no_files) {
    SeaStateValues state = announced();
    state.scene = "[sea]\nseed = 1\n[[sea.system]]\ntype = \"measured\"\nfile = \"/etc/hostname\"\n"
                  "[[cascade]]\nlength_m = 100\nsize = 64\n";
    EXPECT_NE(refusal_of(state).find("may name no file"), std::string::npos) << refusal_of(state);
    state.scene = announced().scene +
                  "[[weather]]\nat_s = 100\nover_s = 60\n"
                  "set = { sea.system = [ { type = \"measured\", file = \"/etc/hostname\" } ] }\n";
    EXPECT_NE(refusal_of(state).find("may name no file"), std::string::npos)
        << "nor does its timetable: " << refusal_of(state);
}

// ---- the waves themselves, over a socket -------------------------------------------------------

class LiveWaves : public tests::WaveServer {
  protected:
    std::unique_ptr<Client> connect() {
        auto client = Client::connect({.url = net->url(), .timeout_s = 60});
        EXPECT_TRUE(client) << (client ? "" : client.error().message);
        return client ? std::move(*client) : nullptr;
    }
    static std::vector<sea::QueryPoint> points() {
        std::mt19937_64 random(7);
        std::uniform_real_distribution<double> place(-1e5, 1e5);
        std::uniform_int_distribution<sea::TimeUs> time(-1'000'000'000'000, 100'000'000'000'000);
        std::vector<sea::QueryPoint> made;
        for (int i = 0; i < 200; ++i)
            made.push_back({place(random), place(random), time(random)});
        return made;
    }
};

TEST_F(LiveWaves, answer_at_any_time_within_the_bound_without_another_question) {
    const auto client = connect();
    ASSERT_TRUE(client);
    ASSERT_FALSE(client->sample(points())) << "nothing is held yet";
    const Result<protocol::SpectrumGrant> grant =
        client->subscribe_spectrum({.error_m = 0.001f}, 30);
    ASSERT_TRUE(grant) << grant.error().message;
    EXPECT_EQ(grant->error_m, 0.001f);
    const auto answers = client->sample(points());
    ASSERT_TRUE(answers) << answers.error().message;
    for (std::size_t i = 0; i < points().size(); ++i) {
        const sea::Answer truth = sea.truth(points()[i]);
        EXPECT_LE(std::abs((*answers)[i].height_m - truth.height_m), (*answers)[i].error_m);
        EXPECT_LE((*answers)[i].error_m, 0.0015) << "what was granted, on a slope";
        EXPECT_EQ((*answers)[i].flags & sea::answer_extrapolated, 0u);
    }
    EXPECT_EQ(sea.queries, 0);
    EXPECT_EQ(sea.fetches, 0);
}

// The bits of a wrong sea are a right message: only the probes know.
TEST_F(LiveWaves, that_are_not_the_sea_that_was_announced_are_given_up_with_the_reason) {
    sea.spectrum_change = [](sea::WaveBlock& block) {
        for (std::size_t i = 1; i < block.codes.size(); i += 2)
            block.codes[i] = -block.codes[i]; // every wave turned
    };
    const auto client = connect();
    ASSERT_TRUE(client);
    const auto grant = client->subscribe_spectrum({}, 30);
    ASSERT_FALSE(grant);
    EXPECT_EQ(failure_of(grant.error()), Failure::not_held);
    EXPECT_NE(grant.error().message.find("probes differ by"), std::string::npos);
    EXPECT_FALSE(client->sample(points())) << "and nothing is answered from them";
    EXPECT_TRUE(client->is_open());
}

TEST_F(LiveWaves, beyond_a_lattice_end_the_connection) {
    sea.spectrum_change = [](sea::WaveBlock& block) { block.bx = 100; };
    const auto client = connect();
    ASSERT_TRUE(client);
    const auto grant = client->subscribe_spectrum({}, 30);
    ASSERT_FALSE(grant);
    EXPECT_EQ(failure_of(grant.error()), Failure::lost);
    EXPECT_NE(client->closed_reason().find("lattice"), std::string::npos)
        << client->closed_reason();
}

TEST_F(LiveWaves, what_has_come_can_be_asked_and_knows_how_far_it_is) {
    const SeaStatePtr state = std::make_shared<const SeaState>(protocol::values(
        *wire::GetMessage(sea.sea_state_messages().front()->data())->body_as_SeaState()));
    const auto granted = sea.spectrum({.wish = {}, .asker = server::Asker::who_stays()});
    const auto& messages = granted->spectra.front()->messages;
    ReceivedSpectrum received(
        state, protocol::head(*wire::GetMessage(messages[0]->data())->body_as_Spectrum()));
    EXPECT_EQ(received.sea(), nullptr) << "before the first waves";
    double bound_m = 1e9;
    for (std::size_t n = 1; n < messages.size(); ++n) {
        const auto& chunk = *wire::GetMessage(messages[n]->data())->body_as_SpectrumChunk();
        const auto blocks =
            protocol::decode_spectrum({chunk.payload()->data(), chunk.payload()->size()});
        ASSERT_TRUE(received.add(protocol::left(chunk), *blocks));
        const RebuiltSeaPtr now = received.sea();
        EXPECT_LT(now->error().height_m, bound_m);
        bound_m = now->error().height_m;
        for (const sea::QueryPoint& point : points()) {
            sea::Answer answer;
            now->answer({&point, 1}, {&answer, 1}, {});
            EXPECT_LE(std::abs(answer.height_m - sea.truth(point).height_m), answer.error_m);
        }
    }
    EXPECT_LE(bound_m, 0.001);
    EXPECT_FALSE(received.add({}, {})) << "more than its head says";
    EXPECT_LE(received.sea()->error().height_m, 0.001);
}

// Naive: what an answer's bound allows. Sixteen probes of three numbers each lie beyond five deviations in one sea of 75 000, at each try anew.
TEST(Rebuilt, a_sea_is_the_server_s_where_it_is_off_by_more_than_an_answer_may_be_by_chance) {
    protocol::SeaStateValues state = tests::announced();
    const RebuiltError error{.height_m = 0.02, .displacement_m = 0.02, .strain = 0};
    const RebuiltSea sea(tests::announced_waves(), state, error);
    state.probes = sea::make_probes(sea.sum(), 0);
    const double deviation_m = error.height_m / sea::bound_sigmas;
    const double right_m = state.probes[3].height_m;
    for (const double deviations : {0.0, 5.5, 7.5, 9.0, 50.0}) {
        state.probes[3].height_m = right_m + deviations * deviation_m;
        EXPECT_EQ(static_cast<bool>(agrees(state, sea)), deviations < 8) << deviations;
    }
}

/// The largest error of any of these points that are alone and settled, as a share of what is stated there.
double worst_share(const RebuiltSea& truth, const RebuiltSea& rounded,
                   std::span<const sea::QueryPoint> points) {
    std::vector<sea::Answer> is(points.size()), answers(points.size());
    truth.answer(points, is, {});
    rounded.answer(points, answers, {});
    double worst = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (!((is[i].flags | answers[i].flags) & (sea::answer_folded | sea::answer_open)))
            worst = std::max(worst,
                             std::abs(answers[i].height_m - is[i].height_m) / answers[i].error_m);
    return worst;
}

/// So many along x, so far apart.
std::vector<sea::QueryPoint> line_of(int count, double from_m, double apart_m,
                                     sea::TimeUs time_us) {
    std::vector<sea::QueryPoint> points;
    for (int i = 0; i < count; ++i)
        points.push_back({from_m + apart_m * i, 0, time_us});
    return points;
}

/// What a client states that is told of waves, whose phases were given, that this much of them is missed.
RebuiltError error_told_of(sea::CascadeModes missed) {
    missed.given.assign(missed.h0.size(), 1);
    const sea::SpectrumLeft left = sea::quantise(*tests::make_sea({missed}, {1, 1}), {1}).without;
    return {sea::bound_sigmas * left.height_m, sea::bound_sigmas * left.displacement_m,
            sea::fold_sigmas * left.slope};
}

// Naive: to first order, which of many waves leaves room for the rest, and of one none: its height, its slope and how far it moves
// things are off together. Or by components, each of which is less than all of it where a wave runs between the axes.
TEST(Received, one_wave_that_was_rounded_stays_inside_its_bound_however_steep) {
    struct Case {
        double amplitude_m, choppiness, off_m;
    };
    for (const Case& c : {Case{1.2, 1.9, 0.05}, {1.2, 1.0, 0.3}, {0.6, 0.0, 0.1}, {1.5, 1.2, 0.15}})
        for (const std::array<int, 2>& n : {std::array{5, 0}, {3, 4}}) {
            const double k = sea::two_pi / 20;
            const auto wave = [&](double amplitude_m, double phase_rad) {
                sea::CascadeModes modes = tests::calm_cascade(100.0, 64);
                tests::add_wave(modes, n[0], n[1], amplitude_m, phase_rad);
                return modes;
            };
            // Off by the most that it may be, in any phase.
            const auto sea_of = [&](double wrong_m, double phase_rad) {
                sea::CascadeModes modes = wave(c.amplitude_m, 0.3);
                tests::add_wave(modes, n[0], n[1], wrong_m, phase_rad);
                return tests::make_sea({modes}, {c.choppiness, c.choppiness});
            };
            protocol::SeaStateValues state = announced();
            state.cascades.clear();
            state.displacement_reach_m = 6 * c.choppiness * c.amplitude_m;
            state.rms_strain = 0.1;
            state.curvature_per_m = sea::bound_sigmas * c.amplitude_m * k * k / std::sqrt(2.0);
            std::vector<sea::QueryPoint> points = line_of(1000, 0, 0.02, 1'000'000);
            for (sea::QueryPoint& point : points)
                point = {0.2 * n[0] * point.x_m, 0.2 * n[1] * point.x_m, point.time_us};
            const RebuiltSea truth(sea_of(0, 0), state, {});
            const RebuiltError told = error_told_of(wave(c.off_m, 0));
            double worst = 0;
            for (int turn = 0; turn < 12; ++turn) {
                const RebuiltSea rounded(sea_of(c.off_m, turn * sea::two_pi / 12), state, told);
                worst = std::max(worst, worst_share(truth, rounded, points));
            }
            EXPECT_LE(worst, 1) << c.amplitude_m << ' ' << c.choppiness << ' ' << c.off_m;
            EXPECT_GT(worst, 0.7) << "and near it";
        }
}

// Naive: how far the surface bends as if nothing were squeezed, which two waves whose crests meet are by five times and more before they fold.
TEST(Received, two_waves_that_were_rounded_stay_inside_their_bound_where_they_squeeze_the_water) {
    const double k_radpm[] = {sea::two_pi / 20, sea::two_pi * 6 / 100};
    const double amplitude_m = 0.6;
    for (const auto& [choppiness, off_m] :
         {std::pair(1.8, std::array{0.1, 0.1}), {1.8, {0.3, 0.02}}, {1.9, {0.03, 0.03}}}) {
        const double sideways = choppiness;
        const auto sea_of = [&](const std::array<double, 2>& wrong_m, double phase_rad,
                                double other_rad) {
            sea::CascadeModes modes = tests::calm_cascade(100.0, 64);
            tests::add_wave(modes, 5, 0, amplitude_m, 0);
            tests::add_wave(modes, 6, 0, amplitude_m, 0);
            tests::add_wave(modes, 5, 0, wrong_m[0], phase_rad);
            tests::add_wave(modes, 6, 0, wrong_m[1], other_rad);
            return tests::make_sea({modes}, {sideways, sideways});
        };
        protocol::SeaStateValues state = announced();
        state.cascades.clear();
        state.displacement_reach_m = 12 * choppiness * amplitude_m;
        state.rms_strain = 0.1;
        state.curvature_per_m = sea::bound_sigmas * amplitude_m *
                                std::hypot(k_radpm[0] * k_radpm[0], k_radpm[1] * k_radpm[1]) /
                                std::sqrt(2.0);
        const RebuiltSea truth(sea_of({}, 0, 0), state, {});
        const double all_m = off_m[0] + off_m[1];
        const double strain = k_radpm[0] * off_m[0] + k_radpm[1] * off_m[1];
        double worst = 0;
        for (int turn = 0; turn < 144; ++turn) {
            const int other_turn = turn / 12;
            const RebuiltSea rounded(
                sea_of(off_m, turn % 12 * sea::two_pi / 12, other_turn * sea::two_pi / 12), state,
                {all_m, all_m, sea::fold_sigmas / sea::bound_sigmas * strain});
            // Around where crests meet.
            worst = std::max(worst, worst_share(truth, rounded, line_of(150, -3, 0.04, 0)));
        }
        EXPECT_LE(worst, 1) << choppiness << ' ' << off_m[0];
        EXPECT_GT(worst, 0.7) << "and near it";
    }
}

// Bounds are five standard deviations, 1.94 of the error of 99 %, which 10 000 answers tell to 3 %; a slope's part in a bound is of the component
// of the displacement that is missed more of.
TEST(Received, waves_state_no_more_than_about_twice_what_99_percent_of_their_answers_are_off_by) {
    const sea::RealizationPtr waves = tests::announced_waves();
    const sea::QuantisedSpectrum sent = sea::quantise(*waves, {0.02, 0.01});
    const protocol::SeaStateValues state = tests::announced();
    ReceivedSpectrum received(std::make_shared<const SeaState>(state),
                              {.epoch = state.epoch,
                               .chunks = 1,
                               .steps = sent.steps,
                               .dispersion = tests::announced_scene().sea.dispersion()});
    ASSERT_TRUE(received.add(sent.left.back(), sent.blocks));
    const RebuiltSea truth(waves, state, {});
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> place(-1e5, 1e5);
    std::vector<double> off_m, bounds_m;
    for (int time = 0; time < 100; ++time) {
        std::vector<sea::QueryPoint> points(100);
        for (sea::QueryPoint& point : points)
            point = {place(random), place(random), time * sea::TimeUs{7'777'777}};
        std::vector<sea::Answer> is(points.size()), answers(points.size());
        truth.answer(points, is, {});
        received.sea()->answer(points, answers, {});
        for (std::size_t i = 0; i < points.size(); ++i) {
            off_m.push_back(std::abs(answers[i].height_m - is[i].height_m));
            bounds_m.push_back(answers[i].error_m);
            EXPECT_LE(off_m.back(), bounds_m.back());
        }
    }
    std::ranges::sort(off_m);
    std::ranges::sort(bounds_m);
    EXPECT_LT(bounds_m[bounds_m.size() / 2], 2.1 * off_m[off_m.size() * 99 / 100]);
}

} // namespace
} // namespace seaway::client
