// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/maps/strain_windows.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

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
};

using Row = std::vector<F4>; ///< of coefficients, with its border and more

/// `cells` and their border, and round again: who works on four at a time looks at more.
void read_row(const float* texel, std::size_t cells, Row& to) {
    for (std::size_t i = 0; i < to.size(); ++i)
        to[i] = i < cells + SplineMap::border ? displacement(texel + i * channels) : to[i - cells];
}

/// One float a grid point or a cell, as many more as a vector that begins at the last one reads.
using Line = std::vector<float>;
constexpr std::size_t lanes = 4;

F4 load(const float* at) {
    F4 four;
    std::memcpy(&four, at, sizeof four);
    return four;
}
F4 smaller(F4 a, F4 b) {
    return b < a ? b : a;
}
F4 larger(F4 a, F4 b) {
    return b > a ? b : a;
}
F4 size_of(F4 a) {
    return larger(a, -a);
}

/// Differences of neighbouring coefficients along one axis: of the displacement along it, which stretch, and of the other
/// one, which shear; and of their time rates.
struct Differences {
    Line stretch, shear, stretch_rate, shear_rate;

    explicit Differences(std::size_t columns)
        : stretch(columns), shear(columns), stretch_rate(columns), shear_rate(columns) {}
    /// Between so many pairs of points, four at a time. `along`: the component along the axis.
    void set(const F4* from, const F4* to, std::size_t pairs, int along) {
        Line* const lines[] = {along == dx ? &stretch : &shear, along == dx ? &shear : &stretch,
                               along == dx ? &stretch_rate : &shear_rate,
                               along == dx ? &shear_rate : &stretch_rate};
        for (std::size_t i = 0; i < pairs; i += lanes) {
            F4 four[lanes];
            for (std::size_t k = 0; k < lanes; ++k)
                four[k] = to[i + k] - from[i + k];
            const F4 low[] = {__builtin_shufflevector(four[0], four[1], 0, 4, 1, 5),
                              __builtin_shufflevector(four[2], four[3], 0, 4, 1, 5)};
            const F4 high[] = {__builtin_shufflevector(four[0], four[1], 2, 6, 3, 7),
                               __builtin_shufflevector(four[2], four[3], 2, 6, 3, 7)};
            const F4 of_channel[] = {__builtin_shufflevector(low[0], low[1], 0, 1, 4, 5),
                                     __builtin_shufflevector(low[0], low[1], 2, 3, 6, 7),
                                     __builtin_shufflevector(high[0], high[1], 0, 1, 4, 5),
                                     __builtin_shufflevector(high[0], high[1], 2, 3, 6, 7)};
            for (std::size_t c = 0; c < lanes; ++c)
                std::memcpy(lines[c]->data() + i, &of_channel[c], sizeof of_channel[c]);
        }
    }
};

/// What they are at most within cells.
struct Bounds {
    F4 stretch_low, shear_low, shear_high, stretch_rate, shear_rate;

    void add(const Bounds& other) {
        stretch_low = smaller(stretch_low, other.stretch_low);
        shear_low = smaller(shear_low, other.shear_low);
        shear_high = larger(shear_high, other.shear_high);
        stretch_rate = larger(stretch_rate, other.stretch_rate);
        shear_rate = larger(shear_rate, other.shear_rate);
    }
};
using BoundsOfRow = std::vector<Bounds>; ///< of four cells each

/// Of a row, whose cells hang on `wide` differences each.
void bound(const Differences& differences, std::size_t wide, BoundsOfRow& row) {
    for (std::size_t n = 0; n < row.size(); ++n) {
        const auto of = [&](std::size_t i) {
            const F4 shear = load(&differences.shear[i]);
            return Bounds{load(&differences.stretch[i]), shear, shear,
                          size_of(load(&differences.stretch_rate[i])),
                          size_of(load(&differences.shear_rate[i]))};
        };
        row[n] = of(lanes * n);
        for (std::size_t i = 1; i < wide; ++i)
            row[n].add(of(lanes * n + i));
    }
}

/// The rows that a cell hangs on.
template <std::size_t count>
Bounds over(const std::array<BoundsOfRow, count>& rows, std::size_t n) {
    Bounds all = rows[0][n];
    for (std::size_t r = 1; r < count; ++r)
        all.add(rows[r][n]);
    return all;
}

F4 root(F4 a) {
    for (std::size_t i = 0; i < lanes; ++i)
        a[i] = std::sqrt(a[i]);
    return a;
}
/// Of [[xx, xy], [xy, yy]]: how far its eigenvalues lie from the mean of the two on the diagonal.
F4 half_gap(F4 xx, F4 yy, F4 xy) {
    const F4 half = 0.5f * (xx - yy);
    return root(half * half + xy * xy);
}
/// Per cell, of one length.
struct Strains {
    F4 smallest, rate;
};
Strains strains_of(const Bounds& x, const Bounds& y) {
    const F4 xy =
        0.5f * larger(size_of(x.shear_low + y.shear_low), size_of(x.shear_high + y.shear_high));
    const F4 xy_rate = 0.5f * (x.shear_rate + y.shear_rate);
    return {0.5f * (x.stretch_low + y.stretch_low) - half_gap(x.stretch_low, y.stretch_low, xy),
            0.5f * (x.stretch_rate + y.stretch_rate) +
                half_gap(x.stretch_rate, y.stretch_rate, xy_rate)};
}

/// What is widened to hold several cells or blocks: extents before they are put together.
struct Block {
    F4 strain_min = F4{} + 3e38f; ///< of every fourth cell
    F4 strain_rate{};
    Extent moved;

    void add(const Block& other) {
        add(Strains{other.strain_min, other.strain_rate});
        moved.add(other.moved);
    }
    void add(const Strains& strains) {
        strain_min = smaller(strain_min, strains.smallest);
        strain_rate = larger(strain_rate, strains.rate);
    }
    StrainBounds bounds() const {
        const F4 range = moved.high - moved.low;
        StrainBounds all{std::hypot(range[dx], range[dy]), strain_min[0],
                         std::hypot(range[dx + rate], range[dy + rate]), strain_rate[0]};
        for (std::size_t i = 1; i < lanes; ++i) {
            all.strain_min = std::min(all.strain_min, strain_min[i]);
            all.strain_rate = std::max(all.strain_rate, strain_rate[i]);
        }
        return all;
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
std::vector<Block> blocks_of(const float* coefficients, int size, int block, float per_m,
                             Pauses& pauses) {
    const int count = size / block;
    const auto cells = static_cast<std::size_t>(size);
    std::vector<Block> blocks(static_cast<std::size_t>(count * count));
    const std::size_t fours = (cells + lanes - 1) / lanes,
                      columns = lanes * fours + support + lanes;
    // Rows are as long as what is read beyond their last cells.
    const std::size_t points = cells + SplineMap::border;
    Row south(columns + 1), row(columns + 1);
    Differences along_x(columns), along_y(columns);
    // Of as many rows as a cell hangs on, in turns.
    std::array<BoundsOfRow, support> x;
    std::array<BoundsOfRow, support - 1> y;
    x.fill(BoundsOfRow(fours));
    y.fill(BoundsOfRow(fours));
    for (std::size_t r = 0; r < points; ++r) {
        read_row(coefficients + r * points * channels, cells, row);
        add_displacements(row, static_cast<int>(r), block, count, blocks);
        along_x.set(&row[0], &row[1], points - 1, dx);
        bound(along_x, support - 1, x[r % x.size()]);
        if (r > 0) {
            along_y.set(&south[0], &row[0], points, dy);
            bound(along_y, support, y[r % y.size()]);
        }
        std::swap(south, row);
        pauses.after(points);
        if (r + 1 < support)
            continue;
        Block* const of_row = &blocks[index(0, (static_cast<int>(r + 1) - support) / block, count)];
        for (std::size_t n = 0; n < fours; ++n) {
            const Strains strains = strains_of(over(x, n), over(y, n));
            of_row[lanes * n / static_cast<std::size_t>(block)].add(
                Strains{per_m * strains.smallest, per_m * strains.rate});
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

StrainWindows::StrainWindows(const float* coefficients, int size, double length_m, Pauses& pauses)
    : size_(size), length_m_(length_m), cells_a_metre_(size / length_m) {
    int block = smallest_block(size);
    std::vector<Block> blocks =
        blocks_of(coefficients, size, block, static_cast<float>(cells_a_metre_), pauses);
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
