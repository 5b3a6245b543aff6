// SPDX-License-Identifier: Apache-2.0
// Do two who look at the same sea see the same sea? Two clients draw at 144 and 30 frames a second, each behind a
// line of its own (tests/support/fault_proxy.h); the line of the first breaks, and it connects again; the process
// of the second is stopped for a while. Some seconds after the last of it their heights at the same moments and
// places are compared.
//
//     load_two_clients                                 half a minute, both lines 60 +- 20 ms there and back
//     load_two_clients --pause 2 --measure 2 --bound 0.05     as ./dev test runs it
//
// Frames of both are at different moments: between two of the faster one's it is interpolated, which at 7 ms is
// good to 0.1 mm. Prints how far apart they are and what share of frames had no keyframes around them. Where a
// crowded machine has drawn next to nothing that can be compared it is done again, three times in all. Exit code
// 1: more than --bound apart at the 99th percentile, a fifth of the frames without keyframes, or next to no frames.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <optional>
#include <thread>

#include <fmt/format.h>
#include <unistd.h>

#include "base/child_process.h"
#include "base/command_line.h"
#include "base/quantile.h"
#include "client/client.h"
#include "tests/support/fault_proxy.h"
#include "tests/support/folder.h"
#include "tests/support/server_process.h"

using namespace seaway;
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

namespace {

struct Options {
    std::string scene = "scenes/north_sea_gale.toml";
    double pause_s = 10;
    double settle_s = 5;
    double measure_s = 10;
    double delay_ms = 30;
    double jitter_ms = 10;
    double bound_m = 0.01;
    // Of a client, which is this program too:
    std::string play;
    std::string out;
    int frames_per_s = 60;
    double seconds = 0;
    double pause_at_s = 0;
};

constexpr std::size_t places = 16;

/// What a client has shown.
struct Frame {
    double clock_s = 0;
    std::array<float, places> height_m{};
    std::uint32_t flags = 0;
};

double clock_s() {
    return Seconds(Clock::now().time_since_epoch()).count();
}

/// Stops this process as a debugger or a closed lid would; a helper lets it go on.
void stand_still(double seconds) {
    const pid_t self = ::getpid();
    if (::fork() == 0) {
        ::usleep(static_cast<useconds_t>(1e6 * seconds));
        ::kill(self, SIGCONT);
        std::_Exit(0);
    }
    ::raise(SIGSTOP);
}

std::unique_ptr<client::Client> connected(const std::string& url, double until_s) {
    while (clock_s() < until_s) {
        auto client = client::Client::connect({.url = url, .timeout_s = 5});
        if (client && (*client)->subscribe({.fields = sea::surface_fields, .compact = true}, 2, 10))
            return *std::move(client);
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return nullptr;
}

/// A frame now; none if it took so long to look at two clocks that they do not belong together.
std::optional<Frame> shown(client::Client& client) {
    Frame frame;
    const double before_s = clock_s();
    const sea::TimeUs now_us = client.now_us();
    const double after_s = clock_s();
    frame.clock_s = (before_s + after_s) / 2;
    std::array<sea::QueryPoint, places> points;
    for (std::size_t i = 0; i < places; ++i)
        points[i] = {137.0 * static_cast<double>(i), -59.0 * static_cast<double>(i * i), now_us};
    const auto answers = client.sample(points);
    if (!answers || after_s - before_s > 2e-4)
        return std::nullopt;
    for (std::size_t i = 0; i < places; ++i) {
        frame.height_m[i] = static_cast<float>((*answers)[i].height_m);
        frame.flags |= (*answers)[i].flags;
    }
    return frame;
}

/// A client: frames until its time is over, on `out`.
int play(const Options& options) {
    const double begin_s = clock_s();
    const double end_s = begin_s + options.seconds;
    bool paused = options.pause_at_s == 0;
    std::vector<Frame> frames;
    std::unique_ptr<client::Client> client = connected(options.play, end_s);
    int connections = 1;
    while (client && clock_s() < end_s) {
        const auto next = Clock::now() + Seconds(1.0 / options.frames_per_s);
        if (!paused && clock_s() >= begin_s + options.pause_at_s) {
            paused = true;
            stand_still(options.pause_s);
        }
        if (!client->is_open()) {
            client = connected(options.play, end_s);
            ++connections;
            continue;
        }
        if (const auto frame = shown(*client))
            frames.push_back(*frame);
        std::this_thread::sleep_until(next);
    }
    fmt::print("{} frames a second: {} frames, connected {} times\n", options.frames_per_s,
               frames.size(), connections);
    std::ofstream(options.out, std::ios::binary)
        .write(reinterpret_cast<const char*>(frames.data()),
               static_cast<std::streamsize>(frames.size() * sizeof(Frame)));
    return client ? 0 : 1; // of no frames 0, too: whoever compares them sees that there are none
}

std::vector<Frame> frames_in(const std::string& path, double from_s) {
    std::ifstream in(path, std::ios::binary);
    std::vector<Frame> frames;
    for (Frame frame; in.read(reinterpret_cast<char*>(&frame), sizeof frame);)
        if (frame.clock_s >= from_s)
            frames.push_back(frame);
    return frames;
}

struct Comparison {
    std::vector<double> apart_m{};
    std::size_t frames = 0;
    std::size_t without_keyframes = 0;
    std::size_t compared() const { return frames - without_keyframes; }
};

/// Fewer say nothing.
constexpr std::size_t frames_min = 20;
bool says_something(const Comparison& found) {
    return found.compared() >= frames_min && 5 * found.without_keyframes < found.frames;
}
constexpr int rounds_max = 3;

/// Between frames that are further apart nothing is compared. A height that falls with half of g, as a crest does that is about to
/// break and the gale's do less than one time in a hundred (1.7 m/s2 rms), leaves the straight line between two of them by gap^2 g / 16 at
/// most: no more than a twentieth of the bound, and 1.5 mm in 50 ms.
double gap_s_max(double bound_m) {
    constexpr double gravity_mps2 = 9.81;
    return std::clamp(std::sqrt(16 * bound_m / 20 / gravity_mps2), 0.015, 0.05);
}

Comparison compare(const std::vector<Frame>& fast, const std::vector<Frame>& slow, double gap_s) {
    Comparison found;
    for (const Frame& frame : slow) {
        const auto after =
            std::lower_bound(fast.begin(), fast.end(), frame.clock_s,
                             [](const Frame& one, double clock) { return one.clock_s < clock; });
        if (after == fast.begin() || after == fast.end() ||
            after->clock_s - std::prev(after)->clock_s > gap_s)
            continue;
        const Frame& before = *std::prev(after);
        const double share = (frame.clock_s - before.clock_s) / (after->clock_s - before.clock_s);
        ++found.frames;
        if (((frame.flags | before.flags | after->flags) & sea::answer_extrapolated) != 0) {
            ++found.without_keyframes; // and says so: its heights are no promise
            continue;
        }
        for (std::size_t i = 0; i < places; ++i) {
            const double a = static_cast<double>(before.height_m[i]);
            const double b = static_cast<double>(after->height_m[i]);
            found.apart_m.push_back(
                std::abs(a + share * (b - a) - static_cast<double>(frame.height_m[i])));
        }
    }
    return found;
}

/// Starts the client that draws so many frames a second behind this line.
Result<ChildProcess> client_behind(const tests::FaultProxy& line, const Options& options,
                                   int frames_per_s, double pause_at_s, double seconds,
                                   const std::string& out) {
    return ChildProcess::start(
        {std::string(SEAWAY_BIN_DIR) + "/load_two_clients", "--play",
         fmt::format("ws://127.0.0.1:{}", line.port()), "--out", out, "--frames-per-s",
         std::to_string(frames_per_s), "--pause-at", std::to_string(pause_at_s), "--pause",
         std::to_string(options.pause_s), "--seconds", std::to_string(seconds)});
}

/// What two clients of the server at this port have drawn; nothing where one of them failed.
std::optional<Comparison> measured(const Options& options, int port) {
    const auto us = [](double ms) { return std::chrono::microseconds(std::llround(1000 * ms)); };
    const tests::LineFaults faults{.delay = us(options.delay_ms), .jitter = us(options.jitter_ms)};
    tests::FaultProxy fast_line(port, faults, 1);
    tests::FaultProxy slow_line(port, faults, 2);
    constexpr double event_s = 3;
    const double last_event_s = clock_s() + event_s + options.pause_s;
    const double seconds = event_s + options.pause_s + options.settle_s + options.measure_s;
    const std::string folder = tests::folder().file("two_clients");
    auto fast = client_behind(fast_line, options, 144, 0, seconds, folder + "_fast");
    auto slow = client_behind(slow_line, options, 30, event_s, seconds, folder + "_slow");
    if (!fast || !slow) {
        fmt::print(stderr, "{}\n", (fast ? slow : fast).error().message);
        return std::nullopt;
    }
    std::this_thread::sleep_for(Seconds(event_s + options.pause_s));
    fast_line.cut();
    if (fast->wait().code != 0 || slow->wait().code != 0) {
        fmt::print(stderr, "a client did not end well\n");
        return std::nullopt;
    }
    const double from_s = last_event_s + options.settle_s;
    return compare(frames_in(folder + "_fast", from_s), frames_in(folder + "_slow", from_s),
                   gap_s_max(options.bound_m));
}

int meet(const Options& options) {
    tests::ServerProcess server({options.scene, "--listen", "127.0.0.1:0", "--device", "native"});
    const std::string url = server.wait_until_ready();
    if (url.empty()) {
        fmt::print(stderr, "the server did not start:\n{}", server.log());
        return 1;
    }
    std::optional<Comparison> found = measured(options, tests::port_of(url));
    for (int round = 1; round < rounds_max && found && !says_something(*found); ++round)
        found = measured(options, tests::port_of(url));
    if (!found)
        return 1;
    if (!says_something(*found)) {
        fmt::print(stderr, "of {} frames {} without keyframes around them: that is no sea\n",
                   found->frames, found->without_keyframes);
        return 1;
    }
    const auto apart_mm = [&](double share) { return 1000 * quantile(found->apart_m, share); };
    fmt::print(
        "{} frames compared, {} without keyframes around them; apart: p50 {:.2f}, p99 {:.2f}, "
        "most {:.2f} mm\n",
        found->frames, found->without_keyframes, apart_mm(0.5), apart_mm(0.99), apart_mm(1));
    return apart_mm(0.99) <= 1000 * options.bound_m ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
    Options options;
    CommandLine line("load_two_clients", "Two clients behind bad lines see the same sea.");
    line.option("--scene", options.scene, "Scene of the server").takes("FILE");
    line.option("--pause", options.pause_s, "That a process stands still").between(0.1, 1e4);
    line.option("--settle", options.settle_s, "From the last event on").between(0.0, 1e4);
    line.option("--measure", options.measure_s, "Compared").between(1.0, 1e5);
    line.option("--delay", options.delay_ms, "Of a line, each way, ms").between(0.0, 1e4);
    line.option("--jitter", options.jitter_ms, "More or less, ms").between(0.0, 1e4);
    line.option("--bound", options.bound_m, "At the 99th percentile, m").between(0.0, 1e3);
    line.option("--play", options.play, "Be a client of this server").takes("URL");
    line.option("--out", options.out, "Where a client leaves its frames").takes("FILE");
    line.option("--frames-per-s", options.frames_per_s, "Of a client").between(1, 1000);
    line.option("--seconds", options.seconds, "That a client lives").between(0.0, 1e5);
    line.option("--pause-at", options.pause_at_s, "Of a client; 0: never").between(0.0, 1e5);
    const Result<CommandLine::Next> next = line.read(argc, argv);
    if (!next) {
        fmt::print(stderr, "{}\n", next.error().message);
        return 2;
    }
    if (*next == CommandLine::Next::leave)
        return 0;
    return options.play.empty() ? meet(options) : play(options);
}
