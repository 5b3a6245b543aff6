// SPDX-License-Identifier: Apache-2.0
#include "client/view/debug/tables.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "base/check.h"
#include "sea/scene/scene.h"
#include "sea/waves/centred_spectrum.h"

namespace seaway::client {

namespace {

/// texel(column, row) -> colour.
template <class Texel>
FlatTable made_of(int columns, int rows, const Texel& texel) {
    FlatTable table{columns, rows, {}, 0, {}, {}};
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            const glm::vec3 colour(texel(x, y));
            table.rgba.insert(table.rgba.end(), {colour.r, colour.g, colour.b, 1.0f});
            for (int c = 0; c < 3; ++c)
                table.largest = std::max(table.largest, static_cast<double>(colour[c]));
        }
    return table;
}

/// A level of a layer of the tables that shaders have.
FlatTable sky_layer(const Sky& sky, int layer, int mip) {
    const std::vector<float>& texels = *sky.texels();
    std::size_t first = 0;
    int columns = shaders::sky_columns, rows = shaders::sky_rows;
    const auto count = [&] { return static_cast<std::size_t>(4 * columns * rows); };
    for (int m = 0; m < mip; ++m) {
        first += shaders::sky_layers * count();
        columns = std::max(columns / 2, 1);
        rows = std::max(rows / 2, 1);
    }
    first += static_cast<std::size_t>(layer) * count();
    FlatTable table = made_of(columns, rows, [&](int x, int y) {
        const float* texel = &texels[first + static_cast<std::size_t>(4 * (y * columns + x))];
        return glm::vec3(texel[0], texel[1], texel[2]);
    });
    table.across = "once around from the sun, counter-clockwise";
    table.up = "zenith, down to nadir; horizon in the middle";
    return table;
}

/// The middle of a square, as much as holds all that has a number: bands end far before the grid does.
FlatTable without_rim(const FlatTable& all) {
    const int size = all.columns, middle = size / 2;
    const auto texel = [&](int x, int y) { return static_cast<std::size_t>(4 * (y * size + x)); };
    int reach = 1;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
            if (all.rgba[texel(x, y) + 3] > 0)
                reach = std::max({reach, std::abs(x - middle) + 1, std::abs(y - middle) + 1});
    reach = std::min(reach, middle);
    FlatTable table = all;
    table.columns = table.rows = 2 * reach;
    table.rgba.clear();
    for (int y = middle - reach; y < middle + reach; ++y) {
        const auto from = all.rgba.begin() + static_cast<std::ptrdiff_t>(texel(middle - reach, y));
        table.rgba.insert(table.rgba.end(), from, from + 8 * reach);
    }
    return table;
}

FlatTable transmittance(const TransmittanceTable& air) {
    FlatTable table =
        made_of(TransmittanceTable::width, TransmittanceTable::height, [&](int x, int y) {
            return glm::exp(
                -air.depths()[static_cast<std::size_t>(y * TransmittanceTable::width + x)]);
        });
    table.across = "straight up .. along the horizon";
    table.up = "top of the air, down to the sea";
    return table;
}

FlatTable scattering(const MultipleScattering& air) {
    constexpr int size = MultipleScattering::size;
    FlatTable table = made_of(size, size, [&](int x, int y) {
        return air.texels()[static_cast<std::size_t>(y * size + x)];
    });
    table.across = "sun below .. overhead, root of height";
    table.up = "top of the air, down to the sea, root";
    return table;
}

} // namespace

Result<FlatTable> DebugTables::spectrum(const DebugChoice& choice, const DebugMoment& moment) {
    const std::string view = "--debug " + debug_text(choice) + ": ";
    if (moment.scene.empty())
        return Error{view +
                     "the server does not tell its scene, which amplitudes are realised from"};
    if (!sea_ || scene_ != moment.scene) {
        const Result<sea::Scene> scene = sea::parse_scene(moment.scene, "the server's scene");
        if (!scene)
            return Error{view + scene.error().message};
        Result<sea::Realization> sea = sea::realize(*scene);
        if (!sea)
            return Error{view + sea.error().message};
        sea_ = std::make_shared<const sea::Realization>(std::move(*sea));
        scene_ = moment.scene;
    }
    const auto cascade =
        static_cast<std::size_t>(shown_cascade(choice, static_cast<int>(sea_->cascades.size())));
    const sea::CascadeModes& modes = sea_->cascades[cascade];
    const std::vector<std::complex<double>> h0 = sea::centred_h0(modes);
    const std::vector<std::complex<double>> shown =
        choice.view == DebugView::h0 ? h0 : sea::centred_h(*sea_, cascade, moment.frame.time_us);
    FlatTable table{modes.spec.size, modes.spec.size, {}, 0, {}, {}, true};
    for (std::size_t i = 0; i < shown.size(); ++i) {
        const double magnitude = std::abs(shown[i]);
        table.rgba.insert(table.rgba.end(),
                          {static_cast<float>(magnitude), static_cast<float>(std::arg(shown[i])),
                           0.0f, magnitude > 0 ? 1.0f : 0.0f});
        table.largest = std::max(table.largest, std::abs(h0[i]));
    }
    if (choice.view == DebugView::h) // both ways of travel: colours stay as time goes on
        table.largest *= 2;
    table = without_rim(table);
    const int steps = table.columns / 2; // to the edge, whole ones
    const double edge_radpm = steps * modes.spec.wavenumber_step_radpm();
    table.across = fmt::format("kx to {:.3g} rad/m east", edge_radpm);
    table.up = fmt::format("ky to {:.3g} rad/m north", edge_radpm);
    return table;
}

Result<FlatTable> DebugTables::table(const DebugChoice& choice, const DebugMoment& moment) {
    switch (choice.view) {
    case DebugView::sky_eye:
        return sky_layer(moment.sky, shaders::sky_layer_eye, 0);
    case DebugView::sky_sea: {
        FlatTable table = sky_layer(moment.sky, shaders::sky_layer_sea, choice.mip);
        table.largest = sky_layer(moment.sky, shaders::sky_layer_sea, 0).largest;
        return table;
    }
    case DebugView::sky_transmittance:
        return transmittance(moment.sky.air().transmittance);
    case DebugView::sky_scattering:
        return scattering(moment.sky.air().multiple);
    case DebugView::h0:
    case DebugView::h:
        return spectrum(choice, moment);
    default:
        break;
    }
    SEAWAY_CHECK(false, "no table");
    return FlatTable{};
}

namespace {

/// The texel that a pixel shows, of those from `first` to before `last`, columns and rows.
int shown_texel(const FlatTable& table, const int (&first)[2], const int (&last)[2]) {
    int shown = first[1] * table.columns + first[0];
    if (!table.keeps_peaks)
        return shown;
    for (int row = first[1]; row < last[1]; ++row)
        for (int column = first[0]; column < last[0]; ++column) {
            const int texel = row * table.columns + column;
            if (table.rgba[static_cast<std::size_t>(4 * texel)] >
                table.rgba[static_cast<std::size_t>(4 * shown)])
                shown = texel;
        }
    return shown;
}

} // namespace

Picture spread(const FlatTable& table, int width, int height) {
    Picture picture{width, height, {}};
    picture.rgba.assign(4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
                        0.0f);
    const FlatArea area = flat_area(table.columns, table.rows, width, height);
    for (int y = 0; y < area.height; ++y)
        for (int x = 0; x < area.width; ++x) {
            const int up = area.height - 1 - y;
            const int first[] = {x * table.columns / area.width, up * table.rows / area.height};
            const int last[] = {(x + 1) * table.columns / area.width,
                                (up + 1) * table.rows / area.height};
            const auto from = static_cast<std::ptrdiff_t>(4 * shown_texel(table, first, last));
            const auto to =
                static_cast<std::ptrdiff_t>(4 * ((area.top + y) * width + area.left + x));
            std::copy_n(table.rgba.begin() + from, 4, picture.rgba.begin() + to);
        }
    return picture;
}

} // namespace seaway::client
