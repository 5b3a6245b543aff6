// SPDX-License-Identifier: Apache-2.0
// What a running sea says about itself: the SeaState message, /v1/state, /v1/plan, /metrics.
// Pure functions of what they are given; thread-safe.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "protocol/messages.h"
#include "server/following.h"
#include "server/journal/sea_clock.h"
#include "server/refused_changes.h"
#include "server/simulation/simulation.h"

namespace seaway::server {

/// `window`: when it runs.
protocol::SeaStateValues sea_state_values(const RunningSea& sea, const EpochWindow& window,
                                          const std::vector<std::string>& warnings);

/// The same with the probes of a steady sea, which cost 16 times of its exact sum: for the message.
protocol::SeaStateValues announcement(const RunningSea& sea, const EpochWindow& window,
                                      const std::vector<std::string>& warnings);

std::string state_json(const RunningSea& sea, const std::vector<std::string>& warnings,
                       const std::string& device, const SeaMoment& at,
                       const std::optional<Following>& following = {},
                       const RefusedChanges::Counts& refused = {});
std::string plan_json(const RunningSea& sea, const EffectPlan& plan,
                      const SimulationCounters& counters, const EffectCosts& costs,
                      const std::string& device, const SeaMoment& at);
std::string metrics_text(const EffectPlan& plan, const SimulationCounters& counters,
                         const EffectCosts& costs, const SeaMoment& at);

} // namespace seaway::server
