// SPDX-License-Identifier: Apache-2.0
// seaway-ctl: for administrators of a running server: changes its sea, and looks into it.
#include <cstdio>
#include <exception>
#include <future>

#include <fmt/format.h>

#include "base/messages.h"
#include "base/text_file.h"
#include "client/apps/ctl_options.h"
#include "client/apps/exit_code.h"
#include "client/link/connection.h"
#include "protocol/token_file.h"

namespace {

using namespace seaway;
using namespace seaway::client;

/// Asks and waits: the connection answers once, at the latest when its patience has ended.
template <class Ask>
Result<Reply> answer_to(const Ask& ask) {
    std::promise<Result<Reply>> promise;
    ask([&promise](Result<Reply> reply) { promise.set_value(std::move(reply)); });
    return promise.get_future().get();
}

/// What the answer comes to.
std::string told(const CtlOptions& options, const Reply& reply) {
    if (std::holds_alternative<AdminWish>(options.what))
        return reply.text;
    if (std::get<protocol::ChangeWish>(options.what).pace_permille)
        return fmt::format("{{\"from_s\": {}}}\n", sea::seconds_from_us(reply.start_us));
    return fmt::format("{{\"epoch\": {}, \"start_s\": {}, \"end_s\": {}}}\n", reply.epoch,
                       sea::seconds_from_us(reply.start_us), sea::seconds_from_us(reply.end_us));
}

Result<std::string> run(const CtlOptions& options) {
    SEAWAY_TRY_LET(const std::string token, read_token(options.token_file));
    SEAWAY_TRY_LET(const std::unique_ptr<Connection> connection,
                   Connection::open({.url = options.url,
                                     .name = "seaway-ctl/" SEAWAY_VERSION,
                                     .token = token,
                                     .ca_file = options.ca_file,
                                     .timeout_s = options.timeout_s},
                                    {}));
    SEAWAY_TRY_LET(const Reply reply, answer_to([&](ReplyHandler handler) {
                       if (const auto* wish = std::get_if<protocol::ChangeWish>(&options.what))
                           return connection->change(*wish, options.timeout_s, std::move(handler));
                       const auto& act = std::get<AdminWish>(options.what);
                       connection->administer(act.act, act.session, options.timeout_s,
                                              std::move(handler));
                   }));
    return told(options, reply);
}

} // namespace

int main(int argc, char** argv) {
    try {
        const std::variant<CtlOptions, int> options = read_ctl_options(argc, argv);
        if (const int* done = std::get_if<int>(&options))
            return *done;
        const Result<std::string> text = run(std::get<CtlOptions>(options));
        if (!text)
            return exit_code("seaway-ctl", text.error());
        fmt::print("{}", *text);
        return status_after_output("seaway-ctl", exit_done, exit_output);
    } catch (const std::exception& problem) {
        return complain("seaway-ctl", EXIT_FAILURE, problem.what());
    }
}
