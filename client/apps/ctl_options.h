// SPDX-License-Identifier: Apache-2.0
// The command line of seaway-ctl.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "client/server_options.h"
#include "protocol/messages.h"

namespace seaway::client {

/// Something of the server.
struct AdminWish {
    wire::Act act = wire::Act::state;
    std::uint64_t session = 0;
};

/// Of several servers.
struct StatusWish {
    std::vector<std::string> others; ///< URLs beside that of the options
};

struct RewindWish {
    std::uint64_t change = 1; ///< whose sea comes again
    sea::TimeUs over_us = 0;
    sea::TimeUs at_us = 0;
};

struct DiffWish {
    std::string other; ///< URL
    int points = 1000;
    std::uint64_t seed = 1;
};

struct CtlOptions : ServerOptions {
    CtlOptions() { timeout_s = 30; }

    /// A change with its scene read already.
    std::variant<AdminWish, protocol::ChangeWish, StatusWish, RewindWish, DiffWish> what;
};

/// Seconds, or a number with a unit: "90", "90s", "2m", "1.5h", "3d".
Result<double> parse_duration_s(const std::string& text);

/// The options, or the exit code after --help, --version (0) or a usage error (2), which has been printed.
std::variant<CtlOptions, int> read_ctl_options(int argc, const char* const* argv);

} // namespace seaway::client
