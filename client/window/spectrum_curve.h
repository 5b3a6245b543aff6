// SPDX-License-Identifier: Apache-2.0
// The curve of a sea's spectrum, as its scene asks for it.
#pragma once

#include <string>

#include "client/window/model.h"

namespace seaway::client {

/// S(f), m2/Hz, over frequencies from 0 to `frequency_max_hz`, of the effective scene that a server tells. Empty, with
/// the reason as its caption, where the scene has no spectrum or cannot be read. A millisecond.
Curve spectrum_curve(const std::string& scene_toml);
inline constexpr double frequency_max_hz = 0.5;

} // namespace seaway::client
