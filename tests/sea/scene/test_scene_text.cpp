// SPDX-License-Identifier: Apache-2.0
// Scenes that are refused for how they are written, and by which key.
#include <string>

#include <gmock/gmock.h>

#include "sea/scene/scene.h"

namespace seaway::sea {
namespace {

using ::testing::HasSubstr;

std::string error_of(const std::string& text) {
    const Result<Scene> scene = parse_scene(text, "s.toml", "");
    return scene ? "no error" : scene.error().message;
}

// Strings of three quotes may end with one or two more that belong to them.
TEST(Scene, bytes_beyond_ascii_are_allowed_in_strings_however_these_end) {
    const std::string note = "caf\xC3\xA9";
    for (const std::string quote : {"\"", "'"})
        for (int more = 0; more <= 2; ++more) {
            std::string text = "[sea]\na = " + quote + quote + quote + "x" + quote + quote + quote;
            for (int i = 0; i < more; ++i)
                text += quote;
            // Unknown keys, which is what is wrong with it.
            EXPECT_THAT(error_of(text + "\nb = " + quote + note + quote + "\n"),
                        HasSubstr("unknown key"))
                << text;
            EXPECT_THAT(error_of(text + "\nb = 1 " + note + "\n"),
                        HasSubstr("s.toml:3: byte 0xc3 is not allowed here"))
                << text;
        }
}

// Refused for what several keys say together: of a list, the key that holds it.
TEST(Scene, stylised_waves_that_are_too_short_or_too_fast_are_blamed_on_where_they_stand) {
    const std::string sines = "[sea]\n[[sea.system]]\ntype = \"sines\"\nshape = \"sine\"\n";
    const std::string list = "wavelength_m,amplitude_m,from_deg,phase_rad\n";
    const std::string data = "data = \"\"\"\n";
    EXPECT_THAT(error_of(sines + "length_m = 1e5\n" + data + list + "0.02,0.1,0,0\n\"\"\"\n"),
                HasSubstr("sea.system[1].data: a list is not allowed"));
    EXPECT_THAT(error_of(sines + "length_m = 1e5\nwavelength_m = 0.02\nfrom_deg = 0\n"),
                HasSubstr("sea.system[1].wavenumber_ratio: "));
}

} // namespace
} // namespace seaway::sea
