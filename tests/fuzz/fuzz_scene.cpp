// SPDX-License-Identifier: Apache-2.0
// Scene texts and parameter sets: an error by name, or a finite sea that reads back as itself.
// First byte '#': all of it is TOML text (tests/data/odd_scenes/ is a corpus). Another odd byte: the rest
// is. Even: the rest picks values, also impossible ones, for the keys of a scene.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "sea/scene/scene.h"
#include "sea/scene/scene_names.h"
#include "sea/waves/reference.h"
#include "sea/waves/statistics/moments.h"

namespace {

using namespace seaway::sea;

void require(bool condition) {
    if (!condition)
        std::abort();
}

/// Bytes as choices; zeros when they run out.
class Choices {
  public:
    Choices(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
    unsigned below(unsigned count) { return (size_ > 0 ? (--size_, *data_++) : 0u) % count; }
    std::string number() {
        static const char* const odd[] = {"nan",   "inf",    "-inf", "-0.0",  "0",
                                          "1e-45", "5e-324", "1e38", "1e308", "-1"};
        if (below(4) == 0)
            return odd[below(10)];
        const int exponent = static_cast<int>(below(9)) - 4;
        return std::to_string(below(100)) + "." + std::to_string(below(10)) + "e" +
               std::to_string(exponent);
    }
    /// A word of one of the tables that reader and writer share.
    template <class Kinds>
    std::string kind_of(const Kinds& kinds) {
        return std::string(kinds[below(static_cast<unsigned>(kinds.size()))].first);
    }

  private:
    const std::uint8_t* data_;
    std::size_t size_;
};

std::string system_text(Choices& c) {
    static const char* const keys[] = {"wind_speed_10m_mps",
                                       "fetch_m",
                                       "gamma",
                                       "swell",
                                       "isotropic",
                                       "from_deg",
                                       "peak_period_s",
                                       "significant_height_m",
                                       "spreading_exponent",
                                       "length_m",
                                       "amplitude_m",
                                       "wavelength_m",
                                       "amplitude_ratio",
                                       "wavenumber_ratio",
                                       "sharpness",
                                       "drag",
                                       "speed_ratio",
                                       "phillips_constant",
                                       "wind_speed_19m5_mps",
                                       "narrow_share",
                                       "direction_step_deg",
                                       "direction_spread_deg"};
    const std::string type(system_names[c.below(static_cast<unsigned>(system_names.size()))]);
    std::string text = "[[sea.system]]\ntype = \"" + type + "\"\n";
    if (type == "sines")
        text += "shape = \"" + c.kind_of(sine_names) + "\"\n";
    else if (type == "measured")
        text += "data = \"\"\"f_hz,df_hz,s_m2_hz,a1,b1,a2,b2\n" + c.number() + ",0.01," +
                c.number() + "," + c.number() + "," + c.number() + ",0.1,0.2\n\"\"\"\n";
    else if (type == "modes")
        text += "data = \"\"\"nx,ny,amplitude_m,phase_rad\n" + std::to_string(c.below(40)) + "," +
                std::to_string(c.below(40)) + "," + c.number() + "," + c.number() + "\n\"\"\"\n";
    else
        text += "spectrum = \"" + c.kind_of(spectrum_names) + "\"\nspreading = \"" +
                c.kind_of(spreading_names) + "\"\n";
    for (const char* key : keys)
        if (c.below(3) != 0)
            text += std::string(key) + " = " + c.number() + "\n";
    return text;
}

std::string scene_text(Choices& c) {
    static const char* const keys[] = {
        "depth_m",      "choppiness",        "gravity_mps2",         "loop_period_s",
        "height_scale", "short_wave_fade_m", "wavenumber_min_radpm", "wavenumber_max_radpm"};
    std::string text = "[sea]\n";
    for (const char* key : keys)
        if (c.below(2) != 0)
            text += std::string(key) + " = " + c.number() + "\n";
    for (unsigned systems = c.below(4); systems > 0; --systems)
        text += system_text(c);
    return text;
}

bool finite(const LagrangianPoint& p) {
    return std::isfinite(p.height) && std::isfinite(p.displacement_x) &&
           std::isfinite(p.displacement_y) && std::isfinite(p.height_rate) &&
           std::isfinite(p.slope_x) && std::isfinite(p.slope_y) && std::isfinite(p.strain_xx) &&
           std::isfinite(p.strain_yy) && std::isfinite(p.strain_xy);
}

void check(const Scene& scene) {
    const std::string effective = to_toml(scene);
    const seaway::Result<Scene> again = parse_scene(effective, "effective", "");
    require(again.has_value() && to_toml(*again) == effective);
    // Small grids hold the same modes; large ones only cost time.
    std::vector<CascadeSpec> tiles = scene.cascades;
    for (CascadeSpec& tile : tiles)
        tile.size = std::min(tile.size, 64);
    if (!assign_bands(tiles))
        return;
    seaway::Result<Realization> sea = realize(scene.sea, tiles);
    if (!sea)
        return;
    for (const CascadeModes& modes : sea->cascades)
        for (const auto& h0 : modes.h0)
            require(std::isfinite(h0.real()) && std::isfinite(h0.imag()));
    const SeaSummary summary = summarize(scene.sea, *sea);
    require(std::isfinite(summary.requested.significant_height_m) &&
            std::isfinite(summary.realised.significant_height_m));
    const DirectSum sum(std::make_shared<const Realization>(*std::move(sea)));
    require(finite(sum.at(12.5, -7e6, 123'456'789)) && finite(sum.at(0, 0, -1)));
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0)
        return 0;
    Choices choices(data + 1, size - 1);
    const std::string text = (data[0] & 1u) == 0
                                 ? scene_text(choices)
                                 : std::string(data + (data[0] == '#' ? 0 : 1), data + size);
    const seaway::Result<Scene> scene = parse_scene(text, "fuzz", "");
    if (scene)
        check(*scene);
    else
        require(!scene.error().message.empty());
    return 0;
}
