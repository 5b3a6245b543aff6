// SPDX-License-Identifier: Apache-2.0
// A day at sea in some minutes: does anything grow, drift or break its bound while servers come and go? One client goes
// through the hours of a sea, has the keyframes around each moment sent and samples points; the exact sum of the server says
// every so often what is true. Its line is cut each quarter of an hour of sea time, the server is killed and started again
// on its journal each hour; the client is the same one throughout and comes back by itself.
//
//     load_soak                                   24 h of the gale, a moment every 5 s: 17 280 moments
//     load_soak --hours 0.5 --step 10 --restart 600 --cut 200 --growth 1     as ./dev test runs it
//
// Times are those of one sea from its beginning on, which a restarted server has to go on with: the answers at the first
// moment are asked for again after each restart, and have to be the same bits. Prints how many answers were held to the
// sum, the worst share of a bound, what the client held an eighth into the run and at its end, and what the first server
// and the last one held at the ends of their lives, MB. Exit code 1: an unflagged answer beyond its bound, another sea
// after a restart, a client that did not come back, or one of the two grown by more than --growth.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <memory>
#include <thread>

#include <fmt/format.h>

#include "base/command_line.h"
#include "client/client.h"
#include "tests/support/draw.h"
#include "tests/support/fault_proxy.h"
#include "tests/support/folder.h"
#include "tests/support/nats_server.h"
#include "tests/support/process_status.h"
#include "tests/support/server_process.h"

using namespace seaway;
using Clock = std::chrono::steady_clock;

namespace {

struct Options {
    std::string scene = "scenes/north_sea_gale.toml";
    double hours = 24;
    double step_s = 5;
    double cut_s = 900;
    double restart_s = 3600;
    int points = 32;
    int exact_every = 10;
    double growth = 0.1;
};

constexpr std::uint32_t no_promise =
    sea::answer_folded | sea::answer_not_converged | sea::answer_extrapolated;

/// A server on one port and one journal, started as often as it takes.
class Servers {
  public:
    Servers(std::string scene, std::string folder)
        : scene_(std::move(scene)), folder_(std::move(folder)) {}

    bool start() {
        server_ = std::make_unique<tests::ServerProcess>(
            std::vector<std::string>{scene_, "--listen", fmt::format("127.0.0.1:{}", port_),
                                     "--device", "native", "--data-dir", folder_});
        const bool ready = !server_->wait_until_ready().empty();
        if (!ready)
            fmt::print(stderr, "the server did not start:\n{}", server_->log());
        return ready;
    }
    bool kill_and_start() {
        server_->send(SIGKILL);
        server_->wait_for_exit(std::chrono::seconds(30));
        return start();
    }
    int port() const { return port_; }
    pid_t pid() const { return server_->pid(); }

  private:
    std::string scene_, folder_;
    const int port_ = tests::free_port(); ///< which nobody is given while it is down
    std::unique_ptr<tests::ServerProcess> server_;
};

struct Found {
    std::uint64_t answers = 0, flagged = 0, held_to_the_sum = 0, beyond = 0;
    int cuts = 0, restarts = 0;
    double worst_share = 0;
    double client_mb = 0; ///< an eighth into the run
    double server_mb = 0; ///< at the end of the first server's life
};

class Voyage {
  public:
    Voyage(const Options& options, Servers& servers, tests::FaultProxy& line,
           client::Client& client)
        : options_(options), servers_(servers), line_(line), client_(client) {}

    /// In words what went wrong; empty: nothing.
    std::string sail() {
        const auto moments = static_cast<std::int64_t>(options_.hours * 3600 / options_.step_s);
        const auto each = [&](double seconds) {
            return std::max<std::int64_t>(1, std::llround(seconds / options_.step_s));
        };
        for (std::int64_t n = 0; n < moments; ++n) {
            if (n > 0 && n % each(options_.restart_s) == 0) {
                if (found_.restarts == 0)
                    found_.server_mb = 1e-6 * tests::memory_bytes(servers_.pid());
                if (!servers_.kill_and_start())
                    return "the server did not come back";
                ++found_.restarts;
            } else if (n > 0 && n % each(options_.cut_s) == 0) {
                line_.cut();
                ++found_.cuts;
            }
            const auto time_us =
                static_cast<sea::TimeUs>(1e6 * options_.step_s * static_cast<double>(n));
            if (std::string wrong = look_at(time_us, n % options_.exact_every == 0); !wrong.empty())
                return wrong;
            if (n % each(options_.restart_s) == 0)
                if (std::string wrong = is_the_same_sea(); !wrong.empty())
                    return wrong;
            if (n == moments / 8)
                found_.client_mb = 1e-6 * tests::memory_bytes(::getpid());
        }
        return {};
    }
    const Found& found() const { return found_; }

  private:
    std::vector<sea::QueryPoint> points(sea::TimeUs time_us) {
        std::vector<sea::QueryPoint> made;
        for (int i = 0; i < options_.points; ++i)
            made.push_back({draw_.uniform(-1e4, 1e4), draw_.uniform(-1e4, 1e4), time_us});
        return made;
    }
    /// Again and again while the client comes back: a minute at most.
    template <class Ask>
    auto patiently(Ask ask) -> decltype(ask()) {
        const auto end = Clock::now() + std::chrono::minutes(1);
        for (;;) {
            auto done = ask();
            if (done || Clock::now() >= end)
                return done;
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
    }
    std::string look_at(sea::TimeUs time_us, bool exactly) {
        const std::vector<sea::QueryPoint> asked = points(time_us);
        const auto answers = patiently([&]() -> Result<std::vector<sea::Answer>> {
            SEAWAY_TRY(client_.hold(std::span(&time_us, 1), 5));
            return client_.sample(asked);
        });
        if (!answers)
            return fmt::format("at {} us: {}", time_us, answers.error().message);
        found_.answers += asked.size();
        if (!exactly)
            return {};
        const auto exact = patiently([&] { return client_.ask(asked, {true, 10, {}}); });
        if (!exact)
            return fmt::format("the exact sum at {} us: {}", time_us, exact.error().message);
        for (std::size_t i = 0; i < asked.size(); ++i) {
            const sea::Answer &mapped = (*answers)[i], &truth = (*exact)[i];
            if (((mapped.flags | truth.flags) & no_promise) != 0) {
                ++found_.flagged;
                continue;
            }
            const double share =
                std::abs(mapped.height_m - truth.height_m) / (mapped.error_m + truth.error_m);
            ++found_.held_to_the_sum;
            found_.beyond += share > 1;
            found_.worst_share = std::max(found_.worst_share, share);
        }
        return {};
    }
    /// The exact heights of the beginning, as they were at first.
    std::string is_the_same_sea() {
        const std::vector<sea::QueryPoint> asked{{12, -40, 0}, {-5000, 3000, 1'000'000}};
        const auto exact = patiently([&] { return client_.ask(asked, {true, 10, {}}); });
        if (!exact)
            return exact.error().message;
        std::vector<double> heights;
        for (const sea::Answer& answer : *exact)
            heights.push_back(answer.height_m);
        if (first_heights_.empty())
            first_heights_ = heights;
        return heights == first_heights_ ? "" : "after a restart it is another sea";
    }

    const Options& options_;
    Servers& servers_;
    tests::FaultProxy& line_;
    client::Client& client_;
    tests::Draw draw_{1};
    std::vector<double> first_heights_;
    Found found_;
};

int sail(const Options& options) {
    Servers servers(options.scene, tests::folder().file("soak"));
    if (!servers.start())
        return 1;
    tests::FaultProxy line(servers.port(), {}, 1);
    const auto client = client::Client::connect(
        {.url = fmt::format("ws://127.0.0.1:{}", line.port()), .timeout_s = 10});
    if (!client) {
        fmt::print(stderr, "{}\n", client.error().message);
        return 1;
    }
    Voyage voyage(options, servers, line, **client);
    const std::string wrong = voyage.sail();
    const Found& found = voyage.found();
    const double client_mb = 1e-6 * tests::memory_bytes(::getpid()),
                 server_mb = 1e-6 * tests::memory_bytes(servers.pid());
    fmt::print("{} answers, {} held to the sum, {} flagged, {} beyond their bound, worst {:.2f} of "
               "it; {} cuts, {} restarts; client {:.1f} to {:.1f} MB, server {:.1f} to {:.1f} MB\n",
               found.answers, found.held_to_the_sum, found.flagged, found.beyond, found.worst_share,
               found.cuts, found.restarts, found.client_mb, client_mb, found.server_mb, server_mb);
    if (!wrong.empty())
        fmt::print(stderr, "{}\n", wrong);
    const auto grown = [&](double from_mb, double to_mb) {
        return to_mb > (1 + options.growth) * from_mb;
    };
    const bool well = wrong.empty() && found.beyond == 0 && found.held_to_the_sum > 0 &&
                      !grown(found.client_mb, client_mb) &&
                      (found.restarts == 0 || !grown(found.server_mb, server_mb));
    return well ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
    Options options;
    CommandLine line("load_soak", "A day of a sea, with servers that come and go.");
    line.option("--scene", options.scene, "Scene of the server").takes("FILE");
    line.option("--hours", options.hours, "Of sea time").between(0.01, 1e4).shows_default();
    line.option("--step", options.step_s, "From moment to moment, s")
        .between(0.1, 1e4)
        .shows_default();
    line.option("--cut", options.cut_s, "The line is cut so often, s of sea time")
        .between(1.0, 1e6)
        .shows_default();
    line.option("--restart", options.restart_s, "The server is killed so often, likewise")
        .between(1.0, 1e6)
        .shows_default();
    line.option("--points", options.points, "At a moment").between(1, 1000).shows_default();
    line.option("--exact-every", options.exact_every, "Moments").between(1, 1000).shows_default();
    line.option("--growth", options.growth, "Of memory, as a share")
        .between(0.0, 10.0)
        .shows_default();
    const Result<CommandLine::Next> next = line.read(argc, argv);
    if (!next) {
        fmt::print(stderr, "{}\n", next.error().message);
        return 2;
    }
    return *next == CommandLine::Next::leave ? 0 : sail(options);
}
