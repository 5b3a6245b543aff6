// SPDX-License-Identifier: Apache-2.0
#include "tools/inspect/report.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "sea/scene/presets.h"
#include "sea/scene/scene_names.h"
#include "sea/scene/scene_warnings.h"

namespace seaway::inspect {

namespace {

using Json = nlohmann::ordered_json;

double variance(const sea::SeaStatistics& s) {
    return s.significant_height_m * s.significant_height_m / 16.0;
}

Json json_of(const sea::SeaStatistics& s) {
    return {{"hs_m", s.significant_height_m},
            {"tp_s", s.peak_period_s},
            {"tz_s", s.zero_crossing_period_s},
            {"tm01_s", s.mean_period_s},
            {"mean_from_deg", sea::mean_from_deg(s)},
            {"spread_deg", s.spread_rad * sea::degrees_per_radian},
            {"mss", s.mean_square_slope}};
}

/// Of the height that was asked for.
Json json_of_label(const sea::SeaStatistics& s) {
    const sea::SeaStateLabel label = sea::wmo_sea_state(s.significant_height_m);
    return {{"code", label.code}, {"name", label.name}};
}

Json json_of_cascades(const Report& report) {
    Json rows = Json::array();
    for (std::size_t c = 0; c < report.sea->cascades.size(); ++c) {
        const sea::CascadeModes& modes = report.sea->cascades[c];
        const sea::CascadeVariance& variance = report.summary.cascades[c];
        rows.push_back(
            {{"length_m", modes.spec.length_m},
             {"size", modes.spec.size},
             {"k_lo_radpm", modes.band.k_lo_radpm},
             {"k_hi_radpm", modes.band.k_hi_radpm},
             {"requested_m2", variance.requested_m2},
             {"expected_m2", variance.expected_m2},
             {"realised_m2", variance.realised_m2},
             {"hs_scatter_expected", variance.expected_scatter},
             {"keyframe_interval_s", sea::seconds_from_us(report.budget.cascades[c].interval_us)}});
    }
    return rows;
}

/// Null where the scene allows no foam. `observed`: where the threshold is not given.
Json json_of_foam(const sea::FoamLaw* law) {
    if (law == nullptr)
        return nullptr;
    Json json = {{"mean_coverage", law->mean_coverage},
                 {"threshold", law->calm() ? Json(nullptr) : Json(law->threshold)},
                 {"bias", law->model.bias},
                 {"decay_s", law->model.decay_s},
                 {"gain_per_s", law->model.gain_per_s},
                 {"observed", nullptr},
                 {"says", describe(*law)}};
    if (law->observed)
        json["observed"] = {
            {"coverage", law->observed->share},
            {"wind_speed_10m_mps", law->observed->wind.speed_10m_mps},
            {"wind_is_given", law->observed->wind.origin == sea::FoamWind::Origin::given}};
    return json;
}

/// Null where the scene names none.
Json json_of_certificate(const Report& report) {
    if (!report.certificate)
        return nullptr;
    const sea::Certificate& c = *report.certificate;
    return {{"file", report.scene.accuracy.certificate.name},
            {"says", describe(c)},
            {"height_error_m", c.promised_m},
            {"percentile", c.percentile},
            {"holds", certificate_warnings(c, report.scene, report.summary.requested).empty()}};
}

/// What `tp_s` means, requested and realised.
std::string tp_definition(const Report& report) {
    const double bin_s = report.summary.peak_bin_period_s;
    const std::string requested =
        bin_s > 0.0 ? fmt::format("top of the parabola through the highest measured bin and its "
                                  "neighbours, or its middle where they do not allow one (the "
                                  "middle: {:.4g} s)",
                                  bin_s)
                    : "where S(f) is largest, or the frequency of given waves that hold more than "
                      "spectra do in a tenth around their peak";
    return fmt::format("requested: {}; realised: S^4-weighted over the densest band", requested);
}

Json json_of_lattice(const Report& report) {
    Json rows = Json::array();
    for (const sea::LatticeBias& bias : report.summary.lattice)
        rows.push_back({{"system", bias.system + 1},
                        {"m0_ratio", bias.energy},
                        {"turned_deg", -bias.turned_rad * sea::degrees_per_radian},
                        {"spread_ratio", bias.spread}});
    return rows;
}

struct Line {
    const char* name;
    const char* unit;
    double requested;
    double realised;
};

std::string text_of_statistics(const Report& report) {
    const sea::SeaStatistics& q = report.summary.requested;
    const sea::SeaStatistics& r = report.summary.realised;
    const Line lines[] = {
        {"significant height Hs", "m", q.significant_height_m, r.significant_height_m},
        {"peak period Tp", "s", q.peak_period_s, r.peak_period_s},
        {"zero-crossing period Tz", "s", q.zero_crossing_period_s, r.zero_crossing_period_s},
        {"mean period Tm01", "s", q.mean_period_s, r.mean_period_s},
        {"mean direction, from", "deg", sea::mean_from_deg(q), sea::mean_from_deg(r)},
        {"directional spread", "deg", q.spread_rad * sea::degrees_per_radian,
         r.spread_rad * sea::degrees_per_radian},
        {"mean square slope", "", q.mean_square_slope, r.mean_square_slope}};
    std::string out = fmt::format("{:28}{:>12}{:>12}\n", "", "requested", "realised");
    for (const Line& line : lines)
        out += fmt::format("{:24}{:>4}{:>12.4g}{:>12.4g}\n", line.name, line.unit, line.requested,
                           line.realised);
    const sea::SeaStateLabel label = sea::wmo_sea_state(q.significant_height_m);
    out += fmt::format("WMO sea state {}: {}\n", label.code, label.name);
    out += fmt::format("Tp {}\n", tp_definition(report));
    out += fmt::format("Hs of one seed scatters by {:.1f} % (one standard deviation)\n",
                       100.0 * sea::hs_scatter(report.summary));
    for (const sea::LatticeBias& bias : report.summary.lattice)
        out += fmt::format("system {} on these tiles, on average over seeds: energy {:+.2f} %, "
                           "direction {:+.2f} degrees, spread {:+.2f} %\n",
                           bias.system + 1, 100.0 * (bias.energy - 1.0),
                           -bias.turned_rad * sea::degrees_per_radian, 100.0 * (bias.spread - 1.0));
    return out;
}

std::string text_of_cascades(const Report& report) {
    std::string out =
        fmt::format("{:>9}{:>7}{:>20}{:>15}{:>15}{:>16}{:>14}\n", "tile, m", "size", "waves, m",
                    "requested, m2", "realised, m2", "Hs scatter, %", "keyframe, s");
    for (std::size_t c = 0; c < report.sea->cascades.size(); ++c) {
        const sea::CascadeModes& modes = report.sea->cascades[c];
        const sea::CascadeVariance& v = report.summary.cascades[c];
        // The lowest band begins half a step below its first wave.
        const double longest = std::min(modes.spec.length_m, sea::two_pi / modes.band.k_lo_radpm);
        out += fmt::format(
            "{:>9g}{:>7}{:>20}{:>15.4g}{:>15.4g}{:>16.1f}{:>14g}\n", modes.spec.length_m,
            modes.spec.size,
            fmt::format("{:.4g} .. {:.3g}", longest, sea::two_pi / modes.band.k_hi_radpm),
            v.requested_m2, v.realised_m2, 100.0 * v.expected_scatter,
            sea::seconds_from_us(report.budget.cascades[c].interval_us));
    }
    return out;
}

std::string text_of_losses(const Report& report) {
    const double whole = variance(report.summary.requested);
    // Below 1e-9 it is what two quadratures differ by.
    const auto share = [whole](double part) {
        return part > 1e-9 * whole ? 100.0 * part / whole : 0.0;
    };
    return fmt::format("not carried, of {:.4g} m2: {:.2g} % longer than the tiles hold, {:.2g} % "
                       "shorter than they resolve, {:.2g} % by fade and cut-offs\n",
                       whole, share(report.summary.lost_below_m2),
                       share(report.summary.lost_above_m2), share(report.summary.lost_fade_m2));
}

} // namespace

Result<Report> make_report(const sea::Scene& scene) {
    SEAWAY_TRY_LET(sea::Realization sea, realize(scene));
    Report report;
    report.scene = scene;
    report.sea = std::make_shared<const sea::Realization>(std::move(sea));
    report.summary = summarize(scene.sea, *report.sea);
    report.budget = plan_budget(*report.sea, scene.accuracy.height_error_m);
    report.warnings = scene_warnings(scene, *report.sea, report.summary, report.budget);
    if (!scene.weather.empty())
        report.warnings.push_back(
            fmt::format("[[weather]]: from {} s on the sea is another; all of this is of the sea "
                        "before",
                        scene.weather.front().at_s));
    SEAWAY_TRY_LET(report.certificate, sea::load_certificate(scene));
    if (report.certificate)
        for (std::string& warning :
             certificate_warnings(*report.certificate, scene, report.summary.requested))
            report.warnings.push_back(std::move(warning));
    report.foam = sea::foam_law_of(scene, *report.sea);
    std::ranges::move(sea::foam_warnings(report.foam), std::back_inserter(report.warnings));
    return report;
}

std::string to_json(const Report& report) {
    const double depth = report.scene.sea.depth_m;
    const Json json = {{"scene", report.scene.source},
                       {"seed", report.scene.sea.seed},
                       {"depth_m", std::isfinite(depth) ? Json(depth) : Json(nullptr)},
                       {"requested", json_of(report.summary.requested)},
                       {"realised", json_of(report.summary.realised)},
                       {"wmo_sea_state", json_of_label(report.summary.requested)},
                       {"hs_scatter_expected", sea::hs_scatter(report.summary)},
                       {"tp_definition", tp_definition(report)},
                       {"tp_bin_s", report.summary.peak_bin_period_s > 0.0
                                        ? Json(report.summary.peak_bin_period_s)
                                        : Json(nullptr)},
                       {"longest_peak_wavelength_m", report.summary.longest_peak_wavelength_m},
                       {"variance",
                        {{"requested_m2", variance(report.summary.requested)},
                         {"realised_m2", variance(report.summary.realised)},
                         {"lost_longer_m2", report.summary.lost_below_m2},
                         {"lost_shorter_m2", report.summary.lost_above_m2},
                         {"lost_fade_m2", report.summary.lost_fade_m2}}},
                       {"lattice_bias", json_of_lattice(report)},
                       {"cascades", json_of_cascades(report)},
                       {"foam", json_of_foam(report.foam.get())},
                       {"certificate", json_of_certificate(report)},
                       {"warnings", report.warnings}};
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

std::string to_text(const Report& report) {
    const sea::SeaState& sea = report.scene.sea;
    std::string out =
        fmt::format("{}: seed {}, {}\n\n", report.scene.source, sea.seed,
                    std::isfinite(sea.depth_m) ? fmt::format("depth {:g} m", sea.depth_m)
                                               : std::string("deep water"));
    out += text_of_statistics(report) + '\n' + text_of_cascades(report) + text_of_losses(report);
    if (report.foam)
        out += fmt::format("foam: {}\n", describe(*report.foam));
    if (report.certificate)
        out += fmt::format("certified: {}\n", describe(*report.certificate));
    if (!report.warnings.empty())
        out += '\n';
    for (const std::string& warning : report.warnings)
        out += fmt::format("warning: {}\n", warning);
    return out;
}

} // namespace seaway::inspect
