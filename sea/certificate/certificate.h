// SPDX-License-Identifier: Apache-2.0
// A certificate: what was measured of one configuration in one range of seas, and where. `seaway-bench
// tune` writes it beside a scene that names it (accuracy.certificate); who runs the scene reads it, says
// what it promises, and warns where the sea or the configuration is not the one that was measured.
//
// JSON with a checksum of its own content, which finds slips of a hand, not malice. docs/accuracy.md
// shows one. Pure functions but for load_certificate(), which reads a file; thread-safe.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "sea/scene/scene.h"
#include "sea/waves/statistics/moments.h"

namespace seaway::sea {

/// "3.78 cm": in the unit in which it is read most easily.
std::string metres(double value_m);

/// A sea in the terms of an envelope.
struct SeaPoint {
    double hs_m;
    double tp_s;
    double depth_m;            ///< infinite: deep water
    double choppiness;         ///< the larger one; 0 where nothing moves sideways
    double wind_speed_10m_mps; ///< the strongest wind that raises waves; 0: none does
};
SeaPoint sea_point(const Scene& scene, const SeaStatistics& requested);

/// From the smallest to the largest of the seas that were measured.
struct Envelope {
    SeaPoint low;
    SeaPoint high;
    void add(const SeaPoint& sea);
};
Envelope envelope_of(const SeaPoint& sea);

/// One sea that was measured.
struct MeasuredError {
    std::string sea; ///< "as given", "rougher", "calmer"
    std::uint64_t seed = 0;
    double hs_m = 0;
    /// Of heights against the waves that the tiles hold: rms, 99th percentile, largest.
    double rms_m = 0;
    double p99_m = 0;
    double max_m = 0;
    double waves_left_out_m = 0; ///< rms of what no tile holds
    double total_rms_m = 0;      ///< both together
    double total_m = 0;          ///< both together, at the percentile of the promise
    double slope_rms = 0;        ///< against the waves that the tiles hold
};

struct Certificate {
    // What it is of.
    std::vector<CascadeSpec> cascades;
    double height_error_m = 0;
    bool streams = true;
    std::string configuration_hash;
    std::string spectrum_hash;
    Envelope envelope{};

    // What it promises: `percentile` percent of points and times are no further off.
    double promised_m = 0;
    double percentile = 99;
    std::optional<double> promised_slope = {};

    // What was measured. Costs by name, the unit last in it.
    std::vector<MeasuredError> measured;
    std::optional<double> beside_finer_waves_m =
        {}; ///< at the percentile, against a sum of shorter waves too
    std::vector<std::pair<std::string, double>> costs;
    std::vector<std::string> runners_up;

    // Where.
    std::string machine;
    std::string device;
    std::string driver;
    std::string compiler;
    std::string commit;
    std::string date_utc;
    std::string command;

    /// The worst of `measured`.
    const MeasuredError& worst() const;
};

using CertificatePtr = std::shared_ptr<const Certificate>;

/// Of what decides how accurate a scene's sea is, apart from the sea: tiles, budget, streams. 16
/// hexadecimal digits.
std::string configuration_hash(const Scene& scene);
/// Of the sea without its seed.
std::string spectrum_hash(const Scene& scene);

std::string to_json(const Certificate& certificate);
/// Errors name the key: missing, of another type, out of range; a checksum that does not fit.
Result<Certificate> parse_certificate(const std::string& text, const std::string& name);

inline constexpr std::size_t certificate_bytes_max = 1u << 20;

/// The certificate that a scene names; null where it names none.
Result<CertificatePtr> load_certificate(const Scene& scene);

/// "5 cm at p99 ...": what is promised, what was measured, by what and when. One line.
std::string describe(const Certificate& certificate);

/// Where the scene is not what was measured: another configuration, a sea outside of the envelope. One
/// sentence each, none if the certificate holds.
std::vector<std::string> certificate_warnings(const Certificate& certificate, const Scene& scene,
                                              const SeaStatistics& requested);

} // namespace seaway::sea
