// SPDX-License-Identifier: Apache-2.0
// Bulk maps: heights, normals or displacements of a whole grid over a rectangle at one time, up to
// 4096 x 4096, computed in chunks of rows by a few threads and pulled in order.
//
//     Result<std::unique_ptr<MapStream>> map = MapStream::start(request, surface);
//     if (!map) return map.error();                      // names the field and its range
//     while (std::optional<MapChunk> chunk = (*map)->next_chunk())
//         send(chunk->values);                           // float32, little-endian
//
// Column i of row j is at (x0_m + i width_m / columns, y0_m + j height_m / rows); row 0 is the
// southernmost. Kinds, values a point:
//     height        1: what Surface::answer says above the world point, m
//     normal        3: unit normal there, z up
//     displacement  3: of the *undisplaced* grid point: lambda D_x, lambda D_y, eta, m
//
// Heights differ from Surface::answer by at most map_difference_max_m wherever that converges: in seas
// that fold (FoldSearch::always) every height and normal *is* its answer, and so are points elsewhere
// for which J comes below fold_suspected_below on the way. The others are the same splines, mixed in
// time once for the whole map; each point starts from its neighbour's solution, and the last Newton step
// is applied to the value by its derivative. Cost with three cascades: about 0.1 us of a core a point
// for a gale; in seas that fold what an answer costs, 4 us and more (docs/performance/points.md).
//
// Memory: 16 bytes a texel of the cascades and map_chunks_ahead_max chunks, whatever the request.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string_view>
#include <thread>
#include <vector>

#include "base/result.h"
#include "sea/surface/map_kernel.h"
#include "sea/surface/surface.h"

namespace seaway::sea {

inline constexpr int map_points_a_side_max = 4096;
inline constexpr double map_width_max_m = 1e6;
inline constexpr double map_difference_max_m = 2e-4;

/// Values of one chunk at most; a row is never split.
inline constexpr int map_chunk_values_max = 128 * 1024;
/// Chunks that are computed before they are pulled; more wait for the reader.
inline constexpr int map_chunks_ahead_max = 4;

struct MapRequest {
    MapKind kind = MapKind::height;
    double x0_m = 0;     ///< west edge, -position_max_m .. position_max_m
    double y0_m = 0;     ///< south edge
    double width_m = 0;  ///< above 0, up to 1e6
    double height_m = 0; ///< north-south extent, above 0, up to 1e6
    int columns = 0;     ///< 1 .. 4096
    int rows = 0;        ///< 1 .. 4096
    TimeUs time_us = 0;  ///< in_time_range()
};

/// "height", "displacement" or "normal".
Result<MapKind> map_kind(std::string_view name);

/// Floats a point.
inline int map_components(MapKind kind) {
    return kind == MapKind::height ? 1 : 3;
}

/// An error names the field, its value and its range.
Result<void> validate(const MapRequest& request);

/// Bound on the heights of a map where the surface does not overhang steeply: what the maps cost where it is as steep as one, or five
/// deviations of its slope, and map_difference_max_m as often.
double map_height_error_m(const Surface& surface);

struct MapChunk {
    int first_row = 0;
    int rows = 0;
    std::vector<float> values; ///< [row][column][component]
};

struct MapOptions {
    int threads = 2; ///< 1 .. 16
    Instructions instructions = best_instructions();
    /// Called on a worker when the chunk that the reader waits for has become ready.
    std::function<void()> on_ready;
    /// Called on a worker, with nothing locked, after each row and after some of the points that are solved one by one: a few
    /// tenths of a millisecond. For who lets others go first; null: not called.
    void (*pause)() = nullptr;
};

class MapStream {
  public:
    /// Starts to compute. The surface must hold request.time_us between its keyframes; its maps are
    /// shared.
    static Result<std::unique_ptr<MapStream>>
    start(const MapRequest& request, const Surface& surface, MapOptions options = {});
    /// Joins the threads, which stop at the end of the row, or of the careful point, that each is at.
    ~MapStream();
    MapStream(const MapStream&) = delete;
    MapStream& operator=(const MapStream&) = delete;

    /// The next rows, in order; waits for them. Nothing after the last, or where it has failed. For one reader.
    std::optional<MapChunk> next_chunk();

    /// next_chunk() would not wait.
    bool ready() const;

    /// There was no memory for the next rows: they do not come.
    bool failed() const { return failed_; }

  private:
    struct Scratch;
    MapStream(const MapRequest& request, const Surface& surface, MapOptions options);
    void work();
    void make_chunks();
    void mix_texels();
    MapChunk compute(int chunk, Scratch& scratch) const;
    int rows_of(int chunk) const;
    void pause() const;
    void solve_carefully(const MapRow& row, double y_m, std::span<const int> columns) const;

    const MapRequest request_;
    const MapOptions options_;
    const MapKernel& kernel_;
    const Surface surface_;
    double base_x_m_ = 0; ///< world coordinate of the kernel's 0
    double base_y_m_ = 0;
    std::vector<std::vector<float>> texels_;
    std::vector<MapTile> tiles_;
    double finest_m_ = std::numeric_limits<double>::infinity(); ///< spacing of their texels
    int rows_a_chunk_ = 1;
    int chunks_ = 0;

    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::atomic<bool> failed_ = false;
    std::atomic<bool> stopping_ = false; ///< set with the lock held, looked at without
    std::once_flag mixed_;               ///< texels_, by the first thread
    int next_to_compute_ = 0;
    int next_to_read_ = 0;
    std::map<int, MapChunk> ready_;
    std::vector<std::jthread> threads_; ///< last: joined before the rest goes
};

} // namespace seaway::sea
