// SPDX-License-Identifier: Apache-2.0
#include "client/window/model.h"

#include <algorithm>

#include <fmt/format.h>

#include "client/view/look_file.h"
#include "client/view/renderer.h"

namespace seaway::client {

namespace {

std::string link_text(const FeedStatus& feed) {
    switch (feed.link) {
    case Link::connecting:
        return feed.connections > 0 ? "connecting again" : "connecting";
    case Link::live:
        return "live";
    case Link::stopped:
        return "stopped";
    case Link::waiting:
        break;
    }
    return fmt::format("next attempt in {:.1f} s", feed.next_s);
}

/// As "of what was asked for | realised".
std::string pair_text(double requested, double realised, const char* unit) {
    return fmt::format("{:.2f} | {:.2f}{}", requested, realised, unit);
}

std::string flags_text(std::uint32_t flags) {
    std::string text;
    for (std::size_t bit = 0; bit < sea::answer_flag_names.size(); ++bit)
        if ((flags >> bit & 1u) != 0)
            text += (text.empty() ? "" : ", ") + std::string(sea::answer_flag_names[bit]);
    return text.empty() ? "none" : text;
}

} // namespace

std::string stale_text(double age_s) {
    return fmt::format("stale, {:.1f} s old", age_s);
}

std::vector<PanelRow> connection_rows(const std::string& url, const FeedStatus& feed,
                                      const Client* client, std::optional<double> stale_s) {
    std::vector<PanelRow> rows{{"server", url}, {"state", link_text(feed)}};
    if (feed.link != Link::live && !feed.reason.empty())
        rows.push_back({"because", feed.reason});
    rows.push_back({"sea shown", stale_s ? stale_text(*stale_s) : "now"});
    if (client == nullptr)
        return rows;
    const ClockStatus clock = client->clock();
    rows.push_back(
        {"round trip", fmt::format("{:.2f} ms", 1e-3 * static_cast<double>(clock.round_trip_us))});
    rows.push_back({"clock", fmt::format("known to {:.2f} ms, {:.2f} ms to make up",
                                         1e-3 * clock.error_us, 1e-3 * clock.slew_us)});
    rows.push_back({"sea less local clock", fmt::format("{:.3f} s", 1e-6 * clock.offset_us)});
    rows.push_back({"connections", fmt::format("{}", feed.connections)});
    return rows;
}

std::vector<PanelRow> rate_rows(const FeedStatus& feed, double keyframes_hz, double bytes_hz,
                                double frames_hz) {
    return {{"frames", fmt::format("{:.1f} a second", frames_hz)},
            {"keyframes", fmt::format("{:.1f} a second, {} in all", keyframes_hz, feed.keyframes)},
            {"maps", fmt::format("{:.2f} MB a second, unpacked", 1e-6 * bytes_hz)},
            {"rung", fmt::format("heights within {:.4g} m", feed.grant.error_m)},
            {"credit", fmt::format("{} keyframes under way", feed.grant.credit)}};
}

std::vector<PanelRow> sea_rows(const SeaState& state, sea::TimeUs time_us) {
    const protocol::SeaNumbers& asked = state.requested;
    const protocol::SeaNumbers made = state.realised_at(time_us);
    std::vector<PanelRow> rows{
        {"sea time", fmt::format("{:.2f} s", sea::seconds_from_us(time_us))},
        {"", "requested | realised"},
        {"Hs", pair_text(asked.hs_m, made.hs_m, " m")},
        {"Tp", pair_text(asked.tp_s, made.tp_s, " s")},
        {"Tz", pair_text(asked.tz_s, made.tz_s, " s")},
        {"from", pair_text(asked.mean_from_deg, made.mean_from_deg, " deg")},
        {"spread", pair_text(asked.spread_deg, made.spread_deg, " deg")},
        {"slope, mean square", fmt::format("{:.4f} | {:.4f}", asked.mss, made.mss)},
        {"error budget", fmt::format("{:.4g} m", state.height_error_m)}};
    for (std::size_t c = 0; c < state.cascades.size(); ++c)
        rows.push_back({fmt::format("cascade {}", c),
                        fmt::format("{:.5g} m, {} points, every {:.3g} s",
                                    state.cascades[c].length_m, state.cascades[c].size,
                                    sea::seconds_from_us(state.cascades[c].interval_us))});
    for (const std::string& warning : state.warnings)
        rows.push_back({"warning", warning});
    return rows;
}

std::vector<PanelRow> pass_rows(std::span<const double> pass_times_s) {
    std::vector<PanelRow> rows;
    double sum_s = 0;
    for (std::size_t i = 0; i < pass_times_s.size() && i < Renderer::passes; ++i) {
        rows.push_back({std::string(Renderer::pass_names[i]),
                        fmt::format("{:.2f} ms", 1e3 * pass_times_s[i])});
        sum_s += pass_times_s[i];
    }
    if (!rows.empty())
        rows.push_back({"all", fmt::format("{:.2f} ms", 1e3 * sum_s)});
    return rows;
}

std::vector<PanelRow> probe_rows(const Probe* probe) {
    if (probe == nullptr)
        return {{"", "click on the sea"}};
    std::vector<PanelRow> rows{{"place", fmt::format("{:.2f} m east, {:.2f} m north",
                                                     probe->place_m().x, probe->place_m().y)}};
    if (!probe->answer()) {
        rows.push_back({"height", "not held"});
        return rows;
    }
    const sea::Answer& a = *probe->answer();
    rows.push_back({"at", fmt::format("{:.2f} s", sea::seconds_from_us(probe->time_us()))});
    rows.push_back({"height", fmt::format("{:.3f} m, within {:.2g} m", a.height_m, a.error_m)});
    rows.push_back(
        {"normal", fmt::format("{:.3f} {:.3f} {:.3f}", a.normal[0], a.normal[1], a.normal[2])});
    rows.push_back({"velocity", fmt::format("{:.2f} {:.2f} {:.2f} m/s", a.velocity_mps[0],
                                            a.velocity_mps[1], a.velocity_mps[2])});
    rows.push_back({"flags", flags_text(a.flags)});
    return rows;
}

Curve trace_curve(const Probe* probe) {
    Curve curve;
    if (probe == nullptr || probe->trace().empty())
        return curve;
    for (const Probe::Sample& sample : probe->trace())
        curve.values.push_back(sample.height_m);
    const auto [least, most] = std::minmax_element(curve.values.begin(), curve.values.end());
    curve.least = *least;
    curve.most = std::max(*most, *least + 0.01f);
    curve.caption = fmt::format(
        "{:.2f} .. {:.2f} m, last {:.0f} s", curve.least, curve.most,
        sea::seconds_from_us(probe->trace().back().time_us - probe->trace().front().time_us));
    return curve;
}

std::string probe_line(const Probe& probe) {
    if (!probe.answer())
        return {};
    return fmt::format("probe x_m={:.4f} y_m={:.4f} t_s={:.6f} height_m={:.5f} error_m={:.3g}\n",
                       probe.place_m().x, probe.place_m().y, sea::seconds_from_us(probe.time_us()),
                       probe.answer()->height_m, probe.answer()->error_m);
}

std::string load_look(ViewChoice& choice) {
    const Result<Look> look = read_look(choice.look_path);
    if (!look)
        return look.error().message;
    choice.look = *look;
    return "loaded " + choice.look_path;
}

std::string save_look(const ViewChoice& choice) {
    const Result<void> written = write_look(choice.look, choice.look_path);
    return written ? "saved " + choice.look_path : written.error().message;
}

} // namespace seaway::client
