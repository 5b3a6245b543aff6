// SPDX-License-Identifier: Apache-2.0
// Clients that send messages with mistakes in them, a million by default, before a server that is started for it,
// beside one who subscribes and asks a hundred single points a second. What mistakes leave right is asked, too: far
// times, many points, fetches.
//
//     load_mutated [--messages N] [--attackers N] [--server PROGRAM]
//
// Prints how many were sent, what the healthy one was answered and when, what it lost, and the server's memory. Exit
// code 1: it was not answered throughout, its session ended, or the server did not end in order afterwards.
#include <cstdio>
#include <memory>
#include <thread>

#include <fmt/format.h>

#include "base/command_line.h"
#include "tests/load/swarm/crew.h"
#include "tests/load/swarm/figures.h"
#include "tests/load/swarm/peer.h"
#include "tests/support/server_process.h"

using namespace seaway;
using namespace seaway::tests;
using namespace seaway::tests::swarm;

namespace {

struct Options {
    std::uint64_t messages = 1'000'000;
    int attackers = 4;
    std::uint64_t seed = 1;
    std::string server = SEAWAY_BIN_DIR "/seaway-server";
};

void pause_s(double seconds) {
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

std::unique_ptr<Tally> sum_of(const Crew& crew) {
    auto sum = std::make_unique<Tally>();
    for (const Tally* one : crew.tallies()) {
        sum->answer += one->answer;
        sum->keyframes += one->keyframes;
        sum->lost += one->lost;
        sum->ended += one->ended;
        sum->refused += one->refused;
    }
    return sum;
}

int run(const Options& options) {
    ServerProcess server({"scenes/north_sea_gale.toml", "--listen", "127.0.0.1:0", "--device",
                          "native", "--connections-per-address", "0",
                          "--sessions-without-hello-per-address", "0",
                          "--request-bytes-per-address", "0"},
                         -1, options.server);
    const std::string url = server.wait_until_ready();
    if (url.empty()) {
        fmt::print(stderr, "the server did not start:\n{}", server.log());
        return 1;
    }
    const int port = port_of(url);
    Stage& stage = shared<Stage>();
    Crew healthy(stage);
    healthy.send({.port = port, .readers = 1, .wish = {.fields = sea::surface_fields}});
    healthy.send({.port = port, .askers = 1});
    while (stage.greeted < 2)
        pause_s(0.01);
    stage.subscribe = true;
    pause_s(2);
    const Figures before = figures_of(server.pid());
    const double begin_s = clock_s();
    stage.measure = true;
    Crew attackers(stage);
    for (int i = 0; i < options.attackers; ++i)
        attackers.send({.port = port, .mutates = options.seed + static_cast<std::uint64_t>(i)});
    while (stage.mutated < options.messages &&
           server.wait_for_exit(std::chrono::milliseconds(0)) == std::nullopt)
        pause_s(0.05);
    const double seconds = clock_s() - begin_s;
    const Figures after = figures_of(server.pid());
    stage.measure = false;
    stage.end = true;
    const bool well = healthy.come_home();
    (void)attackers.come_home(); // whose connections the server ends
    const std::unique_ptr<Tally> sum = sum_of(healthy);
    std::uint64_t attacks = 0;
    for (const Tally* one : attackers.tallies())
        attacks += one->attacks;
    server.send(SIGTERM);
    const auto exit_code = server.wait_for_exit(std::chrono::seconds(20));
    fmt::print("{} messages in {} sessions, {:.0f} s; the healthy one: {} answers, {} refused, p50 "
               "{:.1f}, p99 "
               "{:.1f}, longest {:.1f} ms, {} keyframes, {} lost; server: {:.1f} s of processor, "
               "{:.0f} MB before, "
               "{:+.0f}, exit code {}\n",
               stage.mutated.load(), attacks, seconds, sum->answer.count(), sum->refused,
               sum->answer.quantile_ms(0.5), sum->answer.quantile_ms(0.99),
               sum->answer.quantile_ms(1), sum->keyframes, sum->lost, after.cpu_s - before.cpu_s,
               before.resident_mb, after.resident_mb - before.resident_mb, exit_code.value_or(-1));
    // Ten answers a second are few, and more than somebody gets who is cut off for some seconds.
    const bool answered = static_cast<double>(sum->answer.count()) >= 10 * seconds &&
                          sum->answer.quantile_ms(1) < 5000;
    return well && answered && sum->ended == 0 && sum->refused == 0 && exit_code == 0 ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
    Options options;
    CommandLine line("load_mutated", "Messages with mistakes in them before a live server.");
    line.option("--messages", options.messages, "To be sent").takes("N").shows_default();
    line.option("--attackers", options.attackers, "Processes").between(1, 64).shows_default();
    line.option("--seed", options.seed, "Of the mistakes").takes("N").shows_default();
    line.option("--server", options.server, "Program").takes("PROGRAM");
    const Result<CommandLine::Next> next = line.read(argc, argv);
    if (!next) {
        fmt::print(stderr, "{}\n", next.error().message);
        return 2;
    }
    return *next == CommandLine::Next::leave ? 0 : run(options);
}
