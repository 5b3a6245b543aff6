// SPDX-License-Identifier: Apache-2.0
// point_kernel.h for W floats a vector. Included once per instruction set: all is of internal linkage, and nothing
// of the standard library is instantiated here.
#pragma once

#include "sea/surface/fold_suspicion.h"
#include "sea/surface/point_sums.h"

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

/// What a block looks up.
enum class Phase {
    cascades, ///< one after the other, of who is cold
    newton,   ///< all of them
    rates,
    done,
};

/// Lanes go on together, one look-up after the other: what is worked out from what was looked up is worked out for all of them
/// at once, and what is looked up for one does not wait for another.
template <int W, bool mixed_already, int tiles_max>
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
                held_[t][p] = -1;
            }
        }
        find_next();
    }

    bool done() const { return phase_ == Phase::done; }

    /// The next look-up, and what follows of it. Meanwhile `other` fetches what it needs for its own: while one sums up, the
    /// other's memory comes.
    void go_on(Block* other) {
        if (!fetched_)
            for (int p = 0; p < points_.count; ++p)
                fetch_for(p);
        fetched_ = true;
        if (other != nullptr && !other->fetched_) {
            for (int p = 0; p < lanes; ++p) { // who is no point has nothing to look up, or to fetch
                look_up(p);
                other->fetch_for(p);
            }
            other->fetched_ = true;
        } else
            for (int p = 0; p < points_.count; ++p)
                look_up(p);
        follow();
        find_next();
    }

  private:
    SEAWAY_INLINE static void set(float (&rows)[lanes][4]) {
        for (float(&row)[4] : rows)
            *reinterpret_cast<F4*>(row) = F4{};
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
        const F8 fraction_x = __builtin_convertvector(ux - __builtin_convertvector(ix, D8), F8);
        const F8 fraction_y = __builtin_convertvector(uy - __builtin_convertvector(iy, D8), F8);
        *reinterpret_cast<F8*>(points_.fraction_x[t]) = fraction_x;
        *reinterpret_cast<F8*>(points_.fraction_y[t]) = fraction_y;
        const auto per_m = static_cast<float>(tile.texels_per_m);
        if (points_.count == 1)
            weigh_first(fraction_x[0], fraction_y[0], per_m, weights_[t]);
        else
            weigh(fraction_x, fraction_y, per_m, weights_[t]);
        *reinterpret_cast<I8*>(first_[t]) = iy * tile.pitch + ix * channels;
    }
    SEAWAY_INLINE void find_next() {
        if (phase_ == Phase::cascades && (count_ == task_.tile_count || !any_of(cold_)))
            begin(Phase::newton);
        if (phase_ == Phase::newton && (count_ == steps_max || !any_of(going_)))
            begin(task_.rates ? Phase::rates : Phase::done);
        // Where Newton goes on to, points are in their cells already; rates lie beside what has been mixed.
        fetched_ = phase_ == Phase::done || (phase_ == Phase::newton && count_ > 0) ||
                   (phase_ == Phase::rates && !mixed_already);
        if (phase_ == Phase::cascades)
            look(count_);
        if (phase_ == Phase::newton)
            for (int t = 0; t < task_.tile_count; ++t)
                look(t);
    }
    SEAWAY_INLINE void begin(Phase phase) {
        phase_ = phase;
        count_ = 0;
    }

    SEAWAY_INLINE void fetch_for(int p) {
        if (phase_ == Phase::cascades && cold_[p])
            fetch_tile(count_, p);
        if (phase_ == Phase::newton && going_[p])
            for (int t = 0; t < task_.tile_count; ++t)
                fetch_tile(t, p);
        if (phase_ == Phase::rates && points_.solved[p])
            for (int t = 0; t < task_.tile_count; ++t)
                fetch(task_.tiles[t], held_[t][p]);
    }
    SEAWAY_INLINE void fetch_tile(int t, int p) {
        if (first_[t][p] == held_[t][p])
            return;
        if constexpr (mixed_already)
            fetch_mixed(task_.tiles[t], first_[t][p]);
        else
            fetch(task_.tiles[t], first_[t][p]);
    }

    SEAWAY_INLINE void look_up(int p) {
        if (phase_ == Phase::cascades && cold_[p])
            sum_cascade(p);
        if (phase_ == Phase::newton && going_[p])
            sum_all(p);
        if (phase_ == Phase::rates && points_.solved[p])
            sum_rates(p);
    }
    SEAWAY_INLINE void follow() {
        if (phase_ == Phase::cascades)
            step_to_next();
        if (phase_ == Phase::newton)
            step();
        ++count_;
        if (phase_ == Phase::rates)
            phase_ = Phase::done;
    }

    SEAWAY_INLINE void add_tile(int t, int p, Sums<W>& sums) {
        const PointTile& tile = task_.tiles[t];
        const int first = first_[t][p];
        if constexpr (mixed_already)
            add(weights_[t], p, tile.mixed + first / mixed_share, tile.pitch / mixed_share, sums);
        else {
            if (first != held_[t][p])
                mix<W>(tile, points_.weights[p][t], first, patches_[t][p]);
            add(weights_[t], p, patches_[t][p].texels[0], Patch::pitch, sums);
        }
        held_[t][p] = first;
    }
    SEAWAY_INLINE void sum_cascade(int p) {
        Sums<W> sums;
        add_tile(count_, p, sums);
        *reinterpret_cast<F4*>(points_.value[p]) = sums.value.together();
        *reinterpret_cast<F4*>(points_.d_dx[p]) += sums.d_dx.together();
        *reinterpret_cast<F4*>(points_.d_dy[p]) += sums.d_dy.together();
    }
    SEAWAY_INLINE void sum_all(int p) {
        Sums<W> sums;
        for (int t = 0; t < task_.tile_count; ++t)
            add_tile(t, p, sums);
        *reinterpret_cast<F4*>(points_.value[p]) = sums.value.together();
        *reinterpret_cast<F4*>(points_.d_dx[p]) = sums.d_dx.together();
        *reinterpret_cast<F4*>(points_.d_dy[p]) = sums.d_dy.together();
    }
    SEAWAY_INLINE void sum_rates(int p) {
        Sums<W> sums;
        for (int t = 0; t < task_.tile_count; ++t) {
            Patch patch;
            mix<W, true>(task_.tiles[t], points_.weights[p][t], held_[t][p], patch);
            add(weights_[t], p, patch.texels[0], Patch::pitch, sums);
        }
        *reinterpret_cast<F4*>(points_.rate[p]) = sums.value.together();
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
    SEAWAY_INLINE void step_to_next() {
        constexpr int dx = spline_channel::displacement_x, dy = spline_channel::displacement_y;
        move(Step(task_, points_, task_.choppiness_x * column<dx>(points_.value),
                  task_.choppiness_y * column<dy>(points_.value)),
             cold_);
        for (int p = 0; p < lanes; ++p)
            cold_[p] = cold_[p] && going_[p];
    }

    /// Newton's, from the place that was looked up.
    SEAWAY_INLINE void step() {
        constexpr int dx = spline_channel::displacement_x, dy = spline_channel::displacement_y;
        const D8 x_m = each(points_.shift_x_m) + task_.choppiness_x * column<dx>(points_.value);
        const D8 y_m = each(points_.shift_y_m) + task_.choppiness_y * column<dy>(points_.value);
        const D8 residual_m2 = x_m * x_m + y_m * y_m;
        const Step next(task_, points_, x_m, y_m);
        const L8 there = residual_m2 <= D8{} + task_.tolerance_m * task_.tolerance_m;
        const L8 gentle = next.determinant > D8{} + fold_suspected_below;
        bool moving[lanes];
        for (int p = 0; p < lanes; ++p) {
            moving[p] = going_[p] && !there[p];
            if (going_[p] && there[p]) {
                going_[p] = false;
                points_.solved[p] = gentle[p] != 0;
                points_.residual_m[p] = __builtin_sqrt(residual_m2[p]);
            }
        }
        move(next, moving);
    }

    const PointTask& task_;
    PointBlock& points_;
    Phase phase_ = Phase::cascades;
    int count_ = 0;        ///< cascades or steps that the phase has behind it
    bool fetched_ = false; ///< what the next look-up needs
    bool going_[lanes];    ///< not solved, and not for the careful solver
    bool cold_[lanes];     ///< of those: nothing is known of where it is
    /// The points in the world on each tile, texels.
    alignas(64) double base_x_[tiles_max][lanes];
    alignas(64) double base_y_[tiles_max][lanes];
    /// The place's 4 x 4 coefficients, floats from the beginning of the map; and of what was looked up last.
    alignas(32) int first_[tiles_max][lanes];
    int held_[tiles_max][lanes];
    LaneWeights weights_[tiles_max]; ///< at the place
    Patch patches_[mixed_already ? 1 : tiles_max][lanes];
};

/// By themselves, as is solve_alone(): in one function all kinds of blocks would stand on the stack side by side.
template <class Some>
[[gnu::noinline]] void solve_in_turns(const PointTask& task, PointBlock& first,
                                      PointBlock& second) {
    Some one(task, first), other(task, second);
    while (!one.done() || !other.done()) {
        if (!one.done())
            one.go_on(&other);
        if (!other.done())
            other.go_on(&one);
    }
}

template <class Some>
[[gnu::noinline]] void solve_alone(const PointTask& task, PointBlock& points) {
    for (Some one(task, points); !one.done();)
        one.go_on(nullptr);
}

template <int W>
void solve_points(const PointTask& task, PointBlock& first, PointBlock* second) {
    constexpr int most = PointBlock::tiles_max,
                  few = 4; // patches of more would take too much of a stack twice
    if (second != nullptr && task.tiles[0].mixed != nullptr)
        solve_in_turns<Block<W, true, most>>(task, first, *second);
    else if (second != nullptr && task.tile_count <= few)
        solve_in_turns<Block<W, false, few>>(task, first, *second);
    else
        for (PointBlock* points : {&first, second})
            if (points == nullptr)
                continue;
            else if (task.tiles[0].mixed != nullptr)
                solve_alone<Block<W, true, most>>(task, *points);
            else if (task.tile_count <= few)
                solve_alone<Block<W, false, few>>(task, *points);
            else
                solve_alone<Block<W, false, most>>(task, *points);
}

template <int W>
const PointKernel& kernel_of() {
    static constexpr PointKernel kernel{solve_points<W>, mix_all<W>};
    return kernel;
}

#undef SEAWAY_INLINE

} // namespace
} // namespace seaway::sea
