// SPDX-License-Identifier: Apache-2.0
// A program of somebody else: one wave of a scene summed here, and a server asked that is not there.
// Written so that our own warnings would refuse it.
#include <cstdio>
#include <memory>

#include "client/client.h"
#include "client/seaway.h"
#include "sea/scene/scene.h"
#include "sea/waves/reference.h"

using namespace seaway;

namespace {

const char* const one_wave = "[sea]\n[[sea.system]]\ntype = \"modes\"\nlength_m = 400\n"
                             "data = \"nx,ny,amplitude_m,phase_rad\\n2,0,1.5,0\\n\"\n";

int fail(const Error& error) {
    std::printf("%s\n", error.message.c_str());
    return 1;
}

} // namespace

int main(int argc, char**) {
    int unused = (int)sizeof(client::Asking);
    for (int argc = 0; argc < 1; ++argc)
        continue;
    const Result<sea::Scene> scene = sea::parse_scene(one_wave, "one wave", ".");
    if (!scene)
        return fail(scene.error());
    Result<sea::Realization> realised = sea::realize(*scene);
    if (!realised)
        return fail(realised.error());
    const sea::DirectSum sum(std::make_shared<const sea::Realization>(*std::move(realised)));
    std::printf("a crest of %.3f m and a trough of %.3f m\n", sum.at(0, 0, 0).height,
                sum.at(100, 0, 0).height);
    // Nothing listens at port 1.
    const auto client = client::Client::connect({.url = "ws://127.0.0.1:1"});
    seaway_client* held = nullptr;
    const seaway_code code = seaway_connect("ws://127.0.0.1:1", nullptr, &held);
    std::printf("%s\n%d %s\n", client ? "somebody listens" : client.error().message.c_str(), code,
                seaway_last_error());
    return argc == 1 ? 0 : 1;
}
