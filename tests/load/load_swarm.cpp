// SPDX-License-Identifier: Apache-2.0
// A swarm of clients on loopback, in processes of their own, before a server that is started for it: what it
// costs the server, and what the clients see of it.
//
//     load_swarm SCENARIO [--server PROGRAM[,PROGRAM...]] [--credit N[,N...]] [--rounds N] [--clients N] [--seconds S] ...
//
// Scenarios: crowd (1000 clients, keyframes of 20 KB at 20 Hz), gale (300 clients, every field of the gale),
// stalled (500, of whom 100 never read), answers (200 readers, and one who asks single points), flooded (and one
// who asks for 16 x 4096 points at far times again and again). With several servers each round runs each of
// them, so that builds are compared on the same machine at the same time. With several credits likewise: of up to 3
// each keyframe is acknowledged by itself, of 4 and 5 two together, of 8 four, where the server takes that. With --attach
// PORT:PID it goes to a server that runs, and counts what that process uses. Prints a CSV row a run:
//   acks_a_keyframe  Acks that were sent over the keyframes that came
//   cpu_cores        processor time of the server over the time measured, all threads
//   busiest_cores    of its busiest thread, which is the one of the network under load
//   us_a_message     processor time of the server over the messages that arrived
//   age_ms           from when a keyframe is due to be published to when a client had all of it, by sea time:
//                    what the schedule leads by is not in it
//   lost             keyframes of which a client saw a newer one of the same cascade, but not them
//   answer_ms        a single point asked to its answer
//   age_there_ms, answer_there_ms  the same until the system of the client had it, by its stamps: on cores that
//                    swarm and server share, a client may wait for one longer than for the server
//   rss_mb           of the server when measuring began, and how it had changed at the end
//   messages_a_s     that arrived; answers_a_s: single points answered
//   load             of the machine, which holds the swarm too: with few cores ages are upper bounds
// Ends by itself; exit code 1 where a session was ended by the server.
#include <cstdio>
#include <thread>

#include <fmt/format.h>
#include <poll.h>

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
    std::string scenario;
    std::vector<std::string> servers{SEAWAY_BIN_DIR "/seaway-server"};
    std::string scene;
    std::string fields;
    std::string device = "native";
    std::string attach;
    int clients = -1;
    int stalled = -1;
    int askers = -1;
    double asks_a_second = 100;
    double pings_a_second = 0;
    int processes = 2;
    int rounds = 1;
    std::vector<int> credits{4};
    double seconds = 0;
    double warm_up_s = 3;
    double error_m = 0;
    int nice = 0;
    bool compact = false;
    bool predicted = false;
};

struct Scenario {
    const char* name;
    const char* scene;
    const char* fields;
    int clients;
    int stalled;
    double seconds;
    double error_m; ///< that clients are content with; 0: the scene's
    int askers;
    bool floods;
};

constexpr Scenario scenarios[] = {
    {"crowd", "tests/load/twenty_hertz.toml", "height", 1000, 0, 20, 0.0025, 0, false},
    {"gale", "scenes/north_sea_gale.toml", "all", 300, 0, 20, 0, 0, false},
    {"stalled", "scenes/north_sea_gale.toml", "surface", 400, 100, 60, 0, 0, false},
    {"answers", "scenes/north_sea_gale.toml", "surface", 200, 0, 20, 0, 1, false},
    {"flooded", "scenes/north_sea_gale.toml", "surface", 200, 0, 20, 0, 1, true},
};

/// What is loaded: a server of its own, or one that runs.
struct Target {
    int port = 0;
    pid_t pid = 0;
};

sea::FieldSet fields_called(const std::string& name) {
    if (name == "none")
        return {};
    if (name == "height")
        return {sea::Field::height};
    return name == "surface" ? sea::surface_fields : sea::all_fields;
}

/// How far sea time is ahead of the steady clock: of twenty looks the one that came back soonest.
double sea_minus_clock(Peer& peer) {
    std::vector<std::uint8_t> scratch;
    Tally nobody;
    const Stage nothing;
    double best_s = 1e9;
    double ahead_s = 0;
    for (int i = 0; i < 20; ++i) {
        const double asked_s = clock_s();
        const std::uint32_t before = peer.answers();
        peer.send(protocol::ping(1, 0));
        while (peer.answers() == before) {
            pollfd readable{.fd = peer.handle(), .events = POLLIN, .revents = 0};
            ::poll(&readable, 1, 1000);
            if (!peer.take(scratch, nobody, nothing))
                return 0;
        }
        const double back_s = clock_s();
        if (back_s - asked_s < best_s) {
            best_s = back_s - asked_s;
            ahead_s = 1e-6 * static_cast<double>(peer.sea_time_us()) - (asked_s + back_s) / 2;
        }
    }
    return ahead_s;
}

void send_out(Crew& crew, const Options& options, const Scenario& scenario, int credit, int port) {
    const auto share = [&](int of, int which) {
        return of / options.processes + (which < of % options.processes ? 1 : 0);
    };
    Errand errand{.port = port,
                  .asks_a_second = options.asks_a_second,
                  .pings_a_second = options.pings_a_second,
                  .wish = {.fields = fields_called(options.fields),
                           .error_m = static_cast<float>(options.error_m),
                           .compact = options.compact || options.predicted,
                           .predicted = options.predicted},
                  .credit = credit,
                  .nice = options.nice};
    for (int i = 0; i < options.processes; ++i) {
        errand.readers = share(options.clients, i);
        errand.stalled = share(options.stalled, i);
        crew.send(errand);
    }
    errand.readers = errand.stalled = 0;
    if (options.askers > 0) {
        errand.askers = options.askers;
        errand.nice = 0;
        crew.send(errand);
    }
    if (scenario.floods) {
        errand.askers = 0;
        errand.nice = options.nice;
        errand.floods = true;
        crew.send(errand);
    }
}

/// Of "PORT:PID"; nothing of anything else.
Target target_of(const std::string& words) {
    Target target;
    const int read = std::sscanf(words.c_str(), "%d:%d", &target.port, &target.pid);
    return read == 2 ? target : Target{};
}

void pause(double seconds) {
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

/// A row; false if a session was ended by the server.
bool load(const Options& options, const Scenario& scenario, const std::string& program, int credit,
          int round, const Target& server) {
    Stage& stage = shared<Stage>();
    Crew crew(stage);
    send_out(crew, options, scenario, credit, server.port);
    Peer clock(server.port, 0);
    while (stage.greeted <
           options.clients + options.stalled + options.askers + int{scenario.floods})
        pause(0.02);
    stage.sea_minus_clock_s = sea_minus_clock(clock);
    stage.subscribe = true;
    pause(options.warm_up_s);
    const Figures before = figures_of(server.pid);
    const double begun_s = clock_s();
    stage.measure = true;
    pause(options.seconds);
    stage.measure = false;
    const double seconds = clock_s() - begun_s;
    const Figures after = figures_of(server.pid);
    stage.end = true;
    if (!crew.come_home())
        return false;
    auto sum = std::make_unique<Tally>();
    for (const Tally* one : crew.tallies())
        *sum += *one;
    const double cpu_s = after.cpu_s - before.cpu_s;
    const auto of = [](std::uint64_t count) { return static_cast<double>(count); };
    fmt::print("{},{},{},{},{},{},{:.1f},{:.0f},{:.2f},{:.1f},{:.1f},{:.3f},{:.3f},{:.2f},{:.1f},{:"
               ".1f},{:.1f},{},"
               "{:.1f},{:.1f},{:.1f},{},{},{:.1f},{:+.1f},{:.1f},{:.0f},{:.0f}\n",
               scenario.name, program, round, options.clients, options.stalled, credit, seconds,
               of(sum->keyframes) / seconds,
               of(sum->acks) / of(std::max(sum->keyframes, std::uint64_t{1})),
               of(sum->bytes) / of(std::max(sum->keyframes, std::uint64_t{1})) / 1e3,
               of(sum->bytes) / seconds / 1e6, cpu_s / seconds, busiest_s(before, after) / seconds,
               1e6 * cpu_s / of(std::max(sum->messages, std::uint64_t{1})),
               sum->age.quantile_ms(0.5), sum->age.quantile_ms(0.99),
               sum->age_there.quantile_ms(0.99), sum->lost, sum->answer.quantile_ms(0.5),
               sum->answer.quantile_ms(0.99), sum->answer_there.quantile_ms(0.99), sum->refused,
               sum->ended, before.resident_mb, after.resident_mb - before.resident_mb,
               machine_load(), of(sum->messages) / seconds, of(sum->answer.count()) / seconds);
    std::fflush(stdout);
    return sum->ended == 0;
}

/// Of a server that is started for it.
bool run(const Options& options, const Scenario& scenario, const std::string& program, int credit,
         int round) {
    ServerProcess server({options.scene, "--listen", "127.0.0.1:0", "--device", options.device,
                          "--sessions-max", "4000", "--connections-max", "5000",
                          "--connections-per-address", "0", "--sessions-without-hello-per-address",
                          "0", "--request-bytes-per-address", "0"},
                         -1, program);
    const std::string url = server.wait_until_ready();
    if (url.empty()) {
        fmt::print(stderr, "{} did not start:\n{}", program, server.log());
        return false;
    }
    return load(options, scenario, program, credit, round,
                {.port = port_of(url), .pid = server.pid()});
}

Result<const Scenario*> read(int argc, char** argv, Options& options) {
    CommandLine line("load_swarm", "Many clients on loopback before a server of their own.");
    line.option("scenario", options.scenario, "crowd, gale, stalled, answers or flooded")
        .required();
    line.option("--server", options.servers, "Programs").takes("PROGRAM,...").separated_by(',');
    line.option("--scene", options.scene, "Scene of the server").takes("FILE");
    line.option("--device", options.device, "Device of the server").takes("NAME");
    line.option("--fields", options.fields, "Of the maps").takes("height|surface|all|none");
    line.option("--clients", options.clients, "That read").between(0, 4000);
    line.option("--stalled", options.stalled, "That subscribe and never read").between(0, 4000);
    line.option("--askers", options.askers, "That ask single points").between(0, 4000);
    line.option("--asks", options.asks_a_second, "Of each of them, a second")
        .between(0.01, 1e3)
        .shows_default();
    line.option("--pings", options.pings_a_second, "Of each that reads, a second")
        .between(0.0, 1e3)
        .shows_default();
    line.option("--attach", options.attach, "A server that runs").takes("PORT:PID");
    line.option("--processes", options.processes, "Of the swarm").between(1, 64).shows_default();
    line.option("--nice", options.nice,
                "How far readers and floods stand back for the server, and for who asks, whose "
                "processors they are not where they are on machines of their own")
        .between(0, 19)
        .shows_default();
    line.option("--rounds", options.rounds, "Runs of each server").between(1, 1000);
    line.option("--credit", options.credits,
                "Of each client, 1 to 8; with several each round runs each of them")
        .takes("N,...")
        .separated_by(',')
        .between(1, 8);
    line.option("--seconds", options.seconds, "Measured").between(0.0, 1e5);
    line.option("--warm-up", options.warm_up_s, "Seconds before that").between(0.0, 1e5);
    line.option("--error", options.error_m, "Wanted of the tiles, m").between(0.0, 1e6);
    line.option("--compact", options.compact, "Clients take compact maps");
    line.option("--predicted", options.predicted, "And differences to earlier keyframes");
    SEAWAY_TRY_LET(const CommandLine::Next next, line.read(argc, argv));
    if (next == CommandLine::Next::leave)
        std::exit(0);
    if (!options.attach.empty() && target_of(options.attach).pid <= 0)
        return Error{"--attach: PORT:PID"};
    for (const Scenario& scenario : scenarios)
        if (scenario.name == options.scenario)
            return &scenario;
    return Error{"scenario: crowd, gale, stalled, answers or flooded"};
}

} // namespace

int main(int argc, char** argv) {
    Options options;
    const Result<const Scenario*> scenario = read(argc, argv, options);
    if (!scenario) {
        fmt::print(stderr, "{}\n", scenario.error().message);
        return 2;
    }
    const Scenario& chosen = **scenario;
    options.scene = options.scene.empty() ? chosen.scene : options.scene;
    options.fields = options.fields.empty() ? chosen.fields : options.fields;
    options.clients = options.clients < 0 ? chosen.clients : options.clients;
    options.stalled = options.stalled < 0 ? chosen.stalled : options.stalled;
    options.askers = options.askers < 0 ? chosen.askers : options.askers;
    options.error_m = options.error_m == 0 ? chosen.error_m : options.error_m;
    options.seconds = options.seconds == 0 ? chosen.seconds : options.seconds;
    fmt::print("scenario,server,round,clients,stalled,credit,seconds,keyframes_a_s,acks_a_keyframe,"
               "kb_a_keyframe,mb_a_s,cpu_cores,busiest_cores,us_a_message,age_ms_p50,age_ms_p99,"
               "age_there_ms_p99,"
               "lost,answer_ms_p50,answer_ms_p99,answer_there_ms_p99,refused,ended,rss_mb,rss_"
               "grown_mb,load,"
               "messages_a_s,answers_a_s\n");
    std::fflush(stdout);
    bool well = true;
    if (const Target running = target_of(options.attach); running.pid > 0)
        return load(options, chosen, options.attach, options.credits.front(), 1, running) ? 0 : 1;
    for (int round = 1; round <= options.rounds; ++round)
        for (const std::string& program : options.servers)
            for (const int credit : options.credits)
                well = run(options, chosen, program, credit, round) && well;
    return well ? 0 : 1;
}
