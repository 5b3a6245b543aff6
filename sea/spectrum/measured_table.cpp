// SPDX-License-Identifier: Apache-2.0
// The tables of measured seas (sea/spectrum/measured.h).
#include <algorithm>
#include <cmath>
#include <complex>

#include <fmt/format.h>

#include "base/csv_table.h"
#include "sea/basics/constants.h"
#include "sea/spectrum/measured.h"

namespace seaway::sea {

namespace {

using Complex = std::complex<double>;

constexpr std::size_t bins_max = 4096;
constexpr std::size_t table_rows_max = 72 * 1024;

/// Waves of some hours and of a hand's breadth.
constexpr double frequency_min_hz = 1e-4;
constexpr double frequency_max_hz = 100.0;

/// Of a bin, at least this share must be its own; what bins overlap by less is left to the first.
constexpr double own_share_min = 0.4;
/// Edges closer than this share of a width are the same edge, rounded.
constexpr double same_edge = 1e-6;

constexpr const char* header_wanted =
    "f_hz, then df_hz or f_lo_hz,f_hi_hz, then s_m2_hz, then nothing or a1,b1 or a1,b1,a2,b2 or "
    "r1,alpha1_deg or r1,alpha1_deg,r2,alpha2_deg; or f_hz,dir_from_deg,e_m2_hz_deg";

/// The directional part of a table: which columns, over which angles.
struct Directions {
    enum class Kind { none, cartesian, polar } kind = Kind::none;
    std::vector<std::size_t> columns; ///< 2 or 4

    /// c_n over "towards, anticlockwise from east": phi = 270 degrees - bearing.
    static Complex turned(Complex from, int order) {
        return order == 1 ? Complex(-from.imag(), -from.real())
                          : Complex(-from.real(), from.imag());
    }
    Complex moment(const std::vector<double>& row, int order, CoefficientFrame frame) const {
        const auto first = static_cast<std::size_t>(2 * (order - 1));
        const double a = row[columns[first]];
        const double b = row[columns[first + 1]];
        if (kind == Kind::polar)
            return turned(std::polar(a, order * b * (pi / 180.0)), order);
        return frame == CoefficientFrame::from_clockwise_north ? turned({a, b}, order)
                                                               : Complex(a, b);
    }
};

struct BuoyColumns {
    std::size_t f, s;
    std::optional<std::size_t> df, f_lo, f_hi;
    Directions directions;
};

Result<BuoyColumns> buoy_columns(const CsvTable& table) {
    const auto all_of = [&](std::initializer_list<const char*> names) {
        std::vector<std::size_t> found;
        for (const char* name : names)
            if (const auto column = table.column(name))
                found.push_back(*column);
        return found.size() == names.size() ? found : std::vector<std::size_t>{};
    };
    BuoyColumns columns{};
    std::size_t named = 2;
    if (const auto width = all_of({"df_hz"}); !width.empty()) {
        columns.df = width[0];
        named += 1;
    } else if (const auto edges = all_of({"f_lo_hz", "f_hi_hz"}); !edges.empty()) {
        columns.f_lo = edges[0];
        columns.f_hi = edges[1];
        named += 2;
    }
    Directions& d = columns.directions;
    for (const auto& [kind, names] :
         {std::pair{Directions::Kind::cartesian, all_of({"a1", "b1", "a2", "b2"})},
          {Directions::Kind::cartesian, all_of({"a1", "b1"})},
          {Directions::Kind::polar, all_of({"r1", "alpha1_deg", "r2", "alpha2_deg"})},
          {Directions::Kind::polar, all_of({"r1", "alpha1_deg"})}})
        if (d.kind == Directions::Kind::none && !names.empty())
            d = {kind, names};
    named += d.columns.size();
    const auto f = table.column("f_hz"), s = table.column("s_m2_hz");
    if (!f || !s || (!columns.df && !columns.f_lo) || table.columns.size() != named)
        return Error{fmt::format("{}: the header must be {}", table.name, header_wanted)};
    columns.f = *f;
    columns.s = *s;
    return columns;
}

/// Reads rows into bins, and sees how the bins lie to each other.
class BuoyReader {
  public:
    BuoyReader(const CsvTable& table, const BuoyColumns& columns, CoefficientFrame frame)
        : table_(table), columns_(columns), frame_(frame) {}

    Result<MeasuredSpectrum> read() {
        spectrum_.quality.has_coefficients =
            columns_.directions.kind == Directions::Kind::cartesian;
        for (std::size_t r = 0; r < table_.rows.size(); ++r)
            SEAWAY_TRY(add(r));
        MeasuredQuality& quality = spectrum_.quality;
        if (m0_ > 0.0) {
            quality.overlapped_share = overlapped_m2_ / m0_;
            quality.gap_share = missing_m2_ / m0_;
        }
        return std::move(spectrum_);
    }

  private:
    Result<void> add(std::size_t r) {
        const std::vector<double>& row = table_.rows[r];
        const double f = row[columns_.f], s = row[columns_.s];
        const double lo = columns_.df ? f - 0.5 * row[*columns_.df] : row[*columns_.f_lo];
        const double hi = columns_.df ? f + 0.5 * row[*columns_.df] : row[*columns_.f_hi];
        if (!(lo > 0.0 && lo < f && f < hi && f >= frequency_min_hz && f <= frequency_max_hz &&
              hi < 2.0 * frequency_max_hz))
            return table_.error(r, fmt::format("f_hz = {}, bin {:g} .. {:g} Hz: a bin holds its "
                                               "frequency, {} .. {} Hz, and lies above 0 Hz",
                                               f, lo, hi, frequency_min_hz, frequency_max_hz));
        if (!(s >= 0.0 && s <= 1e6))
            return table_.error(r, fmt::format("s_m2_hz = {}; allowed: 0 .. 1e6", s));
        MeasuredBin bin{two_pi * lo, two_pi * hi, two_pi * f, s / two_pi, std::nullopt};
        SEAWAY_TRY(join(r, bin));
        m0_ += s * (hi - lo);
        return direct(r, bin);
    }

    /// Overlap and gap against the bin before. The energy of a bin stays s df, as its reporter
    /// sums it: where bins overlap the later one yields, and its density rises.
    Result<void> join(std::size_t r, MeasuredBin& bin) {
        if (spectrum_.bins.empty())
            return {};
        const MeasuredBin& before = spectrum_.bins.back();
        const double width = bin.omega_hi_radps - bin.omega_lo_radps;
        const double gap = bin.omega_lo_radps - before.omega_hi_radps;
        const double energy = 0.5 * std::abs(gap) * (bin.density + before.density);
        MeasuredQuality& quality = spectrum_.quality;
        if (gap > same_edge * width) {
            ++quality.gaps;
            missing_m2_ += energy;
            if (gap > two_pi * (quality.widest_gap_hi_hz - quality.widest_gap_lo_hz)) {
                quality.widest_gap_lo_hz = before.omega_hi_radps / two_pi;
                quality.widest_gap_hi_hz = bin.omega_lo_radps / two_pi;
            }
            return {};
        }
        const double left = width + gap;
        if (!(left > own_share_min * width) || !(bin.omega_mid_radps > before.omega_mid_radps))
            return table_.error(r, fmt::format("f_hz = {}: frequencies must ascend and bins must "
                                               "not cover each other",
                                               table_.rows[r][columns_.f]));
        if (gap < -same_edge * width) {
            ++quality.overlaps;
            overlapped_m2_ += energy;
        }
        bin.omega_lo_radps = before.omega_hi_radps;
        bin.density *= width / left;
        return {};
    }

    Result<void> direct(std::size_t r, MeasuredBin& bin) {
        const Directions& d = columns_.directions;
        if (d.kind != Directions::Kind::none) {
            const bool both = d.columns.size() == 4;
            const Complex c1 = d.moment(table_.rows[r], 1, frame_);
            const std::optional<Complex> c2 =
                both ? std::optional(d.moment(table_.rows[r], 2, frame_)) : std::nullopt;
            if (!(std::abs(c1) <= 2.0) || (both && !(std::abs(*c2) <= 2.0)))
                return table_.error(r, d.kind == Directions::Kind::polar
                                           ? "r1 and r2 are within 0 .. 1 (files of a whole month "
                                             "or year hold hundredths)"
                                           : "a1, b1, a2, b2 are Fourier coefficients, within "
                                             "-1 .. 1");
            if (bin.density > 0.0 && c1 == Complex{} && c2.value_or(Complex{}) == Complex{})
                ++spectrum_.quality.undirected_bins;
            bin.directions = MeasuredDirections::from_moments(c1, c2);
            spectrum_.quality.changed_bins += bin.directions->changed();
        }
        spectrum_.bins.push_back(std::move(bin));
        return {};
    }

    const CsvTable& table_;
    const BuoyColumns& columns_;
    CoefficientFrame frame_;
    MeasuredSpectrum spectrum_;
    double m0_ = 0.0;
    double overlapped_m2_ = 0.0;
    double missing_m2_ = 0.0;
};

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

void note_spreads(std::size_t directions, MeasuredSpectrum& spectrum) {
    double m0 = 0.0;
    std::complex<double> moment{};
    for (const MeasuredBin& bin : spectrum.bins) {
        const double energy = bin.density * (bin.omega_hi_radps - bin.omega_lo_radps);
        m0 += energy;
        moment += energy * bin.directions->first_moment();
    }
    if (!(m0 > 0.0))
        return;
    const auto spread = [](double r1) { return std::sqrt(2.0 * std::max(1.0 - r1, 0.0)); };
    const double r1 = std::abs(moment) / m0;
    spectrum.quality.spread_read_rad = spread(r1);
    spectrum.quality.spread_of_rows_rad = spread(r1 / MeasuredDirections::lines_share(directions));
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
        if (!(before < here && here < after && here >= frequency_min_hz &&
              after < frequency_max_hz))
            return table.error(first, fmt::format("f_hz must ascend, {} .. {} Hz", frequency_min_hz,
                                                  frequency_max_hz));
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
                        two_pi * here, sum * *step / two_pi, std::nullopt};
        const double last_from = table.rows[first + count - 1][dir];
        if (!(sum > 0.0))
            density.assign(count, 1.0);
        bin.directions =
            MeasuredDirections::from_table((270.0 - last_from) * (pi / 180.0), std::move(density));
        spectrum.bins.push_back(std::move(bin));
    }
    note_spreads(count, spectrum);
    return spectrum;
}

} // namespace

Result<MeasuredSpectrum> parse_measured(std::string_view csv, const std::string& name,
                                        CoefficientFrame frame) {
    const Result<CsvTable> table = parse_csv(csv, name, table_rows_max);
    if (!table)
        return table.error();
    if (table->column("f_hz") && table->column("dir_from_deg") && table->column("e_m2_hz_deg"))
        return from_directions(*table);
    const Result<BuoyColumns> columns = buoy_columns(*table);
    if (!columns)
        return columns.error();
    if (table->rows.size() > bins_max)
        return Error{fmt::format("{}: more than {} frequencies", name, bins_max)};
    return BuoyReader(*table, *columns, frame).read();
}

} // namespace seaway::sea
