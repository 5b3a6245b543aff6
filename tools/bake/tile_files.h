// SPDX-License-Identifier: Apache-2.0
// The files of one baked tile: its maps as OpenEXR with what one has to know in the header, and beside
// them its mesh where one is wanted (tools/bake/bake.h says what they hold).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sea/foam/foam_law.h"
#include "sea/scene/scene.h"
#include "tools/bake/bake.h"

namespace seaway::bake {

/// What vectors are made of.
inline constexpr sea::FieldSet vector_fields{sea::Field::height, sea::Field::displacement_x,
                                             sea::Field::displacement_y};

class TileFiles {
  public:
    /// `law`: null without foam. Keeps references to sea, options and law.
    TileFiles(const sea::Scene& scene, const sea::Realization& sea, const BakeOptions& options,
              const sea::FoamLaw* law);

    /// Writes `name`.exr, and a mesh if the options say so. The tile holds what the options need;
    /// `foam` stands in for Field::foam, which no keyframe of a synthesizer holds.
    Result<void> write(int frame, const std::string& name, const sea::Keyframe& tile,
                       std::span<const float> foam);

    int count() const { return count_; }
    std::uint64_t bytes() const { return bytes_; }

  private:
    std::vector<exr::ExrChannel> channels(const sea::Keyframe& tile, std::span<const float> foam,
                                          std::vector<std::vector<float>>& made) const;
    std::vector<std::vector<float>> vectors(const sea::Keyframe& tile) const;
    std::vector<exr::ExrAttribute> attributes(int frame, const sea::Keyframe& tile) const;
    Result<void> write_mesh_beside(const std::string& stem, const sea::Keyframe& tile);
    void count_file(const std::string& path);

    const sea::Realization& sea_;
    const BakeOptions& options_;
    const sea::FoamLaw* law_;
    const bool repeats_;
    const std::vector<exr::ExrAttribute> attributes_; ///< the same in every file
    int count_ = 0;
    std::uint64_t bytes_ = 0;
};

} // namespace seaway::bake
