// SPDX-License-Identifier: Apache-2.0
// seaway-query: the surface above points of a running sea, from the command line.
#include <cstdio>

#include <fmt/format.h>

#include "base/messages.h"
#include "base/stop_wanted.h"
#include "base/text_file.h"
#include "client/apps/query_options.h"
#include "client/apps/query_run.h"
#include "client/exit_code.h"

namespace {

using namespace seaway;
using namespace seaway::client;

Result<void> run(const QueryOptions& options) {
    std::vector<Place> places = options.at;
    if (!options.points_file.empty()) {
        Result<std::vector<Place>> read = read_places(options.points_file);
        if (!read)
            return read.error();
        places = std::move(*read);
    }
    SEAWAY_TRY_LET(const ConnectOptions server, options.connect_options("seaway-query"));
    if (options.watch_hz > 0 || options.bench_points > 0)
        note_stop_signals();
    const Connect connect = [&](ClientEvents events) {
        return connect_to(server, std::move(events));
    };
    if (options.bench_points == 0)
        return run_query(connect, options, places, stop_wanted(), stdout);
    const Result<std::unique_ptr<Client>> client = connect({});
    return client ? run_bench(**client, options, stop_wanted(), stdout) : client.error();
}

int run(int argc, char** argv) {
    const std::variant<QueryOptions, int> options = read_query_options(argc, argv);
    if (const int* done = std::get_if<int>(&options))
        return *done;
    const Result<void> done = run(std::get<QueryOptions>(options));
    return done ? status_after_output("seaway-query", exit_done, exit_output)
                : give_up("seaway-query", done.error());
}

} // namespace

int main(int argc, char** argv) {
    return run_main("seaway-query", exit_output, [&] { return run(argc, argv); });
}
