// SPDX-License-Identifier: Apache-2.0
#include "sea/spectrum/measured.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/csv_table.h"
#include "sea/basics/constants.h"

namespace seaway::sea {

namespace {

using Complex = std::complex<double>;

/// How close to a single direction coefficients may come: beyond, the maximum entropy form has
/// peaks that no lattice resolves.
constexpr double first_moment_max = 0.999;
constexpr double second_moment_share_max = 0.98;

constexpr std::size_t bins_max = 4096;
constexpr std::size_t table_rows_max = 72 * 1024;

/// c_n over "towards, anticlockwise from east" of a_n + i b_n over "from, clockwise from north":
/// phi = 270 degrees - bearing.
Complex towards_first(double a1, double b1) {
    return {-b1, -a1};
}
Complex towards_second(double a2, double b2) {
    return {-a2, b2};
}

} // namespace

MeasuredDirections MeasuredDirections::from_moments(Complex c1, std::optional<Complex> c2) {
    MeasuredDirections d;
    if (std::abs(c1) > first_moment_max) {
        c1 *= first_moment_max / std::abs(c1);
        d.changed_ = true;
    }
    d.c1_ = c1;
    if (!c2) {
        const double r1 = std::abs(c1);
        d.beam_ = Spreading::power(r1 / (1.0 - r1)); // r1 = s / (s + 1)
        const double s = d.beam_->exponent();
        const Complex direction = r1 > 0.0 ? c1 / r1 : Complex(1.0);
        d.c2_ = direction * direction * (s * (s - 1.0) / ((s + 1.0) * (s + 2.0)));
        return d;
    }
    // |c2 - c1^2| <= 1 - |c1|^2 is what a density that is nowhere negative obeys.
    const double room = second_moment_share_max * (1.0 - std::norm(c1));
    const Complex excess = *c2 - c1 * c1;
    if (std::abs(excess) > room) {
        c2 = c1 * c1 + excess * (room / std::abs(excess));
        d.changed_ = true;
    }
    d.c2_ = *c2;
    d.phi1_ = (c1 - *c2 * std::conj(c1)) / (1.0 - std::norm(c1));
    d.phi2_ = *c2 - c1 * d.phi1_;
    d.scale_ = (1.0 - d.phi1_ * std::conj(c1) - d.phi2_ * std::conj(*c2)).real() / two_pi;
    return d;
}

MeasuredDirections MeasuredDirections::from_table(double first_rad, std::vector<double> density) {
    MeasuredDirections d;
    d.first_rad_ = first_rad;
    const auto count = static_cast<double>(density.size());
    double sum = 0.0;
    for (const double value : density)
        sum += value;
    for (double& value : density)
        value *= count / (two_pi * sum);
    d.table_ = std::move(density);
    // Moments of the straight lines between the entries: the entries' own, times sinc^2.
    const double step = two_pi / count;
    for (std::size_t i = 0; i < d.table_.size(); ++i) {
        const double angle = first_rad + static_cast<double>(i) * step;
        d.c1_ += std::polar(d.table_[i] * step, angle);
        d.c2_ += std::polar(d.table_[i] * step, 2.0 * angle);
    }
    const double sinc1 = std::sin(0.5 * step) / (0.5 * step);
    const double sinc2 = std::sin(step) / step;
    d.c1_ *= sinc1 * sinc1;
    d.c2_ *= sinc2 * sinc2;
    return d;
}

double MeasuredDirections::operator()(double towards_rad) const {
    if (beam_)
        return (*beam_)(towards_rad - std::arg(c1_));
    if (table_.empty()) {
        const Complex turn{std::cos(towards_rad), -std::sin(towards_rad)};
        return scale_ / std::norm(1.0 - turn * (phi1_ + turn * phi2_));
    }
    const auto count = static_cast<double>(table_.size());
    const double turns = (towards_rad - first_rad_) / two_pi;
    const double place = std::min((turns - std::floor(turns)) * count, count);
    const auto i = static_cast<std::size_t>(place) % table_.size();
    const double share = place - std::floor(place);
    return (1.0 - share) * table_[i] + share * table_[(i + 1) % table_.size()];
}

const MeasuredBin* MeasuredSpectrum::find(double omega_radps) const {
    const auto after = std::upper_bound(
        bins.begin(), bins.end(), omega_radps,
        [](double omega, const MeasuredBin& bin) { return omega < bin.omega_lo_radps; });
    if (after == bins.begin() || omega_radps >= std::prev(after)->omega_hi_radps)
        return nullptr;
    return &*std::prev(after);
}

double MeasuredSpectrum::peak_omega_radps() const {
    const auto highest =
        std::max_element(bins.begin(), bins.end(), [](const MeasuredBin& a, const MeasuredBin& b) {
            return a.density < b.density;
        });
    if (highest == bins.end() || !(highest->density > 0.0))
        return 0.0;
    return 0.5 * (highest->omega_lo_radps + highest->omega_hi_radps);
}

namespace {

Result<MeasuredSpectrum> from_buoy(const CsvTable& table) {
    const auto a1 = table.column("a1"), b1 = table.column("b1");
    const auto a2 = table.column("a2"), b2 = table.column("b2");
    const std::size_t named =
        3 + (a1.has_value() + b1.has_value() + a2.has_value() + b2.has_value());
    if (table.columns.size() != named || a1.has_value() != b1.has_value() ||
        a2.has_value() != b2.has_value() || (a2 && !a1))
        return Error{table.name + ": columns must be f_hz,df_hz,s_m2_hz[,a1,b1[,a2,b2]]"};
    const std::size_t f = *table.column("f_hz");
    const std::size_t df = *table.column("df_hz");
    const std::size_t s = *table.column("s_m2_hz");
    MeasuredSpectrum spectrum;
    for (std::size_t r = 0; r < table.rows.size(); ++r) {
        const std::vector<double>& row = table.rows[r];
        if (!(row[f] > 0.0 && row[f] <= 100.0 && row[df] > 0.0 && row[df] < 2.0 * row[f]))
            return table.error(r, fmt::format("f_hz = {}, df_hz = {}: a bin lies above 0 Hz and "
                                              "below 100 Hz",
                                              row[f], row[df]));
        if (!(row[s] >= 0.0 && row[s] <= 1e6))
            return table.error(r, fmt::format("s_m2_hz = {}; allowed: 0 .. 1e6", row[s]));
        MeasuredBin bin{two_pi * (row[f] - 0.5 * row[df]), two_pi * (row[f] + 0.5 * row[df]),
                        row[s] / two_pi, std::nullopt};
        // Neighbours of different width are often reported with centres that overlap a little: the
        // later bin yields, and its density rises so that its energy stays.
        if (!spectrum.bins.empty() && bin.omega_lo_radps < spectrum.bins.back().omega_hi_radps) {
            const double width = bin.omega_hi_radps - bin.omega_lo_radps;
            bin.omega_lo_radps = spectrum.bins.back().omega_hi_radps;
            const double left = bin.omega_hi_radps - bin.omega_lo_radps;
            if (!(left > 0.4 * width))
                return table.error(r, fmt::format("f_hz = {}: frequencies must ascend and bins "
                                                  "must not cover each other",
                                                  row[f]));
            bin.density *= width / left;
        }
        if (a1) {
            if (!(std::hypot(row[*a1], row[*b1]) <= 2.0) ||
                (a2 && !(std::hypot(row[*a2], row[*b2]) <= 2.0)))
                return table.error(r, "a1, b1, a2, b2 are Fourier coefficients, within -1 .. 1");
            bin.directions = MeasuredDirections::from_moments(
                towards_first(row[*a1], row[*b1]),
                a2 ? std::optional(towards_second(row[*a2], row[*b2])) : std::nullopt);
            spectrum.changed_bins += bin.directions->changed();
        }
        spectrum.bins.push_back(std::move(bin));
    }
    return spectrum;
}

/// Checks that rows first .. first + count are one frequency with directions in equal steps; gives
/// the step in degrees.
Result<double> direction_step(const CsvTable& table, std::size_t first, std::size_t count,
                              std::size_t f, std::size_t dir) {
    const double step = 360.0 / static_cast<double>(count);
    for (std::size_t i = 0; i < count; ++i) {
        const double expected = table.rows[first][dir] + static_cast<double>(i) * step;
        if (table.rows[first + i][f] != table.rows[first][f] ||
            !(std::abs(std::remainder(table.rows[first + i][dir] - expected, 360.0)) < 1e-3))
            return table.error(first + i, "every frequency needs the same directions, in equal "
                                          "ascending steps around the full circle");
    }
    return step;
}

Result<MeasuredSpectrum> from_directions(const CsvTable& table) {
    const std::size_t f = *table.column("f_hz");
    const std::size_t dir = *table.column("dir_from_deg");
    const std::size_t e = *table.column("e_m2_hz_deg");
    const std::size_t rows = table.rows.size();
    std::size_t count = 1;
    while (count < rows && table.rows[count][f] == table.rows[0][f])
        ++count;
    if (table.columns.size() != 3 || count < 4 || rows % count != 0 || rows / count < 2)
        return Error{table.name + ": columns must be f_hz,dir_from_deg,e_m2_hz_deg, with at least "
                                  "2 frequencies of at least 4 directions each"};
    MeasuredSpectrum spectrum;
    const std::size_t bins = rows / count;
    for (std::size_t b = 0; b < bins; ++b) {
        const std::size_t first = b * count;
        const Result<double> step = direction_step(table, first, count, f, dir);
        if (!step)
            return step.error();
        const double here = table.rows[first][f];
        const double before =
            b > 0 ? table.rows[first - count][f] : here - (table.rows[first + count][f] - here);
        const double after = b + 1 < bins ? table.rows[first + count][f] : here + (here - before);
        if (!(before < here && here < after && here > 0.0 && after < 100.0))
            return table.error(first, "f_hz must ascend, above 0 Hz and below 100 Hz");
        // The table turns clockwise in "from"; ours anticlockwise in "towards": last row first.
        std::vector<double> density(count);
        double sum = 0.0;
        for (std::size_t i = 0; i < count; ++i) {
            const double value = table.rows[first + i][e];
            if (!(value >= 0.0 && value <= 1e6))
                return table.error(first + i,
                                   fmt::format("e_m2_hz_deg = {}; allowed: 0 .. 1e6", value));
            density[count - 1 - i] = value;
            sum += value;
        }
        MeasuredBin bin{two_pi * std::max(0.5 * (before + here), 0.0), pi * (here + after),
                        sum * *step / two_pi, std::nullopt};
        const double last_from = table.rows[first + count - 1][dir];
        if (!(sum > 0.0))
            density.assign(count, 1.0);
        bin.directions =
            MeasuredDirections::from_table((270.0 - last_from) * (pi / 180.0), std::move(density));
        spectrum.bins.push_back(std::move(bin));
    }
    return spectrum;
}

} // namespace

Result<MeasuredSpectrum> parse_measured(std::string_view csv, const std::string& name) {
    const Result<CsvTable> table = parse_csv(csv, name, table_rows_max);
    if (!table)
        return table.error();
    if (table->column("f_hz") && table->column("dir_from_deg") && table->column("e_m2_hz_deg"))
        return from_directions(*table);
    if (!table->column("f_hz") || !table->column("df_hz") || !table->column("s_m2_hz"))
        return Error{name + ": the header must be f_hz,df_hz,s_m2_hz[,a1,b1[,a2,b2]] or "
                            "f_hz,dir_from_deg,e_m2_hz_deg"};
    if (table->rows.size() > bins_max)
        return Error{fmt::format("{}: more than {} frequencies", name, bins_max)};
    return from_buoy(*table);
}

} // namespace seaway::sea
