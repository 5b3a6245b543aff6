// SPDX-License-Identifier: Apache-2.0
// seaway-ctl asking one server, and what it asks several.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "client/apps/ctl_options.h"
#include "client/link/connection.h"

namespace seaway::client {

/// As administrator, with the options' token and patience.
Result<std::unique_ptr<Connection>> connect_as_administrator(const CtlOptions& options,
                                                             const std::string& url);

/// What there is, as text.
Result<std::string> administered(Connection& connection, const AdminWish& wish, double timeout_s);

/// The answer of a change, as JSON.
Result<std::string> changed(Connection& connection, const protocol::ChangeWish& wish,
                            double timeout_s);

struct FleetStatus {
    std::string table;
    bool all_certain = true;           ///< each answers, and is sure of its sea
    std::optional<Error> none_answers; ///< why the first does not
};

/// A row for each server: version, whether it is sure of its sea, changes, clock, sessions. One that does not answer has a row that
/// says so.
FleetStatus fleet_status(const CtlOptions& options, const StatusWish& wish);
/// Back to the sea of a change: its scene as a change of now.
Result<std::string> rewound(const CtlOptions& options, const RewindWish& wish);
/// Heights of two servers at random points around now: difference_of() in client/apps/ctl_diff.h.
Result<std::string> difference(const CtlOptions& options, const DiffWish& wish);

} // namespace seaway::client
