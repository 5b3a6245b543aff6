// SPDX-License-Identifier: Apache-2.0
// Spectra as the US National Data Buoy Center publishes them, as text: one file a quantity
// (.data_spec, .swdir, .swdir2, .swr1, .swr2 of the last 45 days; or the files w, d, i, j, k of a
// month or a year), one line a record.
//
//   last 45 days   #YY  MM DD hh mm Sep_Freq  < spec_1 (freq_1) spec_2 (freq_2) ... >
//                  2014 09 11 17 00 0.176 0.000 (0.033) 0.153 (0.038) ...
//                  (the other four without Sep_Freq; newest first)
//   archived       #YY  MM DD hh mm   .0200  .0325 ...   one column a frequency
//                  2023 01 01 00 40    0.00   0.21 ...   r1 and r2 in hundredths
//
// Density in m2/Hz; alpha1 and alpha2 are degrees clockwise from north that waves come from;
// D(A) = (1/pi) (1/2 + r1 cos(A - alpha1) + r2 cos 2(A - alpha2)). Missing: MM; 999 and 9999, however
// many zeros follow, but in densities of the last 45 days, which may be as large. Source: NDBC, "Measurement Descriptions and Units".
//
// Pure functions; thread-safe.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"

namespace seaway::sea {

/// One file's contents and the name that errors quote.
struct NdbcText {
    std::string text;
    std::string name;
};

/// Directions: all four, or alpha1 and r1, or none.
struct NdbcTexts {
    NdbcText density;
    std::optional<NdbcText> alpha1, alpha2, r1, r2;
};

/// A year of records of 47 frequencies is 3 MB.
inline constexpr std::size_t ndbc_bytes_max = 16u << 20;

/// Does the text begin as one of these files does (#YY, YY or YYYY, then MM)?
bool is_ndbc(std::string_view text);

/// One record as a table that parse_measured() reads: f_hz,f_lo_hz,f_hi_hz,s_m2_hz and the polar
/// columns. Bins meet halfway between neighbouring frequencies: the files do not say their widths.
/// A frequency whose directions are missing has r1 = r2 = 0. `time_utc` is YYYY-MM-DDThh:mm; empty:
/// the newest record. Errors name the file: no such record, a density that is missing, frequencies
/// that differ between files.
Result<std::string> ndbc_to_csv(const NdbcTexts& texts, const std::string& time_utc);

} // namespace seaway::sea
