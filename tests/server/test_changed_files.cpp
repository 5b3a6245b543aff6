// SPDX-License-Identifier: Apache-2.0
// Changes of seas whose scenes name files.
#include <regex>

#include <gtest/gtest.h>

#include "sea/certificate/certificate.h"
#include "sea/scene/scene.h"
#include "sea/waves/statistics/moments.h"
#include "tests/server/change_bench.h"

namespace seaway::changes {
namespace {

/// A sea with a certificate beside it, as `seaway-bench tune` writes both.
std::string certified_scene() {
    const std::string text = small_sea_text();
    const std::string named = std::regex_replace(text, std::regex("\\[accuracy\\]"),
                                                 "[accuracy]\ncertificate = \"calm.json\"");
    EXPECT_NE(named, text);
    const sea::Scene scene = *sea::parse_scene(named, "calm", ".");
    sea::Certificate c;
    c.cascades = scene.cascades;
    c.height_error_m = scene.accuracy.height_error_m;
    c.configuration_hash = configuration_hash(scene);
    c.spectrum_hash = spectrum_hash(scene);
    c.envelope =
        sea::envelope_of(sea_point(scene, summarize(scene.sea, *sea::realize(scene)).requested));
    c.promised_m = 0.05;
    c.percentile = 99;
    c.measured = {{.sea = "as given", .seed = 3, .hs_m = 1}};
    tests::folder().write("calm.json", to_json(c));
    return tests::folder().write("certified.toml", named);
}

// Naive: who changes a sea is somewhere else, and there is no such file there.
TEST(Changes, a_sea_with_a_certificate_can_be_changed_and_keeps_it) {
    const std::string scene = certified_scene();
    std::vector<std::string> words = arguments(tests::folder().file("certified"));
    words[0] = scene;
    tests::ServerProcess server(words);
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    Said said = ctl(url, {"set", "systems.0.wind_speed_10m_mps=3", "--over", "10s"});
    ASSERT_EQ(said.code, 0) << said.words;
    said = ctl(url, {"load", scene, "--over", "10s"});
    EXPECT_EQ(said.code, 0) << said.words;
    said = ctl(url, {"state"});
    EXPECT_NE(said.words.find("calm.json"), std::string::npos) << said.words;
}

// Naive: the text of the file alone is sent, and the table that it names is not there.
TEST(Changes, a_scene_whose_table_is_a_file_can_be_loaded) {
    std::vector<std::string> words = arguments(tests::folder().file("measured"));
    words[0] = "scenes/measured_buoy.toml";
    tests::ServerProcess server(words);
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    const Said said =
        ctl(url, {"load", SEAWAY_SOURCE_DIR "/scenes/measured_buoy.toml", "--over", "10s"});
    EXPECT_EQ(said.code, 0) << said.words;
}

} // namespace
} // namespace seaway::changes
