// SPDX-License-Identifier: Apache-2.0
// seaway-ctl: for administrators of a running server: changes its sea, and looks into it.
#include <cstdio>

#include <fmt/format.h>

#include "base/messages.h"
#include "base/text_file.h"
#include "client/apps/ctl_ask.h"
#include "client/apps/ctl_options.h"
#include "client/exit_code.h"

namespace {

using namespace seaway;
using namespace seaway::client;

Result<std::string> run(const CtlOptions& options, int& status_code) {
    if (const auto* wish = std::get_if<StatusWish>(&options.what)) {
        FleetStatus status = fleet_status(options, *wish);
        if (status.none_answers && wish->others.empty())
            return *std::move(status.none_answers);
        status_code = status.none_answers  ? give_up("seaway-ctl", *status.none_answers)
                      : status.all_certain ? exit_done
                                           : exit_unsure;
        return std::move(status.table);
    }
    if (const auto* rewind = std::get_if<RewindWish>(&options.what))
        return rewound(options, *rewind);
    if (const auto* diff = std::get_if<DiffWish>(&options.what))
        return difference(options, *diff);
    SEAWAY_TRY_LET(const std::unique_ptr<Connection> connection,
                   connect_as_administrator(options, options.url));
    if (const auto* wish = std::get_if<protocol::ChangeWish>(&options.what))
        return changed(*connection, *wish, options.timeout_s);
    return administered(*connection, std::get<AdminWish>(options.what), options.timeout_s);
}

int run(int argc, char** argv) {
    const std::variant<CtlOptions, int> options = read_ctl_options(argc, argv);
    if (const int* done = std::get_if<int>(&options))
        return *done;
    int code = exit_done;
    const Result<std::string> text = run(std::get<CtlOptions>(options), code);
    if (!text)
        return give_up("seaway-ctl", text.error());
    fmt::print("{}", *text);
    return status_after_output("seaway-ctl", code, exit_output);
}

} // namespace

int main(int argc, char** argv) {
    return run_main("seaway-ctl", exit_output, [&] { return run(argc, argv); });
}
