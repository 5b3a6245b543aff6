// SPDX-License-Identifier: Apache-2.0
#include "server/options.h"

#include <fmt/format.h>

#include "base/command_line.h"
#include "base/messages.h"
#include "base/text_file.h"
#include "protocol/limits.h"
#include "server/net/senders.h"
#include "server/simulation/answer_threads.h"

namespace seaway::server {
namespace {

/// Less would not let a whole request in.
constexpr double request_bytes_per_s_min = 262144;

void limit_options(CommandLine& line, NetOptions& net) {
    const auto count = [&line](const char* name, int& value, int least, const char* help) {
        line.option(name, value, help).takes("COUNT").between(least, 1'000'000).shows_default();
    };
    count("--connections-max", net.connections_max, 1,
          "Connections at a time, HTTP and streams; needs as many open files");
    count("--sessions-max", net.sessions_max, 1, "Streams at a time");
    count("--connections-per-address", net.connections_per_address, 0,
          "Of these as many from one address. This limit and the next three: 0 is none, for a "
          "proxy in front, which is one address for all");
    count("--sessions-without-hello-per-address", net.sessions_without_hello_per_address, 0,
          "Streams that have not said Hello");
    count("--wrong-tokens-per-address", net.wrong_tokens_per_address, 0, "Wrong tokens a minute");
    line.option("--request-bytes-per-address", net.request_bytes_per_s_per_address,
                "Bytes of requests a second, 262144 and more; what is beyond is read later")
        .takes("BYTES")
        .between(0.0, 1e12)
        .shows_default();
}

void net_options(CommandLine& line, NetOptions& net) {
    line.option("--listen", net.listen, "Address and port; port 0 picks a free one")
        .takes("ADDR:PORT")
        .shows_default();
    line.option("--health-listen", net.health_listen,
                "Serves /healthz, /readyz and /metrics here too, plain and without a token, "
                "however full the "
                "other port is: for the operator alone")
        .takes("ADDR:PORT");
    CommandOption cert = line.option("--tls-cert", net.tls_cert_file, "Certificate chain (PEM)");
    CommandOption key = line.option("--tls-key", net.tls_key_file, "Private key (PEM)");
    cert.needs(key).takes("FILE");
    key.needs(cert).takes("FILE");
    line.option("--admin-token-file", net.admin_token_file,
                "File with the token that marks a client as an administrator; also opens the door")
        .takes("FILE");
    line.option("--client-token-file", net.client_token_file,
                "File with the token that clients then need in their first message, and for every "
                "page and map but /healthz, /readyz and the frame of the status page")
        .takes("FILE");
    line.option("--allow-origin", net.allowed_origins,
                "Pages of this origin may open streams, as https://sea.example.org; its host is a "
                "name that the server answers to. May be given again")
        .takes("ORIGIN")
        .one_at_a_time();
    line.option("--drain", net.drain_s,
                "When it is asked to stop: for how long what was asked for is still answered")
        .takes("SECONDS")
        .between(0.0, 3600.0)
        .shows_default();
    line.option("--retry-after", net.retry_after_s,
                "How long clients are told then to stay away, who wait once to twice as long; 0: "
                "2, or more where "
                "they are more than 400")
        .takes("SECONDS")
        .between(0.0, protocol::limits::retry_after_ms_max / 1000.0)
        .shows_default();
    limit_options(line, net);
}

/// `data_dir`: the same place under its older name.
void journal_options(CommandLine& line, JournalPlace& journal, std::string& data_dir) {
    line.option(
            "--journal", journal.where,
            "Where the sea's changes are kept: a folder, or a world in NATS with JetStream that "
            "other servers of the same sea follow, too. A server that is started again there "
            "goes on with the same sea, at the time at which it would be")
        .takes("DIR|nats://HOST:PORT/WORLD");
    line.option("--data-dir", data_dir, "The same for a folder, made where it is missing")
        .takes("DIR");
    line.say_the_same("--journal", "--data-dir");
    line.option("--journal-credentials", journal.credentials_file,
                "File that lets it into NATS: credentials (.creds), or a line, USER:PASSWORD or a "
                "token")
        .takes("FILE");
    CommandOption ca = line.option("--journal-tls-ca", journal.tls_ca_file,
                                   "Speak TLS with NATS, whose certificates these sign (PEM)");
    CommandOption cert = line.option("--journal-tls-cert", journal.tls_cert_file,
                                     "This server's own certificate chain for NATS (PEM)");
    CommandOption key =
        line.option("--journal-tls-key", journal.tls_key_file, "Its private key (PEM)");
    ca.takes("FILE");
    cert.needs(key).needs(ca).takes("FILE");
    key.needs(cert).takes("FILE");
    line.option("--journal-replicas", journal.replicas,
                "Copies that a cluster of NATS keeps of a world that begins")
        .takes("COUNT")
        .between(1, 5)
        .shows_default();
}

void sea_options(CommandLine& line, Options& options) {
    line.option("--device", options.device,
                "auto: a hardware GPU, else native. Or native (this processor, without Vulkan), "
                "a part of a device's name (lavapipe), its index, or `list` to see them")
        .takes("NAME|INDEX|auto|native|list")
        .shows_default();
    line.option(
            "--readback", options.readback,
            "rounded: maps of a GPU with memory of its own cross the bus as 16 bits, within the "
            "scene's budget of errors; other devices are not touched by it")
        .takes("exact|rounded")
        .one_of({"exact", "rounded"})
        .shows_default();
    line.option("--answer-threads", options.answer_threads,
                "Threads that answer points beside the one that makes keyframes; 0: one a core, "
                "four at most")
        .takes("COUNT")
        .between(0, answer_threads_max)
        .shows_default();
    line.option("--io-threads", options.net.io_threads,
                "Threads that send keyframes to the clients; more than one for many clients on a "
                "large machine")
        .takes("COUNT")
        .between(1, io_threads_max)
        .shows_default();
    line.option("--work-rate", options.work_rate,
                "Share of the threads that work for those who ask that each session may use; who "
                "asks for more is told when to ask again")
        .between(0.001, 1000.0)
        .takes("SHARE")
        .shows_default();
    line.option("--work-burst", options.work_burst_s,
                "Work that a session may ask for at once, beyond its rate")
        .between(0.001, 1e6)
        .takes("SECONDS")
        .shows_default();
    line.option("--memory-mb", options.memory_mb,
                "What may be held for those who ask, MiB: keyframes, questions, tiles and maps; 0: "
                "640, or "
                "more where the scene needs it")
        .takes("MIB")
        .between(0, 1'000'000)
        .shows_default();
}

} // namespace

std::variant<Options, int> read_options(int argc, char** argv) {
    Options options;
    CommandLine line(
        "seaway-server",
        "Computes the sea of a scene and serves it: tiles and answers over WebSocket at "
        "/v1/stream, state over HTTP on the same port.");
    line.option("scene", options.scene, "Scene file (scenes/*.toml)").takes("SCENE.toml");
    net_options(line, options.net);
    std::string data_dir;
    journal_options(line, options.journal, data_dir);
    sea_options(line, options);
    line.option("--log", options.log,
                "How lines on stderr are written: text, or one JSON object a line")
        .takes("text|json")
        .one_of({"text", "json"})
        .shows_default();
    line.option("--check", options.check,
                "Read scene, files and addresses as a start would, say what was found, and end");
    line.file_of_options("--config",
                         "File with these options (TOML), as `listen = \"0.0.0.0:9430\"`; "
                         "what the command line says wins");
    line.option("--validation", options.validation,
                "Vulkan validation layers on; what they report is an error");
    line.footer(
        "Prints `ready ws://ADDR:PORT` when it serves. SIGTERM and SIGINT stop it; SIGHUP reads "
        "tokens and certificate again.\n"
        "Exit codes: 0 asked to stop, 2 usage, bad scene or journal, 3 no usable device, 4 cannot "
        "listen, 5 NATS cannot be reached, or the journal's disk is full.");
    const Result<CommandLine::Next> next = line.read(argc, argv);
    options.config = line.given_file_of_options();
    const bool lacks_scene = options.scene.empty() && options.device != "list";
    if (next && *next == CommandLine::Next::leave)
        return status_after_output("seaway-server", 0, exit_usage);
    const double rate = options.net.request_bytes_per_s_per_address;
    const bool starves = rate > 0 && rate < request_bytes_per_s_min;
    const bool two_journals = !data_dir.empty() && !options.journal.is_none();
    if (!next || lacks_scene || starves || two_journals) {
        const std::string why =
            !next         ? next.error().message
            : lacks_scene ? "SCENE.toml is required"
            : two_journals
                ? line.place_in_file("--data-dir") +
                      "--data-dir and --journal both say where the journal is: give one"
                : fmt::format(
                      "{}--request-bytes-per-address {:g}: 0 for no limit, or {:g} and more",
                      line.place_in_file("--request-bytes-per-address"), rate,
                      request_bytes_per_s_min);
        return complain("seaway-server", exit_usage, why + " (--help shows how)");
    }
    if (!data_dir.empty())
        options.journal.option = "--data-dir", options.journal.where = data_dir;
    return options;
}

} // namespace seaway::server
