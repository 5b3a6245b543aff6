// SPDX-License-Identifier: Apache-2.0
#include "sea/waves/quantised_spectrum.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sea/basics/deviations.h"

namespace seaway::sea {
namespace {

constexpr int tries = 12;
/// Of what is wanted; a step that is as good as this is not looked for any further.
constexpr double close_enough = 0.995;
/// Tried out, in shares of height over slope: where both are wanted.
constexpr double length_shares[] = {0.25, 1.0, 4.0, 16.0};
/// The first layer is as fine as so many bytes allow, so that they leave as little as they can.
constexpr double coarse_bytes = 9500;
/// Which a block costs even where it is nearly empty.
constexpr double block_bits = 64;
/// Codes are 32 bits with their sign; no sea is so fine.
constexpr double code_max = 0x1p30;

struct Wave {
    std::complex<double> h0;
    double kx, ky;
    double aspect2; ///< coth^2(kd)
    std::size_t block;
    std::size_t place; ///< in the block, of the real part
    bool given;        ///< its phase
    double k() const { return std::hypot(kx, ky); }
};

/// What waves are off by. Of waves whose phases are chance variances add up, along any line at once; those that were given may have
/// any, and all be off the same way at some place: of these it is amplitudes.
class Noise {
  public:
    /// The square of |h0| goes from one to another.
    void add(const Wave& wave, double from2, double to2 = 0) {
        const double k = wave.k(), sideways = std::sqrt(wave.aspect2);
        if (wave.given) {
            const double amplitude_m = 2.0 * (std::sqrt(from2) - std::sqrt(to2));
            height_.sure += amplitude_m;
            displacement_.sure += amplitude_m * sideways;
            slope_.sure += amplitude_m * k;
        } else {
            const double variance_m2 = 2.0 * (from2 - to2);
            height_.xx += variance_m2;
            displacement_.along(wave, variance_m2 * wave.aspect2 / (k * k));
            slope_.along(wave, variance_m2);
        }
    }
    Noise& operator+=(const Noise& o) {
        height_ += o.height_;
        displacement_ += o.displacement_;
        slope_ += o.slope_;
        return *this;
    }
    /// Variances of which bound_sigmas deviations are a bound of all, along whichever line.
    double height() const { return height_.variance(); }
    double displacement() const { return displacement_.variance(); }
    double slope() const { return slope_.variance(); }
    SpectrumLeft left() const {
        return {std::sqrt(height()), std::sqrt(displacement()), std::sqrt(slope())};
    }

  private:
    struct Part {
        double xx = 0, yy = 0, xy = 0; ///< covariances of what is chance
        double sure = 0;               ///< what amplitudes add up to

        void along(const Wave& wave, double scale) {
            xx += scale * wave.kx * wave.kx;
            yy += scale * wave.ky * wave.ky;
            xy += scale * wave.kx * wave.ky;
        }
        Part& operator+=(const Part& o) {
            xx += o.xx;
            yy += o.yy;
            xy += o.xy;
            sure += o.sure;
            return *this;
        }
        /// Of the line along which it is largest.
        double variance() const {
            const double largest = 0.5 * (xx + yy + std::hypot(xx - yy, 2 * xy));
            const double all = std::sqrt(std::max(largest, 0.0)) + sure / bound_sigmas;
            return all * all;
        }
    };

    Part height_, displacement_, slope_;
};

struct Rounded {
    double real, imaginary;
    double error2;
};

Rounded rounded(const std::complex<double>& h0, double step) {
    const double real = std::nearbyint(h0.real() / step);
    const double imaginary = std::nearbyint(h0.imag() / step);
    const double dr = h0.real() - real * step, di = h0.imag() - imaginary * step;
    return {real, imaginary, dr * dr + di * di};
}

/// Roughly, of a number that entropy coding knows the scale of.
double bits_of(double code) {
    return code == 0 ? 0.7 : 1.5 + std::log2(1.0 + 2.0 * std::abs(code));
}
double bits_of(const Rounded& code) {
    return bits_of(code.real) + bits_of(code.imaginary);
}

/// Floor division for block numbers.
int block_of(int n) {
    return n >= 0 ? n / WaveBlock::side : -((-n + WaveBlock::side - 1) / WaveBlock::side);
}

class Quantiser {
  public:
    Quantiser(const Realization& sea, const SpectrumAccuracy& wanted)
        : wanted_(wanted), sideways_(sea.choppiness.largest()) {
        for (std::size_t c = 0; c < sea.cascades.size(); ++c)
            take(sea.cascades[c], static_cast<int>(c));
        for (const Wave& wave : waves_)
            whole_.add(wave, std::norm(wave.h0));
        double slope2 = 0;
        for (const Wave& wave : waves_)
            slope2 += 2.0 * std::norm(wave.h0) * wave.k() * wave.k();
        rms_slope_ = std::sqrt(slope2);
        for (const Wave& wave : waves_) {
            largest_m_ = std::max({largest_m_, std::abs(wave.h0.real()), std::abs(wave.h0.imag())});
            shortest_radpm_ = std::max(shortest_radpm_, wave.k());
        }
    }

    QuantisedSpectrum best() {
        QuantisedSpectrum result;
        result.without = whole_.left();
        if (waves_.empty())
            return result;
        double fewest_bits = std::numeric_limits<double>::infinity();
        for (const double length_m : lengths()) {
            const SpectrumSteps steps = widest(length_m);
            const double bits = bits_with(steps);
            if (bits < fewest_bits) {
                fewest_bits = bits;
                result.steps = steps;
            }
        }
        fill(result);
        return result;
    }

  private:
    void take(const CascadeModes& modes, int cascade) {
        SEAWAY_CHECK(modes.sines.empty(), "stylised waves are no modes and have no spectrum");
        const int size = modes.spec.size;
        const double step = modes.spec.wavenumber_step_radpm();
        std::vector<std::size_t> block_at(static_cast<std::size_t>((size / 8 + 2) * (size / 8 + 2)),
                                          SIZE_MAX);
        for (int iy = 0; iy < size; ++iy)
            for (int ix = 0; ix < size; ++ix) {
                const auto index = static_cast<std::size_t>(iy * size + ix);
                if (modes.h0[index] == 0.0)
                    continue;
                const int nx = signed_index(ix, size), ny = signed_index(iy, size);
                const int bx = block_of(nx), by = block_of(ny);
                std::size_t& block = block_at[static_cast<std::size_t>(
                    (by + size / 16 + 1) * (size / 8 + 2) + bx + size / 16 + 1)];
                if (block == SIZE_MAX) {
                    block = blocks_.size();
                    blocks_.push_back({cascade, bx, by, 0, false, {}});
                }
                blocks_[block].given = blocks_[block].given || modes.is_given(index);
                const double aspect = orbit_aspect(step * std::hypot(nx, ny), modes.depth_m);
                waves_.push_back(
                    {modes.h0[index], step * nx, step * ny, aspect * aspect, block,
                     2 * static_cast<std::size_t>((ny - WaveBlock::side * by) * WaveBlock::side +
                                                  nx - WaveBlock::side * bx),
                     modes.is_given(index)});
            }
    }

    std::vector<double> lengths() const {
        if (!std::isfinite(wanted_.slope))
            return {0.0};
        std::vector<double> all;
        for (const double share : length_shares)
            all.push_back(share * wanted_.height_m / wanted_.slope);
        return all;
    }

    /// Largest share of what is wanted, in the square; 1: just as good.
    double share_of_wanted(const Noise& noise) const {
        const double sigmas2 = spectrum_sigmas * spectrum_sigmas;
        const double tilt = rms_slope_ * sideways_;
        const double height = noise.height() + tilt * tilt * noise.displacement();
        return sigmas2 * std::max(height / (wanted_.height_m * wanted_.height_m),
                                  noise.slope() / (wanted_.slope * wanted_.slope));
    }

    Noise noise_with(const SpectrumSteps& steps) const {
        Noise noise;
        for (const Wave& wave : waves_)
            noise.add(wave, rounded(wave.h0, steps.of(wave.k(), 0)).error2);
        return noise;
    }

    double bits_with(const SpectrumSteps& steps) const {
        double bits = 0;
        for (const Wave& wave : waves_) {
            const Rounded code = rounded(wave.h0, steps.of(wave.k(), 0));
            bits += bits_of(code);
        }
        return bits;
    }

    /// Of which no code is too long.
    double finest_m(double length_m) const {
        return largest_m_ / code_max * std::hypot(1.0, shortest_radpm_ * length_m);
    }

    /// The widest steps that are good enough. Noise grows with the step, and no faster than its square where it
    /// is above what is wanted, so that each try is nearer.
    SpectrumSteps widest(double length_m) const {
        SpectrumSteps steps{1.0, length_m};
        Noise even; // s^2 / 6 for each wave
        for (const Wave& wave : waves_) {
            const double step = steps.of(wave.k(), 0);
            even.add(wave, step * step / 6.0);
        }
        const double widest_m = 1e3 * largest_m_; // above it all codes are 0
        const auto within = [&](double step_m) {
            return std::clamp(step_m, finest_m(length_m), widest_m);
        };
        double low_m = finest_m(length_m), high_m = widest_m;
        double try_m = within(1.0 / std::sqrt(share_of_wanted(even)));
        for (int n = 0; n < tries; ++n) {
            const double share = share_of_wanted(noise_with({try_m, length_m}));
            (share <= 1.0 ? low_m : high_m) = try_m;
            if (share <= 1.0 && (share >= close_enough || low_m >= widest_m))
                break;
            double next_m = share > 0 ? try_m / std::sqrt(share) : widest_m;
            if (!(next_m > low_m && next_m < high_m))
                next_m = std::sqrt(low_m * high_m);
            try_m = next_m;
        }
        return {low_m, length_m};
    }

    /// One layer of one block.
    struct Piece {
        WaveBlock block;
        Noise gained;
        double bits = 0;
        bool says = false;
        double worth() const { return gained.height() / (bits + block_bits); }
    };

    using Rest = std::vector<std::complex<double>>; ///< of each wave, what no layer has told yet

    Rest all_of_it() const {
        Rest rest;
        for (const Wave& wave : waves_)
            rest.push_back(wave.h0);
        return rest;
    }

    /// The blocks of one layer that say anything, in no order; takes what they say from `rest`.
    std::vector<Piece> layer(const SpectrumSteps& steps, int shift, Rest& rest) const {
        std::vector<Piece> pieces;
        for (const WaveBlock& block : blocks_) {
            Piece& piece = pieces.emplace_back();
            piece.block = block;
            piece.block.shift = shift;
        }
        for (std::size_t w = 0; w < waves_.size(); ++w) {
            const Wave& wave = waves_[w];
            const double step = steps.of(wave.k(), shift);
            const Rounded code = rounded(rest[w], step);
            Piece& piece = pieces[wave.block];
            piece.bits += bits_of(code);
            if (code.real == 0 && code.imaginary == 0)
                continue;
            piece.says = true;
            piece.block.codes[wave.place] = static_cast<std::int32_t>(code.real);
            piece.block.codes[wave.place + 1] = static_cast<std::int32_t>(code.imaginary);
            piece.gained.add(wave, std::norm(rest[w]), code.error2);
            rest[w] -= std::complex(code.real * step, code.imaginary * step);
        }
        std::erase_if(pieces, [](const Piece& piece) { return !piece.says; });
        return pieces;
    }

    static double bytes_of(const std::vector<Piece>& pieces) {
        return std::accumulate(pieces.begin(), pieces.end(), 0.0, [](double sum, const Piece& p) {
            return sum + (p.bits + block_bits) / 8.0;
        });
    }

    struct Layers {
        std::vector<Piece> pieces; ///< in the order in which they are sent
        Noise left;                ///< once all of them are there
    };

    /// Both layers; one where that is small enough.
    Layers layers(const SpectrumSteps& steps) const {
        std::vector<Piece> coarse;
        Rest rest;
        const auto made = [&] {
            Noise left;
            for (std::size_t w = 0; w < waves_.size(); ++w)
                left.add(waves_[w], std::norm(rest[w]));
            return Layers{std::move(coarse), left};
        };
        for (int shift = 0; shift <= WaveBlock::shift_max; ++shift) {
            rest = all_of_it();
            coarse = layer(steps, shift, rest);
            if (bytes_of(coarse) <= coarse_bytes)
                break;
        }
        // A layer so coarse that all of it is 0 says nothing: then the fine one says it all.
        if (!coarse.empty() && coarse.front().block.shift == 0)
            return made();
        std::vector<Piece> fine = layer(steps, 0, rest);
        const auto most_first = [](const Piece& a, const Piece& b) {
            return a.worth() > b.worth();
        };
        std::stable_sort(coarse.begin(), coarse.end(), most_first);
        std::stable_sort(fine.begin(), fine.end(), most_first);
        coarse.insert(coarse.end(), fine.begin(), fine.end());
        return made();
    }

    void fill(QuantisedSpectrum& result) const {
        Layers made = layers(result.steps);
        // The second layer begins where the first has left it, and may end on the other side of what is wanted.
        double share = 0;
        for (int n = 0; n < tries && (share = share_of_wanted(made.left)) > 1.0; ++n) {
            const double finer_m = 0.99 / std::sqrt(share) * result.steps.step_m;
            if (finer_m < finest_m(result.steps.length_m))
                break;
            result.steps.step_m = finer_m;
            made = layers(result.steps);
        }
        const std::vector<Piece>& all = made.pieces;
        // From the end, so that what is left is a sum of small numbers and no difference of large ones.
        Noise left = made.left;
        result.left.resize(all.size());
        for (std::size_t n = all.size(); n-- > 0;) {
            result.left[n] = left.left();
            left += all[n].gained;
        }
        for (const Piece& piece : all) {
            result.blocks.push_back(piece.block);
            result.bits.push_back(piece.bits);
        }
        if (all.empty()) { // a block that says nothing, so that what is missed is told
            result.blocks.push_back(blocks_.front());
            result.left.push_back(left.left());
            result.bits.push_back(block_bits);
        }
    }

    const SpectrumAccuracy wanted_;
    const double sideways_;
    std::vector<WaveBlock> blocks_;
    std::vector<Wave> waves_;
    Noise whole_;
    double rms_slope_ = 0;
    double largest_m_ = 0;
    double shortest_radpm_ = 0;
};

} // namespace

QuantisedSpectrum quantise(const Realization& sea, const SpectrumAccuracy& wanted) {
    SEAWAY_CHECK(wanted.height_m > 0 && wanted.slope > 0, "an accuracy is above 0");
    return Quantiser(sea, wanted).best();
}

} // namespace seaway::sea
