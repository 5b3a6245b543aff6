// SPDX-License-Identifier: Apache-2.0
#include "server/options.h"

#include <fmt/format.h>

#include "base/command_line.h"
#include "base/messages.h"
#include "base/text_file.h"

namespace seaway::server {

std::variant<Options, int> read_options(int argc, char** argv) {
    Options options;
    CommandLine line(
        "seaway-server",
        "Computes the sea of a scene and serves it: tiles and answers over WebSocket at "
        "/v1/stream, state over HTTP on the same port.");
    line.option("scene", options.scene, "Scene file (scenes/*.toml)").takes("SCENE.toml");
    line.option("--listen", options.listen, "Address and port; port 0 picks a free one")
        .takes("ADDR:PORT")
        .shows_default();
    line.option("--device", options.device,
                "auto: a hardware GPU, else native. Or native (this processor, without Vulkan), "
                "a part of a device's name (lavapipe), its index, or `list` to see them")
        .takes("NAME|INDEX|auto|native|list")
        .shows_default();
    CommandOption cert = line.option("--tls-cert", options.tls_cert, "Certificate chain (PEM)");
    CommandOption key = line.option("--tls-key", options.tls_key, "Private key (PEM)");
    cert.needs(key).takes("FILE");
    key.needs(cert).takes("FILE");
    line.option("--admin-token-file", options.admin_token_file,
                "File with the token that marks a client as an administrator; also opens the door")
        .takes("FILE");
    line.option("--client-token-file", options.client_token_file,
                "File with the token that clients then need in their first message, and for every "
                "page and map but /healthz")
        .takes("FILE");
    line.option("--data-dir", options.data_dir,
                "Folder of the journal, made where it is missing: a server that is started again "
                "there goes on with the same sea, at the time at which it would be")
        .takes("DIR");
    line.option("--validation", options.validation,
                "Vulkan validation layers on; what they report is an error");
    line.footer("Prints `ready ws://ADDR:PORT` when it serves. SIGTERM and SIGINT stop it.\n"
                "Exit codes: 0 asked to stop, 2 usage, bad scene or journal, 3 no usable device, 4 "
                "cannot listen.");
    const Result<CommandLine::Next> next = line.read(argc, argv);
    const bool lacks_scene = options.scene.empty() && options.device != "list";
    if (next && *next == CommandLine::Next::leave)
        return status_after_output("seaway-server", 0, exit_usage);
    if (!next || lacks_scene) {
        const std::string why = next ? "SCENE.toml is required" : next.error().message;
        return complain("seaway-server", exit_usage, why + " (--help shows how)");
    }
    return options;
}

} // namespace seaway::server
