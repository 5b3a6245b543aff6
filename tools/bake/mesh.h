// SPDX-License-Identifier: Apache-2.0
// A tile as geometry: the displaced surface of one keyframe as Wavefront OBJ (text) or Stanford PLY
// (binary, little endian), with normals and texture coordinates, in quads that face up.
//
// A vertex is X + choppiness * D(X), at height eta(X), for every grid point X. A tile that repeats has
// one row and one column more, which are its first ones moved by the length, so that copies side by side
// leave no gap. Normals are the cross product of the two tangents of the displaced surface (docs/physics.md).
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "sea/basics/field.h"
#include "sea/surface/maps/keyframe.h"
#include "sea/waves/realization.h"
#include "tools/bake/axes.h"

namespace seaway::bake {

enum class MeshFormat { none, obj, ply };

/// Names as on the command line; an error lists them.
Result<MeshFormat> mesh_format(std::string_view name);

/// What a keyframe must hold to become a mesh.
inline constexpr sea::FieldSet mesh_fields{sea::Field::height,         sea::Field::displacement_x,
                                           sea::Field::displacement_y, sea::Field::slope_x,
                                           sea::Field::slope_y,        sea::Field::strain_xx,
                                           sea::Field::strain_yy,      sea::Field::strain_xy};

struct MeshOptions {
    MeshFormat format = MeshFormat::ply;
    UpAxis up = UpAxis::z;
    bool repeats = true; ///< the tile meets itself at its edges
};

/// Writes beside the path and renames, so that a file that is there is whole.
Result<void> write_mesh(const std::string& path, const sea::Keyframe& tile,
                        const sea::Choppiness& choppiness, const MeshOptions& options);

} // namespace seaway::bake
