// SPDX-License-Identifier: Apache-2.0
// point_kernel.h for W floats a vector. Included once per instruction set: all is of internal linkage, and nothing
// of the standard library is instantiated here.
#pragma once

#include "sea/surface/fold_suspicion.h"
#include "sea/surface/maps/spline_channels.h"
#include "sea/surface/maps/spline_weights.h"
#include "sea/surface/point_kernel.h"

namespace seaway::sea {
namespace {

#define SEAWAY_INLINE [[gnu::always_inline]] inline

typedef float F4 __attribute__((vector_size(16)));
typedef float F8 __attribute__((vector_size(32)));
typedef float F16 __attribute__((vector_size(64)));
typedef float F4Unaligned __attribute__((vector_size(16), aligned(4), may_alias));
typedef float F8Unaligned __attribute__((vector_size(32), aligned(4), may_alias));
typedef float F16Unaligned __attribute__((vector_size(64), aligned(4), may_alias));

constexpr int channels = spline_channel::count;
constexpr int steps_max = 6;

struct Spot {
    int first; ///< of 4 x 4 coefficients, floats from the beginning of the map
    float fraction_x;
    float fraction_y;
};

/// One cascade around one point, mixed at its time.
struct alignas(64) Patch {
    float texels[16][4];
    int first; ///< Spot::first
};

struct Here {
    F4 value;
    F4 d_dx;
    F4 d_dy;
};

/// Position of the world point on each tile, texels.
struct Base {
    double x[PointKernel::tiles_max];
    double y[PointKernel::tiles_max];
};

SEAWAY_INLINE double within(double u, double size) {
    return u - size * __builtin_floor(u / size);
}

SEAWAY_INLINE int index_of(double u, double size) {
    const int index = static_cast<int>(u);
    const int last = static_cast<int>(size) - 1;
    return index < last ? index : last;
}

SEAWAY_INLINE Spot spot_of(const PointTile& tile, double base_x, double base_y, double shift_x_m,
                           double shift_y_m) {
    double ux = base_x + shift_x_m * tile.texels_per_m;
    double uy = base_y + shift_y_m * tile.texels_per_m;
    if (!(ux >= 0 && ux < tile.size))
        ux = within(ux, tile.size);
    if (!(uy >= 0 && uy < tile.size))
        uy = within(uy, tile.size);
    const int ix = index_of(ux, tile.size), iy = index_of(uy, tile.size);
    return {iy * tile.pitch + ix * channels, static_cast<float>(ux - ix),
            static_cast<float>(uy - iy)};
}

SEAWAY_INLINE void fetch(const PointTile& tile, int first) {
    for (const float* map : {tile.before, tile.after})
        for (int j = 0; j < 4; ++j) {
            const float* row = map + first + j * tile.pitch;
            __builtin_prefetch(row);
            __builtin_prefetch(row + 2 * channels);
            __builtin_prefetch(row + 4 * channels - 1);
        }
}

/// (before's value + after's value) + (before's rate + after's rate), each times its weight.
template <int W>
SEAWAY_INLINE F4 mixed(const float* before, const float* after, const float* w) {
    if constexpr (W == 8) {
        const F8 wb{w[0], w[0], w[0], w[0], w[1], w[1], w[1], w[1]};
        const F8 wa{w[2], w[2], w[2], w[2], w[3], w[3], w[3], w[3]};
        const F8 both = wb * *reinterpret_cast<const F8Unaligned*>(before) +
                        wa * *reinterpret_cast<const F8Unaligned*>(after);
        return __builtin_shufflevector(both, both, 0, 1, 2, 3) +
               __builtin_shufflevector(both, both, 4, 5, 6, 7);
    } else {
        const auto part = [](const float* at) {
            return static_cast<F4>(*reinterpret_cast<const F4Unaligned*>(at));
        };
        return (w[0] * part(before) + w[2] * part(after)) +
               (w[1] * part(before + 4) + w[3] * part(after + 4));
    }
}

/// The same of four texels in a row.
SEAWAY_INLINE F16 mixed_row(const float* before, const float* after, const float* w) {
    const F16 wb{w[0], w[0], w[0], w[0], w[1], w[1], w[1], w[1],
                 w[0], w[0], w[0], w[0], w[1], w[1], w[1], w[1]};
    const F16 wa{w[2], w[2], w[2], w[2], w[3], w[3], w[3], w[3],
                 w[2], w[2], w[2], w[2], w[3], w[3], w[3], w[3]};
    const auto two = [&](int i) {
        return wb * *reinterpret_cast<const F16Unaligned*>(before + i) +
               wa * *reinterpret_cast<const F16Unaligned*>(after + i);
    };
    const F16 west = two(0), east = two(2 * channels);
    return __builtin_shufflevector(west, east, 0, 1, 2, 3, 8, 9, 10, 11, 16, 17, 18, 19, 24, 25, 26,
                                   27) +
           __builtin_shufflevector(west, east, 4, 5, 6, 7, 12, 13, 14, 15, 20, 21, 22, 23, 28, 29,
                                   30, 31);
}

template <int W>
SEAWAY_INLINE void mix(const PointTile& tile, const float* weights, int first, Patch& patch) {
    const float* before = tile.before + first;
    const float* after = tile.after + first;
    for (int j = 0; j < 4; ++j, before += tile.pitch, after += tile.pitch) {
        if constexpr (W == 16)
            *reinterpret_cast<F16*>(patch.texels[4 * j]) = mixed_row(before, after, weights);
        else
            for (int i = 0; i < 4; ++i)
                *reinterpret_cast<F4*>(patch.texels[4 * j + i]) =
                    mixed<W>(before + i * channels, after + i * channels, weights);
    }
    patch.first = first;
}

/// The sum over i of column[i] weight[i], as (0 + 2) + (1 + 3).
SEAWAY_INLINE F4 across(const F4 (&column)[4], F4 weight) {
    return (column[0] * weight[0] + column[2] * weight[2]) +
           (column[1] * weight[1] + column[3] * weight[3]);
}

template <int W>
SEAWAY_INLINE Here sample(const PointTile& tile, const Patch& patch, const Spot& spot) {
    F4 wx, dx, wy, dy;
    spline_weights(spot.fraction_x, wx, dx);
    spline_weights(spot.fraction_y, wy, dy);
    const auto per_m = static_cast<float>(tile.texels_per_m);
    dx *= per_m;
    dy *= per_m;
    if constexpr (W == 16) {
        F16 column{}, slope{};
        for (int j = 0; j < 4; ++j) {
            const F16 row = *reinterpret_cast<const F16*>(patch.texels[4 * j]);
            column += wy[j] * row;
            slope += dy[j] * row;
        }
        const auto sum = [](const F16& c, F4 w) {
            const F16 all =
                c * __builtin_shufflevector(w, w, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
            const F8 both = __builtin_shufflevector(all, all, 0, 1, 2, 3, 4, 5, 6, 7) +
                            __builtin_shufflevector(all, all, 8, 9, 10, 11, 12, 13, 14, 15);
            return __builtin_shufflevector(both, both, 0, 1, 2, 3) +
                   __builtin_shufflevector(both, both, 4, 5, 6, 7);
        };
        return {sum(column, wx), sum(column, dx), sum(slope, wx)};
    } else if constexpr (W == 8) {
        F8 column[2] = {}, slope[2] = {};
        for (int j = 0; j < 4; ++j)
            for (int v = 0; v < 2; ++v) {
                const F8 texels =
                    *reinterpret_cast<const F8Unaligned*>(patch.texels[4 * j + 2 * v]);
                column[v] += wy[j] * texels;
                slope[v] += dy[j] * texels;
            }
        const auto sum = [](const F8(&c)[2], F4 w) {
            const F8 low = __builtin_shufflevector(w, w, 0, 0, 0, 0, 1, 1, 1, 1);
            const F8 high = __builtin_shufflevector(w, w, 2, 2, 2, 2, 3, 3, 3, 3);
            const F8 both = c[0] * low + c[1] * high;
            return __builtin_shufflevector(both, both, 0, 1, 2, 3) +
                   __builtin_shufflevector(both, both, 4, 5, 6, 7);
        };
        return {sum(column, wx), sum(column, dx), sum(slope, wx)};
    } else {
        F4 column[4] = {}, slope[4] = {};
        for (int j = 0; j < 4; ++j)
            for (int i = 0; i < 4; ++i) {
                const F4 texel = *reinterpret_cast<const F4*>(patch.texels[4 * j + i]);
                column[i] += wy[j] * texel;
                slope[i] += dy[j] * texel;
            }
        return {across(column, wx), across(column, dx), across(slope, wx)};
    }
}

/// I + lambda grad D and the residual of a place.
struct Step {
    double a, b, c, d;
    double x_m, y_m; ///< towards the solution
    double determinant;

    Step(const PointTask& task, const Here& p, double residual_x_m, double residual_y_m) {
        constexpr int dx = spline_channel::displacement_x, dy = spline_channel::displacement_y;
        const double cross =
            0.5 * (static_cast<double>(p.d_dy[dx]) + static_cast<double>(p.d_dx[dy]));
        a = 1 + task.choppiness_x * static_cast<double>(p.d_dx[dx]);
        b = task.choppiness_x * cross;
        c = task.choppiness_y * cross;
        d = 1 + task.choppiness_y * static_cast<double>(p.d_dy[dy]);
        determinant = a * d - b * c;
        const double per = 1 / determinant;
        x_m = (b * residual_y_m - d * residual_x_m) * per;
        y_m = (c * residual_x_m - a * residual_y_m) * per;
    }
};

/// A point on its way.
struct Walk {
    Here sum;
    bool leaves; ///< for the careful solver
    bool done;
};

template <int W>
class Block {
  public:
    Block(const PointTask& task, PointPlace* places, int count)
        : task_(task), places_(places), count_(count) {
        for (int p = 0; p < count_; ++p) {
            PointPlace& place = places_[p];
            place.shift_x_m = place.shift_y_m = 0;
            place.solved = false;
            walks_[p].sum = Here{F4{}, F4{}, F4{}};
            walks_[p].leaves = walks_[p].done = false;
            for (int t = 0; t < task_.tile_count; ++t) {
                const PointTile& tile = task_.tiles[t];
                const double east = place.x_m / tile.length_m, north = place.y_m / tile.length_m;
                bases_[p].x[t] = (east - __builtin_floor(east)) * tile.size;
                bases_[p].y[t] = (north - __builtin_floor(north)) * tile.size;
                patches_[p][t].first = -1;
            }
        }
    }

    void run() {
        for (int t = 0; t < task_.tile_count; ++t) {
            for (int p = 0; p < count_; ++p)
                fetch(task_.tiles[t], spot(p, t).first);
            for (int p = 0; p < count_; ++p)
                add_cascade(p, t);
        }
        int left = count_;
        for (int step = 0; step < steps_max && left > 0; ++step) {
            if (step == 0)
                fetch_moved();
            left = 0;
            for (int p = 0; p < count_; ++p)
                left += newton(p) ? 0 : 1;
        }
        if (task_.rates)
            for (int p = 0; p < count_; ++p)
                if (places_[p].solved)
                    add_rates(p);
    }

  private:
    SEAWAY_INLINE Spot spot(int p, int t) const {
        return spot_of(task_.tiles[t], bases_[p].x[t], bases_[p].y[t], places_[p].shift_x_m,
                       places_[p].shift_y_m);
    }

    SEAWAY_INLINE Here here(int p, int t) {
        const Spot at = spot(p, t);
        Patch& patch = patches_[p][t];
        if (patch.first != at.first)
            mix<W>(task_.tiles[t], places_[p].weights[t].value, at.first, patch);
        return sample<W>(task_.tiles[t], patch, at);
    }

    SEAWAY_INLINE void move(int p, const Step& step) {
        PointPlace& place = places_[p];
        place.shift_x_m += step.x_m;
        place.shift_y_m += step.y_m;
        // Not numbers are refused as well: nothing is looked up there.
        const double far_m2 = place.shift_x_m * place.shift_x_m + place.shift_y_m * place.shift_y_m;
        if (!(step.determinant > fold_suspected_below && far_m2 <= task_.reach_m * task_.reach_m)) {
            walks_[p].leaves = true;
            place.shift_x_m = place.shift_y_m = 0;
        }
    }

    /// What the earlier cascades do is taken to be linear meanwhile, and is solved for.
    SEAWAY_INLINE void add_cascade(int p, int t) {
        Walk& walk = walks_[p];
        if (walk.leaves)
            return;
        const Here one = here(p, t);
        walk.sum.d_dx += one.d_dx;
        walk.sum.d_dy += one.d_dy;
        constexpr int dx = spline_channel::displacement_x, dy = spline_channel::displacement_y;
        move(p, Step(task_, walk.sum, task_.choppiness_x * static_cast<double>(one.value[dx]),
                     task_.choppiness_y * static_cast<double>(one.value[dy])));
    }

    SEAWAY_INLINE void fetch_moved() {
        for (int p = 0; p < count_; ++p)
            for (int t = 0; t < task_.tile_count; ++t)
                if (const int first = spot(p, t).first; first != patches_[p][t].first)
                    fetch(task_.tiles[t], first);
    }

    /// Done with this point?
    SEAWAY_INLINE bool newton(int p) {
        Walk& walk = walks_[p];
        if (walk.leaves || walk.done)
            return true;
        walk.sum = Here{F4{}, F4{}, F4{}};
        for (int t = 0; t < task_.tile_count; ++t) {
            const Here one = here(p, t);
            walk.sum.value += one.value;
            walk.sum.d_dx += one.d_dx;
            walk.sum.d_dy += one.d_dy;
        }
        constexpr int dx = spline_channel::displacement_x, dy = spline_channel::displacement_y;
        PointPlace& place = places_[p];
        const double x_m =
            place.shift_x_m + task_.choppiness_x * static_cast<double>(walk.sum.value[dx]);
        const double y_m =
            place.shift_y_m + task_.choppiness_y * static_cast<double>(walk.sum.value[dy]);
        const double residual_m2 = x_m * x_m + y_m * y_m;
        const Step step(task_, walk.sum, x_m, y_m);
        if (residual_m2 <= task_.tolerance_m * task_.tolerance_m) {
            walk.done = true;
            place.solved = step.determinant > fold_suspected_below;
            place.residual_m = __builtin_sqrt(residual_m2);
            for (int c = 0; c < spline_channel::values; ++c) {
                place.value[c] = walk.sum.value[c];
                place.d_dx[c] = walk.sum.d_dx[c];
                place.d_dy[c] = walk.sum.d_dy[c];
            }
            return true;
        }
        move(p, step);
        return false;
    }

    SEAWAY_INLINE void add_rates(int p) {
        F4 rate{};
        for (int t = 0; t < task_.tile_count; ++t) {
            const Spot at = spot(p, t);
            Patch patch;
            mix<W>(task_.tiles[t], places_[p].weights[t].rate, at.first, patch);
            rate += sample<W>(task_.tiles[t], patch, at).value;
        }
        for (int c = 0; c < spline_channel::values; ++c)
            places_[p].rate[c] = rate[c];
    }

    const PointTask& task_;
    PointPlace* places_;
    const int count_;
    Walk walks_[PointKernel::block];
    Base bases_[PointKernel::block];
    Patch patches_[PointKernel::block][PointKernel::tiles_max];
};

template <int W>
void solve_points(const PointTask& task, PointPlace* places, int count) {
    for (int first = 0; first < count; first += PointKernel::block) {
        const int left = count - first;
        Block<W>(task, places + first, left < PointKernel::block ? left : PointKernel::block).run();
    }
}

template <int W>
const PointKernel& kernel_of() {
    static constexpr PointKernel kernel{solve_points<W>};
    return kernel;
}

#undef SEAWAY_INLINE

} // namespace
} // namespace seaway::sea
