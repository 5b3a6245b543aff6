// SPDX-License-Identifier: Apache-2.0
#include "tools/bake/mesh.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <vector>

#include <fmt/format.h>

#include "base/whole_file.h"

namespace seaway::bake {

using sea::Field;

namespace {

struct Vertex {
    float position[3];
    float normal[3];
    float texture[2];
};

struct Mesh {
    std::vector<Vertex> vertices; ///< [y][x], `side` a row
    int side = 0;
};

class MeshBuilder {
  public:
    MeshBuilder(const sea::Keyframe& tile, const sea::Choppiness& choppiness,
                const MeshOptions& options)
        : tile_(tile), choppiness_(choppiness), options_(options) {}

    Mesh build() const {
        Mesh mesh;
        mesh.side = options_.repeats ? tile_.size + 1 : tile_.size;
        for (int y = 0; y < mesh.side; ++y)
            for (int x = 0; x < mesh.side; ++x)
                mesh.vertices.push_back(vertex(x, y));
        return mesh;
    }

  private:
    Vertex vertex(int x, int y) const {
        const auto node = static_cast<std::size_t>(y % tile_.size * tile_.size + x % tile_.size);
        const auto value = [&](Field field) { return tile_.plane(field)[node]; };
        const auto lx = static_cast<float>(choppiness_.x), ly = static_cast<float>(choppiness_.y);
        const auto spacing = static_cast<float>(tile_.length_m / tile_.size);
        const float a = 1 + lx * value(Field::strain_xx), d = 1 + ly * value(Field::strain_yy);
        const float b = lx * value(Field::strain_xy), c = ly * value(Field::strain_xy);
        const float sx = value(Field::slope_x), sy = value(Field::slope_y);
        float east = c * sy - d * sx, north = b * sx - a * sy, up = a * d - b * c;
        const float length = std::sqrt(east * east + north * north + up * up);
        const float scale = length > 0 ? (up < 0 ? -1 : 1) / length : 0; // never turned down
        const auto position =
            turned(options_.up, static_cast<float>(x) * spacing + lx * value(Field::displacement_x),
                   static_cast<float>(y) * spacing + ly * value(Field::displacement_y),
                   value(Field::height));
        const auto normal = turned(options_.up, east * scale, north * scale, up * scale);
        return {{position[0], position[1], position[2]},
                {normal[0], normal[1], normal[2]},
                {texture(x), texture(y)}};
    }

    /// The middle of the pixel that has this point in the tile's own maps; beyond 1 on the seam, where textures repeat.
    float texture(int point) const {
        return (static_cast<float>(point) + 0.5f) / static_cast<float>(tile_.size);
    }

    const sea::Keyframe& tile_;
    const sea::Choppiness& choppiness_;
    const MeshOptions& options_;
};

/// Calls f with the four corners of every quad, anticlockwise as seen from above.
template <class F>
void for_each_quad(int side, const F& f) {
    for (int y = 0; y + 1 < side; ++y)
        for (int x = 0; x + 1 < side; ++x) {
            const int first = y * side + x;
            f(first, first + 1, first + side + 1, first + side);
        }
}

std::string obj_text(const Mesh& mesh) {
    std::string text = "# seaway-bake " SEAWAY_VERSION "\n";
    auto out = std::back_inserter(text);
    for (const Vertex& v : mesh.vertices)
        fmt::format_to(out, "v {} {} {}\n", v.position[0], v.position[1], v.position[2]);
    for (const Vertex& v : mesh.vertices)
        fmt::format_to(out, "vt {} {}\n", v.texture[0], v.texture[1]);
    for (const Vertex& v : mesh.vertices)
        fmt::format_to(out, "vn {:.6f} {:.6f} {:.6f}\n", v.normal[0], v.normal[1], v.normal[2]);
    for_each_quad(mesh.side, [&](int a, int b, int c, int d) { // OBJ counts from one
        fmt::format_to(out, "f {0}/{0}/{0} {1}/{1}/{1} {2}/{2}/{2} {3}/{3}/{3}\n", a + 1, b + 1,
                       c + 1, d + 1);
    });
    return text;
}

std::string ply_bytes(const Mesh& mesh) {
    static_assert(std::endian::native == std::endian::little && sizeof(Vertex) == 32);
    const int quads = (mesh.side - 1) * (mesh.side - 1);
    std::string bytes = fmt::format(
        "ply\nformat binary_little_endian 1.0\ncomment seaway-bake " SEAWAY_VERSION "\n"
        "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
        "property float nx\nproperty float ny\nproperty float nz\nproperty float u\n"
        "property float v\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.vertices.size(), quads);
    bytes.append(reinterpret_cast<const char*>(mesh.vertices.data()),
                 mesh.vertices.size() * sizeof(Vertex));
    for_each_quad(mesh.side, [&](int a, int b, int c, int d) {
        const std::int32_t corners[4] = {a, b, c, d};
        bytes += '\4';
        bytes.append(reinterpret_cast<const char*>(corners), sizeof(corners));
    });
    return bytes;
}

} // namespace

Result<MeshFormat> mesh_format(std::string_view name) {
    if (name == "none")
        return MeshFormat::none;
    if (name == "obj")
        return MeshFormat::obj;
    if (name == "ply")
        return MeshFormat::ply;
    return Error{fmt::format("--mesh '{}': one of none, obj, ply", name)};
}

Result<void> write_mesh(const std::string& path, const sea::Keyframe& tile,
                        const sea::Choppiness& choppiness, const MeshOptions& options) {
    const Mesh mesh = MeshBuilder(tile, choppiness, options).build();
    const Result<void> written = write_whole_file(
        path, options.format == MeshFormat::obj ? obj_text(mesh) : ply_bytes(mesh));
    return written ? written : Error{fmt::format("{}: {}", path, written.error().message)};
}

} // namespace seaway::bake
