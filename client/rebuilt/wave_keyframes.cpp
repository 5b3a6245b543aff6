// SPDX-License-Identifier: Apache-2.0
#include "client/rebuilt/wave_keyframes.h"

#include <utility>

#include "sea/surface/maps/sine_maps.h"
#include "sea/waves/transition.h"

namespace seaway::client {

using sea::FieldSet;

namespace {

std::size_t index_of(const sea::Keyframe& keyframe) {
    return static_cast<std::size_t>(keyframe.cascade);
}

/// A keyframe without values yet, on the grid of a cascade.
sea::Keyframe without_values(std::uint32_t epoch, int cascade, sea::TimeUs time_us,
                             const sea::CascadeSpec& spec, FieldSet fields) {
    sea::Keyframe keyframe;
    keyframe.epoch = epoch;
    keyframe.cascade = cascade;
    keyframe.time_us = time_us;
    keyframe.size = spec.size;
    keyframe.length_m = spec.length_m;
    keyframe.fields = fields;
    keyframe.values.resize(static_cast<std::size_t>(fields.size()) * keyframe.plane_size());
    return keyframe;
}

} // namespace

bool WaveKeyframes::put_maps(const sea::Realization& sea, const sea::NativeTransform* transform,
                             sea::Keyframe& keyframe) {
    const sea::CascadeModes& modes = sea.cascades[index_of(keyframe)];
    const sea::TimeUs phase_us = sea.phase_time(keyframe.time_us);
    if (modes.is_there()) {
        std::optional<sea::NativeTransform> own;
        if (!transform) {
            auto made = sea::NativeTransform::create(modes, sea.choppiness);
            if (!made)
                return false;
            transform = &own.emplace(*std::move(made));
        }
        if (!runner_)
            runner_ = std::make_unique<sea::NativeRunner>(1);
        const sea::NativeTask task{
            transform, phase_us, keyframe.fields, {keyframe.values.data(), keyframe.values.size()}};
        runner_->run({&task, 1});
    }
    for (const sea::SineField& field : modes.sines)
        sea::add_sines(field, phase_us, keyframe);
    return true;
}

bool WaveKeyframes::put_steady(sea::Keyframe& keyframe) {
    if (!steady_) {
        steady_ = waves_->waves_at(keyframe.time_us);
        transforms_.resize(steady_->cascades.size());
    }
    const sea::CascadeModes& modes = steady_->cascades[index_of(keyframe)];
    std::optional<sea::NativeTransform>& transform = transforms_[index_of(keyframe)];
    if (!transform && modes.is_there())
        if (auto made = sea::NativeTransform::create(modes, steady_->choppiness))
            transform.emplace(*std::move(made));
    return put_maps(*steady_, transform ? &*transform : nullptr, keyframe);
}

bool WaveKeyframes::add_growth(const sea::SeaTransition& change, const sea::Realization& growth,
                               FieldSet values, sea::Keyframe& keyframe) {
    sea::Keyframe grown =
        without_values(keyframe.epoch, keyframe.cascade, keyframe.time_us,
                       {.length_m = keyframe.length_m, .size = keyframe.size}, values);
    if (!put_maps(growth, nullptr, grown))
        return false;
    for (const auto& [value, rate] : sea::rate_table)
        if (values.contains(value))
            change.add_growth(keyframe.plane(rate), std::as_const(grown).plane(value),
                              keyframe.time_us);
    return true;
}

bool WaveKeyframes::put_gliding(const sea::SeaTransition& change, sea::Keyframe& keyframe) {
    const std::uint32_t cascade = 1u << keyframe.cascade;
    const sea::TimeUs time_us = keyframe.time_us;
    if (!put_maps(*change.gliding(time_us, cascade), nullptr, keyframe))
        return false;
    if (sea::glide_rate(time_us, change.start_us(), change.end_us()) == 0)
        return true;
    if (!add_growth(change, *change.growth(time_us, cascade), change.grown(), keyframe))
        return false;
    const FieldSet otherwise = change.grown_otherwise();
    return otherwise.empty() ||
           add_growth(change, *change.displacement_growth(time_us, cascade), otherwise, keyframe);
}

std::optional<sea::Keyframe> WaveKeyframes::make(std::uint32_t epoch, int cascade,
                                                 sea::TimeUs time_us) {
    const sea::SeaTransition* change = waves_->change();
    const sea::RealizationPtr tiles = change ? change->after() : waves_->waves_at(time_us);
    sea::Keyframe keyframe = without_values(epoch, cascade, time_us,
                                            tiles->cascades[static_cast<std::size_t>(cascade)].spec,
                                            sea::surface_fields);
    if (change ? put_gliding(*change, keyframe) : put_steady(keyframe))
        return keyframe;
    return std::nullopt;
}

} // namespace seaway::client
