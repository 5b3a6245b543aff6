// SPDX-License-Identifier: Apache-2.0
// The truth: the sum over every wave in double precision, with the exact fixed-point phase. What
// everything faster is held against.
//
//     DirectSum sum(realization);
//     DirectSum::Moment now = sum.at_time(t_us);          // 3.3 ns a wave, once a time
//     Answer answer = surface_at(point, options, now);    // 0.5 ns a wave and evaluation
//
// A wave is a pair k, -k. Of a gale of 14 000: 45 us a time, 7 us an evaluation, 33 us an answer with
// AVX-512. The result is the same bits with every instruction set (wave_sums.h).
//
// x is reduced modulo the tile before it meets a wavenumber, so |x| = 1e7 m costs no accuracy; exp(i kx x)
// is as exact for the shortest waves as for the longest (wave_sums.h). Absolute error of every field below
// 1e-13 of the sum of its amplitudes. Thread-safe after construction.
#pragma once

#include <complex>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/instructions.h"
#include "sea/basics/lagrangian_point.h"
#include "sea/waves/realization.h"
#include "sea/waves/sheet_patch.h"
#include "sea/waves/wave_sums.h"

namespace seaway::sea {

/// How water moves, and what it is pressed by beside its weight.
struct WaterMotion {
    double velocity_mps[3] = {0, 0, 0};
    double pressure_m2ps2 = 0; ///< dynamic pressure over the water's density
};

/// What a sea whose amplitudes change becomes more of: so much of these waves a second, which turn as its own do.
struct WaveGrowth {
    RealizationPtr waves; ///< null: it stands
    double per_s = 0;
};

class DirectSum {
  public:
    /// Keeps one of each pair k, -k that carries anything. The instructions, which the machine must have,
    /// change no bit of any result.
    explicit DirectSum(RealizationPtr sea, Instructions instructions = best_instructions())
        : DirectSum(std::move(sea), {}, instructions) {}
    /// With time rates, and velocities, that have what it grows by. But what water is moved further sideways by as it becomes
    /// shallower, coth(kd), is not in them.
    DirectSum(RealizationPtr sea, WaveGrowth growth,
              Instructions instructions = best_instructions());

    /// The sea at one instant, ready to be evaluated anywhere. Refers to its DirectSum, which must
    /// outlive it.
    class Moment {
      public:
        /// The undisplaced point (X, Y), m. Displacements at choppiness 1.
        LagrangianPoint at(double x_m, double y_m) const;
        LagrangianPoint operator()(double x_m, double y_m) const { return at(x_m, y_m); }

        /// The water that lies at (X, Y) and `still_z_m`, 0 to -depth, when it is still, by linear theory: velocity
        /// at choppiness 1 as at() has it, which this is at still_z_m = 0, and -d phi / dt, of the frequencies that the
        /// waves have. Stylised waves have no water below them. Costs an at() or two and up to three exponentials a pair: of
        /// a gale some 100 us.
        ///     u, v   a w cosh(k (z + d)) / sinh(kd)           w   a w sinh(k (z + d)) / sinh(kd)
        ///     -d phi / dt   a w^2/k cosh(k (z + d)) / sinh(kd)      (Dean and Dalrymple 1991, 4)
        WaterMotion motion(double x_m, double y_m, double still_z_m) const;

        /// One cascade over x_low .. x_high, y_low .. y_high and two lattice steps around: what a
        /// search for folds needs at many places near each other. Costs half to all of the cascade's share of
        /// an at() a column and 0.35 ns a coefficient and row of waves, 0.7 where there are 300 rows.
        SheetPatch patch(int cascade, double x_low_m, double x_high_m, double y_low_m,
                         double y_high_m) const;
        /// Bounds over the tile of one cascade, m: six standard deviations of waves of random phases, and
        /// the sum of those whose phases were given.
        struct PatchScale {
            double displacement_m;
            double missed_m;        ///< by a patch's spline between its lattice points
            double missed_height_m; ///< likewise, of the height
        };
        PatchScale patch_scale(int cascade) const;
        const Realization& sea() const { return sum_->sea(); }
        /// All of its waves do: none is stylised (sea/waves/sine_waves.h).
        bool moves_sideways() const;
        std::size_t bytes() const { return (height_.size() + rate_.size()) * sizeof(PairBlock); }

      private:
        friend class DirectSum;
        bool has(std::size_t tile) const { return (cascades_ >> tile & 1u) != 0; }
        TileWaves waves(std::size_t tile) const;
        void add_growth(std::size_t begin, std::size_t count); ///< to the rates of these blocks
        /// Adds the waves of one tile.
        void add(std::size_t tile, const TileWaves& waves, double x_m, double y_m,
                 LagrangianPoint& point) const;
        struct Motion;
        void add_motion(std::size_t tile, double x_m, double y_m, double still_z_m,
                        Motion& motion) const;

        const DirectSum* sum_ = nullptr;
        std::vector<PairBlock> height_; ///< h(k,t), in the order of blocks
        std::vector<PairBlock> rate_;   ///< dh/dt
        TimeUs phase_time_ = 0;
        std::uint32_t cascades_ = all_cascades;
    };

    /// Of some cascades alone: the others cost nothing and are as if they were not.
    Moment at_time(TimeUs time_us, std::uint32_t cascades = all_cascades) const;

    /// The undisplaced point (X, Y) at a time; builds the moment for this one point.
    LagrangianPoint at(double x_m, double y_m, TimeUs time_us) const {
        return at_time(time_us).at(x_m, y_m);
    }

    const Realization& sea() const { return *sea_; }
    /// Its own, and its sea's.
    std::size_t bytes() const {
        return bytes_of(*sea_) + (growth_.waves ? bytes_of(*growth_.waves) : 0) +
               grown_.size() * sizeof(PairSpectrum) +
               spectrum_.size() * (sizeof(PairSpectrum) + sizeof(Lanes) + sizeof(Given));
    }

  private:
    /// Half plane: ny > 0, or ny = 0 and nx > 0; the other half is its conjugate. In blocks (wave_sums.h).
    struct Tile {
        double length_m;
        std::vector<WaveRun> runs;
        std::vector<Lanes> kx_radpm; ///< [n / 8] up to the largest |nx| or |ny|
        std::vector<std::complex<double>>
            circle; ///< exp(i 2 pi n / (2 size)): the lattice of patches
    };
    /// CascadeModes::given of a block's waves, a bit each.
    struct Given {
        std::uint8_t east;
        std::uint8_t west;
    };
    void add_cascade(const CascadeModes& cascade, const CascadeModes* growth);
    bool add_block(const CascadeModes& cascade, const CascadeModes* growth, int first, int ny);

    RealizationPtr sea_;
    WaveGrowth growth_;
    const WaveSums* sums_;
    // Of each block; what times ask of waves and what places ask of them lies apart.
    std::vector<PairSpectrum> spectrum_;
    std::vector<PairSpectrum> grown_; ///< of growth_, or none
    std::vector<Lanes> displacement_over_k_m_;
    std::vector<Given> given_;
    std::vector<Tile> tiles_;
};

} // namespace seaway::sea
