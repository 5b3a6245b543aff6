// SPDX-License-Identifier: Apache-2.0
#include "client/apps/ctl_options.h"

#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "base/command_line.h"
#include "base/messages.h"
#include "base/text_file.h"
#include "client/apps/query_points.h"
#include "client/exit_code.h"
#include "protocol/limits.h"
#include "sea/basics/glide.h"
#include "sea/basics/pace.h"
#include "sea/scene/scene.h"

namespace seaway::client {
namespace {

constexpr const char* ctl_footer =
    "Each command has options of its own: seaway-ctl COMMAND --help.\n"
    "Changes are written to the server's journal before they are "
    "answered; the answer says when the sea begins to glide,\n"
    "when it is there, and the number of the change, which rewind "
    "takes. PATH is that of a scene file: "
    "sea.system.0.wind_speed_10m_mps, sea.depth_m, foam.bias;\n"
    "systems.0.from_deg is short for sea.system.0.from_deg. Tiles, "
    "effects and accuracy stay as they are.\n"
    "The token is the administrator's (--admin-token-file of the "
    "server), over wss or from the server's own machine.\n"
    "Exit codes: 0 done, 1 cannot write or no memory, 2 usage, 5 cannot connect, "
    "lost or no answer in time, 6 refused by the server;\n"
    "diff: the seas differ, or nothing could be compared,\n"
    "7 status: a server does not answer, or is stale.";

struct CtlWords {
    std::vector<std::string> values;
    std::string scene;
    std::string over = "60s";
    double at_s = -1e12; ///< past: as soon as can be
    std::string session;
    double pace = 1;
    std::string change = "1";
    StatusWish status;
    DiffWish diff;
};

/// Strictly: what is below 0 is no number of anything, and not one near 2^64.
Result<std::uint64_t> number_of(const std::string& option, const std::string& text) {
    std::uint64_t number = 0;
    const char* const end = text.data() + text.size();
    const auto [at, wrong] = std::from_chars(text.data(), end, number);
    if (at != end || wrong != std::errc())
        return Error{fmt::format("{} {}: a number is expected, 0 or more", option, text)};
    return number;
}

Result<protocol::ChangeWish> change_of(const CtlWords& words) {
    protocol::ChangeWish wish;
    wish.set = words.values;
    for (const std::string& value : words.values)
        if (value.starts_with("system."))
            return Error{fmt::format("{}: systems.0... with an s, or sea.system.0...", value)};
    SEAWAY_TRY_LET(const double over_s, parse_duration_s(words.over));
    const double least_s = sea::seconds_from_us(sea::glide_us_min);
    const double most_s = sea::seconds_from_us(sea::glide_us_max);
    if (!(over_s >= least_s && over_s <= most_s))
        return Error{fmt::format("--over {}: {} s to {} s", words.over, least_s, most_s)};
    wish.over_us = sea::us_from_seconds(over_s);
    wish.at_us = sea::us_from_seconds(words.at_s);
    if (words.scene.empty())
        return wish;
    Result<std::string> scene =
        read_text_file(words.scene, protocol::limits::change_scene_bytes_max);
    if (!scene)
        return Error{fmt::format("cannot read scene '{}': {}", words.scene, scene.error().message)};
    wish.scene = *std::move(scene);
    if (sea::parse_scene(wish.scene, words.scene))
        return wish;
    // Whole, with the tables that its files hold. What cannot be read here is said by the server, which may be a newer one.
    if (const Result<sea::Scene> whole = sea::read_scene(words.scene))
        wish.scene = sea::to_toml(*whole);
    if (wish.scene.size() > protocol::limits::change_scene_bytes_max)
        return Error{fmt::format("scene '{}' has {} bytes with its tables, at most {} are sent",
                                 words.scene, wish.scene.size(),
                                 protocol::limits::change_scene_bytes_max)};
    return wish;
}

/// Of a command that changes the sea.
void add_when(CommandLine& command, CtlWords& words) {
    command.option("--over", words.over, "How long the sea takes to glide over: 90s, 2m, 1h")
        .takes("DURATION")
        .shows_default();
    command.option("--at", words.at_s, "Sea time at which it begins; else as soon as can be")
        .between(-sea::time_max_s, sea::time_max_s)
        .takes("SECONDS");
}

Result<protocol::ChangeWish> pace_of(double pace) {
    constexpr double least = 1.0 / sea::pace_unit;
    if (pace > 0 && pace < least)
        return Error{fmt::format("rate {}: {} and more; `pause` stops the sea", pace, least)};
    protocol::ChangeWish wish;
    wish.pace_permille = static_cast<int>(std::lround(pace * sea::pace_unit));
    return wish;
}

Result<CtlOptions> options_of(CtlOptions options, const CtlWords& words, bool changes) {
    SEAWAY_TRY(options.check());
    if (changes) {
        SEAWAY_TRY_LET(options.what, change_of(words));
    }
    return options;
}

/// What can be asked.
struct Commands {
    CommandLine* set = nullptr;
    CommandLine* load = nullptr;
    CommandLine* pause = nullptr;
    CommandLine* rate = nullptr;
    CommandLine* rewind = nullptr;
    CommandLine* history = nullptr;
    CommandLine* status = nullptr;
    CommandLine* diff = nullptr;
    CommandLine* state = nullptr;
    CommandLine* plan = nullptr;
    CommandLine* sessions = nullptr;
    CommandLine* drop = nullptr;

    Commands(CommandLine& line, CtlWords& words) {
        add_changes(line, words);
        add_looks(line, words);
    }
    void add_changes(CommandLine& line, CtlWords& words);
    void add_looks(CommandLine& line, CtlWords& words);
    bool changes() const { return set->given() || load->given() || rewind->given(); }
};

void Commands::add_changes(CommandLine& line, CtlWords& words) {
    set = &line.command("set", "Sets values of the scene; the sea glides over");
    set->option("values", words.values, "Values by their paths").takes("PATH=VALUE ...").required();
    add_when(*set, words);
    load = &line.command("load", "Glides over to another scene");
    load->option("scene", words.scene, "Scene file").takes("SCENE.toml").required();
    add_when(*load, words);
    pause = &line.command("pause", "Stops sea time where it is, in a second");
    rate = &line.command("rate",
                         "How fast sea time runs, in a second: 1 as clocks do, 0.5 half as fast");
    rate->option("rate", words.pace, "In steps of 0.001; keyframes come so much more often")
        .takes("RATE")
        .between(0.0, sea::pace_permille_max / static_cast<double>(sea::pace_unit))
        .required();
    rewind = &line.command(
        "rewind", "Glides to the scene of an earlier change, as its timetable has it by now");
    rewind->option("change", words.change, "Its number, as history says; 1: what it began with")
        .takes("N")
        .required();
    add_when(*rewind, words);
}

void Commands::add_looks(CommandLine& line, CtlWords& words) {
    history = &line.command("history", "The changes of the sea, from its journal");
    history->option("--from", words.change, "The first that is listed; some hundred are")
        .takes("N");
    status =
        &line.command("status", "How servers of one sea stand, a row for each; exit code 7: one "
                                "does not answer, or is stale");
    status->option("urls", words.status.others, "Other servers").takes("URL ...");
    diff = &line.command(
        "diff", "Heights of two servers at random points around now; exit code 6: they differ, or "
                "nothing could be compared");
    diff->option("other", words.diff.other, "The other server").takes("URL").required();
    diff->option("--points", words.diff.points, "How many")
        .takes("COUNT")
        .between(1, 1'000'000)
        .shows_default();
    diff->option("--seed", words.diff.seed, "Of points and times").takes("N").shows_default();
    state = &line.command("state", "The sea, as /v1/state");
    plan = &line.command("plan", "What is computed for whom, as /v1/plan");
    sessions = &line.command("sessions", "Who is connected");
    drop = &line.command("drop", "Ends a session");
    drop->option("session", words.session, "Its number, as sessions says").takes("N").required();
}

/// Of commands that change no sea by words of their own.
Result<void> choose(const Commands& commands, const CtlWords& words, CtlOptions& options) {
    if (commands.pause->given() || commands.rate->given()) {
        SEAWAY_TRY_LET(options.what, pace_of(commands.pause->given() ? 0 : words.pace));
    }
    if (commands.state->given())
        options.what = AdminWish{wire::Act::state};
    if (commands.plan->given())
        options.what = AdminWish{wire::Act::plan};
    if (commands.sessions->given())
        options.what = AdminWish{wire::Act::sessions};
    if (commands.history->given()) {
        SEAWAY_TRY_LET(const std::uint64_t from, number_of("--from", words.change));
        options.what = AdminWish{wire::Act::history, from};
    }
    if (commands.status->given())
        options.what = words.status;
    if (commands.diff->given())
        options.what = words.diff;
    if (commands.drop->given()) {
        SEAWAY_TRY_LET(const std::uint64_t session, number_of("drop", words.session));
        options.what = AdminWish{wire::Act::drop, session};
    }
    return {};
}

Result<CtlOptions> whole_options(CtlOptions options, const CtlWords& words,
                                 const Commands& commands) {
    SEAWAY_TRY(choose(commands, words, options));
    SEAWAY_TRY_LET(options, options_of(std::move(options), words, commands.changes()));
    if (!commands.rewind->given())
        return options;
    SEAWAY_TRY_LET(const std::uint64_t change, number_of("rewind", words.change));
    const auto when = std::get<protocol::ChangeWish>(options.what);
    options.what = RewindWish{change, when.over_us, when.at_us};
    return options;
}

} // namespace

Result<double> parse_duration_s(const std::string& text) {
    constexpr std::pair<char, double> units[] = {{'s', 1}, {'m', 60}, {'h', 3600}, {'d', 86400}};
    std::string number = text;
    double unit_s = 1;
    for (const auto& [letter, seconds] : units)
        if (!text.empty() && text.back() == letter) {
            number.pop_back();
            unit_s = seconds;
        }
    const std::optional<double> value = number_in(number, 1e9);
    if (!value || *value < 0)
        return Error{fmt::format("'{}' is no duration; give one as 90s, 2m, 1.5h or 3d", text)};
    return *value * unit_s;
}

std::variant<CtlOptions, int> read_ctl_options(int argc, const char* const* argv) {
    CtlOptions options;
    CtlWords words;
    CommandLine line("seaway-ctl", "Changes the sea of a running server, and looks into it.");
    line.option("url", options.url, "Server: ws://HOST:PORT or wss://HOST:PORT")
        .takes("URL")
        .required();
    options.describe(line, "the administrator's token");
    const Commands commands(line, words);
    line.footer(ctl_footer);
    const Result<CommandLine::Next> next = line.read(argc, argv);
    if (!next)
        return complain("seaway-ctl", exit_usage, next.error().message);
    if (*next == CommandLine::Next::leave)
        return status_after_output("seaway-ctl", exit_done, exit_output);
    const Result<CtlOptions> whole = whole_options(std::move(options), words, commands);
    if (!whole)
        return complain("seaway-ctl", exit_usage, whole.error().message);
    return *whole;
}

} // namespace seaway::client
