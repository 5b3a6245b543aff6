// SPDX-License-Identifier: Apache-2.0
// How many changes of the sea were asked for and not made, by reason. Thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <string_view>

#include "base/result.h"

namespace seaway::server {

class RefusedChanges {
  public:
    /// By reason: bad_value; busy: to be asked for again later, or of another server; not_offered; gone: the server stops;
    /// unwritten: the journal did not take it, or has not said; full: there are as many as may be. All are there, from the start.
    using Counts = std::map<std::string_view, std::uint64_t>;

    void count(const Error& why);
    Counts counts() const;

  private:
    mutable std::mutex mutex_;
    Counts counts_{{"bad_value", 0}, {"busy", 0},        {"full", 0},
                   {"gone", 0},      {"not_offered", 0}, {"unwritten", 0}};
};

/// Its part of /metrics.
std::string metrics_text(const RefusedChanges::Counts& refused);

} // namespace seaway::server
