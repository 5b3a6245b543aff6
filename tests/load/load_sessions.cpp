// SPDX-License-Identifier: Apache-2.0
// Crowds of sessions on a clock and on links of their own (tests/server/net/simulated/crowd.h), one seed
// after the other, for as long as there is time. A crowd in which a promise is broken ends it with exit
// code 1, the promise, what came before it, and the seed, which lives through the same again.
//
//     load_sessions [--first SEED] [--seeds COUNT] [--minutes MINUTES]
#include <chrono>
#include <cstdio>
#include <map>

#include <fmt/format.h>

#include "base/command_line.h"
#include "tests/server/net/simulated/crowd.h"

int main(int argc, char** argv) {
    using namespace seaway;
    std::uint64_t first = 1;
    std::uint64_t seeds = 100;
    double minutes = 0;
    CommandLine line("load_sessions", "Crowds of sessions without sockets, by lot.");
    line.option("--first", first, "The first seed").takes("SEED").shows_default();
    line.option("--seeds", seeds, "At least so many").takes("COUNT").shows_default();
    line.option("--minutes", minutes, "And for so long").between(0.0, 1e7).takes("MINUTES");
    const Result<CommandLine::Next> next = line.read(argc, argv);
    if (!next) {
        fmt::print(stderr, "{}\n", next.error().message);
        return 2;
    }
    if (*next == CommandLine::Next::leave)
        return 0;
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + std::chrono::duration<double>(60 * minutes);
    std::map<std::string, std::uint64_t> seen;
    std::uint64_t crowds = 0;
    while (crowds < seeds || Clock::now() < end) {
        const std::uint64_t seed = first + crowds++;
        const auto outcome = tests::simulated::live_through(seed);
        if (!outcome.broken.empty()) {
            fmt::print("seed {}:\n{}\nagain: load_sessions --first {} --seeds 1\n", seed,
                       outcome.broken, seed);
            return 1;
        }
        for (const auto& [what, count] : outcome.seen)
            seen[what] += count;
    }
    fmt::print("{} crowds, every promise kept\n", crowds);
    for (const auto& [what, count] : seen)
        fmt::print("{:>12}  {}\n", count, what);
    return 0;
}
