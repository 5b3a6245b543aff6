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

/// How far waves turn, rad, while they are carried: by the rms of strains and their rates. Longer intervals of what is bounded add
/// rates by themselves, shorter ones are bounded as these: 3 % more than the waves of one keyframe have.
constexpr double carried_rad = 0.25;
constexpr double carried_s_min = 1e-3, carried_s_max = 100;
/// Of so many places one is looked at for that, but all of a small map.
constexpr int looked_at = 8;

/// D_x, D_y carried on, and carried back, side by side.
typedef float F4 __attribute__((vector_size(16)));
constexpr int dx = 0, dy = 1, back = 2;

struct Texel {
    F4 values, rates;
    explicit Texel(const float* texel) {
        std::memcpy(&values, texel, sizeof values);
        std::memcpy(&rates, texel + spline_channel::rate, sizeof rates);
    }
};

F4 displacement(const float* texel, float carried_s) {
    const Texel at(texel);
    static_assert(spline_channel::displacement_x == 1 && spline_channel::displacement_y == 2);
    const F4 carried{carried_s, carried_s, -carried_s, -carried_s};
    return __builtin_shufflevector(at.values, at.values, 1, 2, 1, 2) +
           carried * __builtin_shufflevector(at.rates, at.rates, 1, 2, 1, 2);
}

/// A map that is flat is carried for a second, which changes nothing; what stands but for rounding, for no longer than waves last.
double carried_for(const float* coefficients, int size) {
    const std::size_t pitch = static_cast<std::size_t>(size + SplineMap::border) * channels;
    const int step = size < looked_at * looked_at ? 1 : looked_at;
    F4 strains{}, rates{};
    // Each row from elsewhere: of a wave as long as a step all places would be alike.
    for (int y = 0; y < size; ++y)
        for (int x = y * (y + 1) / 2 % step; x < size; x += step) {
            const float* at = coefficients + static_cast<std::size_t>(y) * pitch +
                              static_cast<std::size_t>(x) * channels;
            const Texel here(at), east(at + channels), north(at + pitch);
            const F4 along_x = east.values - here.values, along_y = north.values - here.values;
            const F4 rate_x = east.rates - here.rates, rate_y = north.rates - here.rates;
            strains += along_x * along_x + along_y * along_y;
            rates += rate_x * rate_x + rate_y * rate_y;
        }
    using spline_channel::displacement_x, spline_channel::displacement_y;
    const float strain2 = strains[displacement_x] + strains[displacement_y];
    const float rate2 = rates[displacement_x] + rates[displacement_y];
    const double seconds = carried_rad * std::sqrt(static_cast<double>(strain2 / rate2));
    return std::isnan(seconds) ? 1.0 : std::clamp(seconds, carried_s_min, carried_s_max);
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
void read_row(const float* texel, std::size_t cells, float carried_s, Row& to) {
    for (std::size_t i = 0; i < to.size(); ++i)
        to[i] = i < cells + SplineMap::border ? displacement(texel + i * channels, carried_s)
                                              : to[i - cells];
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
/// one, which shear; carried on, and carried back.
struct Differences {
    Line stretch, shear, stretch_back, shear_back;

    explicit Differences(std::size_t columns)
        : stretch(columns), shear(columns), stretch_back(columns), shear_back(columns) {}
    /// Between so many pairs of points, four at a time. `along`: the component along the axis.
    void set(const F4* from, const F4* to, std::size_t pairs, int along) {
        Line* const lines[] = {along == dx ? &stretch : &shear, along == dx ? &shear : &stretch,
                               along == dx ? &stretch_back : &shear_back,
                               along == dx ? &shear_back : &stretch_back};
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
    struct Carried {
        F4 stretch_low, shear_low, shear_high;

        void add(const Carried& other) {
            stretch_low = smaller(stretch_low, other.stretch_low);
            shear_low = smaller(shear_low, other.shear_low);
            shear_high = larger(shear_high, other.shear_high);
        }
    };
    Carried on, back;
    F4 stretch_apart, shear_apart; ///< between carried on and carried back

    void add(const Bounds& other) {
        on.add(other.on);
        back.add(other.back);
        stretch_apart = larger(stretch_apart, other.stretch_apart);
        shear_apart = larger(shear_apart, other.shear_apart);
    }
};
using BoundsOfRow = std::vector<Bounds>; ///< of four cells each

/// Of a row, whose cells hang on `wide` differences each.
void bound(const Differences& differences, std::size_t wide, BoundsOfRow& row) {
    for (std::size_t n = 0; n < row.size(); ++n) {
        const auto of = [&](std::size_t i) {
            const F4 stretch = load(&differences.stretch[i]), shear = load(&differences.shear[i]),
                     stretch_back = load(&differences.stretch_back[i]),
                     shear_back = load(&differences.shear_back[i]);
            return Bounds{{stretch, shear, shear},
                          {stretch_back, shear_back, shear_back},
                          size_of(stretch - stretch_back),
                          size_of(shear - shear_back)};
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
    F4 on = F4{} + 3e38f, back = F4{} + 3e38f; ///< the smallest
    F4 apart{};                                ///< the largest between both

    void add(const Strains& other) {
        on = smaller(on, other.on);
        back = smaller(back, other.back);
        apart = larger(apart, other.apart);
    }
    /// Of all four: the smallest on and back, and of what lies between them the largest, below 0.
    F4 together() const {
        F4 all{on[0], back[0], -apart[0], 0};
        for (std::size_t i = 1; i < lanes; ++i)
            all = smaller(all, F4{on[i], back[i], -apart[i], 0});
        return all;
    }
};
F4 smallest_strain(const Bounds::Carried& x, const Bounds::Carried& y) {
    const F4 xy =
        0.5f * larger(size_of(x.shear_low + y.shear_low), size_of(x.shear_high + y.shear_high));
    return 0.5f * (x.stretch_low + y.stretch_low) - half_gap(x.stretch_low, y.stretch_low, xy);
}
Strains strains_of(const Bounds& x, const Bounds& y) {
    const F4 xy_apart = 0.5f * (x.shear_apart + y.shear_apart);
    return {smallest_strain(x.on, y.on), smallest_strain(x.back, y.back),
            0.5f * (x.stretch_apart + y.stretch_apart) +
                half_gap(x.stretch_apart, y.stretch_apart, xy_apart)};
}

/// What is widened to hold several cells or blocks.
struct Block {
    F4 strains = F4{} + 3e38f; ///< as Strains::together()
    Extent moved;
    /// The most of what is carried on less what is carried back, and of its negative.
    F4 apart = F4{} - 3e38f;

    void add(const Block& other) {
        strains = smaller(strains, other.strains);
        moved.add(other.moved);
        apart = larger(apart, other.apart);
    }
    StrainBounds bounds(float carried_s) const {
        const F4 range = moved.high - moved.low;
        const float a_second = 0.5f / carried_s;
        return {.range_on_m = std::hypot(range[dx], range[dy]),
                .range_back_m = std::hypot(range[dx + back], range[dy + back]),
                .range_rate = a_second * std::hypot(apart[dx] + apart[dx + back],
                                                    apart[dy] + apart[dy + back]),
                .strain_on = strains[0],
                .strain_back = strains[1],
                .strain_rate = -a_second * strains[2]};
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
        Block some;
        for (int i = bx * block; i < bx * block + block + support - 1; ++i) {
            const F4 both = row[static_cast<std::size_t>(i)];
            some.moved.add(both);
            some.apart = larger(some.apart, both - __builtin_shufflevector(both, both, 2, 3, 0, 1));
        }
        for (int by = std::max(0, (number - support + 1) / block);
             by < count && by * block <= number; ++by)
            if (number < by * block + block + support - 1)
                blocks[index(bx, by, count)].add(some);
    }
}

/// The smallest blocks of a map.
std::vector<Block> blocks_of(const float* coefficients, int size, int block, float per_m,
                             float carried_s, Pauses& pauses) {
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
    std::vector<Strains> strains(static_cast<std::size_t>(count)); ///< of a row of blocks
    x.fill(BoundsOfRow(fours));
    y.fill(BoundsOfRow(fours));
    for (std::size_t r = 0; r < points; ++r) {
        read_row(coefficients + r * points * channels, cells, carried_s, row);
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
        for (std::size_t n = 0; n < fours; ++n)
            strains[lanes * n / static_cast<std::size_t>(block)].add(
                strains_of(over(x, n), over(y, n)));
        const int cell_row = static_cast<int>(r + 1) - support;
        if ((cell_row + 1) % block != 0)
            continue;
        for (int bx = 0; bx < count; ++bx)
            blocks[index(bx, cell_row / block, count)].strains =
                per_m * std::exchange(strains[static_cast<std::size_t>(bx)], {}).together();
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
    : size_(size), length_m_(length_m), cells_a_metre_(size / length_m),
      carried_s_(static_cast<double>(static_cast<float>(carried_for(coefficients, size)))) {
    int block = smallest_block(size);
    const auto carried_s = static_cast<float>(carried_s_);
    std::vector<Block> blocks =
        blocks_of(coefficients, size, block, static_cast<float>(cells_a_metre_), carried_s, pauses);
    windows_.reserve(bytes_of(size) / sizeof(StrainBounds));
    for (int count = size / block;; count /= 2, block *= 2) {
        // A single block is shifted away: its number is 0 whatever the size.
        const int shift = count == 1 ? 31 : std::countr_zero(static_cast<unsigned>(block));
        levels_.push_back({block - rounding_cells, shift, count, windows_.size()});
        std::vector<Block> windows = blocks;
        widen_each(windows, count);
        for (const Block& window : windows)
            windows_.push_back(window.bounds(carried_s));
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
