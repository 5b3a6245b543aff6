// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/maps/strain_windows.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "sea/surface/maps/spline_map.h"

namespace seaway::sea {

namespace {

constexpr int channels = SplineMap::channels;
constexpr int block_min = 4;
/// Coefficients a side that the spline within a cell is made of.
constexpr int support = 4;
/// A window ends so many cells before what its blocks hold: places are rounded.
constexpr double rounding_cells = 1e-6;

/// D_x, D_y and their time rates side by side.
typedef float F4 __attribute__((vector_size(16)));
constexpr int dx = 0, dy = 1, rate = 2;

F4 displacement(const float* texel) {
    F4 values, rates;
    std::memcpy(&values, texel, sizeof values);
    std::memcpy(&rates, texel + spline_channel::rate, sizeof rates);
    static_assert(spline_channel::displacement_x == 1 && spline_channel::displacement_y == 2);
    return __builtin_shufflevector(values, rates, 1, 2, 5, 6);
}

struct Extent {
    F4 low = F4{} + 3e38f;
    F4 high = F4{} - 3e38f;

    void add(F4 value) { add(Extent{value, value}); }
    void add(const Extent& other) {
        low = other.low < low ? other.low : low;
        high = other.high > high ? other.high : high;
    }
    float size(int c) const { return std::max(std::abs(low[c]), std::abs(high[c])); }
};

using Row = std::vector<F4>; ///< of coefficients, with its border

void read_row(const float* coefficients, std::size_t row, Row& to) {
    const float* texel = coefficients + row * to.size() * channels;
    for (F4& one : to) {
        one = displacement(texel);
        texel += channels;
    }
}

/// What differences of neighbours are at most within each cell of a row: along x in one row of coefficients, along y
/// between two.
void differences_x(const Row& row, std::vector<Extent>& of_cells) {
    for (std::size_t x = 0; x < of_cells.size(); ++x) {
        of_cells[x] = {};
        for (std::size_t i = x; i < x + support - 1; ++i)
            of_cells[x].add(row[i + 1] - row[i]);
    }
}
void differences_y(const Row& south, const Row& north, std::vector<Extent>& of_cells) {
    for (std::size_t x = 0; x < of_cells.size(); ++x) {
        of_cells[x] = {};
        for (std::size_t i = x; i < x + support; ++i)
            of_cells[x].add(north[i] - south[i]);
    }
}

/// Of [[xx, xy], [xy, yy]]: its distance from the mean of the two on the diagonal.
float half_gap(float xx, float yy, float xy) {
    const float half = 0.5f * (xx - yy);
    return std::sqrt(half * half + xy * xy);
}

/// What is widened to hold several cells or blocks: extents before they are put together.
struct Block {
    float strain_min = 3e38f;
    float strain_rate = 0;
    Extent moved;

    void add(const Block& other) {
        strain_min = std::min(strain_min, other.strain_min);
        strain_rate = std::max(strain_rate, other.strain_rate);
        moved.add(other.moved);
    }
    void add_cell(const Extent& x, const Extent& y, float per_m) {
        const float xy_low = 0.5f * (y.low[dx] + x.low[dy]),
                    xy_high = 0.5f * (y.high[dx] + x.high[dy]);
        const float xy = std::max(std::abs(xy_low), std::abs(xy_high));
        const float xx = x.low[dx], yy = y.low[dy];
        strain_min = std::min(strain_min, per_m * (0.5f * (xx + yy) - half_gap(xx, yy, xy)));
        const float xx_rate = x.size(dx + rate), yy_rate = y.size(dy + rate);
        const float xy_rate = 0.5f * (y.size(dx + rate) + x.size(dy + rate));
        strain_rate = std::max(strain_rate, per_m * (0.5f * (xx_rate + yy_rate) +
                                                     half_gap(xx_rate, yy_rate, xy_rate)));
    }
    StrainBounds bounds() const {
        const F4 range = moved.high - moved.low;
        return {std::hypot(range[dx], range[dy]), strain_min,
                std::hypot(range[dx + rate], range[dy + rate]), strain_rate};
    }
};

/// Side of the smallest blocks. A size that is no power of two has one window, the whole tile.
int smallest_block(int size) {
    return std::has_single_bit(static_cast<unsigned>(size)) ? std::min(block_min, size) : size;
}

std::size_t index(int x, int y, int count) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(count) +
           static_cast<std::size_t>(x);
}

/// A row of coefficients, to all blocks whose cells hang on it.
void add_displacements(const Row& row, int number, int block, int count,
                       std::vector<Block>& blocks) {
    for (int bx = 0; bx < count; ++bx) {
        Extent extent;
        for (int i = bx * block; i < bx * block + block + support - 1; ++i)
            extent.add(row[static_cast<std::size_t>(i)]);
        for (int by = std::max(0, (number - support + 1) / block);
             by < count && by * block <= number; ++by)
            if (number < by * block + block + support - 1)
                blocks[index(bx, by, count)].moved.add(extent);
    }
}

/// The smallest blocks of a map.
std::vector<Block> blocks_of(const float* coefficients, int size, int block, float per_m) {
    const int count = size / block;
    const auto cells = static_cast<std::size_t>(size);
    std::vector<Block> blocks(static_cast<std::size_t>(count * count));
    Row south, row(cells + SplineMap::border);
    // Of as many rows of coefficients as a cell hangs on, in turns.
    std::array<std::vector<Extent>, support> along_x;
    std::array<std::vector<Extent>, support - 1> along_y;
    for (auto& one : along_x)
        one.resize(cells);
    for (auto& one : along_y)
        one.resize(cells);
    for (std::size_t r = 0; r < row.size(); ++r) {
        read_row(coefficients, r, row);
        add_displacements(row, static_cast<int>(r), block, count, blocks);
        differences_x(row, along_x[r % along_x.size()]);
        if (r > 0)
            differences_y(south, row, along_y[r % along_y.size()]);
        south = row;
        if (r + 1 < support)
            continue;
        const int y = static_cast<int>(r + 1) - support;
        for (std::size_t x = 0; x < cells; ++x) {
            Extent over_x, over_y;
            for (const auto& one : along_x)
                over_x.add(one[x]);
            for (const auto& one : along_y)
                over_y.add(one[x]);
            blocks[index(static_cast<int>(x) / block, y / block, count)].add_cell(over_x, over_y,
                                                                                  per_m);
        }
    }
    return blocks;
}

/// Four blocks make one of twice the side.
std::vector<Block> halved(const std::vector<Block>& blocks, int count) {
    std::vector<Block> larger;
    for (int y = 0; y < count; y += 2)
        for (int x = 0; x < count; x += 2) {
            larger.push_back(blocks[index(x, y, count)]);
            larger.back().add(blocks[index(x + 1, y, count)]);
            larger.back().add(blocks[index(x, y + 1, count)]);
            larger.back().add(blocks[index(x + 1, y + 1, count)]);
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
                    blocks[index(x, y, count)].add(
                        before[along_x ? index((x + step) % count, y, count)
                                       : index(x, (y + step) % count, count)]);
    }
}

} // namespace

StrainWindows::StrainWindows(const float* coefficients, int size, double length_m)
    : size_(size), length_m_(length_m), cells_a_metre_(size / length_m) {
    int block = smallest_block(size);
    std::vector<Block> blocks =
        blocks_of(coefficients, size, block, static_cast<float>(cells_a_metre_));
    windows_.reserve(bytes_of(size) / sizeof(StrainBounds));
    for (int count = size / block;; count /= 2, block *= 2) {
        // A single block is shifted away: its number is 0 whatever the size.
        const int shift = count == 1 ? 31 : std::countr_zero(static_cast<unsigned>(block));
        levels_.push_back({block - rounding_cells, shift, count, windows_.size()});
        std::vector<Block> windows = blocks;
        widen_each(windows, count);
        for (const Block& window : windows)
            windows_.push_back(window.bounds());
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

} // namespace seaway::sea
