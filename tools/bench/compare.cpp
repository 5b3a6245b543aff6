// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/compare.h"

#include <memory>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "server/device/device_choice.h"
#include "server/simulation/running_sea.h"
#include "tools/bench/map_difference.h"
#include "tools/bench/timing.h"

namespace seaway::bench {

using server::KeyframeRequest;
using server::RunningSeaPtr;
using server::Synthesizer;

namespace {

std::vector<KeyframeRequest> all_cascades(const server::RunningSea& sea, sea::TimeUs time_us) {
    const sea::FieldSet linear = sea.offered.without({sea::Field::foam});
    std::vector<KeyframeRequest> requests;
    for (int c = 0; c < static_cast<int>(sea.realization->cascades.size()); ++c)
        requests.push_back({c, time_us, linear});
    return requests;
}

} // namespace

Result<void> run_compare(const CompareOptions& options) {
    const Result<sea::Scene> scene = sea::read_scene(options.scene);
    if (!scene)
        return scene.error();
    const Result<RunningSeaPtr> sea = server::make_running_sea(*scene, 1);
    if (!sea)
        return sea.error();
    std::unique_ptr<Synthesizer> devices[2];
    const std::string* names[] = {&options.first, &options.second};
    for (int i = 0; i < 2; ++i) {
        SEAWAY_TRY_LET(devices[i], server::make_synthesizer(*names[i]));
        SEAWAY_TRY(devices[i]->set_sea((*sea)->realization, 1));
    }
    sea::TimeUs time_us = 12'340'000;
    std::vector<server::NewKeyframePtr> made[2];
    std::optional<Error> failure;
    std::vector<Variant> variants;
    for (int i = 0; i < 2; ++i)
        variants.push_back({*names[i], [&, i] {
                                auto keyframes =
                                    devices[i]->synthesize(all_cascades(**sea, time_us));
                                if (keyframes)
                                    made[i] = std::move(keyframes).value();
                                else
                                    failure = keyframes.error();
                            }});
    interleave(variants, options.rounds);
    if (failure)
        return *failure;
    MapDifference largest;
    for (std::size_t c = 0; c < made[0].size(); ++c) {
        const MapDifference here = largest_difference(*made[0][c], *made[1][c]);
        if (here.share > largest.share)
            largest = here;
    }
    fmt::print(
        "{} | {}: largest difference of a map {:.1e} of 4 rms ({}), keyframe of all cascades "
        "{:.1f} ms | {:.1f} ms\n",
        devices[0]->description(), devices[1]->description(), largest.share, largest.field,
        1e3 * variants[0].median_s(), 1e3 * variants[1].median_s());
    return {};
}

} // namespace seaway::bench
