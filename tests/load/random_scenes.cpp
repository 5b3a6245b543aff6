// SPDX-License-Identifier: Apache-2.0
#include "tests/load/random_scenes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "tests/support/draw.h"

namespace seaway::tests {

namespace {

constexpr double deep_m = std::numeric_limits<double>::infinity();

std::string cascades(Draw& draw, double length_m, int count, double ratio) {
    std::string text;
    for (int i = 0; i < count; ++i, length_m /= ratio)
        text += fmt::format("[[cascade]]\nlength_m = {:.4g}\nsize = {}\n", length_m,
                            draw.one_of({64, 64, 128}));
    return text;
}

std::string head(Draw& draw, double depth_m, double choppiness, const std::string& more = "") {
    return fmt::format("[sea]\nseed = {}\ndepth_m = {:.4g}\nchoppiness = {:.3g}\n{}",
                       draw.below(1u << 30), depth_m, choppiness, more);
}

double depth(Draw& draw) {
    return draw.one_of({deep_m, draw.log_uniform(3, 3000)});
}

std::string wind(Draw& draw, double low_mps, double high_mps) {
    return fmt::format("[[sea.system]]\ntype = \"wind\"\nspectrum = \"{}\"\nfrom_deg = {:.1f}\n"
                       "wind_speed_10m_mps = {:.3g}\nspreading = \"{}\"\n",
                       draw.one_of({"jonswap", "tma", "pierson_moskowitz", "phillips"}),
                       draw.uniform(0, 359), draw.log_uniform(low_mps, high_mps),
                       draw.one_of({"cos2", "cos2s", "mitsuyasu", "hasselmann", "donelan_banner"}));
}

std::string swell(Draw& draw, double height_m, double period_s, double exponent) {
    return fmt::format(
        "[[sea.system]]\ntype = \"swell\"\nspectrum = \"jonswap\"\nfrom_deg = {:.1f}\n"
        "significant_height_m = {:.3g}\npeak_period_s = {:.3g}\nspreading = \"cos2s\"\n"
        "spreading_exponent = {:.3g}\n",
        draw.uniform(0, 359), height_m, period_s, exponent);
}

/// A measured table with energy in some of its bins of 10 mHz only.
template <class Holds>
std::string measured(Draw& draw, Holds holds) {
    std::string text =
        "[[sea.system]]\ntype = \"measured\"\ndata = '''\nf_hz,df_hz,s_m2_hz,a1,b1,a2,b2\n";
    const double towards = draw.uniform(0, 6.28), r1 = draw.uniform(0.3, 0.95);
    for (int bin = 4; bin < 110; ++bin) {
        const double f = 0.01 * bin;
        const double s = holds(f) ? draw.uniform(0.2, 2.0) * 1e-3 * std::pow(f, -4.0) : 0.0;
        text += fmt::format("{:.2f},0.01,{:.4g},{:.4f},{:.4f},0,0\n", f, s, r1 * std::cos(towards),
                            r1 * std::sin(towards));
    }
    return text + "'''\n";
}

std::string scene_with_gaps(Draw& draw) {
    const double gap = draw.uniform(0.1, 0.5), width = draw.uniform(0.05, 0.3);
    return head(draw, depth(draw), draw.one_of({0.0, 1.0})) +
           measured(draw,
                    [&](double f) { return f > 0.08 && f < 0.6 && (f < gap || f > gap + width); }) +
           cascades(draw, draw.uniform(600, 1200), 3, draw.uniform(5, 8));
}

std::string scene_with_empty_cascades(Draw& draw) {
    const auto which = draw.below(3);
    return head(draw, deep_m, 1.0) +
           measured(draw,
                    [&](double f) {
                        const bool low = f >= 0.08 && f <= 0.12, high = f >= 0.8 && f <= 1.0;
                        return which == 0 ? low : which == 1 ? high : low || high;
                    }) +
           cascades(draw, 1021, 3, 6);
}

} // namespace

const char* name(Oddity oddity) {
    constexpr const char* names[oddity_count] = {"gaps",  "empty",   "loop",       "narrow",
                                                 "steep", "shallow", "many_tiles", "crossing"};
    return names[static_cast<int>(oddity)];
}

RandomScene random_scene(std::uint64_t seed, int number) {
    Draw draw(seed * 1'000'003 + static_cast<std::uint64_t>(number));
    const auto oddity = static_cast<Oddity>(number % oddity_count);
    std::string text;
    switch (oddity) {
    case Oddity::gaps:
        text = scene_with_gaps(draw);
        break;
    case Oddity::empty:
        text = scene_with_empty_cascades(draw);
        break;
    case Oddity::loop:
        text = head(draw, draw.one_of({20.0, deep_m}), 1.0,
                    fmt::format("loop_period_s = {}\n",
                                number / oddity_count ? draw.whole(1, 60) : 1)) +
               swell(draw, 2, draw.uniform(5, 12), 10) + cascades(draw, 200, 2, 6.7);
        break;
    case Oddity::narrow:
        text = head(draw, depth(draw), 1.0) +
               swell(draw, draw.uniform(0.5, 3), draw.uniform(8, 16), draw.log_uniform(100, 1e6)) +
               cascades(draw, draw.uniform(600, 3000), 2, 5);
        break;
    case Oddity::steep:
        text = head(draw, deep_m, draw.uniform(1.2, 3),
                    fmt::format("height_scale = {:.3g}\n", draw.uniform(1, 3))) +
               wind(draw, 12, 40) + cascades(draw, draw.uniform(100, 900), 3, 6);
        break;
    case Oddity::shallow:
        text = head(draw, 0.5, 1.0) + swell(draw, draw.uniform(0.02, 0.2), draw.uniform(1, 6), 10) +
               cascades(draw, draw.uniform(20, 80), 2, 5);
        break;
    case Oddity::many_tiles:
        text = head(draw, depth(draw), 1.0) + wind(draw, 4, 20) +
               cascades(draw, 1500, 5, draw.uniform(3, 5));
        break;
    case Oddity::crossing:
        text = head(draw, depth(draw), draw.uniform(0, 1));
        for (int i = draw.whole(1, 4); i > 0; --i)
            text += draw.below(2) ? wind(draw, 0.5, 15)
                                  : swell(draw, draw.log_uniform(1e-3, 4), draw.log_uniform(1, 20),
                                          draw.log_uniform(1, 1e4));
        text += cascades(draw, draw.uniform(50, 1500), draw.whole(1, 4), draw.uniform(3, 9));
        break;
    }
    return {oddity, text + fmt::format("[accuracy]\nheight_error_m = {}\n",
                                       draw.one_of({0.002, 0.01, 0.05}))};
}

std::string extreme_scene(std::uint64_t seed, int number) {
    Draw draw(seed * 2'000'003 + static_cast<std::uint64_t>(number));
    const int kind = number % extreme_count;
    std::string text =
        head(draw, kind == 0 ? draw.log_uniform(0.05, 10) : deep_m, draw.uniform(0, 1.2),
             kind == 0 ? "" : fmt::format("height_scale = {:.3g}\n", draw.uniform(1, 2.5)));
    if (kind != 1) // a breath of wind, and what is left of a swell
        text += wind(draw, 0.3, 3) + swell(draw, draw.log_uniform(1e-6, 1e-3),
                                           draw.log_uniform(0.3, 1.5), draw.log_uniform(1, 100));
    if (kind != 0)
        text += wind(draw, 40, 100) + swell(draw, draw.log_uniform(10, 40), draw.uniform(20, 30),
                                            draw.log_uniform(1, 1000));
    text += kind == 0 ? cascades(draw, draw.log_uniform(1, 30), 2, draw.uniform(3, 9))
                      : cascades(draw, draw.log_uniform(3e3, 5e4), 3, draw.uniform(4, 12));
    return text + fmt::format("[accuracy]\nheight_error_m = {}\n",
                              kind == 0 ? draw.one_of({1e-4, 0.002}) : draw.one_of({0.01, 0.05}));
}

} // namespace seaway::tests
