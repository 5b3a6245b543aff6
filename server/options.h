// SPDX-License-Identifier: Apache-2.0
// The command line of seaway-server. The sea is in the scene file; these are the process.
#pragma once

#include <string>
#include <variant>

#include "server/journal/open_journal.h"
#include "server/net/options.h"

namespace seaway::server {

struct Options {
    std::string scene;
    std::string config; ///< file of options; empty: none
    NetOptions net;
    std::string device = "auto";    ///< auto | list | name part | index
    std::string readback = "exact"; ///< exact | rounded (server/simulation/readback.h)
    JournalPlace journal;           ///< none: the sea ends with the process
    int answer_threads = 0;         ///< that answer points; 0: answer_threads_default()
    double work_rate = 1;     ///< of each session: share of the threads that work for those who ask
    double work_burst_s = 10; ///< of each session: work asked for at once, beyond the rate, s
    int memory_mb =
        0; ///< MiB for what is held for those who ask (host/memory.h); 0: what the sea needs
    std::string log = "text"; ///< text | json
    bool check = false;       ///< look at everything, serve nothing
    bool validation = false;  ///< Vulkan validation layers; their messages are errors
};

/// Exit codes of seaway-server: the public contract.
enum ExitCode : int {
    exit_stopped = 0,
    exit_usage = 2,
    exit_no_device = 3,
    exit_cannot_listen = 4,
    exit_no_journal = 5 ///< NATS cannot be reached, or the disk is full; it passes with that
};

/// The options, or the exit code after --help, --version (0) or a usage error (2), which has been
/// printed.
std::variant<Options, int> read_options(int argc, char** argv);

} // namespace seaway::server
