// SPDX-License-Identifier: Apache-2.0
// point_kernel.h for W floats a vector. Included once per instruction set: all is of internal linkage, and nothing
// of the standard library is instantiated here.
#pragma once

#include "sea/surface/fold_suspicion.h"
#include "sea/surface/point_texels.h"

namespace seaway::sea {
namespace {

typedef double D8 __attribute__((vector_size(64)));
typedef long long L8 __attribute__((vector_size(64)));
typedef int I8 __attribute__((vector_size(32)));

constexpr int lanes = PointBlock::size;
constexpr int steps_max = 6;

SEAWAY_INLINE D8 each(const double (&of_lanes)[lanes]) {
    return *reinterpret_cast<const D8*>(of_lanes);
}

/// One channel of all lanes.
template <int channel>
SEAWAY_INLINE D8 column(const float (&rows)[lanes][4]) {
    const F16 first = *reinterpret_cast<const F16*>(rows[0]);
    const F16 second = *reinterpret_cast<const F16*>(rows[4]);
    constexpr int c = channel;
    return __builtin_convertvector(__builtin_shufflevector(first, second, c, c + 4, c + 8, c + 12,
                                                           c + 16, c + 20, c + 24, c + 28),
                                   D8);
}

SEAWAY_INLINE bool any(const L8& mask) {
    long long all = 0;
    for (int p = 0; p < lanes; ++p)
        all |= mask[p];
    return all != 0;
}

/// 0 <= u < size, texels.
SEAWAY_INLINE D8 within(D8 u, double size) {
    if (any((u < 0) | (u >= size)))
        for (int p = 0; p < lanes; ++p)
            u[p] -= size * __builtin_floor(u[p] / size);
    return u;
}

SEAWAY_INLINE I8 cell_of(const D8& u, double size) {
    const I8 cell = __builtin_convertvector(u, I8);
    const I8 last = I8{} + (static_cast<int>(size) - 1);
    return cell < last ? cell : last;
}

/// Towards the solution, from I + lambda grad D and the residual.
struct Step {
    D8 x_m, y_m;
    D8 determinant;

    SEAWAY_INLINE Step(const PointTask& task, const PointBlock& points, const D8& residual_x_m,
                       const D8& residual_y_m) {
        constexpr int dx = spline_channel::displacement_x, dy = spline_channel::displacement_y;
        const D8 cross = 0.5 * (column<dx>(points.d_dy) + column<dy>(points.d_dx));
        const D8 a = 1 + task.choppiness_x * column<dx>(points.d_dx);
        const D8 b = task.choppiness_x * cross;
        const D8 c = task.choppiness_y * cross;
        const D8 d = 1 + task.choppiness_y * column<dy>(points.d_dy);
        determinant = a * d - b * c;
        const D8 per = 1 / determinant;
        x_m = (b * residual_y_m - d * residual_x_m) * per;
        y_m = (c * residual_x_m - a * residual_y_m) * per;
    }
};

/// Lanes go on together: what is worked out from what was looked up is worked out for all of them at once, and what is
/// looked up for one does not wait for another.
template <int W, bool mixed_already>
class Block {
  public:
    Block(const PointTask& task, PointBlock& points) : task_(task), points_(points) {
        for (int p = points_.count; p < lanes; ++p) { // any place will do
            points_.x_m[p] = points_.y_m[p] = 0;
            points_.weights[p] = points_.weights[0];
        }
        for (int p = 0; p < lanes; ++p) {
            going_[p] = p < points_.count;
            cold_[p] = going_[p] && !points_.warm[p];
            if (!going_[p] || cold_[p])
                points_.shift_x_m[p] = points_.shift_y_m[p] = 0;
            points_.residual_m[p] = 0;
            points_.solved[p] = false;
        }
        set(points_.value);
        set(points_.d_dx);
        set(points_.d_dy);
        for (int t = 0; t < task_.tile_count; ++t) {
            const PointTile& tile = task_.tiles[t];
            for (int p = 0; p < lanes; ++p) {
                const double east = points_.x_m[p] / tile.length_m;
                const double north = points_.y_m[p] / tile.length_m;
                base_x_[t][p] = (east - __builtin_floor(east)) * tile.size;
                base_y_[t][p] = (north - __builtin_floor(north)) * tile.size;
                patches_[t][p].first = -1;
            }
        }
    }

    void run() {
        for (int t = 0; t < task_.tile_count && any_of(cold_); ++t)
            add_cascade(t);
        for (int step = 0; step < steps_max && any_of(going_); ++step)
            newton(step == 0);
        if (!task_.rates)
            return;
        if constexpr (mixed_already) // of values alone
            for (int p = 0; p < points_.count; ++p)
                for (int t = 0; t < task_.tile_count; ++t)
                    fetch(task_.tiles[t], patches_[t][p].first);
        for (int p = 0; p < points_.count; ++p)
            if (points_.solved[p])
                add_rates(p);
    }

  private:
    SEAWAY_INLINE static void set(float (&rows)[lanes][4]) {
        for (float(&row)[4] : rows)
            *reinterpret_cast<F4*>(row) = F4{};
    }
    SEAWAY_INLINE static void add(float (&row)[4], const F4& more) {
        *reinterpret_cast<F4*>(row) += more;
    }
    SEAWAY_INLINE static bool any_of(const bool (&of_lanes)[lanes]) {
        bool any = false;
        for (const bool one : of_lanes)
            any |= one;
        return any;
    }

    /// Where the points are on a tile.
    SEAWAY_INLINE void look(int t) {
        const PointTile& tile = task_.tiles[t];
        const D8 ux =
            within(each(base_x_[t]) + each(points_.shift_x_m) * tile.texels_per_m, tile.size);
        const D8 uy =
            within(each(base_y_[t]) + each(points_.shift_y_m) * tile.texels_per_m, tile.size);
        const I8 ix = cell_of(ux, tile.size), iy = cell_of(uy, tile.size);
        *reinterpret_cast<I8*>(points_.cell_x[t]) = ix;
        *reinterpret_cast<I8*>(points_.cell_y[t]) = iy;
        *reinterpret_cast<F8*>(points_.fraction_x[t]) =
            __builtin_convertvector(ux - __builtin_convertvector(ix, D8), F8);
        *reinterpret_cast<F8*>(points_.fraction_y[t]) =
            __builtin_convertvector(uy - __builtin_convertvector(iy, D8), F8);
        *reinterpret_cast<I8*>(first_[t]) = iy * tile.pitch + ix * channels;
    }
    SEAWAY_INLINE void fetch_what_is_new(int t, const bool (&of)[lanes]) {
        for (int p = 0; p < points_.count; ++p)
            if (of[p] && first_[t][p] != patches_[t][p].first) {
                if constexpr (mixed_already)
                    fetch_mixed(task_.tiles[t], first_[t][p]);
                else
                    fetch(task_.tiles[t], first_[t][p]);
            }
    }
    SEAWAY_INLINE Here here(int t, int p) {
        const PointTile& tile = task_.tiles[t];
        Patch& patch = patches_[t][p];
        if constexpr (mixed_already) {
            patch.first = first_[t][p];
            return sample<W>(tile, tile.mixed + patch.first / mixed_share, tile.pitch / mixed_share,
                             points_.fraction_x[t][p], points_.fraction_y[t][p]);
        }
        if (patch.first != first_[t][p])
            mix<W>(tile, points_.weights[p][t], first_[t][p], patch);
        return sample<W>(tile, patch.texels[0], Patch::pitch, points_.fraction_x[t][p],
                         points_.fraction_y[t][p]);
    }

    /// Of those in `moving`.
    SEAWAY_INLINE void move(const Step& step, const bool (&moving)[lanes]) {
        const D8 x_m = each(points_.shift_x_m) + step.x_m, y_m = each(points_.shift_y_m) + step.y_m;
        // Not numbers are refused as well: nothing is looked up there.
        const L8 near = x_m * x_m + y_m * y_m <= D8{} + task_.reach_m * task_.reach_m;
        const L8 stays = near & (step.determinant > D8{} + fold_suspected_below);
        for (int p = 0; p < lanes; ++p)
            if (moving[p]) {
                points_.shift_x_m[p] = stays[p] ? x_m[p] : 0;
                points_.shift_y_m[p] = stays[p] ? y_m[p] : 0;
                going_[p] = stays[p] != 0; // else it is for the careful solver
            }
    }

    /// What the earlier cascades do is taken to be linear meanwhile, and is solved for.
    SEAWAY_INLINE void add_cascade(int t) {
        look(t);
        fetch_what_is_new(t, cold_);
        for (int p = 0; p < points_.count; ++p)
            if (cold_[p]) {
                const Here one = here(t, p);
                *reinterpret_cast<F4*>(points_.value[p]) = one.value;
                add(points_.d_dx[p], one.d_dx);
                add(points_.d_dy[p], one.d_dy);
            }
        constexpr int dx = spline_channel::displacement_x, dy = spline_channel::displacement_y;
        move(Step(task_, points_, task_.choppiness_x * column<dx>(points_.value),
                  task_.choppiness_y * column<dy>(points_.value)),
             cold_);
        for (int p = 0; p < lanes; ++p)
            cold_[p] = cold_[p] && going_[p];
    }

    SEAWAY_INLINE void newton(bool first) {
        for (int t = 0; t < task_.tile_count; ++t) {
            look(t);
            if (first)
                fetch_what_is_new(t, going_);
        }
        for (int p = 0; p < points_.count; ++p)
            if (going_[p]) {
                Here sum{};
                for (int t = 0; t < task_.tile_count; ++t) {
                    const Here one = here(t, p);
                    sum.value += one.value;
                    sum.d_dx += one.d_dx;
                    sum.d_dy += one.d_dy;
                }
                *reinterpret_cast<F4*>(points_.value[p]) = sum.value;
                *reinterpret_cast<F4*>(points_.d_dx[p]) = sum.d_dx;
                *reinterpret_cast<F4*>(points_.d_dy[p]) = sum.d_dy;
            }
        constexpr int dx = spline_channel::displacement_x, dy = spline_channel::displacement_y;
        const D8 x_m = each(points_.shift_x_m) + task_.choppiness_x * column<dx>(points_.value);
        const D8 y_m = each(points_.shift_y_m) + task_.choppiness_y * column<dy>(points_.value);
        const D8 residual_m2 = x_m * x_m + y_m * y_m;
        const Step step(task_, points_, x_m, y_m);
        const L8 there = residual_m2 <= D8{} + task_.tolerance_m * task_.tolerance_m;
        const L8 gentle = step.determinant > D8{} + fold_suspected_below;
        bool moving[lanes];
        for (int p = 0; p < lanes; ++p) {
            moving[p] = going_[p] && !there[p];
            if (going_[p] && there[p]) {
                going_[p] = false;
                points_.solved[p] = gentle[p] != 0;
                points_.residual_m[p] = __builtin_sqrt(residual_m2[p]);
            }
        }
        move(step, moving);
    }

    SEAWAY_INLINE void add_rates(int p) {
        F4 rate{};
        for (int t = 0; t < task_.tile_count; ++t) {
            const PointTile& tile = task_.tiles[t];
            Patch patch;
            mix<W, true>(tile, points_.weights[p][t], patches_[t][p].first, patch);
            rate += sample<W>(tile, patch.texels[0], Patch::pitch, points_.fraction_x[t][p],
                              points_.fraction_y[t][p])
                        .value;
        }
        *reinterpret_cast<F4*>(points_.rate[p]) = rate;
    }

    const PointTask& task_;
    PointBlock& points_;
    bool going_[lanes]; ///< not solved, and not for the careful solver
    bool cold_[lanes];  ///< of those: nothing is known of where it is
    /// The points in the world on each tile, texels.
    alignas(64) double base_x_[PointBlock::tiles_max][lanes];
    alignas(64) double base_y_[PointBlock::tiles_max][lanes];
    alignas(32) int first_[PointBlock::tiles_max][lanes]; ///< Patch::first of the place
    Patch patches_[PointBlock::tiles_max][lanes];
};

template <int W>
void solve_points(const PointTask& task, PointBlock& points) {
    if (task.tiles[0].mixed != nullptr)
        Block<W, true>(task, points).run();
    else
        Block<W, false>(task, points).run();
}

template <int W>
const PointKernel& kernel_of() {
    static constexpr PointKernel kernel{solve_points<W>, mix_all<W>};
    return kernel;
}

#undef SEAWAY_INLINE

} // namespace
} // namespace seaway::sea
