// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/line.h"

#include <algorithm>

#include <fmt/format.h>

#include "base/elapsed.h"
#include "client/held/tile_assembly.h"
#include "server/device/device_choice.h"
#include "server/host/grant.h"
#include "server/publish/encoder.h"
#include "tools/bench/accuracy/seas/configured_sea.h"
#include "tools/bench/effects.h"
#include "tools/bench/streamed_demand.h"

namespace seaway::bench {

using sea::Field;
using sea::FieldSet;
using server::RunningSea;

namespace {

/// Of one second.
struct Sum {
    double bits = 0;
    double joining_bits = 0; ///< of one whole keyframe of each cascade, in the middle of a stream
    double encode_s = 0;
    double take_s = 0; ///< a client's: to whole keyframes of the cascade's own grid
};

struct FieldCost {
    Field field;
    int size = 0;
    float bound = 0;
    double bits = 0; ///< of all keyframes
    double samples = 0;
};

/// One cascade; prints its rows.
Result<Sum> measure(const RunningSea& sea, server::Synthesizer& device, int cascade,
                    const server::Demand& grant, int keyframes, server::Encoder& encoder,
                    server::FoamMaps& foam) {
    const sea::CascadeBudget& own = sea.budget.cascades[static_cast<std::size_t>(cascade)];
    const sea::CascadeSpec& spec =
        sea.realization->cascades[static_cast<std::size_t>(cascade)].spec;
    const server::RungMaps maps = server::maps_of(sea.budget, cascade, grant.fields, grant.quality);
    const sea::TimeUs interval_us = maps.every * own.interval_us;
    const protocol::CascadeInfo info{.length_m = spec.length_m, .size = spec.size};
    client::TileAssembly assembly;
    std::vector<FieldCost> rows;
    Sum sum;
    const std::optional<sea::WaveLaw> law = maps.predicted ? sea.wave_law() : std::nullopt;
    for (int n = law ? -TileStream::leads : 0; n < keyframes; ++n) {
        const sea::TimeUs time_us = demand_start_us + (law ? n : 7 * n) * interval_us;
        const server::KeyframeRequest request{cascade, time_us - time_us % interval_us,
                                              grant.fields};
        SEAWAY_TRY_LET(const auto made, foam.synthesize(device, {request}));
        // Foam may have come with what it stands on.
        const std::vector<float> bounds =
            server::maps_of(sea.budget, cascade, made[0]->fields, grant.quality).codec_error;
        const double start_s = process_cpu_seconds();
        SEAWAY_TRY_LET(const server::EncodedKeyframePtr encoded,
                       encoder.encode(*made[0], bounds, grant.quality, grant.fields,
                                      {maps.compact_size, grant.follows, maps.coarser, law}));
        const double encoded_s = process_cpu_seconds();
        protocol::MessageReader reader(protocol::Sender::server);
        const bool begins = n < 0;
        sum.joining_bits = 8.0 * static_cast<double>(message_bytes(*encoded, grant.fields));
        for (const server::EncodedField& map : encoded->maps) {
            const auto row = std::find_if(rows.begin(), rows.end(),
                                          [&](const FieldCost& r) { return r.field == map.field; });
            FieldCost& into = row != rows.end() ? *row : rows.emplace_back(FieldCost{map.field});
            into.bound = map.error;
            for (const protocol::SharedBytes& part :
                 map.differences.empty() ? map.parts : map.differences) {
                SEAWAY_TRY_LET(const wire::Message* message, reader.read(*part));
                const wire::Tile& tile = *message->body_as_Tile();
                into.size = tile.size();
                into.bits += begins ? 0.0 : 8.0 * static_cast<double>(part->size());
                into.samples += begins ? 0.0 : tile.width() * tile.height();
                SEAWAY_TRY(assembly.add(
                    protocol::header(tile), {tile.payload()->data(), tile.payload()->size()}, info,
                    sea.scene.sea.depth_m, grant.fields | grant.follows, {}, law));
            }
        }
        sum.encode_s += begins ? 0.0 : encoded_s - start_s;
        sum.take_s += begins ? 0.0 : process_cpu_seconds() - encoded_s;
    }
    const double rate = 1.0 / sea::seconds_from_us(interval_us);
    for (const FieldCost& row : rows) {
        fmt::print("  {:>5g} m  {:<20} {:>5} {:>8.3g} {:>10.3g} {:>8.2f} {:>9.1f}\n", spec.length_m,
                   sea::info(row.field).name, row.size, rate, row.bound, row.bits / row.samples,
                   1e-3 * row.bits / keyframes * rate);
        sum.bits += row.bits;
    }
    for (double* part : {&sum.bits, &sum.encode_s, &sum.take_s})
        *part *= rate / keyframes;
    return sum;
}

} // namespace

Result<void> run_line(const LineOptions& options) {
    SEAWAY_TRY_LET(const sea::Scene scene, sea::read_scene(options.scene));
    SEAWAY_TRY_LET(const server::RunningSeaPtr sea, server::make_running_sea(scene, 1));
    FieldSet fields = sea->sampler_fields();
    if (!options.ask.empty()) {
        SEAWAY_TRY_LET(fields, fields_asked(options.ask, sea->offered));
    }
    SEAWAY_TRY(options.limits.check());
    SEAWAY_TRY_LET(const auto device, server::make_synthesizer(options.device));
    SEAWAY_TRY(device->set_sea(sea->realization, 1));
    const sea::ErrorBudget* const budgets[] = {&sea->budget};
    const server::Demand grant =
        server::grant_of({.cascades = sea::all_cascades,
                          .fields = fields,
                          .error_m = static_cast<float>(options.error_m),
                          .compact = !options.whole,
                          .predicted = !options.whole && !options.alone,
                          .rate_hz_max = static_cast<float>(options.limits.rate_hz_max),
                          .size_max = options.limits.size_max},
                         budgets, sea->streamed(), {});
    if (grant.empty())
        return Error{grant.why};
    if (!grant.why.empty())
        fmt::print("granted less: {}\n", grant.why);
    fmt::print("asked {:g} m, granted {:.4f} m, {} maps\n  cascade  {:<20} {:>5} {:>8} {:>10} "
               "{:>8} {:>9}\n",
               options.error_m, grant.error_m,
               options.whole   ? "whole"
               : options.alone ? "compact"
                               : "predicted",
               "field", "grid", "a second", "bound", "bits", "kbit/s");
    SEAWAY_TRY_LET(server::FoamMaps foam, foam_at_start(sea, *device));
    server::Encoder encoder;
    Sum all;
    for (int c = 0; c < static_cast<int>(sea->budget.cascades.size()); ++c) {
        SEAWAY_TRY_LET(const Sum one,
                       measure(*sea, *device, c, grant, options.keyframes, encoder, foam));
        all.bits += one.bits;
        all.joining_bits += one.joining_bits;
        all.encode_s += one.encode_s;
        all.take_s += one.take_s;
    }
    fmt::print("  {:.3f} Mbit/s, one whole keyframe of each cascade {:.1f} KB; encoding {:.1f} ms "
               "of CPU a second, "
               "taking {:.1f} ms\n",
               1e-6 * all.bits, 1e-3 / 8 * all.joining_bits, 1e3 * all.encode_s, 1e3 * all.take_s);
    return {};
}

} // namespace seaway::bench
