// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/streamed_demand.h"

#include <algorithm>
#include <utility>

#include "base/elapsed.h"
#include "protocol/limits.h"
#include "protocol/tile_codec.h"
#include "tools/bench/accuracy/seas/configured_sea.h"

namespace seaway::bench {

using sea::TimeUs;
using server::KeyframeRequest;

Spent& Spent::operator+=(const Spent& more) {
    maps_s += more.maps_s;
    stream_s += more.stream_s;
    bytes += more.bytes;
    transforms += more.transforms;
    keyframes += more.keyframes;
    return *this;
}

Spent Spent::operator-(const Spent& less) const {
    return {maps_s - less.maps_s, stream_s - less.stream_s, bytes - less.bytes,
            transforms - less.transforms, keyframes - less.keyframes};
}

Spent Spent::operator/(double divisor) const {
    return {maps_s / divisor, stream_s / divisor, bytes / divisor, transforms / divisor,
            keyframes / divisor};
}

Result<server::FoamMaps> foam_at_start(const server::RunningSeaPtr& sea,
                                       server::Synthesizer& device) {
    server::FoamMaps foam(server::steady_course(sea));
    if (!sea->foam_law)
        return foam;
    for (int c = 0; c < static_cast<int>(sea->realization->cascades.size()); ++c)
        SEAWAY_TRY(
            foam.walk_towards(device, c, demand_start_us, foam.ticks_to(c, demand_start_us) + 1));
    return foam;
}

StreamedDemand::StreamedDemand(server::RunningSeaPtr sea, server::Synthesizer& device,
                               std::vector<sea::FieldSet> fields, const server::FoamMaps& foam)
    : sea_(std::move(sea)), device_(device), fields_(std::move(fields)),
      course_(server::steady_course(sea_)), schedule_(*course_), foam_(foam) {
    for (std::size_t c = 0; c < fields_.size(); ++c)
        plan_.cascades.push_back(
            {fields_[c], sea_->budget.cascades[c].interval_us, server::transforms_for(fields_[c])});
}

Result<void> StreamedDemand::encode(const sea::Keyframe& keyframe, Spent& spent) const {
    const sea::FieldSet fields = fields_[static_cast<std::size_t>(keyframe.cascade)];
    const std::vector<float> bounds =
        sea::codec_bounds(sea_->budget, fields, keyframe.cascade, sea_->budget.codec_error_m);
    const auto size = static_cast<std::size_t>(keyframe.size);
    const int side = std::min(keyframe.size, protocol::limits::tile_side_max);
    std::size_t f = 0;
    for (const sea::Field field : fields) {
        const std::span<const float> plane = keyframe.plane(field);
        for (int y = 0; y < keyframe.size; y += side)
            for (int x = 0; x < keyframe.size; x += side) {
                const auto part =
                    plane.subspan(static_cast<std::size_t>(y) * size + static_cast<std::size_t>(x));
                SEAWAY_TRY_LET(const auto bytes,
                               protocol::encode_tile(part, {side, side}, size, bounds[f]));
                spent.bytes += static_cast<double>(bytes.size());
            }
        ++f;
    }
    return {};
}

Result<void> StreamedDemand::serve(const std::vector<KeyframeRequest>& due, Spent& spent) {
    const double start_s = process_cpu_seconds();
    SEAWAY_TRY_LET(const std::vector<server::NewKeyframePtr> made, foam_.synthesize(device_, due));
    const double made_s = process_cpu_seconds();
    for (const server::NewKeyframePtr& keyframe : made)
        SEAWAY_TRY(encode(*keyframe, spent));
    spent.maps_s += made_s - start_s;
    spent.stream_s += process_cpu_seconds() - made_s;
    spent.keyframes += static_cast<double>(made.size());
    return {};
}

Result<Spent> StreamedDemand::run(TimeUs duration_us) {
    Spent spent;
    const TimeUs end_us = now_us_ + duration_us;
    const std::uint64_t before = device_.counters().transforms;
    for (; now_us_ < end_us;
         now_us_ = std::min(end_us, schedule_.next_due_us(plan_).value_or(end_us)))
        for (;;) {
            const server::Schedule::Due due = schedule_.take_due(plan_, now_us_);
            SEAWAY_CHECK(due.left_out == 0, "sea time waits for the work");
            if (due.keyframes.empty())
                break;
            SEAWAY_TRY(serve(due.keyframes, spent));
        }
    spent.transforms = static_cast<double>(device_.counters().transforms - before);
    return spent;
}

} // namespace seaway::bench
