// SPDX-License-Identifier: Apache-2.0
#include "server/device/native_synthesizer.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <new>

#include <fmt/format.h>

#include "base/check.h"
#include "base/thread_pool.h"
#include "sea/foam/foam.h"
#include "server/device/spare_buffers.h"
#include "server/device/stylised_waves.h"

namespace seaway::server {

namespace {

struct NativeFoam final : FoamMap {
    explicit NativeFoam(sea::FoamRatios map) : ratios(std::move(map)) {}
    bool lost() const override { return false; }
    sea::FoamRatios ratios;
};

/// Its turn looks at strains that are not among its maps.
bool lacks_strains(const KeyframeRequest& request) {
    return request.foam != nullptr && request.foam->looks(request.fields) &&
           !request.fields.contains(sea::foam_inputs);
}

} // namespace

NativeSynthesizer::NativeSynthesizer(int threads)
    : runner_(threads), spare_(std::make_shared<SpareBuffers>()) {}

std::string NativeSynthesizer::description() const {
    return fmt::format("native ({}, {} threads)", name(best_instructions()), runner_.threads());
}

Result<void> NativeSynthesizer::set_sea(sea::RealizationPtr sea, std::uint32_t epoch) {
    std::vector<std::optional<sea::NativeTransform>> cascades;
    for (const sea::CascadeModes& modes : sea->cascades) {
        if (!modes.is_there()) {
            cascades.emplace_back();
            continue;
        }
        auto cascade = sea::NativeTransform::create(modes, sea->choppiness);
        if (!cascade)
            return cascade.error();
        cascades.emplace_back(std::move(*cascade));
        ++counters_.cascades;
    }
    sea_ = std::move(sea);
    epoch_ = epoch;
    cascades_ = std::move(cascades);
    return {};
}

Result<FoamMapPtr> NativeSynthesizer::open_foam(int size, const FoamMap* from) try {
    if (from != nullptr)
        return FoamMapPtr(std::make_shared<NativeFoam>(static_cast<const NativeFoam&>(*from)));
    return FoamMapPtr(std::make_shared<NativeFoam>(sea::FoamRatios(size)));
} catch (const std::bad_alloc&) {
    return Error{DeviceError::out_of_memory, "native foam: out of memory"};
}

void NativeSynthesizer::take_turn(const FoamTurn& turn, const sea::Keyframe& strains,
                                  sea::Keyframe& keyframe) {
    struct Work {
        const FoamTurn& turn;
        sea::FoamRatios& ratios;
        const sea::Keyframe& strains;
        sea::Keyframe& keyframe;
        bool shows;
    } const work{turn, static_cast<NativeFoam&>(*turn.map).ratios, strains, keyframe,
                 keyframe.fields.contains(sea::Field::foam)};
    const auto some = [](const void* context, int chunk, int) {
        const Work& of = *static_cast<const Work*>(context);
        const sea::FoamRatios::Part part = of.ratios.part(chunk);
        if (of.turn.kept)
            of.ratios.take(*of.turn.kept, &of.strains, part);
        if (of.shows)
            of.ratios.show(of.turn.shown, &of.strains, of.keyframe.plane(sea::Field::foam), part);
    };
    runner_.pool().run(std::array{Phase{some, &work, work.ratios.parts()}});
    counters_.dispatches += turn.kept || work.shows;
    counters_.foam_ticks += turn.kept.has_value() + (work.shows && turn.shown.tick.looks());
}

NewKeyframePtr NativeSynthesizer::keyframe(const KeyframeRequest& request,
                                           sea::FieldSet fields) const {
    SEAWAY_CHECK(request.cascade >= 0 && request.cascade < static_cast<int>(cascades_.size()),
                 "request for a cascade that the sea does not have");
    const sea::CascadeSpec& spec = sea_->cascades[static_cast<std::size_t>(request.cascade)].spec;
    NewKeyframePtr made = make_keyframe(spare_);
    *made = {epoch_, request.cascade, request.time_us, spec.size, spec.length_m, fields};
    made->values = spare_->take(static_cast<std::size_t>(fields.size()) * made->plane_size());
    return made;
}

Result<std::vector<NewKeyframePtr>>
NativeSynthesizer::synthesize(std::span<const KeyframeRequest> requests) try {
    std::vector<NewKeyframePtr> keyframes,
        strains; ///< the latter: for foam, where others lack them; or null
    std::vector<sea::NativeTask> tasks;
    for (const KeyframeRequest& request : requests) {
        sea::Keyframe& made = *keyframes.emplace_back(keyframe(request, request.fields));
        const auto& cascade = cascades_[static_cast<std::size_t>(request.cascade)];
        SEAWAY_CHECK(cascade, "request for a cascade that the sea was given without");
        const sea::FieldSet fields = synthesized(request.fields);
        const std::size_t values = static_cast<std::size_t>(fields.size()) * made.plane_size();
        sea::NativeTask& task =
            tasks.emplace_back(sea::NativeTask{&*cascade, sea_->phase_time(request.time_us), fields,
                                               std::span(made.values).first(values)});
        strains.push_back(lacks_strains(request) ? keyframe(request, sea::foam_inputs) : nullptr);
        if (strains.back())
            task.strains = strains.back()->values;
        counters_.transforms += static_cast<std::uint64_t>(task.transformed().size());
        counters_.dispatches += task.transformed().empty() ? 0 : 2;
    }
    counters_.keyframes += with_fields(requests);
    const auto start = std::chrono::steady_clock::now();
    runner_.run(tasks);
    const auto mapped = std::chrono::steady_clock::now();
    for (std::size_t i = 0; i < keyframes.size(); ++i) {
        if (requests[i].foam == nullptr)
            continue;
        for (const sea::Field field : (requests[i].fields & sea::foam_inputs))
            if (strains[i])
                sea::copy_map(*keyframes[i], field, *strains[i]);
        take_turn(*requests[i].foam, strains[i] ? *strains[i] : *keyframes[i], *keyframes[i]);
    }
    const auto seconds = [](auto span) { return std::chrono::duration<double>(span).count(); };
    counters_.device_seconds += seconds(mapped - start);
    counters_.foam_seconds += seconds(std::chrono::steady_clock::now() - mapped);
    add_stylised(requests, *sea_, keyframes, counters_);
    return keyframes;
} catch (const std::bad_alloc&) {
    return Error{DeviceError::out_of_memory, "native synthesis: out of memory"};
}

void NativeSynthesizer::trim() {
    runner_.trim();
    spare_->trim();
}

Result<std::vector<SynthesisStage>> NativeSynthesizer::stages(const KeyframeRequest& request) {
    const sea::NativeTransform& cascade = *cascades_[static_cast<std::size_t>(request.cascade)];
    const auto size = static_cast<std::size_t>(cascade.size());
    std::vector<float> planes(static_cast<std::size_t>(request.fields.size()) * size * size);
    std::vector<SynthesisStage> stages;
    for (const sea::NativeLines& lines : runner_.run_and_show(
             {&cascade, sea_->phase_time(request.time_us), request.fields, planes})) {
        SynthesisStage stage{"columns", lines.name, cascade.size(), cascade.size() / 2, true, {}};
        for (const std::complex<float>& value : lines.values)
            stage.values.insert(stage.values.end(), {value.real(), value.imag()});
        stages.push_back(std::move(stage));
    }
    return stages;
}

} // namespace seaway::server
