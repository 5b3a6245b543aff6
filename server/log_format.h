// SPDX-License-Identifier: Apache-2.0
// How the lines of the log are written: for people, or one JSON object a line for those who collect logs.
#pragma once

#include <string>
#include <string_view>

namespace seaway::server {

/// The default logger writes to stderr from now on, as "text" or "json" says, on a thread of its own: who logs never
/// waits for who reads. Where nobody reads, the oldest of 8192 lines are lost.
void set_log_format(const std::string& format);

/// All lines have been written when it is over; what is logged later is written at once. Who does not read them is waited
/// for a second.
class LogEnd {
  public:
    LogEnd() = default;
    ~LogEnd();
    LogEnd(const LogEnd&) = delete;
    LogEnd& operator=(const LogEnd&) = delete;
};

/// Returns `status`, for main; where lines wait for who does not read them the process ends with it here.
int end_with(int status);

/// Why the program gives up: complain(), or the same as a line of a log in JSON. Returns `status`.
int give_up(int status, const std::string& why);

/// {"time":"...","level":"info","message":"event=session_open session=1","fields":{"event":"session_open","session":1}}.
/// `fields` are the key=value pairs of a message that begins with event=: numbers as numbers, "quoted words" whole.
/// What is no UTF-8 is replaced.
std::string json_line(std::string_view time, std::string_view level, std::string_view message);

} // namespace seaway::server
