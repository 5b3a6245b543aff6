// SPDX-License-Identifier: Apache-2.0
// How the lines of the log are written: for people, or one JSON object a line for those who collect logs.
#pragma once

#include <string>
#include <string_view>

namespace seaway::server {

/// The default logger writes to stderr from now on, as "text" or "json" says.
void set_log_format(const std::string& format);

/// {"time":"...","level":"info","message":"event=session_open session=1","fields":{"event":"session_open","session":1}}.
/// `fields` are the key=value pairs of a message that begins with event=: numbers as numbers, "quoted words" whole.
/// What is no UTF-8 is replaced.
std::string json_line(std::string_view time, std::string_view level, std::string_view message);

} // namespace seaway::server
