// SPDX-License-Identifier: Apache-2.0
#include <limits>
#include <string>

#include <gmock/gmock.h>

#include <fmt/format.h>

#include "sea/certificate/certificate.h"
#include "tests/support/folder.h"

namespace seaway::sea {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::string scene_text = R"(
[sea]
seed = 3
depth_m = 95
[[sea.system]]
type = "wind"
wind_speed_10m_mps = 19
from_deg = 315
fetch_m = 300e3
[[cascade]]
length_m = 2111
size = 128
[[cascade]]
length_m = 400
size = 128
[accuracy]
height_error_m = 0.1
certificate = "gale.certificate.json"
)";

Scene scene_of(const std::string& text) {
    const Result<Scene> scene = parse_scene(text, "gale.toml", "");
    EXPECT_TRUE(scene) << scene.error().message;
    return scene ? *scene : Scene{};
}

std::string with(std::string text, const std::string& what, const std::string& by) {
    const std::size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return at == std::string::npos ? text : text.replace(at, what.size(), by);
}

SeaStatistics statistics_of(double hs_m, double tp_s) {
    SeaStatistics statistics;
    statistics.significant_height_m = hs_m;
    statistics.peak_period_s = tp_s;
    return statistics;
}

const SeaStatistics gale = statistics_of(6.6, 10.8);

/// Of the scene above, measured in a gale and in one of Hs 5.5 m, Tp 9.9 s, wind 17 m/s.
Certificate certificate() {
    const Scene scene = scene_of(scene_text);
    Certificate c;
    c.cascades = scene.cascades;
    c.height_error_m = scene.accuracy.height_error_m;
    c.configuration_hash = configuration_hash(scene);
    c.spectrum_hash = spectrum_hash(scene);
    c.envelope = envelope_of(sea_point(scene, gale));
    c.envelope.add({5.5, 9.9, 95.0, 1.0, 17.0});
    c.promised_m = 0.05;
    c.measured = {{"as given", 3, 6.5, 0.004, 0.011, 0.02, 0.014, 0.0146, 0.0376, 0.01},
                  {"calmer", 99, 5.4, 0.004, 0.011, 0.02, 0.0141, 0.0147, 0.0379, 0.01}};
    c.beside_finer_waves_m = 0.0371;
    c.costs = {{"work_ms_per_s", 21.5}, {"bytes_per_s", 123456.0}};
    c.runners_up = {"2111 m/64: 0.06 m as given"};
    c.machine = "a machine, 2 cores";
    c.device = "native";
    c.driver = "Seaway";
    c.compiler = "g++ 12";
    c.commit = "abc1234";
    c.date_utc = "2026-11-22T08:00Z";
    c.command = "seaway-bench tune gale.toml";
    return c;
}

std::string error_of(const std::string& text) {
    const Result<Certificate> read = parse_certificate(text, "c.json");
    return read ? "no error" : read.error().message;
}

TEST(Certificate, reads_back_what_was_written_to_the_bit) {
    for (const double depth_m : {95.0, std::numeric_limits<double>::infinity()}) {
        Certificate written = certificate();
        written.envelope.high.depth_m = depth_m;
        written.measured[0].rms_m = 0.1 + 0.2; // no short decimal
        const std::string text = to_json(written);
        const Result<Certificate> read = parse_certificate(text, "c.json");
        ASSERT_TRUE(read) << read.error().message;
        EXPECT_EQ(to_json(*read), text);
        EXPECT_EQ(read->measured[0].rms_m, 0.1 + 0.2);
        EXPECT_EQ(read->envelope.high.depth_m, depth_m);
        EXPECT_EQ(read->cascades.size(), 2u);
    }
}

TEST(Certificate, a_figure_that_was_changed_by_hand_is_found) {
    const std::string text = to_json(certificate());
    for (const auto& [was, is] :
         {std::pair{"0.0376", "0.0276"}, std::pair{"\"percentile\": 99", "\"percentile\": 98"},
          std::pair{"abc1234", "abc1235"}, std::pair{"0.05", "0.01"}})
        EXPECT_THAT(error_of(with(text, was, is)), HasSubstr("checksum")) << was;
    // White space carries nothing.
    EXPECT_EQ(error_of(with(text, "\"promise\":", "\"promise\"  :")), "no error");
}

TEST(Certificate, what_is_missing_or_of_another_kind_is_named_by_its_key) {
    const std::string text = to_json(certificate());
    EXPECT_THAT(error_of("[]"), HasSubstr("not JSON that begins with an object"));
    EXPECT_THAT(error_of("{"), HasSubstr("not JSON"));
    EXPECT_THAT(error_of("{}"), HasSubstr("format: missing"));
    EXPECT_THAT(error_of(with(text, "certificate 1", "certificate 2")), HasSubstr("format: "));
    EXPECT_THAT(error_of(with(text, "\"tp_s\": 9.9", "\"tq_s\": 9.9")),
                HasSubstr("envelope.low.tp_s: missing"));
    EXPECT_THAT(
        error_of(with(text, "\"percentile\": 99.0", "\"percentile\": \"99\"")),
        HasSubstr("promise.percentile: \"99\" is not allowed; allowed: a number 50 .. 99.9"));
    EXPECT_THAT(error_of(with(text, "\"size\": 128", "\"size\": 4096")),
                HasSubstr("configuration.cascades[1].size: 4096 is not allowed"));
    EXPECT_THAT(error_of(with(text, "\"streams\": true", "\"streams\": 1")),
                HasSubstr("configuration.streams: 1 is not allowed; allowed: true, false"));
    // It becomes part of a line of a log.
    EXPECT_THAT(error_of(with(text, "abc1234", "abc\\nerror: all is lost")),
                HasSubstr("place.commit"));
}

TEST(Certificate, lists_hold_up_to_4096_rows_and_one_at_least) {
    for (const std::size_t rows :
         {std::size_t{0}, std::size_t{1}, std::size_t{4096}, std::size_t{4097}}) {
        Certificate c = certificate();
        c.measured.assign(rows, certificate().measured[0]);
        const std::string said = error_of(to_json(c));
        if (rows == 1 || rows == 4096)
            EXPECT_EQ(said, "no error") << rows;
        else
            EXPECT_THAT(said, HasSubstr("measured: a list of 1 .. 4096 is needed")) << rows;
    }
}

TEST(Certificate, no_cut_and_no_flipped_byte_does_harm) {
    const std::string text = to_json(certificate());
    for (std::size_t length = 0; length + 2 < text.size(); length += 7)
        EXPECT_NE(error_of(text.substr(0, length)), "no error") << length;
    for (std::size_t at = 0; at < text.size(); at += 3) {
        std::string flipped = text;
        flipped[at] = static_cast<char>(flipped[at] ^ 0x11);
        error_of(flipped); // an error or, in white space or a key that may be absent, none
    }
}

// Naive: shown in a message, and each depth takes a call.
TEST(Certificate, one_without_a_bottom_is_refused) {
    constexpr int depth = 400'000;
    const Result<Certificate> read = parse_certificate(
        "{\"format\": " + std::string(depth, '[') + std::string(depth, ']') + "}", "deep");
    ASSERT_FALSE(read);
    EXPECT_NE(
        read.error().message.find("deep has objects or lists within one another more than 16"),
        std::string::npos)
        << read.error().message;
}

TEST(Certificate, holds_for_its_own_configuration_with_any_seed) {
    const Certificate c = certificate();
    EXPECT_THAT(certificate_warnings(c, scene_of(scene_text), gale), IsEmpty());
    const Scene other_seed = scene_of(with(scene_text, "seed = 3", "seed = 4"));
    EXPECT_THAT(certificate_warnings(c, other_seed, gale), IsEmpty());
    EXPECT_EQ(spectrum_hash(other_seed), c.spectrum_hash);
    EXPECT_NE(spectrum_hash(scene_of(with(scene_text, "315", "316"))), c.spectrum_hash);
}

TEST(Certificate, another_configuration_is_warned_of) {
    const Certificate c = certificate();
    for (const auto& [was, is] :
         {std::pair{"height_error_m = 0.1", "height_error_m = 0.2"},
          std::pair{"length_m = 400", "length_m = 401"}, std::pair{"size = 128", "size = 256"},
          std::pair{"[accuracy]", "[effects]\ndisplacement = \"height\"\n[accuracy]"},
          std::pair{"[accuracy]", "[accuracy]\npreset = \"query_only\""}})
        EXPECT_THAT(certificate_warnings(c, scene_of(with(scene_text, was, is)), gale),
                    ::testing::Contains(HasSubstr("certifies another configuration")))
            << is;
}

TEST(Certificate, a_sea_that_leaves_the_envelope_is_warned_of_by_what_leaves_it) {
    const Certificate c = certificate();
    const Scene scene = scene_of(scene_text);
    EXPECT_THAT(certificate_warnings(c, scene, statistics_of(6.0, 10.0)), IsEmpty());
    EXPECT_THAT(certificate_warnings(c, scene, statistics_of(7.0, 10.8)),
                ElementsAre(HasSubstr("Hs 7 m, measured 5.5 .. 6.6 m")));
    EXPECT_THAT(certificate_warnings(c, scene, statistics_of(6.0, 9.0)),
                ElementsAre(HasSubstr("Tp 9 s, measured 9.9 .. 10.8 s")));
    EXPECT_THAT(
        certificate_warnings(c, scene_of(with(scene_text, "depth_m = 95", "depth_m = 20")), gale),
        ElementsAre(HasSubstr("depth 20 m, measured 95 .. 95 m")));
    EXPECT_THAT(
        certificate_warnings(c, scene_of(with(scene_text, "seed = 3", "choppiness = 1.2")), gale),
        ElementsAre(HasSubstr("choppiness 1.2, measured 1 .. 1")));
    // The larger one of the two counts.
    for (const char* choppiness : {"choppiness = [1.2, 0.5]", "choppiness = [0.5, 1.2]"})
        EXPECT_THAT(
            certificate_warnings(c, scene_of(with(scene_text, "seed = 3", choppiness)), gale),
            ElementsAre(HasSubstr("choppiness 1.2, measured 1 .. 1")));
    EXPECT_THAT(
        certificate_warnings(c, scene_of(with(scene_text, "10m_mps = 19", "10m_mps = 25")), gale),
        ElementsAre(HasSubstr("wind 25 m/s, measured 17 .. 19 m/s")));
    // Deep water stays deep water.
    Certificate deep = certificate();
    deep.envelope.low.depth_m = deep.envelope.high.depth_m =
        std::numeric_limits<double>::infinity();
    EXPECT_THAT(certificate_warnings(
                    deep, scene_of(with(scene_text, "depth_m = 95", "depth_m = inf")), gale),
                IsEmpty());
    EXPECT_THAT(certificate_warnings(deep, scene, gale), ElementsAre(HasSubstr("depth 95 m")));
}

TEST(Certificate, is_described_by_its_worst_sea) {
    EXPECT_EQ(describe(certificate()),
              "5 cm at p99, measured 3.79 cm (rms 1.47 cm, of which maps 4 mm and waves left out "
              "1.41 cm) in the worst of 2 seas, by seaway-bench tune of abc1234 on a machine, "
              "2 cores, 2026-11-22T08:00Z");
}

TEST(Certificate, is_read_beside_its_scene_and_errors_name_both) {
    Scene scene = scene_of(scene_text);
    scene.accuracy.certificate.name.clear();
    ASSERT_TRUE(load_certificate(scene));
    EXPECT_EQ(*load_certificate(scene), nullptr);
    const tests::Folder& folder = tests::folder();
    const Result<Scene> beside = parse_scene(scene_text, "gale.toml", folder.file(""));
    ASSERT_TRUE(beside);
    const Result<CertificatePtr> none = load_certificate(*beside);
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().message, "gale.toml: accuracy.certificate: cannot read "
                                    "'gale.certificate.json': no such file");
    folder.write("gale.certificate.json", to_json(certificate()));
    const Result<CertificatePtr> read = load_certificate(*beside);
    EXPECT_TRUE(read) << read.error().message;
    folder.write("gale.certificate.json", "{}");
    const Result<CertificatePtr> empty = load_certificate(*beside);
    ASSERT_FALSE(empty);
    EXPECT_THAT(empty.error().message,
                HasSubstr("accuracy.certificate: gale.certificate.json: format: missing"));
    folder.write("gale.certificate.json", std::string(certificate_bytes_max + 1, ' '));
    EXPECT_FALSE(load_certificate(*beside));
}

// The wind that counts is the strongest, wherever it stands; of choppiness the larger.
TEST(Certificate, a_sea_point_has_the_strongest_wind_and_the_larger_choppiness) {
    const auto with_winds = [](double first_mps, double second_mps, const char* effects) {
        return scene_of(fmt::format("[sea]\ndepth_m = 33\nchoppiness = [0.4, 1.2]\n"
                                    "[[sea.system]]\ntype = \"wind\"\nwind_speed_10m_mps = {}\n"
                                    "from_deg = 10\n"
                                    "[[sea.system]]\ntype = \"swell\"\nsignificant_height_m = 2\n"
                                    "peak_period_s = 12\nfrom_deg = 20\n"
                                    "[[sea.system]]\ntype = \"wind\"\nwind_speed_10m_mps = {}\n"
                                    "from_deg = 30\n{}",
                                    first_mps, second_mps, effects));
    };
    for (const auto& [first_mps, second_mps] : {std::pair(17.0, 6.0), {6.0, 17.0}}) {
        const SeaPoint point = sea_point(with_winds(first_mps, second_mps, ""), gale);
        EXPECT_EQ(point.wind_speed_10m_mps, 17);
        EXPECT_EQ(point.choppiness, 1.2);
        EXPECT_EQ(point.depth_m, 33);
        EXPECT_EQ(point.hs_m, 6.6);
        EXPECT_EQ(point.tp_s, 10.8);
    }
    const Scene still = with_winds(5, 4, "[effects]\ndisplacement = \"height\"\n");
    EXPECT_EQ(sea_point(still, gale).choppiness, 0) << "nothing moves sideways";
}

// What is promised is a percentile: the sea that is worst by it need not have the largest rms.
TEST(Certificate, is_told_by_the_sea_that_is_worst_at_the_percentile) {
    Certificate c = certificate();
    c.measured = {{"as given", 3, 6.5, 0.0041, 0.011, 0.02, 0.0142, 0.0191, 0.0376, 0.01},
                  {"calmer", 5, 5.4, 0.0063, 0.012, 0.03, 0.0155, 0.0184, 0.0412, 0.02},
                  {"rougher", 7, 7.7, 0.0022, 0.013, 0.04, 0.0117, 0.0203, 0.0398, 0.03}};
    EXPECT_EQ(c.worst().sea, "calmer");
    EXPECT_EQ(describe(c),
              "5 cm at p99, measured 4.12 cm (rms 1.84 cm, of which maps 6.3 mm and waves "
              "left out 1.55 cm) in the worst of 3 seas, by seaway-bench tune of abc1234 on "
              "a machine, 2 cores, 2026-11-22T08:00Z");
}

} // namespace
} // namespace seaway::sea
