// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/compare.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "server/device/device_choice.h"
#include "server/simulation/running_sea.h"
#include "tools/bench/timing.h"

namespace seaway::bench {

using server::KeyframeRequest;
using server::RunningSeaPtr;
using server::Synthesizer;

namespace {

std::vector<KeyframeRequest> all_cascades(const server::RunningSea& sea, sea::TimeUs time_us) {
    const auto linear =
        sea::FieldSet::from_bits(sea.offered.bits() & ~sea::FieldSet{sea::Field::foam}.bits());
    std::vector<KeyframeRequest> requests;
    for (int c = 0; c < static_cast<int>(sea.realization->cascades.size()); ++c)
        requests.push_back({c, time_us, linear});
    return requests;
}

struct Difference {
    double share = 0; ///< of four times the rms
    std::string_view field = "none";
};

/// The largest over all maps of two keyframes of the same cascade and time.
Difference largest_difference(const sea::Keyframe& a, const sea::Keyframe& b) {
    Difference largest;
    for (const sea::Field field : a.fields) {
        const auto p = a.plane(field), q = b.plane(field);
        double squares = 0, worst = 0;
        for (std::size_t i = 0; i < p.size(); ++i) {
            squares += static_cast<double>(p[i]) * static_cast<double>(p[i]);
            worst =
                std::max(worst, std::abs(static_cast<double>(p[i]) - static_cast<double>(q[i])));
        }
        const double scale = 4 * std::sqrt(squares / static_cast<double>(p.size()));
        if (scale > 0 && worst / scale > largest.share)
            largest = {worst / scale, sea::info(field).name};
    }
    return largest;
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
    Difference largest;
    for (std::size_t c = 0; c < made[0].size(); ++c) {
        const Difference here = largest_difference(*made[0][c], *made[1][c]);
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
