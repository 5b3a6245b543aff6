// SPDX-License-Identifier: Apache-2.0
// SeaState to bytes and back (protocol/messages.h).
#include <cmath>

#include "base/bound_to_float.h"
#include "protocol/limits.h"
#include "protocol/messages.h"

namespace seaway::protocol {
namespace {

wire::SeaNumbers to_wire(const SeaNumbers& n) {
    return {n.hs_m, n.tp_s, n.tz_s, n.tm01_s, n.mean_from_deg, n.spread_deg, n.mss};
}

SeaNumbers from_wire(const wire::SeaNumbers* n) {
    if (n == nullptr)
        return {};
    return {n->hs_m(),          n->tp_s(),       n->tz_s(), n->tm01_s(),
            n->mean_from_deg(), n->spread_deg(), n->mss()};
}

wire::CascadeLoss to_wire(const sea::CascadeLoss& loss) {
    const sea::MapLoss &h = loss.height, &d = loss.displacement;
    return {bound_to_float(h.time_m), bound_to_float(h.east_m), bound_to_float(h.north_m),
            bound_to_float(d.time_m), bound_to_float(d.east_m), bound_to_float(d.north_m)};
}

sea::CascadeLoss from_wire(const wire::CascadeLoss& loss) {
    sea::CascadeLoss out;
    out.height.time_m = static_cast<double>(loss.time_m());
    out.height.east_m = static_cast<double>(loss.east_m());
    out.height.north_m = static_cast<double>(loss.north_m());
    out.displacement.time_m = static_cast<double>(loss.displacement_time_m());
    out.displacement.east_m = static_cast<double>(loss.displacement_east_m());
    out.displacement.north_m = static_cast<double>(loss.displacement_north_m());
    return out;
}

std::vector<wire::Probe> to_wire(const std::vector<sea::Probe>& probes) {
    std::vector<wire::Probe> out;
    for (const sea::Probe& p : probes)
        out.emplace_back(p.x_m, p.y_m, p.time_us, p.height_m, p.displacement_x_m,
                         p.displacement_y_m);
    return out;
}

std::vector<sea::Probe> from_wire(const flatbuffers::Vector<const wire::Probe*>* probes) {
    std::vector<sea::Probe> out;
    if (probes != nullptr)
        for (const wire::Probe* p : *probes)
            out.push_back({p->x_m(), p->y_m(), p->time_us(), p->height_m(), p->displacement_x_m(),
                           p->displacement_y_m()});
    return out;
}

std::optional<GlideValues> glide_of(const wire::SeaState& state) {
    const wire::Glide* glide = state.glide();
    if (glide == nullptr)
        return std::nullopt;
    GlideValues values{.end_us = glide->end_us(),
                       .choppiness_x = glide->choppiness_x(),
                       .choppiness_y = glide->choppiness_y(),
                       .foam_mean = glide->foam_mean(),
                       .foam_threshold = glide->foam_threshold(),
                       .leads_to = from_wire(state.leads_to())};
    if (const auto* longest = state.glide_k_lo_radpm())
        values.k_lo_radpm.assign(longest->begin(), longest->end());
    if (state.realised_before() != nullptr)
        values.realised = from_wire(state.realised_before());
    return values;
}

std::optional<sea::WaveLaw> wave_law_of(const wire::SeaState& state) {
    const wire::WaveLaw* law = state.wave_law();
    if (law == nullptr)
        return std::nullopt;
    return sea::WaveLaw{{law->gravity_mps2(), law->surface_tension_m3ps2(), law->depth_m()},
                        law->loop_period_us()};
}

/// A server that says nothing says zeros: a black sea floor is then none that somebody chose.
sea::Water water_of(const wire::SeaState& state) {
    sea::Water water;
    if (state.water() < sea::water_types.size())
        water.type = static_cast<sea::WaterType>(state.water());
    if (state.depth_m() > 0)
        water.bottom_albedo = {static_cast<double>(state.bottom_red()),
                               static_cast<double>(state.bottom_green()),
                               static_cast<double>(state.bottom_blue())};
    return water;
}

} // namespace

SeaNumbers glided(const SeaNumbers& from, const SeaNumbers& to, double share) {
    const auto on_the_way = [share](double a, double b) { return sea::glided(a, b, share); };
    const double turned_deg = std::remainder(to.mean_from_deg - from.mean_from_deg, 360.0);
    const double bearing_deg = from.mean_from_deg + share * turned_deg;
    return {on_the_way(from.hs_m, to.hs_m),
            on_the_way(from.tp_s, to.tp_s),
            on_the_way(from.tz_s, to.tz_s),
            on_the_way(from.tm01_s, to.tm01_s),
            bearing_deg - 360.0 * std::floor(bearing_deg / 360.0),
            on_the_way(from.spread_deg, to.spread_deg),
            on_the_way(from.mss, to.mss)};
}

SeaNumbers SeaStateValues::realised_at(sea::TimeUs time_us) const {
    if (!glide || !glide->realised)
        return realised;
    return protocol::glided(*glide->realised, realised,
                            sea::glide_share(time_us, start_time_us, glide->end_us));
}

double SeaStateValues::glided(double GlideValues::*from, double to, sea::TimeUs time_us) const {
    return glide ? sea::glided((*glide).*from, to,
                               sea::glide_share(time_us, start_time_us, glide->end_us))
                 : to;
}

namespace {

std::uint32_t stylised_bits(std::span<const CascadeInfo> cascades) {
    std::uint32_t bits = 0;
    for (std::size_t c = 0; c < cascades.size(); ++c)
        bits |= cascades[c].stylised ? 1u << c : 0u;
    return bits;
}

} // namespace

Bytes sea_state(const SeaStateValues& state) {
    SEAWAY_CHECK(state.scene.size() <= limits::scene_bytes_max, "scene too long for the wire");
    flatbuffers::FlatBufferBuilder built(1024 + state.scene.size());
    built.ForceDefaults(true);
    std::vector<wire::CascadeInfo> cascades;
    for (const CascadeInfo& c : state.cascades)
        cascades.emplace_back(c.length_m, c.k_lo_radpm, c.k_hi_radpm, c.interval_us,
                              static_cast<std::uint32_t>(c.size), c.placed_alone ? 1u : 0u);
    std::vector<wire::CascadeLoss> losses;
    for (const sea::CascadeLoss& loss : state.losses)
        losses.push_back(to_wire(loss));
    const auto probe_list = built.CreateVectorOfStructs(to_wire(state.probes));
    const auto leads_to = built.CreateVectorOfStructs(
        to_wire(state.glide ? state.glide->leads_to : std::vector<sea::Probe>{}));
    const auto glide_k_lo =
        built.CreateVector(state.glide ? state.glide->k_lo_radpm : std::vector<double>{});
    const auto loss_list = built.CreateVectorOfStructs(losses);
    const auto cascade_list = built.CreateVectorOfStructs(cascades);
    const auto scene = built.CreateString(state.scene);
    std::vector<std::string> said = state.warnings;
    said.resize(std::min(said.size(), limits::warnings_max));
    for (std::string& warning : said)
        warning.resize(std::min(warning.size(), limits::warning_bytes_max));
    const auto warnings = built.CreateVectorOfStrings(said);
    const wire::SeaNumbers requested = to_wire(state.requested);
    const wire::SeaNumbers realised = to_wire(state.realised);
    std::optional<wire::Glide> glide;
    if (state.glide)
        glide =
            wire::Glide(state.glide->end_us, state.glide->choppiness_x, state.glide->choppiness_y,
                        state.glide->foam_mean, state.glide->foam_threshold);
    std::optional<wire::SeaNumbers> before;
    if (state.glide && state.glide->realised)
        before = to_wire(*state.glide->realised);
    std::optional<wire::WaveLaw> law;
    if (state.wave_law)
        law = wire::WaveLaw(state.wave_law->dispersion.gravity_mps2,
                            state.wave_law->dispersion.surface_tension_m3ps2,
                            state.wave_law->dispersion.depth_m, state.wave_law->loop_period_us);
    const auto bottom = [&](std::size_t colour) {
        return static_cast<float>(state.water.bottom_albedo[colour]);
    };
    const auto body = wire::CreateSeaState(
        built, state.epoch, state.start_time_us, cascade_list, state.choppiness_x,
        state.choppiness_y, state.height_error_m, &requested, &realised,
        state.interpolation_error_m, state.rms_slope, scene, warnings, state.foam_mean,
        state.foam_threshold, state.displacement_reach_m, state.rms_strain,
        state.interpolation_displacement_m, state.interpolation_strain, loss_list,
        state.single_precision_m, state.single_precision_displacement_m, state.depth_m,
        static_cast<std::uint8_t>(state.water.type), bottom(0), bottom(1), bottom(2), probe_list,
        state.probe_error_m, glide ? &*glide : nullptr, law ? &*law : nullptr,
        before ? &*before : nullptr, state.curvature_per_m, stylised_bits(state.cascades), leads_to,
        glide_k_lo);
    built.Finish(wire::CreateMessage(built, wire::Body::SeaState, body.Union()),
                 wire::MessageIdentifier());
    return {built.GetBufferPointer(), built.GetBufferPointer() + built.GetSize()};
}

SeaStateValues values(const wire::SeaState& state) {
    SeaStateValues out{.epoch = state.epoch(),
                       .start_time_us = state.start_time_us(),
                       .cascades = {},
                       .choppiness_x = state.choppiness_x(),
                       .choppiness_y = state.choppiness_y(),
                       .height_error_m = state.height_error_m(),
                       .requested = from_wire(state.requested()),
                       .realised = from_wire(state.realised()),
                       .interpolation_error_m = state.interpolation_error_m(),
                       .rms_slope = state.rms_slope(),
                       .curvature_per_m = state.curvature_per_m(),
                       .scene = state.scene() ? state.scene()->str() : std::string(),
                       .warnings = {},
                       .foam_mean = state.foam_mean(),
                       .foam_threshold = state.foam_threshold(),
                       .displacement_reach_m = state.displacement_reach_m(),
                       .rms_strain = state.rms_strain(),
                       .interpolation_displacement_m = state.interpolation_displacement_m(),
                       .interpolation_strain = state.interpolation_strain(),
                       .losses = {},
                       .single_precision_m = state.single_precision_m(),
                       .single_precision_displacement_m = state.single_precision_displacement_m(),
                       .depth_m = state.depth_m(),
                       .water = water_of(state),
                       .probes = from_wire(state.probes()),
                       .probe_error_m = state.probe_error_m(),
                       .glide = glide_of(state),
                       .wave_law = wave_law_of(state)};
    if (const auto* losses = state.losses())
        for (const wire::CascadeLoss* loss : *losses)
            out.losses.push_back(from_wire(*loss));
    if (const auto* cascades = state.cascades())
        for (const wire::CascadeInfo* c : *cascades)
            out.cascades.push_back({.length_m = c->length_m(),
                                    .size = static_cast<int>(c->size()),
                                    .k_lo_radpm = c->k_lo_radpm(),
                                    .k_hi_radpm = c->k_hi_radpm(),
                                    .placed_alone = c->placed_alone() != 0,
                                    .interval_us = c->interval_us()});
    for (std::size_t c = 0; c < out.cascades.size(); ++c)
        out.cascades[c].stylised = (state.stylised() >> c & 1u) != 0;
    if (const auto* warnings = state.warnings())
        for (const flatbuffers::String* warning : *warnings)
            out.warnings.push_back(warning->str());
    return out;
}

} // namespace seaway::protocol
