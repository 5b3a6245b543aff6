// SPDX-License-Identifier: Apache-2.0
// The sky of a frame: a look, a camera and the time of the sea.
#pragma once

#include "client/view/camera.h"
#include "client/view/picture.h"
#include "client/view/sky/sky_feed.h"
#include "sea/basics/time.h"

namespace seaway::client {

/// Where sun, moon and stars stand for a look: of its place and time, which goes on with the sea's in steps
/// of half a minute, a quarter of the sun's width: 0.06 degrees off at the most; without a place, of its hour, at which they stand still.
Heavens heavens_of(const Look& look, sea::TimeUs time_us);

/// Clouds drift with the wind of the look. Waits for its tables: for files.
Result<Sky> sky_of_frame(SkyMaker& maker, const Look& look, const Camera& camera,
                         sea::TimeUs time_us);
/// With the tables that there are: for windows.
Sky sky_of_frame(SkyFeed& feed, const Look& look, const Camera& camera, sea::TimeUs time_us);

/// How a window shows a look: metered by the light on the sea, not from each picture, which would breathe as waves go by.
Display display_by_light(const Look& look, const Sky& sky, DebugView view,
                         double significant_height_m);

} // namespace seaway::client
