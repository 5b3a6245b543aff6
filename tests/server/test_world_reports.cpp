// SPDX-License-Identifier: Apache-2.0
// What a running sea says about itself: every line and field holds the figure that it names. No two
// figures of this sea are equal, east is not north and the first cascade is not the second.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/elapsed.h"
#include "protocol/messages.h"
#include "sea/certificate/certificate.h"
#include "sea/surface/steepest_sea.h"
#include "sea/waves/probes.h"
#include "server/process_metrics.h"
#include "server/world_reports.h"
#include "tests/server/simulation/simulation_bench.h"
#include "tests/support/metrics_page.h"

namespace seaway::server {
namespace {

using nlohmann::json;

/// Equal values of the same shape, numbers to rounding; each difference is named by its path.
void expect_same(const json& shown, const json& expected) {
    const json flat = shown.flatten(), wanted = expected.flatten();
    for (const auto& [path, value] : wanted.items()) {
        ASSERT_TRUE(flat.contains(path)) << path << " is missing";
        if (value.is_number())
            EXPECT_NEAR(flat[path].get<double>(), value.get<double>(),
                        1e-12 * std::abs(value.get<double>()))
                << path;
        else
            EXPECT_EQ(flat[path], value) << path;
    }
    for (const auto& [path, value] : flat.items())
        EXPECT_TRUE(wanted.contains(path)) << path << " is not known to this test";
}

sea::SeaStatistics statistics(double first, double towards_rad) {
    return {first,       first + 1,   first + 2,   first + 3,
            towards_rad, 0.1 * first, first + 0.5, first + 99};
}

/// The small sea with figures of its own.
RunningSea some_sea() {
    RunningSea sea = *running_sea();
    sea.epoch = 6;
    sea.scene.source = "some.toml";
    sea.scene.accuracy.certificate.name = "c.json";
    sea.scene.sea.depth_m = 23;
    sea.scene.water = {sea::WaterType::jerlov_3, {0.1, 0.2, 0.3}};
    sea.budget.height_error_m = 0.051;
    sea.budget.codec_error_m = 0.013;
    sea.budget.single_precision_m = 0.0017;
    sea.budget.single_precision_displacement_m = 0.0019;
    sea.budget.interpolation_m = 0.0023;
    sea.budget.interpolation_displacement_m = 0.0029;
    sea.budget.interpolation_strain = 0.0031;
    sea.budget.rms_slope = 0.37;
    sea.budget.rms_strain = 0.41;
    sea.budget.displacement_reach_m = 43;
    sea.budget.cascades = {{250'000,
                            {{.time_m = 0.01, .east_m = 0.03, .north_m = 0.04},
                             {.time_m = 0.11, .east_m = 0.13, .north_m = 0.17}},
                            0.25,
                            4.7},
                           {125'000,
                            {{.time_m = 0.02, .east_m = 0.05, .north_m = 0.12},
                             {.time_m = 0.19, .east_m = 0.21, .north_m = 0.22}},
                            0.75,
                            0.6}};
    sea.summary.requested = statistics(5, 0.5);
    sea.summary.realised = statistics(17, 5.5);
    sea.summary.cascades = {{1.5, 1.6, 1.7, 1.8}, {2.5, 2.6, 2.7, 2.8}};
    auto realization = std::make_shared<sea::Realization>(*sea.realization);
    realization->choppiness = {0.7, 1.2};
    realization->cascades[0].band = {0.011, 0.27};
    realization->cascades[1].band = {0.29, 3.1};
    sea.realization = realization;
    auto law = std::make_shared<sea::FoamLaw>(*sea.foam_law);
    law->mean_coverage = 0.031;
    law->threshold = -0.27;
    sea.foam_law = law;
    return sea;
}

/// Runs for ever.
constexpr EpochWindow always{1, std::numeric_limits<sea::TimeUs>::min(),
                             std::numeric_limits<sea::TimeUs>::max()};

TEST(SeaStateValues, every_member_is_that_of_the_running_sea) {
    const RunningSea sea = some_sea();
    const protocol::SeaStateValues state = sea_state_values(sea, always, {"first", "second"});
    EXPECT_EQ(state.epoch, 6u);
    ASSERT_EQ(state.cascades.size(), 2u);
    const double lengths_m[] = {301, 43}, k_lo[] = {0.011, 0.29}, k_hi[] = {0.27, 3.1};
    const sea::TimeUs intervals_us[] = {250'000, 125'000};
    for (std::size_t c = 0; c < 2; ++c) {
        EXPECT_EQ(state.cascades[c].length_m, lengths_m[c]);
        EXPECT_EQ(state.cascades[c].size, 64);
        EXPECT_EQ(state.cascades[c].k_lo_radpm, k_lo[c]);
        EXPECT_EQ(state.cascades[c].k_hi_radpm, k_hi[c]);
        EXPECT_EQ(state.cascades[c].interval_us, intervals_us[c]);
    }
    ASSERT_EQ(state.losses.size(), 2u);
    EXPECT_EQ(state.losses[0].height.north_m, 0.04);
    EXPECT_EQ(state.losses[1].displacement.east_m, 0.21);
    EXPECT_EQ(state.choppiness_x, 0.7);
    EXPECT_EQ(state.choppiness_y, 1.2);
    EXPECT_EQ(state.height_error_m, 0.051);
    EXPECT_EQ(state.interpolation_error_m, 0.0023);
    EXPECT_EQ(state.interpolation_displacement_m, 0.0029);
    EXPECT_EQ(state.interpolation_strain, 0.0031);
    EXPECT_EQ(state.single_precision_m, 0.0017);
    EXPECT_EQ(state.single_precision_displacement_m, 0.0019);
    EXPECT_EQ(state.rms_slope, 0.37);
    EXPECT_EQ(state.rms_strain, 0.41);
    EXPECT_EQ(state.displacement_reach_m, 43);
    EXPECT_EQ(state.depth_m, 23);
    EXPECT_EQ(state.water, (sea::Water{sea::WaterType::jerlov_3, {0.1, 0.2, 0.3}}));
    EXPECT_EQ(state.foam_mean, 0.031);
    EXPECT_EQ(state.foam_threshold, -0.27);
    EXPECT_NE(state.scene.find("threshold = -0.27"), std::string::npos) << state.scene;
    EXPECT_EQ(state.warnings, (std::vector<std::string>{"first", "second"}));
    for (const auto& [shown, first, from_deg] :
         {std::tuple(state.requested, 5.0, 270 - 28.64788975654116),      // towards 0.5 rad
          std::tuple(state.realised, 17.0, 630 - 315.126787321952766)}) { // towards 5.5 rad
        EXPECT_EQ(shown.hs_m, first);
        EXPECT_EQ(shown.tp_s, first + 1);
        EXPECT_EQ(shown.tz_s, first + 2);
        EXPECT_EQ(shown.tm01_s, first + 3);
        EXPECT_NEAR(shown.mean_from_deg, from_deg, 1e-10);
        EXPECT_NEAR(shown.spread_deg, 0.1 * first * 57.29577951308232, 1e-10);
        EXPECT_EQ(shown.mss, first + 0.5);
    }
}

TEST(SeaStateValues, the_announcement_has_the_probes_of_the_sea_from_its_start_on) {
    const RunningSea sea = some_sea();
    EXPECT_TRUE(sea_state_values(sea, always, {}).probes.empty()) << "pages do without";
    const protocol::SeaStateValues state = announcement(sea, always, {"first"});
    EXPECT_EQ(state.start_time_us, -sea::time_us_max) << "it has run for ever";
    EXPECT_EQ(state.probes, sea::make_probes(*sea.truth, 0));
    EXPECT_EQ(state.probe_error_m, 1e-6);
    EXPECT_EQ(state.warnings, std::vector<std::string>{"first"});
}

// The longest scene that fits is sent; one byte more leaves it out, and says so.
TEST(SeaStateValues, a_scene_at_the_limit_is_sent_and_one_beyond_it_is_left_out_with_a_warning) {
    RunningSea sea = some_sea();
    std::string& name = sea.scene.accuracy.certificate.name;
    name = "n";
    const std::size_t around =
        sea_state_values(sea, always, {}).scene.size() - 1; // all but the name
    name = std::string(128 * 1024 - around, 'n');
    const protocol::SeaStateValues fits = sea_state_values(sea, always, {"other"});
    EXPECT_EQ(fits.scene.size(), 128u * 1024);
    EXPECT_EQ(fits.warnings, std::vector<std::string>{"other"});
    name += 'n';
    const protocol::SeaStateValues beyond = sea_state_values(sea, always, {"other"});
    EXPECT_EQ(beyond.scene, "");
    ASSERT_EQ(beyond.warnings.size(), 2u);
    EXPECT_NE(beyond.warnings[1].find("131072 bytes"), std::string::npos);
}

json numbers(double first, double from_deg) {
    return json{{"hs_m", first},
                {"tp_s", first + 1},
                {"tz_s", first + 2},
                {"tm01_s", first + 3},
                {"mean_from_deg", from_deg},
                {"spread_deg", 0.1 * first * 57.29577951308232},
                {"mss", first + 0.5}};
}
json cascade(double length_m, double k_lo, double k_hi, double interval_s, double time_m,
             double space_m, double requested, double realised) {
    return json{{"length_m", length_m},
                {"size", 64},
                {"k_lo_radpm", k_lo},
                {"k_hi_radpm", k_hi},
                {"keyframe_interval_s", interval_s},
                {"time_interpolation_rms_m", time_m},
                {"space_interpolation_rms_m", space_m},
                {"requested_m2", requested},
                {"realised_m2", realised}};
}

TEST(StateJson, every_field_is_that_of_the_running_sea) {
    RunningSea sea = some_sea();
    auto certificate = std::make_shared<sea::Certificate>();
    certificate->promised_m = 0.07;
    certificate->percentile = 95;
    certificate->measured = {{.max_m = 9, .total_m = 0.02}, {.max_m = 1, .total_m = 0.061}};
    certificate->configuration_hash = "of another";
    certificate->envelope = sea::envelope_of(sea::sea_point(sea.scene, sea.summary.requested));
    sea.certificate = certificate;
    json fields = json::array();
    for (const sea::FieldInfo& field : sea::field_table)
        fields.push_back(field.name);
    json shown = json::parse(state_json(sea, {"first", "second"}, "abacus",
                                        {12'500'000, 5'000'000, 2500, 0, 1'700'000'000'000'001}, {},
                                        {{"busy", 3}}));
    EXPECT_FALSE(shown["certificate"]["says"].get<std::string>().empty());
    shown["certificate"].erase("says");
    EXPECT_GT(shown["cpu_s"].get<double>(), 0);
    EXPECT_LE(shown["cpu_s"].get<double>(), process_cpu_seconds());
    shown.erase("cpu_s");
    expect_same(shown, {{"epoch", 6},
                        {"sea_time_s", 12.5},
                        {"pace", 2.5},
                        {"epoch_utc", "2023-11-14T22:13:20.000001Z"},
                        {"device", "abacus"},
                        {"scene", "some.toml"},
                        {"requested", numbers(5, 270 - 28.64788975654116)},
                        {"realised", numbers(17, 630 - 315.126787321952766)},
                        {"realised_before", nullptr},
                        // 3-4-5 and 5-12-13: what both axes miss together.
                        {"cascades",
                         {cascade(301, 0.011, 0.27, 0.25, 0.01, 0.05, 1.5, 1.7),
                          cascade(43, 0.29, 3.1, 0.125, 0.02, 0.13, 2.5, 2.7)}},
                        {"offered_fields", fields},
                        {"glides_until_s", nullptr},
                        {"foam_mean", 0.031},
                        {"foam_threshold", -0.27},
                        {"height_error_m", 0.051},
                        {"error_budget",
                         {{"level_m", sea::level_error_m(sea.budget, 0.013)},
                          {"interpolation_m", 0.0023},
                          {"codec_m", 0.013},
                          {"single_precision_m", 0.0017},
                          {"inverse_m", sea::inverse_share * 0.051}}},
                        {"certificate",
                         {{"file", "c.json"},
                          {"height_error_m", 0.07},
                          {"percentile", 95},
                          {"measured_m", 0.061},
                          {"holds", false}}},
                        {"changes_refused", {{"busy", 3}}},
                        {"warnings", {"first", "second"}}});
    sea.certificate = nullptr;
    EXPECT_TRUE(json::parse(state_json(sea, {}, "", {}))["certificate"].is_null());
}

/// Two keyframes of the first cascade and one of the second. By transforms times n^2 log2 n (64:
/// 24576, 32: 5120) the height of the first weighs 4 * 24576 = 98304, that of the second 5120 and its
/// slopes 10240: 113664 in all. Transforms alone are 4, 1 and 2.
constexpr double weight_all = 113664;
EffectCosts some_costs() {
    using sea::Field;
    EffectCosts costs({64, 32});
    const sea::FieldSet height{Field::height, Field::height_rate};
    const KeyframeRequest requests[] = {
        {0, 0, height}, {0, 1, height}, {1, 0, {Field::height, Field::slope_x, Field::slope_y}}};
    costs.add(requests, {.dispatches = 70, .transforms = 7, .keyframes = 3, .device_seconds = 0.5});
    const FoamTurn turn{};
    const KeyframeRequest foam{1, 0, {}, 1, &turn};
    costs.add({&foam, 1}, {.foam_seconds = 0.125});
    return costs;
}

EffectPlan some_plan() {
    using sea::Field;
    return {{{{Field::height, Field::slope_x}, 250'000, 17}, {{}, 125'000, 19}}};
}

SimulationCounters some_counters() {
    SynthesisCounters synthesis{3, 5, 7, 9, 11.5, 79, 83, 0.0, 71, 73};
    for (std::size_t i = 0; i < synthesis.maps_too_large.size(); ++i)
        synthesis.maps_too_large[i] = 100 + i;
    synthesis.stylised_sums = 89;
    return {.synthesis = synthesis,
            .store = {.keyframes = 13, .bytes = 17, .hits = 19, .misses = 23},
            .keyframes_published = 29,
            .keyframes_skipped = 31,
            .stream_slices = 37,
            .questions = 41,
            .questions_over_budget = 59,
            .question_bytes = 61,
            .fetch_bytes = 43,
            .fetch_bytes_most = 47,
            .device_rebuilds = 53};
}

TEST(SimulationMetrics, every_line_shows_the_figure_that_it_names) {
    std::map<std::string, double> expected{{"seaway_sea_time_seconds", 59.25},
                                           {"seaway_sea_clock_behind_seconds", -0.25},
                                           {"seaway_sea_pace_ratio", 0.5},
                                           {"seaway_plan_idle", 0},
                                           {"seaway_dispatches_total", 3},
                                           {"seaway_transforms_total", 5},
                                           {"seaway_cascades_taken_total", 9},
                                           {"seaway_keyframes_total", 7},
                                           {"seaway_keyframes_copied_total", 79},
                                           {"seaway_foam_ticks_total", 83},
                                           {"seaway_stylised_sums_total", 89},
                                           {"seaway_device_seconds_total", 11.5},
                                           {"seaway_keyframes_published_total", 29},
                                           {"seaway_keyframes_skipped_total", 31},
                                           {"seaway_questions_total", 41},
                                           {"seaway_questions_over_budget_total", 59},
                                           {"seaway_device_rebuilds_total", 53},
                                           {"seaway_keyframe_store_hits_total", 19},
                                           {"seaway_keyframe_store_misses_total", 23}};
    expected["seaway_readback_bytes_total"] = 71;
    expected["seaway_maps_rounded_total"] = 73;
    for (const sea::FieldInfo& row : sea::field_table)
        expected["seaway_maps_too_large_total{field=\"" + std::string(row.name) + "\"}"] =
            100 + static_cast<int>(row.field);
    const char* const effects[] = {"height", "choppy", "slopes", "gradient", "foam"};
    for (int cascade = 0; cascade < 2; ++cascade)
        for (const std::string effect : effects) {
            const double weight = cascade == 0         ? (effect == "height" ? 98304 : 0)
                                  : effect == "height" ? 5120
                                  : effect == "slopes" ? 10240
                                                       : 0;
            const double transforms = weight / (cascade == 0 ? 24576 : 5120);
            const double keyframes = weight == 0 ? 0 : cascade == 0 ? 2 : 1;
            const double beside_s = cascade == 1 && effect == "foam" ? 0.125 : 0;
            const auto put = [&](const char* name, double value) {
                expected[std::string("seaway_effect_") + name + "_total{cascade=\"" +
                         std::to_string(cascade) + "\",effect=\"" + effect + "\"}"] = value;
            };
            put("keyframes", keyframes);
            put("dispatches", 10 * transforms);
            put("transforms", transforms);
            put("seconds", 0.5 * weight / weight_all + beside_s);
        }
    tests::expect_metrics(
        tests::read_metrics(metrics_text(some_plan(), some_counters(), some_costs(),
                                         {59'250'000, 118'500'000, 500, -250'000, 0})),
        expected);
    EffectPlan idle = some_plan();
    idle.cascades[0].fields = {};
    EXPECT_EQ(
        tests::read_metrics(metrics_text(idle, {}, some_costs(), {})).values.at("seaway_plan_idle"),
        1);
}

TEST(PlanJson, every_field_is_that_of_the_plan_and_of_what_was_measured) {
    const RunningSea sea = some_sea();
    // A second of the device does weight_all / 0.5 s; a keyframe comes four times a second of the sea's, which runs four times as fast
    // as clocks do.
    const auto effect = [](const char* name, const char* field, double weight, double share_us,
                           int keyframes) {
        const double predicted_us = 1e6 * weight * 0.5 / weight_all;
        return json{{"effect", name},
                    {"fields", {field}},
                    {"predicted_us_per_keyframe", predicted_us},
                    {"share_us_per_keyframe", share_us},
                    {"predicted_us_per_s", 16 * predicted_us},
                    {"keyframes", keyframes}};
    };
    expect_same(
        json::parse(plan_json(sea, some_plan(), some_counters(), some_costs(), "abacus",
                              {.pace_permille = 4000})),
        {{"device", "abacus"},
         {"idle", false},
         {"cascades",
          {{{"length_m", 301.0},
            {"size", 64},
            {"effects",
             {effect("height", "height", 24576, 1e6 * 0.5 * 98304 / weight_all / 2, 2),
              effect("slopes", "slope_x", 24576, 0, 0)}},
            {"fields", {"height", "slope_x"}},
            {"keyframes_per_s", 16.0},
            {"transforms_per_keyframe", 17}},
           {{"length_m", 43.0},
            {"size", 64},
            {"effects", json::array()},
            {"fields", json::array()},
            {"keyframes_per_s", 0.0},
            {"transforms_per_keyframe", 19}}}},
         {"done",
          {{"dispatches", 3}, {"transforms", 5}, {"keyframes", 7}, {"device_seconds", 11.5}}}});
}

// What foam is told to go by is what its maps do: of two seas of which one has none the other's threshold holds throughout.
TEST(SeaStateValues, a_glide_is_told_the_foam_threshold_that_its_maps_go_by) {
    const auto sea_of = [](const char* wind_mps) {
        std::string text = small_sea;
        text.replace(text.find("9.0"), 3, wind_mps);
        return make_running_sea(*sea::parse_scene(text + "[effects]\nfoam = true\n", "foam"), 1)
            .value();
    };
    const RunningSeaPtr calm = sea_of("2.0"), fresh = sea_of("12.0"), storm = sea_of("18.0");
    ASSERT_TRUE(calm->foam_law->calm());
    ASSERT_FALSE(fresh->foam_law->calm());
    ASSERT_GT(std::abs(storm->foam_law->threshold - fresh->foam_law->threshold), 1e-3);
    for (const auto& [from, to] : {std::pair(calm, storm), {storm, calm}, {fresh, storm}}) {
        const RunningSeaPtr glide = make_glide(*from, *to, 2, 0, 100'000'000).value();
        const protocol::SeaStateValues told = sea_state_values(*glide, {2, 0, 100'000'000}, {});
        // Half of one of 16 steps, where both have foam.
        const double step = std::abs(told.foam_threshold - told.glide->foam_threshold) / 32;
        for (sea::TimeUs t_us = 2'000'000; t_us < 99'000'000; t_us += 3'000'000)
            EXPECT_NEAR(told.foam_threshold_at(t_us), glide->foam_law_at(t_us)->threshold,
                        step + 1e-12)
                << t_us;
    }
}

// Naive: who has no free file to look into the list of what is open with finds nothing open, just when it matters.
TEST(ProcessMetrics, leave_out_what_is_not_known) {
    const std::string text = process_metrics_text("/nowhere");
    EXPECT_EQ(text.find("process_open_fds"), std::string::npos) << text;
    EXPECT_EQ(text.find("process_resident_memory_bytes"), std::string::npos) << text;
    EXPECT_NE(text.find("\nprocess_max_fds "), std::string::npos) << text;
    const std::string known = process_metrics_text();
    EXPECT_NE(known.find("\nprocess_open_fds "), std::string::npos);
    EXPECT_NE(known.find("\nprocess_resident_memory_bytes "), std::string::npos);
}

// Naive: a server refuses slopes of a million, and a client mean squares of a thousand million.
TEST(State, of_the_steepest_sea_that_is_run_is_one_that_a_client_takes) {
    sea::Scene steep = some_sea().scene;
    steep.accuracy.certificate = {};
    steep.sea.systems.clear();
    sea::ExplicitModes modes;
    modes.length_m = 0.1;
    modes.modes = {{300, 0, 15.0, 0.0}};
    steep.sea.systems.emplace_back(modes);
    steep.cascades = {{0.1, 1024}};
    const auto sea = make_running_sea(steep, 1);
    ASSERT_TRUE(sea) << sea.error().message;
    EXPECT_GT((*sea)->budget.rms_slope, 0.7 * sea::steady_share_of_told * sea::told_slope_max);
    std::get<sea::ExplicitModes>(steep.sea.systems[0]).modes = {{0, 300, 15.0, 0.0}};
    const auto across = make_running_sea(steep, 3);
    ASSERT_TRUE(across) << across.error().message;
    const auto glide = make_glide(**sea, **across, 2, 100'000'000, 110'000'000);
    ASSERT_TRUE(glide) << glide.error().message;
    for (const RunningSea* one : {sea->get(), glide->get()}) {
        const protocol::Bytes bytes = protocol::sea_state(sea_state_values(*one, always, {}));
        protocol::MessageReader reader(protocol::Sender::server);
        const auto message = reader.read(bytes);
        ASSERT_TRUE(message && *message);
        const Result<void> taken = protocol::check(*(*message)->body_as_SeaState());
        EXPECT_TRUE(taken) << taken.error().message;
    }
}

} // namespace
} // namespace seaway::server
