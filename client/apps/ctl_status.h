// SPDX-License-Identifier: Apache-2.0
// What seaway-ctl status says of one server.
#pragma once

#include <string>

namespace seaway::client {

struct StatusRow {
    std::string text;     ///< one line
    bool certain = false; ///< the server is sure of its sea
};

/// Of what a server said to Act::sessions, and to Act::state at the beginning and at the end of some time, JSON. One of
/// another version may say it in other words: the row says so, and is not certain.
StatusRow status_row(const std::string& url, const std::string& version,
                     const std::string& state_before, const std::string& state, double between_s,
                     const std::string& sessions);

} // namespace seaway::client
