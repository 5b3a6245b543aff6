// SPDX-License-Identifier: Apache-2.0
#include "sea/certificate/certificate.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "base/check.h"
#include "base/hash.h"
#include "base/text_file.h"

namespace seaway::sea {

namespace {

/// Figures of a sea come from quadratures and a search for a peak: the same scene on another machine
/// differs in last digits.
constexpr double rounding_share = 1e-3;

/// The members of a sea point, with what people call them.
struct Quantity {
    const char* name;
    const char* unit;
    double SeaPoint::*value;
};
constexpr Quantity quantities[] = {{"Hs", " m", &SeaPoint::hs_m},
                                   {"Tp", " s", &SeaPoint::tp_s},
                                   {"depth", " m", &SeaPoint::depth_m},
                                   {"choppiness", "", &SeaPoint::choppiness},
                                   {"wind", " m/s", &SeaPoint::wind_speed_10m_mps}};

bool outside(double value, double low, double high) {
    return value < low * (1.0 - rounding_share) || value > high * (1.0 + rounding_share);
}

} // namespace

std::string metres(double value_m) {
    if (value_m >= 1.0)
        return fmt::format("{:.3g} m", value_m);
    return value_m >= 0.01 ? fmt::format("{:.3g} cm", 100.0 * value_m)
                           : fmt::format("{:.3g} mm", 1000.0 * value_m);
}

SeaPoint sea_point(const Scene& scene, const SeaStatistics& requested) {
    const Choppiness& choppiness = scene.sea.choppiness;
    SeaPoint point{requested.significant_height_m, requested.peak_period_s, scene.sea.depth_m,
                   scene.effects.choppy ? choppiness.largest() : 0.0, 0.0};
    for (const WaveSystem& system : scene.sea.systems)
        if (const auto* wind = std::get_if<WindSea>(&system))
            point.wind_speed_10m_mps = std::max(point.wind_speed_10m_mps, wind->wind_speed_10m_mps);
    return point;
}

void Envelope::add(const SeaPoint& sea) {
    for (const Quantity& q : quantities) {
        low.*q.value = std::min(low.*q.value, sea.*q.value);
        high.*q.value = std::max(high.*q.value, sea.*q.value);
    }
}

Envelope envelope_of(const SeaPoint& sea) {
    return {sea, sea};
}

const MeasuredError& Certificate::worst() const {
    SEAWAY_CHECK(!measured.empty(), "a certificate has measurements");
    return *std::max_element(
        measured.begin(), measured.end(),
        [](const MeasuredError& a, const MeasuredError& b) { return a.total_m < b.total_m; });
}

std::string configuration_hash(const Scene& scene) {
    std::string text;
    for (const CascadeSpec& cascade : scene.cascades)
        text += fmt::format("{}/{} ", cascade.length_m, cascade.size);
    return hex_hash(text + fmt::format("{} {} {}", scene.accuracy.height_error_m,
                                       scene.accuracy.streams(), scene.effects.choppy));
}

std::string spectrum_hash(const Scene& scene) {
    Scene sea_alone;
    sea_alone.sea = scene.sea;
    sea_alone.sea.seed = 0;
    return hex_hash(to_toml(sea_alone));
}

Result<CertificatePtr> load_certificate(const Scene& scene) {
    const CertificateFile& file = scene.accuracy.certificate;
    if (file.name.empty())
        return CertificatePtr();
    const Result<std::string> text = read_text_file(file.path, certificate_bytes_max);
    if (!text)
        return Error{fmt::format("{}: accuracy.certificate: cannot read '{}': {}", scene.source,
                                 file.name, text.error().message)};
    Result<Certificate> certificate = parse_certificate(*text, file.name);
    if (!certificate)
        return Error{
            fmt::format("{}: accuracy.certificate: {}", scene.source, certificate.error().message)};
    return std::make_shared<const Certificate>(*std::move(certificate));
}

std::string describe(const Certificate& certificate) {
    const MeasuredError& worst = certificate.worst();
    return fmt::format(
        "{} at p{:g}, measured {} (rms {}, of which maps {} and waves left out {}) in "
        "the worst of {} seas, by seaway-bench tune of {} on {}, {}",
        metres(certificate.promised_m), certificate.percentile, metres(worst.total_m),
        metres(worst.total_rms_m), metres(worst.rms_m), metres(worst.waves_left_out_m),
        certificate.measured.size(), certificate.commit, certificate.machine, certificate.date_utc);
}

std::vector<std::string> certificate_warnings(const Certificate& certificate, const Scene& scene,
                                              const SeaStatistics& requested) {
    std::vector<std::string> warnings;
    const std::string& name = scene.accuracy.certificate.name;
    if (const std::string hash = configuration_hash(scene); hash != certificate.configuration_hash)
        warnings.push_back(
            fmt::format("{} certifies another configuration ({}, this one is {}): tiles, "
                        "height_error_m, streams or displacement were changed; what it promises "
                        "was not measured of this one",
                        name, certificate.configuration_hash, hash));
    const SeaPoint here = sea_point(scene, requested);
    const SeaPoint &low = certificate.envelope.low, &high = certificate.envelope.high;
    for (const Quantity& q : quantities)
        if (outside(here.*q.value, low.*q.value, high.*q.value))
            warnings.push_back(fmt::format(
                "the sea is outside of what {} certifies: {} {:.4g}{}, measured {:.4g} .. {:.4g}{}",
                name, q.name, here.*q.value, q.unit, low.*q.value, high.*q.value, q.unit));
    return warnings;
}

} // namespace seaway::sea
