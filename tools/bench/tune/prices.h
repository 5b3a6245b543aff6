// SPDX-License-Identifier: Apache-2.0
// What a configuration costs to run, from stages that were measured once: keyframes and splines by size,
// coding by samples and bytes, answers by tiles. A price is a function of the configuration and of these
// few numbers alone; kept in a file, they make every later search on the machine find the same prices.
//
// For one thread.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "tools/bench/accuracy/measure/stage_costs.h"
#include "tools/bench/accuracy/seas/configured_sea.h"

namespace seaway::bench {

/// Milliseconds of CPU and bytes per second of sea.
struct Price {
    double keyframes_ms = 0;
    double splines_ms = 0;
    double encoding_ms = 0;
    double answers_ms = 0; ///< of queries_per_s
    double bytes_per_s = 0;
    double work_ms() const { return keyframes_ms + splines_ms + encoding_ms + answers_ms; }
};

/// Where a tuner asks for prices, of one scene.
class Prices {
  public:
    virtual ~Prices() = default;
    /// Never above the price of any configuration with these tiles and a budget that is not larger than
    /// this one; null: with any budget. Cheap: nothing is computed or coded.
    virtual Result<Price> at_least(const std::vector<sea::CascadeSpec>& cascades,
                                   const sea::Scene& scene, const sea::ErrorBudget* budget) = 0;
    /// Of a sea that was gone to some time, so that its codec has worked.
    virtual Result<Price> of(const ConfiguredSea& sea) = 0;
};

/// Stages of this machine; those of `file` where it has them, written there where not.
Result<std::unique_ptr<Prices>> stage_prices(const std::string& device, const std::string& file,
                                             Devices& devices);

} // namespace seaway::bench
