// SPDX-License-Identifier: Apache-2.0
// What the window's panels show, as text and numbers, and what they let the user choose: plain values. Panels draw
// them; tests read them.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/client.h"
#include "client/view/debug/legend.h"
#include "client/view/quality.h"
#include "client/view/sky/look.h"
#include "client/window/feed.h"
#include "client/window/pilot.h"
#include "client/window/probe.h"

namespace seaway::client {

struct PanelRow {
    std::string label, value;
};

/// What the user sets.
struct ViewChoice {
    Look look;
    std::size_t quality = quality_default; ///< place in quality_table
    DebugChoice debug;
    bool second_camera = false; ///< the mesh stays as it is for the camera that it was built for
    bool panels = true;
    std::string look_path = "look.toml"; ///< that is loaded and saved
};

/// A curve over even steps.
struct Curve {
    std::vector<float> values;
    float least = 0, most = 1;
    std::string caption;
};

struct WindowModel {
    bool shows_sea = false;        ///< there is something to show
    std::optional<double> stale_s; ///< so old is what is shown; nothing: it is of now
    std::string notice;            ///< over the sea; empty: none
    std::vector<PanelRow> connection, rates, sea, passes, probe;
    Curve spectrum, trace;
    std::string look_said;         ///< what became of loading or saving; an error is one line
    sea::WaterType water_of_sea{}; ///< what the sea says of itself
    std::optional<glm::dvec2> probe_mark; ///< on the picture, -1 .. 1
    Legend legend;                        ///< of a view of numbers
    glm::dvec2 legend_pixels{1};          ///< size of the picture that it is for
    int cascades = 0;
    double speed_mps = 0;
    CameraMode camera = CameraMode::fly;
};

/// "stale, 3.2 s old".
std::string stale_text(double age_s);

std::vector<PanelRow> connection_rows(const std::string& url, const FeedStatus& feed,
                                      const Client* client, std::optional<double> stale_s);
/// `keyframes_hz`, `bytes_hz`: as measured over the last seconds.
std::vector<PanelRow> rate_rows(const FeedStatus& feed, double keyframes_hz, double bytes_hz,
                                double frames_hz);
std::vector<PanelRow> sea_rows(const SeaState& state, sea::TimeUs time_us);
std::vector<PanelRow> pass_rows(std::span<const double> pass_times_s);
std::vector<PanelRow> probe_rows(const Probe* probe);
Curve trace_curve(const Probe* probe);

/// Reads or writes the file of choice.look_path; what to say of it.
std::string load_look(ViewChoice& choice);
std::string save_look(const ViewChoice& choice);

/// A probe's reading as one line of output: probe x_m=.. y_m=.. t_s=.. height_m=.. error_m=..
std::string probe_line(const Probe& probe);

} // namespace seaway::client
