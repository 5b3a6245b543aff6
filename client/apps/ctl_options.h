// SPDX-License-Identifier: Apache-2.0
// The command line of seaway-ctl.
#pragma once

#include <cstdint>
#include <string>
#include <variant>

#include "protocol/messages.h"

namespace seaway::client {

/// Something of the server.
struct AdminWish {
    wire::Act act = wire::Act::state;
    std::uint64_t session = 0;
};

struct CtlOptions {
    std::string url;
    std::string token_file;
    std::string ca_file;
    double timeout_s = 30;
    std::variant<AdminWish, protocol::ChangeWish> what; ///< a change with its scene read already
};

/// Seconds, or a number with a unit: "90", "90s", "2m", "1.5h", "3d".
Result<double> parse_duration_s(const std::string& text);

/// The options, or the exit code after --help, --version (0) or a usage error (2), which has been printed.
std::variant<CtlOptions, int> read_ctl_options(int argc, const char* const* argv);

} // namespace seaway::client
