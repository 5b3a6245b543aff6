// SPDX-License-Identifier: Apache-2.0
// The status page: a shell without a word about the sea, for everybody, whose script asks /v1/state, /v1/plan, /metrics and
// /v1/map for what it shows, with the token that its reader types where the server wants one. Nothing is asked while
// nobody looks. No library, no inline script: what it may load says status_policy.
#pragma once

#include <string_view>

namespace seaway::server {

inline constexpr std::string_view status_script_path = "/status.js";
inline constexpr std::string_view status_style_path = "/status.css";

/// Content-Security-Policy of it, and of every other page.
inline constexpr std::string_view status_policy =
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src data:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

extern const std::string_view status_html;
extern const std::string_view status_script;
extern const std::string_view status_style;

} // namespace seaway::server
