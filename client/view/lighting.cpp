// SPDX-License-Identifier: Apache-2.0
#include "client/view/lighting.h"

#include <cmath>

#include "gpu/keep.h"
#include "shaders/view/final_clear_frag.h"
#include "shaders/view/final_frag.h"
#include "shaders/view/final_one_clear_frag.h"
#include "shaders/view/final_one_frag.h"
#include "shaders/view/picture_vert.h"
#include "shaders/view/sky_clear_frag.h"
#include "shaders/view/sky_frag.h"
#include "shaders/view/sky_plain_frag.h"
#include "shaders/view/under_frag.h"
#include "shaders/view/under_one_frag.h"

namespace seaway::client {

namespace {

std::size_t index(SkySeen sky) {
    return static_cast<std::size_t>(sky);
}

std::span<const std::uint32_t> sky_shader(SkySeen sky) {
    switch (sky) {
    case SkySeen::plain:
        return sky_plain_frag;
    case SkySeen::discs:
        return sky_clear_frag;
    case SkySeen::clouds:
        break;
    }
    return sky_frag;
}

/// With clouds, or without.
SkySeen sea_kind(SkySeen sky) {
    return sky == SkySeen::clouds ? SkySeen::clouds : SkySeen::plain;
}

} // namespace

SkySeen sky_seen(const shaders::SkyValues& sky, const Camera& camera) {
    if (sky.cloud_threshold <= 1.5f)
        return SkySeen::clouds;
    if (sky.star_klx > 0)
        return SkySeen::discs;
    const glm::dvec3 ahead = glm::normalize(camera.ray(0, 0));
    const double corner = std::acos(glm::dot(ahead, glm::normalize(camera.ray(1, 1))));
    const double reach = corner + 2 * static_cast<double>(sky.disc_rad) + 2 * camera.pixel_rad();
    const auto seen = [&](const shaders::vec3& to, double light) {
        const glm::dvec3 disc(static_cast<double>(to.x), static_cast<double>(to.y),
                              static_cast<double>(to.z));
        return light > 0 && glm::dot(ahead, disc) > std::cos(reach);
    };
    const bool discs = seen(sky.to_sun, static_cast<double>(sky.sun_low.x + sky.sun_high.x)) ||
                       seen(sky.to_moon, static_cast<double>(sky.moon.y));
    return discs ? SkySeen::discs : SkySeen::plain;
}

Result<void> Lighting::make(gpu::GraphicsPipeline& target, const char* name,
                            std::span<const std::uint32_t> fragment, bool depth,
                            gpu::DepthTest test) {
    if (target.get() != VK_NULL_HANDLE)
        return {};
    gpu::GraphicsOptions options{.test = test};
    if (depth)
        options.depth_format = gpu::Offscreen::depth_format;
    return gpu::keep(target, gpu::GraphicsPipeline::create(*device_, name, picture_vert, fragment,
                                                           bindings_, options));
}

Result<void> Lighting::prepare(const Needs& needs) {
    using gpu::DepthTest;
    const std::size_t sky = index(needs.sky);
    const std::span<const std::uint32_t> many_under = under_frag, one_under = under_one_frag;
    if (needs.under)
        return make(under_, "under water", one_sample() ? one_under : many_under, false,
                    DepthTest::nearer);
    if (!needs.sea)
        return make(sky_[sky], "sky", sky_shader(needs.sky), false, DepthTest::nearer);
    const bool cloudy = needs.sky == SkySeen::clouds;
    gpu::GraphicsPipeline& sea = sea_[index(sea_kind(needs.sky))];
    if (!one_sample())
        return make(sea, "sea and sky",
                    cloudy ? std::span<const std::uint32_t>(final_frag) : final_clear_frag, false,
                    DepthTest::nearer);
    SEAWAY_TRY(make(sea, "sea's light",
                    cloudy ? std::span<const std::uint32_t>(final_one_frag) : final_one_clear_frag,
                    true, DepthTest::covered));
    return make(sky_around_[sky], "sky around", sky_shader(needs.sky), true, DepthTest::bare);
}

void Lighting::record(gpu::Commands& commands, gpu::Offscreen& target,
                      const gpu::Bindings& bindings, const Needs& needs) const {
    const auto draw = [&](const gpu::GraphicsPipeline& pipeline) {
        pipeline.record_bind(commands, bindings);
        vkCmdDraw(commands.get(), 3, 1, 0, 0);
    };
    const bool split = needs.sea && one_sample() && !needs.under;
    target.begin_picture(commands, split);
    draw(needs.under ? under_
         : needs.sea ? sea_[index(sea_kind(needs.sky))]
                     : sky_[index(needs.sky)]);
    if (split)
        draw(sky_around_[index(needs.sky)]);
    target.end_picture(commands);
}

} // namespace seaway::client
