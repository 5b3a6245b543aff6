// SPDX-License-Identifier: Apache-2.0
// `seaway-bench effects`: what every effect of every cascade of a scene costs for each second of sea, alone
// and on top of the rest; what is asked for, and what it would cost if everything ran. docs/effects.md
// shows it.
//
// Maps (synthesis, and the history of foam) and one stream that all clients share (encoding, bytes) are
// kept apart. CPU time of this process, so that other programs do not count.
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "sea/basics/field.h"
#include "tools/bench/usual_scene.h"

namespace seaway::bench {

struct EffectsOptions {
    std::string scene = usual_scene();
    std::string device = "auto";  ///< auto | native | index or part of a name
    std::vector<std::string> ask; ///< effects, as height,choppy; empty: all that the scene allows
    std::string out = "out/bench";
    int rounds = 9; ///< of 2 s of sea each
};

/// Prints a table; writes effects.csv into `out`. Rows, each for one second of sea:
///     everything   all effects of all cascades, whatever the scene allows, and they together
///     asked        those of `ask` that the scene allows
///     effect       one effect of one cascade, alone; and on top of all others of that cascade
///     cascade      all effects of one cascade
Result<void> run_effects(const EffectsOptions& options);

/// The fields of effects by name, of those that are offered; all of them if none is named.
Result<sea::FieldSet> fields_asked(const std::vector<std::string>& names, sea::FieldSet offered);

} // namespace seaway::bench
