// SPDX-License-Identifier: Apache-2.0
// The whole way of the data with real programs, sockets and device: scene to answer.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "client/client.h"
#include "sea/certificate/certificate.h"
#include "sea/waves/statistics/moments.h"
#include "tests/server/net/clients.h"
#include "tests/support/airy_waves.h"
#include "tests/support/folder.h"
#include "tests/support/server_process.h"

namespace seaway {
namespace {

using client::Client;
using sea::Answer;
using sea::QueryPoint;

Result<std::unique_ptr<Client>> connect(const std::string& url) {
    return Client::connect({.url = url, .timeout_s = 60});
}

/// Ten points at each of a hundred times, all random: |x| up to 1e6 m, from a year before the
/// sea's epoch to thirty years after it.
std::vector<QueryPoint> random_points() {
    std::mt19937_64 random(20261121);
    std::uniform_real_distribution<double> place(-1e6, 1e6);
    std::uniform_int_distribution<sea::TimeUs> time(-31'557'600'000'000, 946'728'000'000'000);
    std::vector<QueryPoint> points;
    for (int t = 0; t < 100; ++t) {
        const sea::TimeUs time_us = time(random);
        for (int i = 0; i < 10; ++i)
            points.push_back({place(random), place(random), time_us});
    }
    return points;
}

class EndToEnd : public ::testing::TestWithParam<const char*> {};

TEST_P(EndToEnd, server_local_and_exact_answers_agree_within_the_stated_bound) {
    tests::ServerProcess server({"scenes/north_sea_gale.toml", "--listen", "127.0.0.1:0",
                                 "--device", GetParam(), "--validation"});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    Result<std::unique_ptr<Client>> client = connect(url);
    ASSERT_TRUE(client) << client.error().message;

    const std::vector<QueryPoint> points = random_points();
    const Result<std::vector<Answer>> served = (*client)->ask(points, {.timeout_s = 120});
    ASSERT_TRUE(served) << served.error().message;
    const Result<std::vector<Answer>> exact =
        (*client)->ask(points, {.exact = true, .timeout_s = 120});
    ASSERT_TRUE(exact) << exact.error().message;
    const Result<std::vector<Answer>> local = (*client)->fetch_and_sample(points, 120);
    ASSERT_TRUE(local) << local.error().message;

    // Of the waves themselves, sent once; and of the client's own, made from the scene that was announced.
    const Result<protocol::SpectrumGrant> spectrum = (*client)->subscribe_spectrum({}, 120);
    ASSERT_TRUE(spectrum) << spectrum.error().message;
    const Result<std::vector<Answer>> waves = (*client)->sample(points);
    ASSERT_TRUE(waves && (*client)->rebuild((*client)->now_us()));
    std::vector<Answer> own(points.size());
    ASSERT_TRUE((*client)->sample_into(points, own, {.summed = true}));
    double height_max = 0;
    double worst_bound_m = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double truth = (*exact)[i].height_m;
        height_max = std::max(height_max, std::abs(truth));
        for (const Answer* answer : {&(*served)[i], &(*local)[i], &(*waves)[i]}) {
            EXPECT_LE(std::abs(answer->height_m - truth), answer->error_m + (*exact)[i].error_m)
                << "point " << i;
            EXPECT_EQ(answer->flags & (sea::answer_extrapolated | sea::answer_invalid), 0u);
            // Stale: on a machine so busy that the client has heard nothing for seconds, its bound says that.
            if (!(answer->flags &
                  (sea::answer_folded | sea::answer_not_converged | sea::answer_stale)))
                worst_bound_m = std::max(worst_bound_m, answer->error_m);
            EXPECT_NEAR(std::hypot(answer->normal[0], answer->normal[1], answer->normal[2]), 1.0,
                        1e-6);
        }
        EXPECT_TRUE((*exact)[i].flags & sea::answer_exact);
        EXPECT_LE(std::abs(own[i].height_m - truth), own[i].error_m + (*exact)[i].error_m);
        if (!(own[i].flags & sea::answer_stale)) {
            EXPECT_LE(own[i].error_m, 1e-5) << "what probes allow, and slopes";
        }
    }
    // Promise for height_error_m = 0.01; a gale's slopes stay below 1.
    EXPECT_LE(worst_bound_m, 0.02);
    EXPECT_GT(height_max, 3.0) << "an Hs of 6.6 m must show in 1000 points";
    client->reset();
    server.send(SIGTERM);
    EXPECT_EQ(server.wait_for_exit(std::chrono::seconds(60)), 0) << "one that hangs ends with 3";
    EXPECT_EQ(server.log().find("VUID"), std::string::npos) << server.log();
}

// Exponential-sine waves are no modes: every device has to add them to its maps.
TEST_P(EndToEnd, stylised_waves_agree_with_the_exact_sum_on_every_device) {
    tests::ServerProcess server(
        {"scenes/gerstner_toy.toml", "--listen", "127.0.0.1:0", "--device", GetParam()});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    Result<std::unique_ptr<Client>> client = connect(url);
    ASSERT_TRUE(client) << client.error().message;
    std::vector<QueryPoint> points;
    for (int i = 0; i < 200; ++i)
        points.push_back({i * 3.7, i * -1.9, (i / 20) * 1'234'567});
    const Result<std::vector<Answer>> served = (*client)->ask(points, {.timeout_s = 60});
    const Result<std::vector<Answer>> exact =
        (*client)->ask(points, {.exact = true, .timeout_s = 60});
    ASSERT_TRUE(served && exact);
    for (std::size_t i = 0; i < points.size(); ++i)
        EXPECT_LE(std::abs((*served)[i].height_m - (*exact)[i].height_m),
                  (*served)[i].error_m + (*exact)[i].error_m)
            << i;
}

// Linear theory at finite depth, through server and client: heights, celerity, displacement (a height is
// asked for where displacement puts it) and velocity. The exact sum is within 1e-6 of the formulas.
// Answers from maps keep the bound that they state. Their velocities lose what the derivative of Hermite's
// cubic does between keyframes, u^3 sqrt(3)/216 of a wave of phase step u, and 1e-5 for single precision
// and the spline; tiles add their codec, which keeps the same 1e-5 m: 1.5e-4 (measured 1e-4).
TEST_P(EndToEnd, ten_waves_at_finite_depth_move_water_as_linear_theory_says) {
    for (const tests::AiryWave& wave : tests::airy_waves) {
        const std::string path = tests::folder().write("airy.toml", tests::airy_scene(wave, 1.0));
        tests::ServerProcess server({path, "--listen", "127.0.0.1:0", "--device", GetParam()});
        const std::string url = server.wait_until_ready();
        ASSERT_FALSE(url.empty()) << server.log();
        Result<std::unique_ptr<Client>> client = connect(url);
        ASSERT_TRUE(client) << client.error().message;
        const std::vector<tests::AiryPoint> truth = tests::airy_points(wave, 1.0);
        std::vector<QueryPoint> points;
        for (const tests::AiryPoint& p : truth)
            points.push_back({p.x_m, p.y_m, p.time_us});
        const auto served = (*client)->ask(points, {.timeout_s = 60});
        const auto exact = (*client)->ask(points, {.exact = true, .timeout_s = 60});
        const auto local = (*client)->fetch_and_sample(points, 60);
        ASSERT_TRUE(served && exact && local);
        const double phase_step =
            sea::two_pi / wave.period_s *
            sea::seconds_from_us((*client)->sea_state(0)->cascades[0].interval_us);
        const double hermite = std::pow(phase_step, 3) * std::sqrt(3.0) / 216;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const std::string what =
                fmt::format("{} s on {} m, point {}", wave.period_s, wave.depth_m, i);
            EXPECT_NEAR((*exact)[i].height_m, truth[i].height_m, 1e-6 * wave.amplitude_m()) << what;
            for (const Answer* answer : {&(*served)[i], &(*local)[i]}) {
                EXPECT_LE(std::abs(answer->height_m - truth[i].height_m),
                          answer->error_m + 1e-6 * wave.amplitude_m())
                    << what;
                if (!(answer->flags & sea::answer_stale)) {
                    EXPECT_LT(answer->error_m, 6e-5) << what;
                }
            }
            const auto velocity = [&](const Answer& answer, double tolerance) {
                for (std::size_t axis = 0; axis < 3; ++axis)
                    EXPECT_NEAR(answer.velocity_mps[axis], truth[i].velocity_mps[axis],
                                tolerance * wave.horizontal_speed_mps())
                        << what << ", axis " << axis << ", to " << tolerance;
            };
            velocity((*exact)[i], 1e-6);
            velocity((*served)[i], hermite + 1e-5);
            velocity((*local)[i], hermite + 1.5e-4);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Devices, EndToEnd, ::testing::Values("lavapipe", "native"),
                         [](const auto& device) { return std::string(device.param); });

struct BadStart {
    const char* what;
    std::vector<std::string> arguments;
    int exit_code;
    const char* says;
};

class BadStarts : public ::testing::TestWithParam<BadStart> {};

TEST_P(BadStarts, one_helpful_line_and_the_documented_exit_code) {
    tests::ServerProcess server(GetParam().arguments);
    EXPECT_EQ(server.wait_until_ready(), "");
    EXPECT_EQ(server.wait_for_exit(std::chrono::seconds(60)), GetParam().exit_code);
    const std::string log = server.log();
    EXPECT_NE(log.find(GetParam().says), std::string::npos) << log;
    EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 1) << log;
}

INSTANTIATE_TEST_SUITE_P(
    All, BadStarts,
    ::testing::Values(
        BadStart{"missing_file", {"no/such/scene.toml"}, 2, "no/such/scene.toml"},
        BadStart{"broken_toml", {"tests/data/scenes/broken.toml"}, 2, "broken.toml:"},
        BadStart{"unknown_key", {"tests/data/scenes/unknown_key.toml"}, 2, "colour"},
        BadStart{"value_out_of_range", {"tests/data/scenes/out_of_range.toml"}, 2, "gamma"},
        BadStart{
            "unknown_device", {"scenes/north_sea_gale.toml", "--device", "abacus"}, 3, "abacus"},
        BadStart{"bad_address",
                 {"scenes/north_sea_gale.toml", "--device", "native", "--listen", "here:there"},
                 2, // a word on the command line; 4 is an address that cannot be had
                 "here:there"}),
    [](const auto& start) { return std::string(start.param.what); });

// No Vulkan device has kernels of this size, whatever this machine has.
TEST(Start, auto_takes_the_native_device_for_a_sea_that_no_vulkan_device_can_do) {
    tests::ServerProcess server({"tests/data/scenes/tile_of_32.toml", "--listen", "127.0.0.1:0"});
    ASSERT_NE(server.wait_until_ready(), "") << server.log();
    EXPECT_NE(server.log().find("device=auto takes=\"native"), std::string::npos) << server.log();
    EXPECT_NE(server.log().find("why="), std::string::npos) << server.log();
    tests::ServerProcess wanted(
        {"tests/data/scenes/tile_of_32.toml", "--listen", "127.0.0.1:0", "--device", "0"});
    EXPECT_EQ(wanted.wait_until_ready(), "") << "asked for by number, it is not replaced";
    EXPECT_EQ(wanted.wait_for_exit(std::chrono::seconds(60)), 3);
}

tests::HttpAnswer http_get(const std::string& url, const std::string& target) {
    return tests::ask_http(tests::port_of(url), target, "GET");
}

TEST(BulkMap, a_whole_grid_is_what_queries_answer_point_by_point) {
    tests::ServerProcess server(
        {"scenes/north_sea_gale.toml", "--device", "native", "--listen", "127.0.0.1:0"});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    const auto [status, bytes, fields] = http_get(
        url, "/v1/map?kind=height&x0_m=-500&y0_m=1000&width_m=700&height_m=350&columns=1400&rows="
             "700&t_s=86400.5");
    ASSERT_EQ(status, 200) << bytes.substr(0, 200);
    ASSERT_EQ(bytes.size(), 64u + 1400u * 700u * sizeof(float));
    float error_m = 0;
    std::memcpy(&error_m, bytes.data() + 20, sizeof error_m);
    EXPECT_LE(error_m, 0.02f);
    std::vector<QueryPoint> points;
    std::vector<float> heights;
    for (int j = 0; j < 700; j += 69)
        for (int i = 0; i < 1400; i += 77) {
            points.push_back({-500 + 0.5 * i, 1000 + 0.5 * j, 86'400'500'000});
            float height = 0;
            std::memcpy(&height,
                        bytes.data() + 64 + sizeof height * static_cast<std::size_t>(j * 1400 + i),
                        sizeof height);
            heights.push_back(height);
        }
    Result<std::unique_ptr<Client>> client = connect(url);
    ASSERT_TRUE(client) << client.error().message;
    const Result<std::vector<Answer>> exact =
        (*client)->ask(points, {.exact = true, .timeout_s = 60});
    ASSERT_TRUE(exact) << exact.error().message;
    for (std::size_t i = 0; i < points.size(); ++i)
        EXPECT_NEAR(static_cast<double>(heights[i]), (*exact)[i].height_m,
                    static_cast<double>(error_m));

    EXPECT_EQ(http_get(url, "/v1/map?width_m=10&height_m=10&columns=5000&rows=1").status, 400);
    const auto [refused, why, headers] = http_get(url, "/v1/map?colour=blue");
    EXPECT_EQ(refused, 400);
    EXPECT_NE(why.find("colour"), std::string::npos);
}

/// Keyframes with foam of every cascade around a time; none where the server offers no foam.
std::vector<client::KeyframePair> foam_around(const std::string& url, sea::TimeUs time_us) {
    Result<std::unique_ptr<Client>> client = connect(url);
    EXPECT_TRUE(client);
    const Result<void> held = (*client)->hold({&time_us, 1}, 60, {sea::Field::foam});
    EXPECT_TRUE(held) << held.error().message;
    const client::SeaStatePtr state = (*client)->sea_state(time_us);
    std::vector<client::KeyframePair> pairs;
    for (std::size_t c = 0; c < state->cascades.size(); ++c) {
        const auto pair = (*client)->ring().around(
            static_cast<int>(c), state->epoch, time_us, state->cascades[c].interval_us,
            sea::surface_fields | sea::FieldSet{sea::Field::foam});
        if (pair)
            pairs.push_back(*pair);
    }
    EXPECT_EQ(pairs.empty(), state->foam_mean == 0);
    return pairs;
}

// Crests of a gale are tens of times whiter than its mean; a tile of 2 km holds hundreds of them,
// so that its own mean is 1 within a factor of two, and clean water is most of it.
TEST(Foam, of_a_gale_reaches_a_client_as_ratios_and_a_calm_sea_has_none) {
    tests::ServerProcess gale(
        {"scenes/north_sea_gale.toml", "--listen", "127.0.0.1:0", "--device", "native"});
    const std::vector<client::KeyframePair> pairs =
        foam_around(gale.wait_until_ready(), 1'000'123'456);
    ASSERT_EQ(pairs.size(), 3u);
    for (const client::KeyframePair& pair : pairs) {
        EXPECT_TRUE(pair.covers);
        const std::span<const float> foam = pair.before->keyframe().plane(sea::Field::foam);
        double sum = 0;
        for (const float ratio : foam)
            sum += static_cast<double>(ratio);
        const double mean = sum / static_cast<double>(foam.size());
        EXPECT_GT(mean, 0.5);
        EXPECT_LT(mean, 2.0);
        EXPECT_GT(*std::max_element(foam.begin(), foam.end()), 3 * mean);
        EXPECT_GE(*std::min_element(foam.begin(), foam.end()),
                  -pair.before->error(sea::Field::foam));
    }
    tests::ServerProcess calm(
        {"scenes/calm.toml", "--listen", "127.0.0.1:0", "--device", "native"});
    EXPECT_TRUE(foam_around(calm.wait_until_ready(), 1'000'123'456).empty());
}

TEST(Start, port_in_use_is_exit_code_4) {
    const std::vector<std::string> arguments{"scenes/north_sea_gale.toml", "--device", "native",
                                             "--listen"};
    std::vector<std::string> first_arguments = arguments;
    first_arguments.push_back("127.0.0.1:0");
    tests::ServerProcess first(first_arguments);
    const std::string url = first.wait_until_ready();
    ASSERT_FALSE(url.empty()) << first.log();
    std::vector<std::string> second_arguments = arguments;
    second_arguments.push_back(url.substr(std::string("ws://").size()));
    tests::ServerProcess second(second_arguments);
    EXPECT_EQ(second.wait_for_exit(std::chrono::seconds(60)), 4);
    EXPECT_NE(second.log().find("in use"), std::string::npos) << second.log();
}

std::string small_scene(const std::string& sea, const std::string& accuracy) {
    return "[sea]\ndepth_m = 50\n[[sea.system]]\ntype = \"wind\"\nfrom_deg = 270\nfetch_m = "
           "50e3\n" +
           sea + "[[cascade]]\nlength_m = 400\nsize = 64\n[accuracy]\n" + accuracy;
}

TEST(Presets, query_only_answers_and_offers_no_stream) {
    const tests::Folder& folder = tests::folder();
    tests::ServerProcess server({folder.write("q.toml", small_scene("wind_speed_10m_mps = 8\n",
                                                                    "preset = \"query_only\"\n")),
                                 "--device", "native", "--listen", "127.0.0.1:0"});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    Result<std::unique_ptr<Client>> client = connect(url);
    ASSERT_TRUE(client) << client.error().message;
    const QueryPoint here{1, 2, 3'000'000};
    const auto answers = (*client)->ask({&here, 1}, {.timeout_s = 60});
    ASSERT_TRUE(answers) << answers.error().message;
    EXPECT_GT((*answers)[0].error_m, 0.0f);
    const auto grant = (*client)->subscribe({.fields = sea::surface_fields}, 2, 60);
    ASSERT_FALSE(grant);
    EXPECT_NE(grant.error().message.find("streams no height"), std::string::npos)
        << grant.error().message;
    EXPECT_NE(http_get(url, "/v1/state").body.find("\"offered_fields\": []"), std::string::npos);
}

TEST(Certificates, server_says_what_is_certified_and_warns_where_it_does_not_hold) {
    const tests::Folder& folder = tests::folder();
    const auto scene_with = [](const std::string& wind_mps) {
        return small_scene("wind_speed_10m_mps = " + wind_mps + "\n",
                           "height_error_m = 0.1\ncertificate = \"c.json\"\n");
    };
    const auto scene = sea::parse_scene(scene_with("10"), "s", "");
    ASSERT_TRUE(scene) << scene.error().message;
    const auto realized = sea::realize(*scene);
    ASSERT_TRUE(realized);
    sea::Certificate c;
    c.cascades = scene->cascades;
    c.height_error_m = scene->accuracy.height_error_m;
    c.configuration_hash = configuration_hash(*scene);
    c.spectrum_hash = spectrum_hash(*scene);
    c.envelope = envelope_of(sea_point(*scene, sea::summarize(scene->sea, *realized).requested));
    c.promised_m = 0.05;
    c.measured.resize(1);
    c.commit = "abc1234";
    folder.write("c.json", to_json(c));
    for (const bool holds : {true, false}) {
        tests::ServerProcess server({folder.write("s.toml", scene_with(holds ? "10" : "14")),
                                     "--device", "native", "--listen", "127.0.0.1:0"});
        const std::string url = server.wait_until_ready();
        ASSERT_FALSE(url.empty()) << server.log();
        EXPECT_NE(server.log().find("certified: 5 cm at p99"), std::string::npos) << server.log();
        const bool warned =
            server.log().find("the sea is outside of what c.json certifies: wind 14 m/s, "
                              "measured 10 .. 10 m/s") != std::string::npos;
        EXPECT_EQ(warned, !holds) << server.log();
        const std::string state = http_get(url, "/v1/state").body;
        EXPECT_NE(state.find("\"percentile\": 99"), std::string::npos) << state;
        EXPECT_NE(state.find(holds ? "\"holds\": true" : "\"holds\": false"), std::string::npos);
        EXPECT_EQ(state.find("is outside of what c.json certifies") != std::string::npos, !holds);
    }
    folder.write("c.json", "{}");
    tests::ServerProcess server({folder.write("s.toml", scene_with("10")), "--device", "native",
                                 "--listen", "127.0.0.1:0"});
    EXPECT_EQ(server.wait_until_ready(), "");
    EXPECT_EQ(server.wait_for_exit(std::chrono::seconds(60)), 2);
    EXPECT_NE(server.log().find("accuracy.certificate: c.json: format: missing"), std::string::npos)
        << server.log();
}

// A device that does not exist would be exit code 3: what is wrong with the words comes first.
TEST(Start, options_that_make_no_sense_are_exit_code_2_before_a_device_is_chosen) {
    const std::string garbage = tests::folder().write("garbage.pem", "this is no certificate\n");
    const std::pair<std::vector<std::string>, std::string> cases[] = {
        {{"--listen", "abc"}, "--listen abc"},
        {{"--listen", "127.0.0.1:70000"}, "--listen 127.0.0.1:70000"},
        {{"--tls-cert", garbage, "--tls-key", garbage}, "--tls-cert " + garbage},
        {{"--client-token-file", "/no/such/file"}, "/no/such/file"},
        {{"--admin-token-file", ""}, "--admin-token-file"}};
    for (const auto& [words, named] : cases) {
        std::vector<std::string> arguments{"scenes/calm.toml", "--device", "no such device"};
        arguments.insert(arguments.end(), words.begin(), words.end());
        tests::ServerProcess server(arguments);
        EXPECT_EQ(server.wait_for_exit(std::chrono::seconds(60)), 2) << named;
        EXPECT_NE(server.log().find(named), std::string::npos) << server.log();
    }
}

TEST(Stop, both_signals_end_it_within_two_seconds_with_clients_connected) {
    for (const int signal : {SIGTERM, SIGINT}) {
        std::optional<int> code;
        // A busy machine may stand still for two seconds, and hardly ten times in a row.
        for (int i = 0; i < 10 && !code; ++i) {
            tests::ServerProcess server(
                {"scenes/north_sea_gale.toml", "--device", "native", "--listen", "127.0.0.1:0"});
            const std::string url = server.wait_until_ready();
            ASSERT_FALSE(url.empty()) << server.log();
            Result<std::unique_ptr<Client>> client = connect(url);
            ASSERT_TRUE(client) << client.error().message;
            ASSERT_TRUE((*client)->subscribe({.fields = sea::surface_fields}, 2, 60));
            server.send(signal);
            code = server.wait_for_exit(std::chrono::seconds(2));
            if (!code) { // late is all that it may be
                ASSERT_EQ(server.wait_for_exit(std::chrono::seconds(60)), 0) << signal;
            }
        }
        EXPECT_EQ(code, 0) << signal;
    }
}

} // namespace
} // namespace seaway
