// SPDX-License-Identifier: Apache-2.0
#include "tools/bake/bake.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <system_error>

#include <fmt/format.h>

#include "sea/foam/foam.h"
#include "sea/waves/moments.h"
#include "sea/waves/realize.h"

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

double degrees_from(double towards_rad) {
    const double degrees = 270.0 - towards_rad * 180.0 / std::numbers::pi;
    return degrees - 360.0 * std::floor(degrees / 360.0);
}

/// What is the same for every file.
std::vector<ExrAttribute> sea_attributes(const sea::Scene& scene, const sea::Realization& sea) {
    const sea::SeaSummary summary = sea::summarize(scene.sea, sea);
    const sea::SeaStatistics& s = summary.realised;
    return {
        {"software", std::string("seaway-bake " SEAWAY_VERSION)},
        {"seaway.scene", scene.source},
        {"seaway.scene_toml", sea::to_toml(scene)},
        {"seaway.rows", std::string("south to north")},
        {"seaway.hs_m", s.significant_height_m},
        {"seaway.tp_s", s.peak_period_s},
        {"seaway.tz_s", s.zero_crossing_period_s},
        {"seaway.tm01_s", s.mean_period_s},
        {"seaway.mean_from_deg", degrees_from(s.mean_towards_rad)},
        {"seaway.requested_hs_m", summary.requested.significant_height_m},
        {"seaway.requested_tp_s", summary.requested.peak_period_s},
        {"seaway.choppiness_x", sea.choppiness.x},
        {"seaway.choppiness_y", sea.choppiness.y},
    };
}

class Baker {
  public:
    Baker(const sea::Scene& scene, sea::RealizationPtr sea, const BakeOptions& options,
          server::Synthesizer& synthesizer)
        : sea_(std::move(sea)), options_(options), synthesizer_(synthesizer),
          attributes_(sea_attributes(scene, *sea_)) {
        if (!options_.fields.contains(Field::foam))
            return;
        law_ = sea::make_foam_law(*sea_, scene.foam);
        for (std::size_t c = 0; c < sea_->cascades.size(); ++c)
            foam_.emplace_back(law_, static_cast<int>(c), sea_->cascades[c].spec.size);
    }

    Result<void> frame(int frame) {
        Stopwatch watch;
        const TimeUs time_us = frame_time(options_, frame);
        std::vector<server::KeyframeRequest> requests;
        for (int c = 0; c < static_cast<int>(sea_->cascades.size()); ++c)
            requests.push_back({c, time_us, synthesized_fields()});
        Result<std::vector<sea::KeyframePtr>> keyframes = synthesizer_.synthesize(requests);
        if (!keyframes)
            return keyframes.error();
        for (std::size_t c = 0; c < foam_.size(); ++c)
            if (Result<void> done = advance_foam(c, (*keyframes)[c]); !done)
                return done;
        report_.synthesis_s += watch.lap_s();
        for (std::size_t c = 0; c < keyframes->size(); ++c)
            if (Result<void> done = write(frame, *(*keyframes)[c]); !done)
                return done;
        report_.files_s += watch.lap_s();
        ++report_.frames;
        return {};
    }

    BakeReport& report() { return report_; }

  private:
    FieldSet synthesized_fields() const {
        FieldSet fields =
            FieldSet::from_bits(options_.fields.bits() & ~FieldSet{Field::foam}.bits());
        return foam_.empty() ? fields : fields | sea::foam_inputs;
    }

    /// The frame's own strains are at hand; a first frame asks for those before it.
    Result<void> advance_foam(std::size_t cascade, const sea::KeyframePtr& keyframe) {
        const TimeUs interval_us = std::max<TimeUs>(sea::us_from_seconds(1.0 / options_.fps), 1);
        const auto strains = [&](TimeUs time_us) -> Result<sea::KeyframePtr> {
            if (time_us == keyframe->time_us)
                return keyframe;
            const server::KeyframeRequest request{static_cast<int>(cascade), time_us,
                                                  sea::foam_inputs};
            Result<std::vector<sea::KeyframePtr>> made = synthesizer_.synthesize({&request, 1});
            if (!made)
                return made.error();
            return made->front();
        };
        return foam_[cascade].advance_to(keyframe->time_us, interval_us, strains);
    }

    Result<void> write(int frame, const sea::Keyframe& keyframe) {
        const auto cascade = static_cast<std::size_t>(keyframe.cascade);
        ExrMap map;
        map.size = keyframe.size;
        map.half = options_.half;
        map.compression = options_.compression;
        for (const Field field : options_.fields)
            map.channels.push_back(
                {std::string(sea::info(field).name),
                 field == Field::foam ? foam_[cascade].ratios() : keyframe.plane(field)});
        map.attributes = attributes_;
        const auto add = [&](const char* name, double value) {
            map.attributes.emplace_back(name, value);
        };
        add("seaway.cascade", keyframe.cascade);
        add("seaway.length_m", keyframe.length_m);
        add("seaway.frame", frame);
        add("seaway.time_s", sea::seconds_from_us(keyframe.time_us));
        map.attributes.emplace_back("seaway.time_us", std::to_string(keyframe.time_us));
        add("seaway.tick_s", 1.0 / options_.fps);
        if (law_)
            add("seaway.foam_mean", law_->mean_coverage);
        const std::string path =
            fmt::format("{}/cascade{}.{:05}.exr", options_.folder, keyframe.cascade, frame);
        if (Result<void> written = write_exr(path, map); !written)
            return written;
        std::error_code ignored;
        report_.bytes += std::filesystem::file_size(path, ignored);
        ++report_.files;
        return {};
    }

    sea::RealizationPtr sea_;
    const BakeOptions& options_;
    server::Synthesizer& synthesizer_;
    std::vector<ExrAttribute> attributes_;
    sea::FoamLawPtr law_; ///< null without foam
    std::vector<sea::FoamHistory> foam_;
    BakeReport report_;
};

Result<void> validate(const BakeOptions& options) {
    const auto refused = [](std::string message) { return Error{std::move(message), bad_options}; };
    if (options.frames < 1 || options.frames > frames_max)
        return refused(fmt::format("--frames {}: 1 .. {}", options.frames, frames_max));
    if (!(options.fps > 0 && options.fps <= fps_max))
        return refused(fmt::format("--fps {}: above 0, up to {}", options.fps, fps_max));
    if (options.fields.empty())
        return refused("--fields: none is left");
    return {};
}

} // namespace

FieldSet all_fields() {
    return FieldSet::from_bits(~0u);
}

Result<FieldSet> parse_fields(const std::string& list) {
    if (list == "all")
        return all_fields();
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
    return options.start_us + sea::us_from_seconds(frame / options.fps);
}

Result<BakeReport> bake(const sea::Scene& scene, const BakeOptions& options,
                        server::Synthesizer& synthesizer) {
    if (Result<void> valid = validate(options); !valid)
        return valid.error();
    Stopwatch watch;
    Result<sea::Realization> realized = sea::realize(scene);
    if (!realized)
        return Error{realized.error().message, bad_options};
    const auto sea = std::make_shared<const sea::Realization>(std::move(realized).value());
    if (Result<void> ready = synthesizer.set_sea(sea, 1); !ready)
        return ready.error();
    std::error_code error;
    std::filesystem::create_directories(options.folder, error);
    if (error)
        return Error{fmt::format("--out {}: {}", options.folder, error.message())};
    Baker baker(scene, sea, options, synthesizer);
    for (int frame = 0; frame < options.frames; ++frame)
        if (Result<void> done = baker.frame(frame); !done)
            return done.error();
    baker.report().total_s = watch.lap_s();
    return baker.report();
}

} // namespace seaway::bake
