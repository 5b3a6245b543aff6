// SPDX-License-Identifier: Apache-2.0
// The views of numbers that --debug can show: one table row each (client/view/debug_views.cpp), and how one is asked for.
//
//     VIEW[:key=value,...]      slope:cascade=1,channel=x,gain=4    map_slope:cascade=1,mip=3    h0:channel=phase
//
// A number alone is cascade=: cascade:2. Numbers are worked out by shaders/view/debug.frag (on the sea) and
// debug_map.frag (maps as they lie in memory), and by client/view/debug/tables.h (sky, spectrum).
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "base/result.h"
#include "client/view/debug/colours.h"

namespace seaway::client {

enum class DebugView : int {
    final = shaders::view_final,
    height = shaders::view_height,
    place = shaders::view_place,
    normal = shaders::view_normal,
    slope = shaders::view_slope,
    jacobian = shaders::view_jacobian,
    roughness = shaders::view_roughness,
    foam = shaders::view_foam,
    cascade = shaders::view_cascade,
    grid = shaders::view_grid,
    displacement = shaders::view_displacement,
    gradient = shaders::view_gradient,
    reflected = shaders::view_reflected,
    density = shaders::view_density,
    wireframe = shaders::view_wireframe,
    age = shaders::view_age,
    bound = shaders::view_bound,
    map_displacement = shaders::view_map_displacement,
    map_slope = shaders::view_map_slope,
    map_gradient = shaders::view_map_gradient,
    map_jacobian = shaders::view_map_jacobian,
    map_roughness = shaders::view_map_roughness,
    map_foam = shaders::view_map_foam,
    sky_eye,
    sky_sea,
    sky_transmittance,
    sky_scattering,
    h0,
    h
};
inline constexpr std::size_t debug_views = 29;

/// Where a view's numbers come from.
enum class DebugSource {
    light, ///< the picture itself
    sea,   ///< what each pixel shows of the sea
    map,   ///< a cascade's map on the device, flat
    table  ///< a table of the sky or the spectrum, flat
};

/// What can be set of a view.
enum class DebugKey : int { cascade, mip, channel, gain, bias, flip, legend };
inline constexpr std::size_t debug_keys = 7;

struct DebugChannel {
    std::string_view name;
    std::string_view unit;
    Scale scale;
};

struct DebugViewInfo {
    DebugView view;
    std::string_view name;
    DebugSource source;
    std::string_view meaning;
    std::array<DebugChannel, 3> channels{}; ///< those with names
    bool together =
        false; ///< three channels are red, green and blue on the first one's scale; else the first is shown
    enum class Cascades { none, all_or_one, one } cascades = Cascades::none;
    int mip_max = -1;   ///< below 0: there are no levels
    bool folds = false; ///< a channel below 0 folds and has a colour of its own

    int channel_count() const;
    bool takes(DebugKey key) const;
};

std::span<const DebugViewInfo, debug_views> debug_view_table();
const DebugViewInfo& info(DebugView view);

struct DebugChoice {
    static constexpr int unset = -1; ///< all cascades, or of a view of one the longest tile's
    DebugView view = DebugView::final;
    int cascade = unset;
    int mip = 0;
    Colouring colouring{};
    bool legend = true;

    bool operator==(const DebugChoice&) const = default;
};

/// The cascade that is shown of so many; below 0: all.
int shown_cascade(const DebugChoice& choice, int cascades);

/// "normal", "cascade:2", "map_slope:cascade=1,mip=3". An error is one line: what is wrong, what its range is, and
/// which keys this view has.
Result<DebugChoice> parse_debug_view(std::string_view text);
/// As parse_debug_view() reads it, shortest.
std::string debug_text(const DebugChoice& choice);
/// "cascade=0..7|all channel=x|y ...": what can be set of a view.
std::string keys_text(const DebugViewInfo& row);

/// An error names the cascade or level that this sea, of grids of so many points a side, does not have.
Result<void> check_debug(const DebugChoice& choice, std::span<const int> points, int nodes_a_point);

} // namespace seaway::client
