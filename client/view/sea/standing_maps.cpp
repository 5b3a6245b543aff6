// SPDX-License-Identifier: Apache-2.0
#include "client/view/sea/standing_maps.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "base/check.h"
#include "gpu/descriptor_types.h"
#include "gpu/keep.h"
#include "shaders/shared/view.h"
#include "shaders/view/planes_comp.h"
#include "shaders/view/splines_comp.h"

namespace seaway::client {

namespace {

using gpu::keep;

using gpu::storage;
using gpu::texel_buffer;
using gpu::uniform;

/// What shaders/view/planes.comp is told.
struct Planes {
    std::int32_t cascade;
    std::int32_t dx, dy, eta;
    std::int32_t dx_rate, dy_rate, eta_rate;
    std::int32_t foam;
};

Planes planes_of(std::size_t cascade, sea::FieldSet fields) {
    using sea::Field;
    const auto map = [&](Field field) {
        return fields.contains(field) ? fields.index_of(field) : -1;
    };
    return {static_cast<std::int32_t>(cascade),
            map(Field::displacement_x),
            map(Field::displacement_y),
            map(Field::height),
            map(Field::displacement_x_rate),
            map(Field::displacement_y_rate),
            map(Field::height_rate),
            map(Field::foam)};
}

} // namespace

Result<StandingMaps> StandingMaps::create(gpu::Device& device) {
    StandingMaps made;
    made.device_ = &device;
    SEAWAY_TRY(keep(made.planes_,
                    gpu::Kernel::create(
                        device, "mix of maps", planes_comp,
                        {{{"View", uniform}, {"maps", texel_buffer}, {"DisplacementMaps", storage}},
                         sizeof(Planes),
                         view_groups})));
    SEAWAY_TRY(keep(made.splines_,
                    gpu::Kernel::create(
                        device, "splines", splines_comp,
                        {{{"View", uniform}, {"samples", texel_buffer}, {"Coefficients", storage}},
                         sizeof(std::int32_t),
                         view_groups})));
    return made;
}

Result<void> StandingMaps::fit(std::size_t displacement_bytes) {
    planes_sets_.clear();
    splines_sets_.clear();
    SEAWAY_TRY(keep(half_way_, gpu::Buffer::create(*device_, "splines half-way", displacement_bytes,
                                                   gpu::BufferKind::device)));
    return keep(half_way_texels_,
                gpu::TexelView::create(*device_, half_way_, VK_FORMAT_R32G32B32A32_SFLOAT,
                                       texel_bytes, 0, displacement_bytes));
}

Result<void> StandingMaps::take(const SeaFrame& frame, const gpu::Buffer& values,
                                const gpu::Buffer& displacements,
                                const gpu::TexelView& displacement_texels) {
    taken_before_ = std::exchange(taken_, {});
    for (const CascadeFrame& cascade : frame.cascades) {
        const auto& [before, after] = *cascade.standing;
        SEAWAY_CHECK(before->maps == after->maps && before->fields == after->fields &&
                         before->size == after->size,
                     "both keyframes of a tile stand side by side, with the same maps");
        taken_.insert(taken_.end(), {before, after});
        gpu::Bindings& set = planes_sets_[{values.get(), before->maps->get()}];
        if (set.get() == VK_NULL_HANDLE)
            SEAWAY_TRY(
                keep(set, planes_.bind(*device_, {gpu::whole(values), gpu::texels(*before->maps),
                                                  gpu::whole(displacements)})));
    }
    if (splines_sets_.contains(values.get()))
        return {};
    Splines& sets = splines_sets_[values.get()];
    SEAWAY_TRY(keep(sets.along_x,
                    splines_.bind(*device_, {gpu::whole(values), gpu::texels(displacement_texels),
                                             gpu::whole(half_way_)})));
    return keep(sets.along_y,
                splines_.bind(*device_, {gpu::whole(values), gpu::texels(half_way_texels_),
                                         gpu::whole(displacements)}));
}

void StandingMaps::record(gpu::Commands& commands, const gpu::Buffer& values) {
    using gpu::Stage;
    // Whoever computed the maps did so in a run of his own.
    commands.barrier(Stage::compute, Stage::compute);
    int points = 0;
    for (std::size_t c = 0; 2 * c < taken_.size(); ++c) {
        const StandingKeyframe& before = *taken_[2 * c];
        const Planes planes = planes_of(c, before.fields);
        commands.dispatch_all(planes_, planes_sets_.at({values.get(), before.maps->get()}),
                              std::as_bytes(std::span(&planes, 1)),
                              static_cast<std::size_t>(before.size * before.size / 4),
                              shaders::view_group);
        points = std::max(points, before.size);
    }
    const Splines& sets = splines_sets_.at(values.get());
    for (const std::int32_t axis : {0, 1}) {
        commands.barrier(Stage::compute, Stage::compute);
        commands.dispatch_all(splines_, axis == 0 ? sets.along_x : sets.along_y,
                              std::as_bytes(std::span(&axis, 1)),
                              static_cast<std::size_t>(points * points), shaders::view_group,
                              static_cast<std::uint32_t>(taken_.size() / 2));
    }
}

} // namespace seaway::client
