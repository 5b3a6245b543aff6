// SPDX-License-Identifier: Apache-2.0
// The command line of seaway-view.
#pragma once

#include <optional>
#include <string>
#include <variant>

#include "client/exit_code.h"
#include "client/server_options.h"
#include "client/tile_limits.h"
#include "client/view/camera.h"
#include "client/view/debug_views.h"
#include "client/view/frame_times.h"
#include "client/view/quality.h"
#include "client/view/sky/look.h"
#include "sea/basics/time.h"

namespace seaway::client {

struct ViewOptions : ServerOptions {
    ViewOptions() { timeout_s = 20; }

    std::string scene;      ///< file, of a sea that is made here; empty: `url` is a server's
    bool offscreen = false; ///< to files; else in a window
    Camera camera;          ///< with the size of the picture, or of the window
    int frames = 1;
    std::optional<int>
        first; ///< number of the first that is drawn, of a film in pieces; nothing: 0
    FrameRate rate;
    std::string out;              ///< pattern of paths, see frame_path()
    std::string path;             ///< CSV file of a CameraPath; empty: none
    bool turntable = false;       ///< see CameraPath::turntable()
    std::string look_path;        ///< of --look; empty: none
    Look look;                    ///< of --look, and what options say over it
    std::optional<double> time_s; ///< sea time of frame 0; nothing: now, or 0 of a scene
    DebugChoice debug;
    bool sheet = false; ///< --debug all: every view in one picture
    Quality quality = quality_table[quality_high];
    std::optional<double> cell_pixels; ///< of --density; nothing: the quality's own
    int bench_frames = 0;              ///< above 0: these are drawn and timed, no file is written
    std::string device = "auto";
    TileLimits limits; ///< of what is streamed

    /// Number of the i-th that is drawn.
    int frame(int i) const { return first.value_or(0) + i; }
    /// Is there more than this picture of its name?
    bool numbered() const { return frames > 1 || first; }
    /// A quality with the density that was asked for whatever the quality.
    Quality as_dense(Quality of) const {
        of.cell_pixels = cell_pixels.value_or(of.cell_pixels);
        return of;
    }
};

/// Options, or the code to exit with at once (--help, --version, --list-debug, a usage error that
/// has been printed).
std::variant<ViewOptions, int> read_view_options(int argc, const char* const* argv);

/// "out/####.png" or "out/%04d.png" with the frame's number, of a field in the file's name, not in a folder's; a
/// pattern without one has "-0000" put before its ending where frames are numbered, and is the path itself where not.
std::string frame_path(const std::string& pattern, int frame, bool numbered);

} // namespace seaway::client
