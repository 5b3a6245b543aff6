// SPDX-License-Identifier: Apache-2.0
// The journal of a run, accuracy.csv: one row a figure, flushed trial by trial. A run that was stopped
// finds there what it has done; a trial that it had not finished is measured again.
//
// First line: a note that says of which points the figures are. Rows:
//     state,knob,value,metric,figure,ci_low,ci_high,device,driver,machine,commit
// A trial's last row has the metric "done": CPU seconds that it took. For one thread.
#pragma once

#include <fstream>
#include <set>
#include <span>
#include <string>

#include "base/result.h"
#include "tools/bench/accuracy/measure/metrics.h"
#include "tools/bench/accuracy/seas/configured_sea.h"

namespace seaway::bench {

/// Where figures were taken.
struct Place {
    std::string device; ///< as it describes itself; where a server is asked, its address
    std::string driver;
    std::string machine; ///< processor and cores
    std::string commit;
};

/// Where a configuration is measured. An error: there is no such device.
Result<Place> place_of(const Configuration& configuration, Devices& devices);

/// Of this machine; "unknown" where it does not say.
std::string machine_name();
/// What this program was built from; "unknown" where that was no repository.
std::string commit_name();

struct TrialName {
    std::string state;
    std::string knob;
    std::string value;
    std::string device; ///< description
};

class Journal {
  public:
    /// Opens or begins `path`. `settings` is the note; an error if the file is of other settings, or
    /// cannot be written.
    static Result<Journal> open(const std::string& path, const std::string& settings);

    bool has(const TrialName& trial) const { return done_.contains(key(trial)); }
    std::size_t trials() const { return done_.size(); }

    Result<void> add(const TrialName& trial, const Place& place, std::span<const Figure> figures,
                     double seconds);

  private:
    static std::string key(const TrialName& trial);

    std::string path_;
    std::ofstream file_;
    std::set<std::string> done_;
};

} // namespace seaway::bench
