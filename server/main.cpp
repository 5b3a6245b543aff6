// SPDX-License-Identifier: Apache-2.0
// seaway-server: reads a scene, computes its sea, serves it. Exit codes: server/options.h.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <iterator>
#include <memory>
#include <new>
#include <system_error>
#include <variant>
#include <vector>

#include <fmt/core.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "base/messages.h"
#include "base/spare_memory.h"
#include "base/standard_files.h"
#include "base/text_file.h"
#include "server/devices.h"
#include "server/log_format.h"
#include "server/net/credentials.h"
#include "server/net/open_files.h"
#include "server/net/server.h"
#include "server/options.h"
#include "server/progress.h"
#include "server/resume.h"
#include "server/sea_director.h"
#include "server/service_manager.h"
#include "server/simulation/memory_needs.h"
#include "server/start_files.h"
#include "server/stop_deadline.h"
#include "server/stop_signal.h"
#include "server/world.h"

namespace seaway::server {
namespace {

/// From the end of --drain on: with its half second less than what a service manager waits before it kills (systemd 90 s,
/// Docker 10 s).
constexpr std::chrono::milliseconds stop_limit{7500};

int fail(ExitCode code, const Error& error) {
    return give_up(code, error.message);
}

SimulationEvents events(World& world) {
    return {[&world](const sea::KeyframePtr& keyframe, std::size_t rate) {
                world.on_keyframe(keyframe, rate);
            },
            [](const std::string& why) { spdlog::warn("{}", why); },
            [](const std::string& why) {
                spdlog::error("{}", why);
                StopSignal::fail();
            },
            give_back_spare_memory};
}

/// SIGHUP.
void reload(NetServer& net, const StartFiles& start_files) {
    const NetServer::Reloaded read = net.reload();
    std::vector<FileReadAgain> files = read.files;
    std::ranges::move(start_files.look(), std::back_inserter(files));
    for (const FileReadAgain& file : files)
        spdlog::log(file.outcome == ReadAgain::failed ? spdlog::level::err : spdlog::level::info,
                    "{}", file.line());
    if (!read.all)
        return spdlog::error("event=reload_refused why={}", in_quotes(read.all.error().message));
    spdlog::info("event=reloaded files={}",
                 std::ranges::count(files, ReadAgain::read_again, &FileReadAgain::outcome));
}

/// Logs what a user should know of this sea.
void tell_of(const RunningSea& sea) {
    if (sea.certificate)
        spdlog::info("{}: certified: {}", sea.scene.source, describe(*sea.certificate));
    for (const std::string& warning : warnings_of(sea))
        spdlog::warn("{}: {}", sea.scene.source, warning);
}

/// A name of a world or folder that was meant to be another begins another sea: who reads the log sees that.
void tell_of_beginning(const Resumed& resumed) {
    spdlog::info("event={} journal={} epoch={} changes={}",
                 resumed.begins ? "sea_begins" : "sea_goes_on",
                 in_quotes(resumed.journal ? resumed.journal->name() : "none"),
                 utc_text(resumed.epoch_utc_us), resumed.changes);
}

/// The budget of --memory-mb.
Result<MemoryPtr> memory_for(const Options& options, const RunningSea& sea) {
    constexpr std::size_t mib = 1024 * 1024;
    const MemoryNeeds needs = needs_of(sea);
    const std::size_t wanted = static_cast<std::size_t>(options.memory_mb) * mib;
    const std::size_t least = Memory::least_bytes(needs);
    if (wanted > 0 && wanted < least)
        return Error{fmt::format("--memory-mb {}: {} needs {} and more, or 0 for what is usual",
                                 options.memory_mb, sea.scene.source, (least + mib - 1) / mib)};
    return std::make_shared<Memory>(wanted > 0 ? wanted : Memory::default_bytes(needs), needs);
}

/// The end of --check: what a start would serve, in one line.
int checked(const RunningSea& sea) {
    fmt::print("{}: fine: Hs {:.2f} m, {} cascades, heights within {:g} m\n", sea.scene.source,
               sea.summary.realised.significant_height_m, sea.budget.cascades.size(),
               sea::level_error_m(sea.budget, sea.budget.codec_error_m));
    return status_after_output("seaway-server", exit_stopped, exit_usage);
}

/// Of a process that cannot end.
std::string last_words(bool json) {
    const std::string words =
        fmt::format("event=stop_hangs why=\"the device or a thread has not ended "
                    "for {:g} s; what the journal holds is safe\"",
                    std::chrono::duration<double>(stop_limit).count());
    const std::string time = utc_text(SeaClock::utc_now_us());
    return json ? json_line(time, "critical", words) : time + " critical " + words;
}

std::chrono::milliseconds drain_of(const NetOptions& options) {
    return std::chrono::ceil<std::chrono::milliseconds>(
        std::chrono::duration<double>(options.drain_s));
}

/// How often somebody looks whether the server comes on.
std::chrono::microseconds look_every(const ServiceManager& manager) {
    return std::min<std::chrono::microseconds>(manager.pat_every(), std::chrono::seconds(1));
}

/// A server that goes on leaves what there is no memory for.
template <class Work>
void or_leave(const char* event, Work work) {
    try {
        work();
    } catch (const std::bad_alloc&) {
        spdlog::error("event={} why=\"there is no memory for it\"", event);
    }
}

void say_ready(const std::string& url) {
    constexpr int patience_ms = 1000; // with a pipe that is full and that nobody reads
    pollfd out{.fd = STDOUT_FILENO, .events = POLLOUT, .revents = 0};
    const Result<void> told = ::poll(&out, 1, patience_ms) > 0
                                  ? write_out(stdout, fmt::format("ready {}\n", url))
                                  : Error{"nobody reads standard output: \"ready\" is not written"};
    if (!told) // who reads the log knows the address all the same
        spdlog::warn("{}", told.error().message);
}

/// For the simulation.
SimulationClock clock_of(SeaClock& clock) {
    return {[&clock] { return clock.now_us(); },
            [&clock](sea::TimeUs time_us) { return clock.wait_us(time_us); },
            [&clock] { return clock.hurry(); }};
}

/// What can be known before there is anything to serve.
struct Read {
    sea::Scene scene;
    std::shared_ptr<SeaCourse> course;
    MemoryPtr memory;
};

/// Or the exit code, of what has been complained about.
std::variant<Read, int> read_all(const Options& options) {
    if (const Result<void> fine = NetServer::check(options.net); !fine)
        return fail(exit_usage, fine.error());
    if (const Result<void> fine = check_journal_place(options.journal); !fine)
        return fail(exit_usage, fine.error());
    if (const Result<void> raised = raise_open_files(options.net); !raised)
        return fail(exit_usage, raised.error());
    Result<sea::Scene> scene = sea::read_scene(options.scene);
    if (!scene)
        return fail(exit_usage, scene.error());
    Result<std::shared_ptr<SeaCourse>> course = SeaCourse::begin(*scene);
    if (!course)
        return fail(exit_usage, course.error());
    const RunningSea& first = *(*course)->first();
    tell_of(first);
    Result<MemoryPtr> memory = memory_for(options, first);
    if (!memory)
        return fail(exit_usage, memory.error());
    return Read{*std::move(scene), *std::move(course), *std::move(memory)};
}

int check(const Options& options) {
    const auto read = read_all(options);
    if (const int* code = std::get_if<int>(&read))
        return *code;
    if (const Result<void> here = NetServer::check_addresses(options.net); !here)
        return fail(exit_cannot_listen, here.error());
    return checked(*std::get<Read>(read).course->first());
}

ExitCode without_journal(const Error& why) {
    const bool passes = why.is(JournalError::unreachable) || why.is(JournalError::unknown);
    return passes ? exit_no_journal : exit_usage;
}

int serve(const Options& options) {
    StopSignal::end_at_once(exit_stopped);
    const auto read = read_all(options);
    if (const int* code = std::get_if<int>(&read))
        return *code;
    const auto& [scene, course, memory] = std::get<Read>(read);
    const StartFiles start_files(options);
    ServiceManager manager;
    Result<Resumed> resumed = begin_or_resume(options.journal, *course, SeaClock::utc_now_us(),
                                              [&manager] { manager.starting(); });
    if (!resumed)
        return fail(without_journal(resumed.error()), resumed.error());

    const StopSignal stop;
    StopDeadline deadline(stop_limit + drain_of(options.net), exit_no_device,
                          [json = options.log == "json"] { return last_words(json); });
    const LogEnd log_end; // before the deadline is called off
    SeaClock clock(resumed->epoch_utc_us, SeaClock::utc_now_us, local_now_us, resumed->paces);
    World world(course, clock, memory);
    Result<std::unique_ptr<Simulation>> simulation = Simulation::start(
        course, device_factory(options), world.subscriptions(), clock_of(clock), events(world),
        {.rate = options.work_rate, .burst_s = options.work_burst_s}, memory,
        options.answer_threads > 0 ? options.answer_threads : answer_threads_default(),
        options.readback == "rounded" ? Readback::rounded : Readback::exact);
    if (!simulation)
        return fail(exit_no_device, simulation.error());
    world.attach(**simulation);
    Result<std::unique_ptr<NetServer>> net = NetServer::start(options.net, world);
    if (!net)
        return fail(exit_cannot_listen, net.error());
    tell_of_beginning(*resumed);
    spdlog::info("device={} scene={} epoch={} url={}", in_quotes((*simulation)->device()),
                 scene.source, utc_text(resumed->epoch_utc_us), (*net)->url());
    world.publish_to([&net](KeyframeTiles tiles) { (*net)->publish(std::move(tiles)); });
    world.announce_to([&net](SharedBytes state) { (*net)->announce(std::move(state)); });
    world.hand_over_by([&net](const std::string& why, const std::string& in_general) {
        (*net)->hand_over(why, in_general);
    });
    auto director = std::make_unique<SeaDirector>(course, resumed->journal.get(), resumed->changes,
                                                  world, clock);

    manager.ready((*net)->url());
    say_ready((*net)->url());
    Progress progress;
    const auto look = [&] {
        if (progress.comes_on(world.health(), (*net)->silence()))
            manager.alive();
    };
    const bool asked =
        stop.wait([&] { or_leave("reload_refused", [&] { reload(**net, start_files); }); },
                  look_every(manager), [&] { or_leave("watchdog_not_told", look); });
    manager.stopping();
    deadline.begins();
    (*net)->stop();
    director.reset(); // nobody asks it any more
    (*simulation).reset();
    resumed->journal.reset(); // its disk or its NATS may hang, too
    return asked ? exit_stopped : exit_no_device;
}

int list_devices() {
    const Result<std::string> devices = device_list();
    if (!devices)
        return fail(exit_no_device, devices.error());
    fmt::print("{}", *devices);
    return status_after_output("seaway-server", exit_stopped, exit_usage);
}

} // namespace
} // namespace seaway::server

int main(int argc, char** argv) {
    using namespace seaway::server;
    seaway::hold_standard_files();
    seaway::keep_ends_of_arenas_short();
    try {
        set_log_format("text");
        const auto options = read_options(argc, argv);
        if (const int* code = std::get_if<int>(&options))
            return *code;
        const auto& wanted = std::get<Options>(options);
        set_log_format(wanted.log);
        if (wanted.device == "list")
            return list_devices();
        return wanted.check ? check(wanted) : end_with(serve(wanted));
    } catch (const std::system_error& error) {
        if (error.code() != std::errc::resource_unavailable_try_again)
            return give_up(exit_usage, error.what());
        return give_up(exit_usage,
                       fmt::format("{}; --answer-threads 1 --io-threads 1 needs the fewest",
                                   seaway::no_further_thread));
    } catch (const std::exception& error) {
        return give_up(1, error.what());
    }
}
