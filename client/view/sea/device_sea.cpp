// SPDX-License-Identifier: Apache-2.0
#include "client/view/sea/device_sea.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <span>
#include <utility>

#include "base/check.h"
#include "gpu/descriptor_types.h"
#include "gpu/keep.h"
#include "sea/basics/constants.h"
#include "sea/surface/maps/hermite.h"
#include "shaders/view/gradients_comp.h"
#include "shaders/view/mips_comp.h"
#include "shaders/view/mix_comp.h"

namespace seaway::client {

namespace {

using gpu::uniform;
constexpr VkFormat floats = VK_FORMAT_R32G32B32A32_SFLOAT;
using gpu::storage;
using gpu::texel_buffer;

std::size_t square(int side) {
    return static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
}

std::size_t spline_floats(int points) {
    return square(points + sea::SplineMap::border) * sea::SplineMap::channels;
}

/// Texels of all levels of a map.
int chain_texels(int side) {
    return (4 * side * side - 1) / 3;
}

using gpu::keep;

/// The level from which on a texel of a map is as long as the cascade's longest wave, whose mean is nothing then.
int levels_of(int side, const CascadeFrame& from) {
    const int last = static_cast<int>(std::bit_width(static_cast<unsigned>(side))) - 1;
    if (from.band.k_lo_radpm <= 0)
        return last;
    const double texels = 2 * sea::pi / from.band.k_lo_radpm / from.spec.length_m * side;
    return std::clamp(static_cast<int>(std::ceil(std::log2(texels))), 1, last);
}

/// Of the way from one time to a later one: 0 before it, 1 behind.
float share_of(sea::TimeUs before_us, sea::TimeUs after_us, sea::TimeUs time_us) {
    if (after_us <= before_us)
        return 0;
    const auto share =
        static_cast<float>(time_us - before_us) / static_cast<float>(after_us - before_us);
    return std::clamp(share, 0.0f, 1.0f);
}

shaders::vec4 narrow(const double (&weights)[4]) {
    return {static_cast<float>(weights[0]), static_cast<float>(weights[1]),
            static_cast<float>(weights[2]), static_cast<float>(weights[3])};
}

} // namespace

int DeviceSea::nodes_of(int points, const DeviceSeaOptions& options) {
    const int wished = std::clamp(points * options.nodes_a_point, DeviceSeaOptions::nodes_min,
                                  DeviceSeaOptions::nodes_max);
    return std::max(wished, points);
}

int DeviceSea::Slots::find(const std::shared_ptr<const void>& map) const {
    for (int i = 0; i < slots; ++i)
        if (!holds[i].owner_before(map) && !map.owner_before(holds[i]))
            return i;
    return -1;
}

int DeviceSea::Slots::oldest() const {
    return static_cast<int>(std::min_element(std::begin(used), std::end(used)) - std::begin(used));
}

Result<DeviceSea> DeviceSea::create(gpu::Device& device, const DeviceSeaOptions& options) {
    DeviceSea made;
    made.device_ = &device;
    made.options_ = options;
    SEAWAY_TRY(made.create_kernels());
    SEAWAY_TRY(keep(made.standing_, StandingMaps::create(device)));
    return made;
}

Result<void> DeviceSea::create_kernels() {
    using gpu::Kernel;
    SEAWAY_TRY(keep(
        mix_, Kernel::create(
                  *device_, "mix of keyframes", mix_comp,
                  {{{"View", uniform}, {"keyframes", texel_buffer}, {"DisplacementMaps", storage}},
                   sizeof(std::int32_t),
                   view_groups})));
    SEAWAY_TRY(keep(level_0_, Kernel::create(*device_, "gradients", gradients_comp,
                                             {{{"View", uniform},
                                               {"displacements", texel_buffer},
                                               {"GradientMaps", storage}},
                                              0,
                                              view_groups})));
    return keep(mips_, Kernel::create(*device_, "mip levels", mips_comp,
                                      {{{"View", uniform},
                                        {"DisplacementMaps", storage},
                                        {"GradientMaps", storage},
                                        {"displacements_above", texel_buffer},
                                        {"gradients_above", texel_buffer}},
                                       sizeof(std::int32_t),
                                       view_groups}));
}

bool DeviceSea::fits(const SeaFrame& frame) const {
    if (frame.cascades.size() != cascades_.size() || frame.stands_there() != stands_)
        return false;
    for (std::size_t c = 0; c < cascades_.size(); ++c)
        if (frame.cascades[c].points() != cascades_[c].points)
            return false;
    return true;
}

Result<void> DeviceSea::allocate(const SeaFrame& frame) {
    cascades_.clear();
    sets_.clear();
    pending_.clear(); // of staging buffers that are gone
    stands_ = frame.stands_there();
    int displacement_texels = 0, gradient_texels = 0;
    for (const CascadeFrame& from : frame.cascades) {
        Cascade made;
        made.points = from.points();
        made.nodes = nodes_of(made.points, options_);
        made.displacement_first =
            std::exchange(displacement_texels, displacement_texels + chain_texels(made.points));
        made.gradient_first =
            std::exchange(gradient_texels, gradient_texels + chain_texels(made.nodes));
        if (!stands_)
            SEAWAY_TRY(allocate_keyframes(made));
        cascades_.push_back(std::move(made));
    }
    const auto buffer = [&](gpu::Buffer& target, gpu::TexelView& view, const char* name,
                            VkFormat format, int texels) -> Result<void> {
        const std::size_t bytes = static_cast<std::size_t>(texels) * texel_bytes;
        SEAWAY_TRY(
            keep(target, gpu::Buffer::create(*device_, name, bytes, gpu::BufferKind::device)));
        return keep(view, gpu::TexelView::create(*device_, target, format, texel_bytes, 0, bytes));
    };
    SEAWAY_TRY(buffer(displacements_, displacement_texels_, "displacement maps", floats,
                      displacement_texels));
    SEAWAY_TRY(buffer(gradients_, gradient_texels_, "gradient maps", VK_FORMAT_R32G32B32A32_UINT,
                      gradient_texels));
    if (stands_)
        SEAWAY_TRY(standing_.fit(displacements_.size_bytes()));
    ++generation_;
    return {};
}

Result<void> DeviceSea::allocate_keyframes(Cascade& cascade) {
    const std::size_t bytes =
        slots * (spline_floats(cascade.points) + square(cascade.points)) * sizeof(float);
    SEAWAY_TRY(keep(cascade.keyframes, gpu::Buffer::create(*device_, "keyframes of a tile", bytes,
                                                           gpu::BufferKind::device)));
    SEAWAY_TRY(keep(cascade.texels, gpu::TexelView::create(*device_, cascade.keyframes, floats,
                                                           texel_bytes, 0, bytes)));
    if (!cascade.keyframes.mapped().empty())
        return {};
    return keep(cascade.staging,
                gpu::Buffer::create(*device_, "new keyframes", bytes, gpu::BufferKind::upload));
}

Result<void> DeviceSea::bind(const gpu::Buffer& values) {
    if (sets_.contains(values.get()))
        return {};
    for (Cascade& cascade : cascades_)
        if (!stands_)
            SEAWAY_TRY(keep(cascade.mix[values.get()],
                            mix_.bind(*device_, {gpu::whole(values), gpu::texels(cascade.texels),
                                                 gpu::whole(displacements_)})));
    Sets& sets = sets_[values.get()];
    SEAWAY_TRY(keep(sets.gradients,
                    level_0_.bind(*device_, {gpu::whole(values), gpu::texels(displacement_texels_),
                                             gpu::whole(gradients_)})));
    return keep(sets.mips,
                mips_.bind(*device_,
                           {gpu::whole(values), gpu::whole(displacements_), gpu::whole(gradients_),
                            gpu::texels(displacement_texels_), gpu::texels(gradient_texels_)}));
}

void DeviceSea::copy(std::size_t cascade, Slots& kept, const std::shared_ptr<const void>& map,
                     std::span<const float> floats, std::size_t first, std::size_t stride) {
    if (kept.find(map) >= 0)
        return;
    const int slot = kept.oldest();
    kept.holds[slot] = map;
    kept.used[slot] = frame_;
    Cascade& to = cascades_[cascade];
    const std::size_t at = first + static_cast<std::size_t>(slot) * stride;
    const bool staged = to.keyframes.mapped().empty();
    std::copy(floats.begin(), floats.end(),
              (staged ? to.staging : to.keyframes).mapped_as<float>().begin() +
                  static_cast<std::ptrdiff_t>(at));
    if (staged)
        pending_.push_back({cascade, at, floats.size(),
                            &kept == &to.foams ? &Cascade::foams : &Cascade::splines, slot});
    ++copies_;
}

void DeviceSea::put(std::size_t cascade, const CascadeFrame& from) {
    Cascade& to = cascades_[cascade];
    const auto take_both = [&](Slots& kept, const auto& before, const auto& after, auto&& floats_of,
                               std::size_t first, std::size_t stride) {
        // What is there already is marked first: room is made of what neither needs.
        for (const auto& map : {before, after})
            if (const int at = kept.find(map); at >= 0)
                kept.used[at] = frame_;
        copy(cascade, kept, before, floats_of(*before), first, stride);
        copy(cascade, kept, after, floats_of(*after), first, stride);
    };
    const auto coefficients = [&](const sea::SplineMap& map) {
        SEAWAY_CHECK(map.size() == to.points, "both keyframes of a tile have its size");
        return map.coefficients();
    };
    const auto foam = [&](const sea::Keyframe& map) {
        SEAWAY_CHECK(map.size == to.points, "foam has the size of its tile");
        return map.plane(sea::Field::foam);
    };
    const std::size_t stride = spline_floats(to.points);
    take_both(to.splines, from.keyframes.before, from.keyframes.after, coefficients, 0, stride);
    if (from.foam_before && from.foam_after)
        take_both(to.foams, from.foam_before, from.foam_after, foam, slots * stride,
                  square(to.points));
}

/// What a frame without the sea has put into staging buffers and this frame does not need: its slots may be filled again
/// while the device still reads them for this frame.
void DeviceSea::forget_unwanted() {
    std::erase_if(pending_, [&](const Copy& part) {
        Slots& kept = cascades_[part.cascade].*part.kept;
        if (kept.used[part.slot] == frame_)
            return false;
        kept.holds[part.slot].reset();
        return true;
    });
}

Result<void> DeviceSea::take(const SeaFrame& frame, const gpu::Buffer& values) {
    SEAWAY_CHECK(!frame.cascades.empty() && frame.cascades.size() <= shaders::view_cascades_max,
                 "1 .. view_cascades_max cascades");
    if (!fits(frame))
        SEAWAY_TRY(allocate(frame));
    ++frame_;
    if (stands_)
        SEAWAY_TRY(standing_.take(frame, values, displacements_, displacement_texels_));
    for (std::size_t c = 0; c < cascades_.size() && !stands_; ++c)
        put(c, frame.cascades[c]);
    forget_unwanted();
    return bind(values);
}

void DeviceSea::describe_standing(const CascadeFrame::Standing& from, sea::TimeUs time_us,
                                  shaders::ViewCascade& out) {
    out.before_first = static_cast<int>(from.before->first_texel);
    out.after_first = static_cast<int>(from.after->first_texel);
    out.foam_share = from.before->fields.contains(sea::Field::foam)
                         ? share_of(from.before->time_us, from.after->time_us, time_us)
                         : -1;
}

void DeviceSea::describe_copied(const Cascade& kept, const CascadeFrame& from, sea::TimeUs time_us,
                                shaders::ViewCascade& out) {
    const auto place = [](const Slots& kept_slots, const std::shared_ptr<const void>& map,
                          std::size_t first, std::size_t stride) {
        return static_cast<int>((first + static_cast<std::size_t>(kept_slots.find(map)) * stride) /
                                4);
    };
    const std::size_t stride = spline_floats(kept.points);
    out.before_first = place(kept.splines, from.keyframes.before, 0, stride);
    out.after_first = place(kept.splines, from.keyframes.after, 0, stride);
    out.foam_share = -1;
    if (!from.foam_before || !from.foam_after)
        return;
    const std::size_t foams = square(kept.points);
    out.foam_before_first = place(kept.foams, from.foam_before, slots * stride, foams);
    out.foam_after_first = place(kept.foams, from.foam_after, slots * stride, foams);
    out.foam_share = share_of(from.foam_before->time_us, from.foam_after->time_us, time_us);
}

void DeviceSea::describe(const SeaFrame& frame, const glm::dvec2& camera_m,
                         shaders::ViewValues& values) const {
    values.cascades = static_cast<int>(cascades_.size());
    for (std::size_t c = 0; c < cascades_.size(); ++c) {
        const Cascade& kept = cascades_[c];
        const CascadeFrame& from = frame.cascades[c];
        shaders::ViewCascade& out = values.cascade[c];
        const glm::dvec2 tiles = camera_m / from.spec.length_m;
        const glm::dvec2 origin = tiles - glm::floor(tiles);
        out.origin = {static_cast<float>(origin.x), static_cast<float>(origin.y)};
        out.maps_per_m = static_cast<float>(1 / from.spec.length_m);
        out.points = kept.points;
        out.nodes = kept.nodes;
        out.gradient_levels = levels_of(kept.nodes, from);
        out.displacement_levels = levels_of(kept.points, from);
        out.displacement_first = kept.displacement_first;
        out.gradient_first = kept.gradient_first;
        out.hermite =
            narrow(sea::hermite_weights(from.before_us(), from.after_us(), frame.time_us).value);
        if (from.standing)
            describe_standing(*from.standing, frame.time_us, out);
        else
            describe_copied(kept, from, frame.time_us, out);
    }
}

void DeviceSea::record(gpu::Commands& commands, const gpu::Buffer& values) {
    using gpu::Stage;
    for (const Copy& part : pending_)
        commands.copy(cascades_[part.cascade].staging, cascades_[part.cascade].keyframes,
                      part.count * sizeof(float), part.first * sizeof(float),
                      part.first * sizeof(float));
    if (!pending_.empty())
        commands.barrier(Stage::copy, Stage::compute);
    pending_.clear();
    int points = 0, nodes = 0;
    if (stands_)
        standing_.record(commands, values);
    for (std::size_t c = 0; c < cascades_.size(); ++c) {
        const auto index = static_cast<std::int32_t>(c);
        if (!stands_)
            commands.dispatch_all(mix_, cascades_[c].mix.at(values.get()),
                                  std::as_bytes(std::span(&index, 1)), square(cascades_[c].points),
                                  shaders::view_group);
        points = std::max(points, cascades_[c].points);
        nodes = std::max(nodes, cascades_[c].nodes);
    }
    commands.barrier(Stage::compute, Stage::compute);
    const auto layers = static_cast<std::uint32_t>(cascades_.size());
    const Sets& sets = sets_.at(values.get());
    commands.dispatch_all(level_0_, sets.gradients, {}, square(nodes), shaders::view_group, layers);
    commands.barrier(Stage::compute, Stage::compute);
    for (std::int32_t level = 1;
         level < static_cast<int>(std::bit_width(static_cast<unsigned>(nodes))); ++level) {
        commands.dispatch_all(mips_, sets.mips, std::as_bytes(std::span(&level, 1)),
                              square(std::max(nodes >> level, points >> level)),
                              shaders::view_group, layers);
        commands.barrier(Stage::compute, Stage::compute);
    }
}

} // namespace seaway::client
