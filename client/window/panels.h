// SPDX-License-Identifier: Apache-2.0
// Panels: draws a WindowModel beside the sea and lets the user change a ViewChoice. Between Gui::begin() and record().
#pragma once

#include <map>
#include <string>

#include <glm/glm.hpp>

#include "client/window/model.h"

namespace seaway::client {

class Panels {
  public:
    /// In points of the window.
    struct Box {
        glm::dvec2 low{0.0}, high{0.0};
        bool holds(double x, double y) const {
            return x >= low.x && x < high.x && y >= low.y && y < high.y;
        }
    };
    /// What the user asked for besides what he set.
    struct Asked {
        bool mode_changed = false;
        CameraMode mode = CameraMode::fly;
        bool forget_probe = false;
        bool load_look = false, save_look = false;
        double speed_mps = 0; ///< 0: as it is
    };

    Asked draw(const WindowModel& model, ViewChoice& choice);

    /// Of the last frame: is this the panels', not the sea's?
    bool taken(double x, double y) const { return box_.holds(x, y); }
    /// Where what has this name was drawn last: "hour", "exposure", "quality", ...
    const std::map<std::string, Box>& places() const { return places_; }

  private:
    void note(const char* name);
    void plot(const char* name, const Curve& curve);
    bool header(const char* name, bool open);
    void view(const WindowModel& model, ViewChoice& choice);
    void light(const WindowModel& model, ViewChoice& choice);
    void look_file(const WindowModel& model, ViewChoice& choice, Asked& asked);
    void debug(const WindowModel& model, DebugChoice& choice);
    void camera(const WindowModel& model, ViewChoice& choice, Asked& asked);

    Box box_;
    std::map<std::string, Box> places_;
};

} // namespace seaway::client
