// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/maps/strain_windows.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "sea/surface/maps/spline_hull.h"
#include "sea/surface/maps/spline_map.h"

namespace seaway::sea {

namespace {

constexpr int channels = SplineMap::channels;
constexpr int dx = spline_channel::displacement_x, dy = spline_channel::displacement_y;
constexpr int dx_rate = dx + spline_channel::rate, dy_rate = dy + spline_channel::rate;
constexpr int block_min = 4;

/// Grid points beyond a place that the derivatives of its spline depend on.
constexpr int support = 2;

using Hull = SplineHull<channels, 1>;

/// What is widened to hold several blocks: extents before they are put together.
struct Block {
    StrainBounds strains;
    float low[4]; ///< D_x, D_y and their rates
    float high[4];
};

Block block_of(const Hull& hull, float per_m) {
    const float xy_min = 0.5f * per_m * (hull.y.low[dx] + hull.x.low[dy]);
    const float xy_max = 0.5f * per_m * (hull.y.high[dx] + hull.x.high[dy]);
    Block block{{.xx_min = per_m * hull.x.low[dx],
                 .yy_min = per_m * hull.y.low[dy],
                 .xy_size = std::max(std::abs(xy_min), std::abs(xy_max)),
                 .xx_rate = per_m * hull.x.size(dx_rate),
                 .yy_rate = per_m * hull.y.size(dy_rate),
                 .xy_rate = 0.5f * per_m * (hull.y.size(dx_rate) + hull.x.size(dy_rate))},
                {},
                {}};
    constexpr int kept[4] = {dx, dy, dx_rate, dy_rate};
    for (int i = 0; i < 4; ++i) {
        block.low[i] = hull.value.low[kept[i]];
        block.high[i] = hull.value.high[kept[i]];
    }
    return block;
}

void widen(Block& a, const Block& b) {
    StrainBounds& s = a.strains;
    s.xx_min = std::min(s.xx_min, b.strains.xx_min);
    s.yy_min = std::min(s.yy_min, b.strains.yy_min);
    s.xy_size = std::max(s.xy_size, b.strains.xy_size);
    s.xx_rate = std::max(s.xx_rate, b.strains.xx_rate);
    s.yy_rate = std::max(s.yy_rate, b.strains.yy_rate);
    s.xy_rate = std::max(s.xy_rate, b.strains.xy_rate);
    for (int i = 0; i < 4; ++i) {
        a.low[i] = std::min(a.low[i], b.low[i]);
        a.high[i] = std::max(a.high[i], b.high[i]);
    }
}

StrainBounds bounds_of(const Block& block) {
    StrainBounds bounds = block.strains;
    const auto range = [&](int i) { return block.high[i] - block.low[i]; };
    bounds.range_m = std::hypot(range(0), range(1));
    bounds.range_rate = std::hypot(range(2), range(3));
    return bounds;
}

/// Side of the smallest blocks. A size that is no power of two has one window, the whole tile.
int smallest_block(int size) {
    return std::has_single_bit(static_cast<unsigned>(size)) ? std::min(block_min, size) : size;
}

std::size_t index(int x, int y, int count) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(count) +
           static_cast<std::size_t>(x);
}

std::vector<Block> smallest_blocks(const float* coefficients, int size, int block, float per_m) {
    const std::size_t pitch = static_cast<std::size_t>(size + SplineMap::border) * channels;
    std::vector<Block> blocks;
    blocks.reserve(static_cast<std::size_t>((size / block) * (size / block)));
    for (int by = 0; by < size; by += block)
        for (int bx = 0; bx < size; bx += block) {
            Hull hull;
            for (int y = by; y < by + block; ++y)
                for (int x = bx; x < bx + block; ++x)
                    hull.add(coefficients + static_cast<std::size_t>(y + 1) * pitch +
                                 static_cast<std::size_t>(x + 1) * channels,
                             pitch);
            blocks.push_back(block_of(hull, per_m));
        }
    return blocks;
}

/// Four blocks make one of twice the side.
std::vector<Block> halved(const std::vector<Block>& blocks, int count) {
    std::vector<Block> larger;
    for (int y = 0; y < count; y += 2)
        for (int x = 0; x < count; x += 2) {
            larger.push_back(blocks[index(x, y, count)]);
            widen(larger.back(), blocks[index(x + 1, y, count)]);
            widen(larger.back(), blocks[index(x, y + 1, count)]);
            widen(larger.back(), blocks[index(x + 1, y + 1, count)]);
        }
    return larger;
}

/// Each block with those around it, along x, then along y.
void widen_each(std::vector<Block>& blocks, int count) {
    for (const bool along_x : {true, false}) {
        const std::vector<Block> before = blocks;
        for (int y = 0; y < count; ++y)
            for (int x = 0; x < count; ++x)
                for (const int step : {1, count - 1})
                    widen(blocks[index(x, y, count)],
                          before[along_x ? index((x + step) % count, y, count)
                                         : index(x, (y + step) % count, count)]);
    }
}

} // namespace

StrainWindows::StrainWindows(const float* coefficients, int size, double length_m)
    : size_(size), length_m_(length_m) {
    int block = smallest_block(size);
    std::vector<Block> blocks =
        smallest_blocks(coefficients, size, block, static_cast<float>(size / length_m));
    for (int count = size / block;; count /= 2, block *= 2) {
        levels_.push_back({block, count, windows_.size()});
        std::vector<Block> windows = blocks;
        widen_each(windows, count);
        for (const Block& window : windows)
            windows_.push_back(bounds_of(window));
        if (count == 1)
            return;
        blocks = halved(blocks, count);
    }
}

std::size_t StrainWindows::bytes_of(int size) {
    std::size_t windows = 0;
    for (int count = size / smallest_block(size); count > 0; count /= 2)
        windows += static_cast<std::size_t>(count) * static_cast<std::size_t>(count);
    return windows * sizeof(StrainBounds);
}

std::size_t StrainWindows::place(double x_m, double y_m, double radius_m) const {
    const double per_m = size_ / length_m_;
    std::size_t i = 0;
    while (i + 1 < levels_.size() && radius_m * per_m > levels_[i].block - support)
        ++i;
    const Level& level = levels_[i];
    const auto block = [&](double position_m) {
        const double turns = position_m / length_m_;
        return std::min(static_cast<int>((turns - std::floor(turns)) * level.blocks),
                        level.blocks - 1);
    };
    return level.first + index(block(x_m), block(y_m), level.blocks);
}

} // namespace seaway::sea
