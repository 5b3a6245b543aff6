// SPDX-License-Identifier: Apache-2.0
#include "server/options.h"

#include <CLI/CLI.hpp>

#include "base/text_file.h"

namespace seaway::server {

std::variant<Options, int> read_options(int argc, char** argv) {
    Options options;
    CLI::App app{"Computes the sea of a scene and serves it: tiles and answers over WebSocket at "
                 "/v1/stream, state over HTTP on the same port."};
    app.name("seaway-server");
    app.set_version_flag("--version", std::string("seaway-server ") + SEAWAY_VERSION);
    app.add_option("scene", options.scene, "Scene file (scenes/*.toml)")->type_name("SCENE.toml");
    app.add_option("--listen", options.listen, "Address and port; port 0 picks a free one")
        ->type_name("ADDR:PORT")
        ->capture_default_str();
    app.add_option("--device", options.device,
                   "auto: a hardware GPU, else native. Or native (this processor, without Vulkan), "
                   "a part of a device's name (lavapipe), its index, or `list` to see them")
        ->type_name("NAME|INDEX|auto|native|list")
        ->capture_default_str();
    CLI::Option* cert = app.add_option("--tls-cert", options.tls_cert, "Certificate chain (PEM)");
    CLI::Option* key = app.add_option("--tls-key", options.tls_key, "Private key (PEM)");
    cert->needs(key)->type_name("FILE");
    key->needs(cert)->type_name("FILE");
    app.add_option(
           "--admin-token-file", options.admin_token_file,
           "File with the token that marks a client as an administrator; also opens the door")
        ->type_name("FILE");
    app.add_option("--client-token-file", options.client_token_file,
                   "File with the token that clients then need in their first message")
        ->type_name("FILE");
    app.add_flag("--validation", options.validation,
                 "Vulkan validation layers on; what they report is an error");
    app.footer("Prints `ready ws://ADDR:PORT` when it serves. SIGTERM and SIGINT stop it.\n"
               "Exit codes: 0 asked to stop, 2 usage or bad scene, 3 no usable device, 4 cannot "
               "listen.");
    try {
        app.parse(argc, argv);
        if (options.scene.empty() && options.device != "list")
            throw CLI::RequiredError("SCENE.toml");
    } catch (const CLI::Success& asked) {
        return status_after_output("seaway-server", app.exit(asked), exit_usage);
    } catch (const CLI::ParseError& error) {
        app.exit(error);
        return exit_usage;
    }
    return options;
}

} // namespace seaway::server
