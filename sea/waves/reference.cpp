// SPDX-License-Identifier: Apache-2.0
#include "sea/waves/reference.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "sea/basics/constants.h"
#include "sea/basics/field.h"

namespace seaway::sea {

namespace {

using Complex = std::complex<double>;

/// x / length in turns, 0.64 fixed point, rounded once.
std::uint64_t turns_of(double x_m, double length_m) {
    const double rest_m = std::remainder(x_m, length_m);
    const double turns = rest_m / length_m;
    const double coarse = std::nearbyint(turns * 0x1p32);
    const double fine = (turns - coarse * 0x1p-32) + std::fma(-turns, length_m, rest_m) / length_m;
    return (static_cast<std::uint64_t>(static_cast<std::int64_t>(coarse)) << 32) +
           static_cast<std::uint64_t>(std::llrint(fine * 0x1p64));
}

/// Takes the wave at (nx, ny) into a lane; false: it carries nothing.
bool take(const CascadeModes& cascade, int nx, int ny, int lane, SpectrumBlock& block,
          std::uint8_t& given) {
    const int size = cascade.spec.size;
    const auto index = [size](int x, int y) {
        return static_cast<std::size_t>((y + size) % size * size + (x + size) % size);
    };
    const std::size_t i = index(nx, ny), opposite = index(-nx, -ny);
    const Complex h0 = cascade.h0[i], h0_opposite = cascade.h0[opposite];
    if (h0 == Complex{} && h0_opposite == Complex{})
        return false;
    block.h0[0].at[lane] = h0.real();
    block.h0[1].at[lane] = h0.imag();
    block.h0_opposite[0].at[lane] = h0_opposite.real();
    block.h0_opposite[1].at[lane] = h0_opposite.imag();
    block.rate[lane] = cascade.rate[i];
    block.omega_radps.at[lane] = omega_from_rate(cascade.rate[i]);
    if (cascade.is_given(i) || cascade.is_given(opposite))
        given = static_cast<std::uint8_t>(given | 1u << lane);
    return true;
}

/// exp(i 2 pi n / count), exactly periodic.
std::vector<Complex> circle_of(int count) {
    std::vector<Complex> circle;
    for (int n = 0; n < count; ++n) {
        const double phase = two_pi * n / count;
        circle.emplace_back(std::cos(phase), std::sin(phase));
    }
    return circle;
}

} // namespace

const WaveSums& wave_sums(Instructions instructions) {
#if defined(SEAWAY_X86)
    switch (instructions) {
    case Instructions::portable:
        break;
    case Instructions::avx2:
        return wave_sums_avx2();
    case Instructions::avx512:
        return wave_sums_avx512();
    }
#else
    SEAWAY_CHECK(instructions == Instructions::portable, "no other loops are built");
#endif
    return wave_sums_portable();
}

DirectSum::DirectSum(RealizationPtr sea, WaveGrowth growth, Instructions instructions)
    : sea_(std::move(sea)), growth_(std::move(growth)), sums_(&wave_sums(instructions)) {
    SEAWAY_CHECK(sea_ != nullptr, "direct sum of no sea");
    SEAWAY_CHECK(!growth_.waves || growth_.waves->cascades.size() == sea_->cascades.size(),
                 "what a sea grows by stands on its tiles");
    for (std::size_t c = 0; c < sea_->cascades.size(); ++c)
        add_cascade(sea_->cascades[c], growth_.waves ? &growth_.waves->cascades[c] : nullptr);
}

void DirectSum::add_cascade(const CascadeModes& cascade, const CascadeModes* growth) {
    const int size = cascade.spec.size;
    const double step = cascade.spec.wavenumber_step_radpm();
    Tile& tile =
        tiles_.emplace_back(Tile{cascade.spec.length_m, {}, {}, circle_of(2 * cascade.spec.size)});
    int blocks = 0; // along an axis
    int next = 0;   // nx after the last block that is held
    for (int ny = 0; ny < size / 2; ++ny)
        for (int first = 0; first < size / 2; first += sum_lanes) {
            if (!add_block(cascade, growth, first, ny))
                continue;
            const std::size_t block = spectrum_.size() - 1;
            if (tile.runs.empty() || tile.runs.back().ny != ny || next != first)
                tile.runs.push_back({ny, first, block, block, step * ny});
            tile.runs.back().end = block + 1;
            next = first + sum_lanes;
            blocks = std::max({blocks, first / sum_lanes + 1, ny / sum_lanes + 1});
        }
    tile.kx_radpm.resize(static_cast<std::size_t>(blocks));
    for (int nx = 0; nx < blocks * sum_lanes; ++nx)
        tile.kx_radpm[static_cast<std::size_t>(nx / sum_lanes)].at[nx % sum_lanes] = step * nx;
}

/// Eight pairs from nx = first on; false: none carries anything.
bool DirectSum::add_block(const CascadeModes& cascade, const CascadeModes* growth, int first,
                          int ny) {
    Given given{};
    bool carries = false;
    const auto taken = [&](const CascadeModes& from) {
        PairSpectrum block{};
        for (int lane = 0; lane < sum_lanes; ++lane) {
            const int nx = first + lane;
            if (nx > 0 || ny > 0)
                carries |= take(from, nx, ny, lane, block.east, given.east);
            if (nx > 0 && ny > 0)
                carries |= take(from, -nx, ny, lane, block.west, given.west);
        }
        return block;
    };
    const PairSpectrum block = taken(cascade);
    const PairSpectrum grown = growth ? taken(*growth) : PairSpectrum{};
    if (!carries)
        return false;
    spectrum_.push_back(block);
    if (growth)
        grown_.push_back(grown);
    given_.push_back(given);
    Lanes& over_k_m = displacement_over_k_m_.emplace_back();
    const double step = cascade.spec.wavenumber_step_radpm();
    for (int lane = 0; lane < sum_lanes; ++lane)
        if (first + lane > 0 || ny > 0)
            over_k_m.at[lane] = cascade.displacement_over_k(step * std::hypot(first + lane, ny));
    return true;
}

DirectSum::Moment DirectSum::at_time(TimeUs time_us, std::uint32_t cascades) const {
    Moment moment;
    moment.sum_ = this;
    moment.height_.resize(spectrum_.size());
    moment.rate_.resize(spectrum_.size());
    moment.phase_time_ = sea_->phase_time(time_us);
    moment.cascades_ = cascades;
    for (std::size_t t = 0; t < tiles_.size(); ++t) {
        if (!moment.has(t) || tiles_[t].runs.empty())
            continue;
        const std::size_t begin = tiles_[t].runs.front().begin;
        const std::size_t count = tiles_[t].runs.back().end - begin;
        sums_->evolve(spectrum_.data() + begin, count, moment.phase_time_,
                      moment.height_.data() + begin, moment.rate_.data() + begin);
        if (!grown_.empty())
            moment.add_growth(begin, count);
    }
    return moment;
}

void DirectSum::Moment::add_growth(std::size_t begin, std::size_t count) {
    std::vector<PairBlock> more(count), unused(count);
    sum_->sums_->evolve(sum_->grown_.data() + begin, count, phase_time_, more.data(),
                        unused.data());
    const double per_s = sum_->growth_.per_s;
    for (std::size_t b = 0; b < count; ++b)
        for (int i = 0; i < 2; ++i)
            for (int lane = 0; lane < sum_lanes; ++lane) {
                rate_[begin + b].even[i].at[lane] += per_s * more[b].even[i].at[lane];
                rate_[begin + b].odd[i].at[lane] += per_s * more[b].odd[i].at[lane];
            }
}

TileWaves DirectSum::Moment::waves(std::size_t tile) const {
    const Tile& t = sum_->tiles_[tile];
    return {t.runs.data(), has(tile) ? t.runs.size() : 0,       height_.data(),
            rate_.data(),  sum_->displacement_over_k_m_.data(), t.kx_radpm.data()};
}

bool DirectSum::Moment::moves_sideways() const {
    for (std::size_t t = 0; t < sum_->tiles_.size(); ++t)
        if (has(t) && !sum_->sea_->cascades[t].sines.empty())
            return false;
    return true;
}

LagrangianPoint DirectSum::Moment::at(double x_m, double y_m) const {
    LagrangianPoint point;
    if (!std::isfinite(x_m) || !std::isfinite(y_m)) {
        for (const Field field : linear_fields)
            point.*info(field).at_point = std::numeric_limits<double>::quiet_NaN();
        return point;
    }
    for (std::size_t t = 0; t < sum_->tiles_.size(); ++t) {
        if (!has(t))
            continue;
        add(t, waves(t), x_m, y_m, point);
        for (const SineField& field : sum_->sea_->cascades[t].sines) {
            const LagrangianPoint sines = sines_at(field, x_m, y_m, phase_time_);
            point.height += sines.height;
            point.height_rate += sines.height_rate;
            point.slope_x += sines.slope_x;
            point.slope_y += sines.slope_y;
        }
        if (const Realization* growth = sum_->growth_.waves.get())
            for (const SineField& field : growth->cascades[t].sines)
                point.height_rate +=
                    sum_->growth_.per_s * sines_at(field, x_m, y_m, phase_time_).height;
    }
    return point;
}

void DirectSum::Moment::add(std::size_t tile, const TileWaves& waves, double x_m, double y_m,
                            LagrangianPoint& point) const {
    const Tile& t = sum_->tiles_[tile];
    const std::size_t blocks = t.kx_radpm.size();
    std::vector<Turns> east(blocks), north(blocks);
    sum_->sums_->turns(turns_of(x_m, t.length_m), blocks, east.data());
    sum_->sums_->turns(turns_of(y_m, t.length_m), blocks, north.data());
    sum_->sums_->point(waves, east.data(), north.data(), point);
}

} // namespace seaway::sea
