// SPDX-License-Identifier: Apache-2.0
#include "tools/bake/bake.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>

#include <fmt/format.h>

#include "sea/foam/foam.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/waves/realize.h"
#include "tools/bake/summed.h"
#include "tools/bake/tile_files.h"

namespace seaway::bake {

using sea::Field;
using sea::FieldSet;
using sea::TimeUs;

namespace {

class Stopwatch {
  public:
    double lap_s() {
        const auto now = std::chrono::steady_clock::now();
        const double lap = std::chrono::duration<double>(now - since_).count();
        since_ = now;
        return lap;
    }

  private:
    std::chrono::steady_clock::time_point since_ = std::chrono::steady_clock::now();
};

class Baker {
  public:
    Baker(const sea::Scene& scene, sea::RealizationPtr sea, const BakeOptions& options,
          server::Synthesizer& synthesizer)
        : sea_(std::move(sea)), options_(options), synthesizer_(synthesizer) {
        if (options_.fields.contains(Field::foam))
            law_ = sea::foam_law_of(scene, *sea_);
        files_.emplace(law_ ? sea::with_threshold(scene, *law_) : scene, *sea_, options_,
                       law_.get());
        if (!law_)
            return;
        // The ticks of foam are those that a server makes of this scene, whatever the frame rate.
        const sea::ErrorBudget budget = sea::plan_budget(*sea_, scene.accuracy.height_error_m);
        for (std::size_t c = 0; c < sea_->cascades.size(); ++c)
            foam_.emplace_back(law_, static_cast<int>(c), sea_->cascades[c].spec.size,
                               budget.cascades[c].interval_us);
    }

    Result<void> frame(int frame) {
        Stopwatch watch;
        const TimeUs time_us = frame_time(options_, frame);
        std::vector<server::KeyframeRequest> requests;
        for (int c = 0; c < static_cast<int>(sea_->cascades.size()); ++c)
            requests.push_back({c, time_us, synthesized_fields()});
        SEAWAY_TRY_LET(const std::vector<server::NewKeyframePtr> made,
                       synthesizer_.synthesize(requests));
        const std::vector<sea::KeyframePtr> keyframes(made.begin(), made.end());
        for (std::size_t c = 0; c < foam_.size(); ++c)
            SEAWAY_TRY(advance_foam(c, keyframes[c]));
        report_.synthesis_s += watch.lap_s();
        SEAWAY_TRY(write_all(frame, keyframes));
        report_.files_s += watch.lap_s();
        ++report_.frames;
        return {};
    }

    BakeReport report() const {
        BakeReport report = report_;
        report.files = files_->count();
        report.bytes = files_->bytes();
        return report;
    }

  private:
    FieldSet synthesized_fields() const {
        FieldSet fields = options_.fields.without({Field::foam});
        if (options_.vectors)
            fields |= vector_fields;
        if (options_.mesh != MeshFormat::none)
            fields |= mesh_fields;
        if (options_.summed && fields.contains(Field::jacobian))
            fields |= {Field::strain_xx, Field::strain_yy, Field::strain_xy};
        return foam_.empty() ? fields : fields | sea::foam_inputs;
    }

    Result<void> go_on() const {
        if (!options_.stops())
            return {};
        return Error{BakeError::stopped,
                     fmt::format("stopped by a signal: {} of {} frames are whole; --first {} "
                                 "--frames {} goes on",
                                 report_.frames, options_.frames, options_.first + report_.frames,
                                 options_.frames - report_.frames)};
    }

    /// The frame's own strains are at hand; those of the ticks before it are asked for.
    Result<void> advance_foam(std::size_t cascade, const sea::KeyframePtr& keyframe) {
        const auto strains = [&](TimeUs time_us) -> Result<sea::KeyframePtr> {
            SEAWAY_TRY(go_on());
            if (time_us == keyframe->time_us)
                return keyframe;
            const server::KeyframeRequest request{static_cast<int>(cascade), time_us,
                                                  sea::foam_inputs};
            SEAWAY_TRY_LET(const std::vector<server::NewKeyframePtr> made,
                           synthesizer_.synthesize({&request, 1}));
            return sea::KeyframePtr(made.front());
        };
        return foam_[cascade].advance_to(keyframe->time_us, strains);
    }

    Result<void> write_all(int frame, const std::vector<sea::KeyframePtr>& keyframes) {
        if (options_.summed) {
            CascadeMaps maps{keyframes, {}, law_ ? law_->mean_coverage : 0.0};
            for (const sea::FoamHistory& history : foam_)
                maps.foam_ratios.push_back(history.ratios());
            FieldSet fields = synthesized_fields();
            if (!foam_.empty())
                fields |= {Field::foam};
            const sea::Keyframe sea = sum_cascades(*sea_, maps, fields);
            const std::span<const float> foam =
                foam_.empty() ? std::span<const float>() : sea.plane(Field::foam);
            SEAWAY_TRY(go_on());
            return files_->write(frame, fmt::format("sea.{:05}", frame), sea, foam);
        }
        // A sea that never breaks has no average that a ratio could be of.
        const auto ratios = [&](std::size_t c) {
            if (law_->calm())
                none_.assign(keyframes[c]->plane_size(), 0.0f);
            return law_->calm() ? std::span<const float>(none_) : foam_[c].ratios();
        };
        for (std::size_t c = 0; c < keyframes.size(); ++c) {
            SEAWAY_TRY(go_on());
            SEAWAY_TRY(files_->write(frame, fmt::format("cascade{}.{:05}", c, frame), *keyframes[c],
                                     foam_.empty() ? std::span<const float>() : ratios(c)));
        }
        return {};
    }

    sea::RealizationPtr sea_;
    const BakeOptions& options_;
    server::Synthesizer& synthesizer_;
    sea::FoamLawPtr law_; ///< null without foam
    std::vector<sea::FoamHistory> foam_;
    std::vector<float> none_; ///< a map of no foam
    std::optional<TileFiles> files_;
    BakeReport report_;
};

Result<void> validate(const BakeOptions& options) {
    const auto refused = [](std::string message) {
        return Error{BakeError::bad_options, std::move(message)};
    };
    if (options.frames < 1 || options.frames > frames_max)
        return refused(fmt::format("--frames {}: 1 .. {}", options.frames, frames_max));
    if (options.first < 0 || options.first > frames_max - options.frames)
        return refused(fmt::format("--first {} --frames {}: frames are numbered 0 .. {}",
                                   options.first, options.frames, frames_max - 1));
    const double start_s = sea::seconds_from_us(options.start_us);
    const double last_s = start_s + options.rate.offset_s(options.first + options.frames - 1);
    if (!(std::abs(start_s) <= time_max_s && last_s <= time_max_s))
        return refused(fmt::format("--start {} --frames {} --fps {}: frames from {} to {} s; "
                                   "allowed: {:g} .. {:g} s",
                                   start_s, options.frames, options.rate.text(), start_s, last_s,
                                   -time_max_s, time_max_s));
    if (options.fields.empty())
        return refused("--fields: none is left");
    return {};
}

/// A size that the device does not make is of the options; the native device's only error is of that, and has no kind.
Error of_device(const Error& error) {
    const bool asked_for =
        error.is(server::DeviceError::cannot_do_this_sea) || error.is(ErrorKind{});
    return asked_for ? Error{BakeError::bad_options, error.message} : error;
}

} // namespace

Result<FieldSet> parse_fields(const std::string& list) {
    if (list == "all")
        return sea::all_fields;
    FieldSet fields;
    std::size_t at = 0;
    while (at <= list.size()) {
        const std::size_t comma = std::min(list.find(',', at), list.size());
        const std::string_view name = std::string_view(list).substr(at, comma - at);
        const sea::FieldInfo* found = nullptr;
        std::string names;
        for (const sea::FieldInfo& info : sea::field_table) {
            if (info.name == name)
                found = &info;
            names += fmt::format("{}{}", names.empty() ? "" : ", ", info.name);
        }
        if (!found)
            return Error{fmt::format("--fields '{}': no field; there are {}; or all", name, names)};
        fields.insert(found->field);
        at = comma + 1;
    }
    return fields;
}

TimeUs frame_time(const BakeOptions& options, int frame) {
    return options.start_us + options.rate.offset_us(frame);
}

Result<BakeReport> bake(const sea::Scene& scene, const BakeOptions& options,
                        server::Synthesizer& synthesizer) {
    SEAWAY_TRY(validate(options));
    if (options.fields.contains(Field::foam) && !sea::has_foam(scene.effects))
        return Error{BakeError::bad_options,
                     fmt::format("--fields: foam, but [effects] has {} in {}",
                                 scene.effects.foam ? "displacement height, where nothing breaks,"
                                                    : "no foam",
                                 scene.source)};
    if (!scene.weather.empty())
        return Error{BakeError::bad_options,
                     fmt::format("{}: it has a timetable ([[weather]]): seas that change are a "
                                 "server's",
                                 scene.source)};
    Stopwatch watch;
    Result<sea::Realization> realized = sea::realize(scene);
    if (!realized)
        return Error{BakeError::bad_options, realized.error().message};
    const auto sea = std::make_shared<const sea::Realization>(std::move(realized).value());
    if (const Result<void> taken = synthesizer.set_sea(sea, 1); !taken)
        return of_device(taken.error());
    std::error_code error;
    std::filesystem::create_directories(options.folder, error);
    if (error)
        return Error{fmt::format("--out {}: {}", options.folder, error.message())};
    Baker baker(scene, sea, options, synthesizer);
    for (int i = 0; i < options.frames; ++i)
        SEAWAY_TRY(baker.frame(options.first + i));
    BakeReport report = baker.report();
    report.total_s = watch.lap_s();
    return report;
}

} // namespace seaway::bake
