// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/accuracy/seas/sea_states.h"

#include <array>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace seaway::bench {

namespace {

/// A wind sea, and the swell that a gale and a storm at sea come with; the storm's is as long as its own waves.
struct State {
    double wind_mps;
    double fetch_m;
    double swell_height_m; ///< 0: none
    double swell_period_s;
    double depth_m[2]; ///< deep, shallow
};

// Hs and Tp of the wind over deep water: 0.5 m and 3 s; 6.6 m and 10.8 s; 16 m and 17 s.
constexpr State states[] = {
    {6.0, 20e3, 0.0, 0.0, {200.0, 10.0}},
    {19.0, 300e3, 1.5, 13.0, {95.0, 15.0}},
    {28.0, 800e3, 2.5, 17.0, {500.0, 20.0}},
};

constexpr std::array<std::string_view, 6> names{"calm_deep",    "calm_shallow", "gale_deep",
                                                "gale_shallow", "storm_deep",   "storm_shallow"};

constexpr const char* wind_text = R"(
[sea]
seed = {}
depth_m = {}
[[sea.system]]
type = "wind"
spectrum = "tma"
wind_speed_10m_mps = {}
from_deg = 315
fetch_m = {}
spreading = "hasselmann"
swell = 0.2
)";

constexpr const char* swell_text = R"(
[[sea.system]]
type = "swell"
spectrum = "jonswap"
significant_height_m = {}
peak_period_s = {}
from_deg = 0
spreading = "cos2s"
spreading_exponent = 38
)";

constexpr const char* accuracy_text = R"(
[accuracy]
preset = "balanced"
)";

} // namespace

std::span<const std::string_view> sea_state_names() {
    return names;
}

Result<sea::Scene> sea_state(std::string_view name, std::uint64_t seed) {
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] != name)
            continue;
        const State& state = states[i / 2];
        std::string text = fmt::format(fmt::runtime(wind_text), seed, state.depth_m[i % 2],
                                       state.wind_mps, state.fetch_m);
        if (state.swell_height_m > 0)
            text +=
                fmt::format(fmt::runtime(swell_text), state.swell_height_m, state.swell_period_s);
        return sea::parse_scene(text + accuracy_text, std::string(name), "");
    }
    return Error{
        fmt::format("no sea state is called \"{}\"; there are {}", name, fmt::join(names, ", "))};
}

} // namespace seaway::bench
