// SPDX-License-Identifier: Apache-2.0
// A file of its own: X11 has macros with names that other headers use.
#include "tests/client/window/x11.h"

#include <X11/Xatom.h>
#include <X11/Xlib.h>

namespace seaway::tests {

bool ask_to_close(const std::string& name, unsigned long window) {
    ::Display* display = XOpenDisplay(name.c_str());
    if (display == nullptr)
        return false;
    XEvent event{};
    event.xclient.type = ClientMessage;
    event.xclient.window = window;
    event.xclient.message_type = XInternAtom(display, "WM_PROTOCOLS", False);
    event.xclient.format = 32;
    event.xclient.data.l[0] = static_cast<long>(XInternAtom(display, "WM_DELETE_WINDOW", False));
    XSendEvent(display, window, False, NoEventMask, &event);
    XCloseDisplay(display);
    return true;
}

bool set_dots_an_inch(const std::string& name, int dots) {
    ::Display* display = XOpenDisplay(name.c_str());
    if (display == nullptr)
        return false;
    const std::string resources = "Xft.dpi:\t" + std::to_string(dots) + "\n";
    XChangeProperty(display, DefaultRootWindow(display), XA_RESOURCE_MANAGER, XA_STRING, 8,
                    PropModeReplace, reinterpret_cast<const unsigned char*>(resources.data()),
                    static_cast<int>(resources.size()));
    XCloseDisplay(display);
    return true;
}

} // namespace seaway::tests
