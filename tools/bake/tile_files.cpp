// SPDX-License-Identifier: Apache-2.0
#include "tools/bake/tile_files.h"

#include <filesystem>
#include <system_error>

#include <fmt/format.h>

#include "sea/scene/scene_names.h"
#include "sea/waves/statistics/moments.h"
#include "tools/bake/summed.h"

namespace seaway::bake {

using exr::ExrAttribute;
using exr::ExrChannel;
using sea::Field;

namespace {

/// What is the same for every file.
std::vector<ExrAttribute> sea_attributes(const sea::Scene& scene, const sea::Realization& sea,
                                         const BakeOptions& options) {
    const sea::SeaSummary summary = sea::summarize(scene.sea, sea);
    const sea::SeaStatistics& s = summary.realised;
    sea::Scene alone = scene; // whoever reads it has no other file
    alone.accuracy.certificate = {};
    return {
        {"software", std::string("seaway-bake " SEAWAY_VERSION)},
        {"seaway.scene", scene.source},
        {"seaway.scene_toml", sea::to_toml(alone)},
        {"seaway.rows", std::string(options.north_up ? "north to south" : "south to north")},
        {"seaway.hs_m", s.significant_height_m},
        {"seaway.tp_s", s.peak_period_s},
        {"seaway.tz_s", s.zero_crossing_period_s},
        {"seaway.tm01_s", s.mean_period_s},
        {"seaway.mean_from_deg", sea::mean_from_deg(s)},
        {"seaway.requested_hs_m", summary.requested.significant_height_m},
        {"seaway.requested_tp_s", summary.requested.peak_period_s},
        {"seaway.choppiness_x", sea.choppiness.x},
        {"seaway.choppiness_y", sea.choppiness.y},
    };
}

} // namespace

TileFiles::TileFiles(const sea::Scene& scene, const sea::Realization& sea,
                     const BakeOptions& options, const sea::FoamLaw* law)
    : sea_(sea), options_(options), law_(law), repeats_(summed_tile_repeats(sea)),
      attributes_(sea_attributes(scene, sea, options)) {}

Result<void> TileFiles::write(int frame, const std::string& name, const sea::Keyframe& tile,
                              std::span<const float> foam) {
    const std::string stem = options_.folder + "/" + name;
    std::vector<std::vector<float>> made; // planes that no keyframe holds
    const exr::ExrMap map{.width = tile.size,
                          .height = tile.size,
                          .channels = channels(tile, foam, made),
                          .attributes = attributes(frame, tile),
                          .half = options_.half,
                          .compression = options_.compression,
                          .upside_down = options_.north_up};
    SEAWAY_TRY(exr::write_exr(stem + ".exr", map));
    count_file(stem + ".exr");
    return options_.mesh == MeshFormat::none ? Result<void>() : write_mesh_beside(stem, tile);
}

Result<void> TileFiles::write_mesh_beside(const std::string& stem, const sea::Keyframe& tile) {
    const std::string path = stem + (options_.mesh == MeshFormat::obj ? ".obj" : ".ply");
    const MeshOptions mesh{options_.mesh, options_.up, repeats_ || !options_.summed};
    SEAWAY_TRY(write_mesh(path, tile, sea_.choppiness, mesh));
    count_file(path);
    return {};
}

void TileFiles::count_file(const std::string& path) {
    std::error_code ignored;
    bytes_ += std::filesystem::file_size(path, ignored);
    ++count_;
}

std::vector<ExrChannel> TileFiles::channels(const sea::Keyframe& tile, std::span<const float> foam,
                                            std::vector<std::vector<float>>& made) const {
    std::vector<ExrChannel> channels;
    if (!options_.vectors) {
        for (const Field field : options_.fields)
            channels.push_back({std::string(sea::info(field).name),
                                field == Field::foam ? foam : tile.plane(field)});
        return channels;
    }
    made = vectors(tile);
    for (std::size_t axis = 0; axis < 3; ++axis)
        channels.push_back({std::string(1, "RGB"[axis]), made[axis]});
    if (!foam.empty())
        channels.push_back({"A", foam});
    return channels;
}

/// Where every point goes: choppiness * D and height, along the axes that were asked for.
std::vector<std::vector<float>> TileFiles::vectors(const sea::Keyframe& tile) const {
    const auto lx = static_cast<float>(sea_.choppiness.x);
    const auto ly = static_cast<float>(sea_.choppiness.y);
    const auto dx = tile.plane(Field::displacement_x), dy = tile.plane(Field::displacement_y),
               height = tile.plane(Field::height);
    std::vector<std::vector<float>> axes(3, std::vector<float>(tile.plane_size()));
    for (std::size_t i = 0; i < tile.plane_size(); ++i) {
        const auto moved = turned(options_.up, lx * dx[i], ly * dy[i], height[i]);
        for (std::size_t axis = 0; axis < 3; ++axis)
            axes[axis][i] = moved[axis];
    }
    return axes;
}

std::vector<ExrAttribute> TileFiles::attributes(int frame, const sea::Keyframe& tile) const {
    std::vector<ExrAttribute> all = attributes_;
    const auto add = [&](const char* name, double value) { all.emplace_back(name, value); };
    if (options_.summed)
        all.emplace_back("seaway.repeats", repeats_ ? "yes" : "no");
    else
        add("seaway.cascade", tile.cascade);
    add("seaway.length_m", tile.length_m);
    add("seaway.frame", frame);
    add("seaway.time_s", sea::seconds_from_us(tile.time_us));
    all.emplace_back("seaway.time_us", std::to_string(tile.time_us));
    add("seaway.tick_s", options_.rate.frame_s());
    if (options_.vectors)
        all.emplace_back("seaway.axes",
                         options_.up == UpAxis::z ? "east, north, up" : "east, up, south");
    if (law_)
        add("seaway.foam_mean", law_->mean_coverage);
    return all;
}

} // namespace seaway::bake
