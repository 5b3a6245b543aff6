// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/accuracy/seas/configured_sea.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sea/surface/surface_sheets.h"
#include "server/device/device_choice.h"
#include "server/device/vulkan_synthesizer.h"
#include "server/simulation/schedule.h"

namespace seaway::bench {

Result<server::Synthesizer*> Devices::get(const Configuration& configuration) {
    auto& device = made_[{configuration.device, configuration.any_device_kernels}];
    if (device)
        return device.get();
    SEAWAY_TRY_LET(const server::DeviceChoice choice, server::choose_device(configuration.device));
    if (choice.vulkan && configuration.any_device_kernels) {
        SEAWAY_TRY_LET(auto made,
                       server::make_vulkan_synthesizer(
                           {.device = std::to_string(*choice.vulkan), .any_device_kernels = true}));
        device = std::move(made);
    } else {
        SEAWAY_TRY_LET(device, server::make_synthesizer(choice));
    }
    return device.get();
}

ConfiguredSea::ConfiguredSea(Waves waves, Configuration configuration, server::Synthesizer& device)
    : waves_(std::move(waves)), configuration_(std::move(configuration)), device_(device) {
    const double codec_m = configuration_.codec_error_m.value_or(waves_.budget.codec_error_m);
    if (configuration_.evaluator == Evaluator::maps && codec_m > 0)
        stream_ = std::make_unique<TileStream>(waves_, configuration_.tiles, codec_m);
}

Result<std::unique_ptr<ConfiguredSea>> ConfiguredSea::create(const sea::Scene& scene,
                                                             const Configuration& configuration,
                                                             Devices& devices) {
    SEAWAY_TRY_LET(Waves waves, configured_waves(scene, configuration));
    return create(std::move(waves), configuration, devices);
}

Result<std::unique_ptr<ConfiguredSea>>
ConfiguredSea::create(Waves waves, const Configuration& configuration, Devices& devices) {
    SEAWAY_TRY_LET(server::Synthesizer * device, devices.get(configuration));
    if (configuration.evaluator == Evaluator::maps)
        SEAWAY_TRY(device->set_sea(waves.used, 1));
    return std::unique_ptr<ConfiguredSea>(
        new ConfiguredSea(std::move(waves), configuration, *device));
}

Result<server::NewKeyframePtr> ConfiguredSea::synthesized(int cascade, sea::TimeUs time_us,
                                                          sea::FieldSet fields) {
    const server::KeyframeRequest request{cascade, time_us, fields};
    SEAWAY_TRY_LET(const auto made, device_.synthesize({&request, 1}));
    round_maps(*made[0], configuration_.format);
    return made[0];
}

Result<sea::KeyframePtr> ConfiguredSea::keyframe(int cascade, sea::TimeUs time_us) {
    const auto held = keyframes_.find({cascade, time_us});
    if (held != keyframes_.end())
        return held->second;
    const sea::TimeUs interval_us =
        waves_.budget.cascades[static_cast<std::size_t>(cascade)].interval_us;
    for (int n = stream_ ? stream_->leads_to(cascade, time_us) : 0; n > 0; --n) {
        SEAWAY_TRY_LET(const server::NewKeyframePtr lead,
                       synthesized(cascade, time_us - n * interval_us, server::predicted_fields));
        SEAWAY_TRY(stream_->lead(*lead));
    }
    SEAWAY_TRY_LET(const server::NewKeyframePtr whole,
                   synthesized(cascade, time_us,
                               configuration_.space == SpaceRule::spline ? sea::surface_fields
                                                                         : sea::linear_fields));
    if (stream_)
        SEAWAY_TRY(stream_->send(*whole));
    return sea::KeyframePtr(whole);
}

sea::TimeUs ConfiguredSea::keyframe_before_us(int cascade, sea::TimeUs time_us) const {
    return server::interval_start(
        time_us, waves_.budget.cascades[static_cast<std::size_t>(cascade)].interval_us);
}

Result<void> ConfiguredSea::go_to_maps() {
    decltype(keyframes_) keyframes;
    decltype(splines_) splines;
    std::vector<sea::SplinePair> pairs;
    naive_.clear();
    surface_of_cascade_.clear();
    for (int c = 0; c < static_cast<int>(waves_.used->cascades.size()); ++c) {
        const sea::TimeUs interval =
            waves_.budget.cascades[static_cast<std::size_t>(c)].interval_us;
        const bool frame = configuration_.time == TimeRule::every_frame;
        const sea::TimeUs before = frame ? shown_us_ : keyframe_before_us(c, shown_us_);
        sea::SplineMapPtr maps[2];
        sea::KeyframePtr around[2];
        for (int i = 0; i < 2; ++i) {
            const sea::TimeUs time = i == 0 || frame ? before : before + interval;
            SEAWAY_TRY_LET(around[i], keyframe(c, time));
            keyframes_[{c, time}] = keyframes[{c, time}] = around[i];
            if (!product_rules())
                continue;
            sea::SplineMapPtr& map = splines_[{c, time}];
            if (!map)
                map = std::make_shared<const sea::SplineMap>(*around[i]);
            maps[i] = splines[{c, time}] = map;
        }
        if (product_rules())
            pairs.push_back({maps[0], maps[1]});
        else
            naive_.emplace_back(around[0], around[1], configuration_.space, configuration_.time);
    }
    keyframes_ = std::move(keyframes);
    splines_ = std::move(splines);
    if (product_rules()) {
        const double codec_m = configuration_.codec_error_m.value_or(waves_.budget.codec_error_m);
        const sea::MapError error = sea::map_error(waves_.budget, codec_m);
        for (const sea::SplinePair& pair : pairs)
            surface_of_cascade_.emplace_back(std::vector{pair}, waves_.used->choppiness,
                                             sea::FoldSearch{}, sea::MapError{});
        surface_ = std::make_unique<sea::Surface>(std::move(pairs), waves_.used->choppiness,
                                                  sea::fold_search(waves_.budget), error);
    }
    return {};
}

void ConfiguredSea::go_to_sum() {
    moment_.reset();
    if (configuration_.phase != PhaseRule::fixed_point) {
        sum_ = std::make_unique<sea::DirectSum>(std::make_shared<const sea::Realization>(
            as_seen_at(*waves_.used, shown_us_, configuration_.phase)));
        moment_ = std::make_unique<sea::DirectSum::Moment>(sum_->at_time(0));
        return;
    }
    if (!sum_)
        sum_ = std::make_unique<sea::DirectSum>(waves_.used);
    moment_ = std::make_unique<sea::DirectSum::Moment>(sum_->at_time(shown_us_));
}

Result<void> ConfiguredSea::go_to(sea::TimeUs time_us) {
    shown_us_ = time_us - sea::us_from_seconds(configuration_.latency_s);
    if (configuration_.evaluator == Evaluator::maps)
        return go_to_maps();
    go_to_sum();
    return {};
}

sea::LagrangianPoint ConfiguredSea::at(double x_m, double y_m) const {
    if (moment_)
        return moment_->at(x_m, y_m);
    if (surface_)
        return surface_->at(x_m, y_m, shown_us_);
    sea::LagrangianPoint sum;
    for (const NaiveCascade& cascade : naive_)
        cascade.add(x_m, y_m, shown_us_, sum);
    return sum;
}

sea::LagrangianPoint ConfiguredSea::at(int cascade, double x_m, double y_m) const {
    const auto c = static_cast<std::size_t>(cascade);
    if (surface_)
        return surface_of_cascade_[c].at(x_m, y_m, shown_us_);
    sea::LagrangianPoint point;
    naive_[c].add(x_m, y_m, shown_us_, point);
    return point;
}

sea::Answer ConfiguredSea::solved(const sea::QueryPoint& point) const {
    const auto field = [this](double x_m, double y_m) { return at(x_m, y_m); };
    if (configuration_.fixed_point_steps)
        return fixed_point_answer(point, *configuration_.fixed_point_steps, waves_.used->choppiness,
                                  sea::LagrangianField(field));
    const sea::InverseOptions options{waves_.used->choppiness, configuration_.tolerance_m,
                                      sea::fold_search(waves_.budget)};
    if (moment_)
        return sea::surface_at(point, options, *moment_);
    if (!surface_)
        return sea::surface_at(point, options, sea::LagrangianField(field));
    sea::SurfaceSheets sheets(*surface_, point.time_us);
    return sea::surface_at(point, options, sea::LagrangianField(field), &sheets);
}

namespace {

/// Counts what a search for sheets looks at.
class CountingSheets final : public sea::SheetBounds {
  public:
    CountingSheets(sea::SheetBounds& sheets, int& count) : sheets_(sheets), count_(count) {}

    std::optional<sea::Box> others(sea::Vec2 target, const sea::Vec2* root,
                                   bool suspected) override {
        return sheets_.others(target, root, suspected);
    }
    double blur_m() const override { return sheets_.blur_m(); }
    double strain_blur() const override { return sheets_.strain_blur(); }
    double height_blur_m() const override { return sheets_.height_blur_m(); }
    bool newton_decides() const override { return sheets_.newton_decides(); }
    double height(sea::Vec2 at) const override { return sheets_.height(at); }
    double spacing_m() const override { return sheets_.spacing_m(); }
    sea::Box left_of(const sea::Box& box, sea::Vec2 target) const override {
        return sheets_.left_of(box, target);
    }
    RecycledVector<sea::Rise> rises(const sea::Box& box) const override {
        return sheets_.rises(box);
    }
    sea::LagrangianPoint displaced(sea::Vec2 at) const override {
        ++count_;
        return sheets_.displaced(at);
    }
    RecycledVector<sea::Roughness> roughness(const sea::Box& box) const override {
        return sheets_.roughness(box);
    }

  private:
    sea::SheetBounds& sheets_;
    int& count_;
};

} // namespace

int ConfiguredSea::evaluations(sea::QueryPoint point) const {
    point.time_us = shown_us_;
    int count = 0;
    const auto field = [this, &count](double x_m, double y_m) {
        ++count;
        return at(x_m, y_m);
    };
    const sea::InverseOptions options{waves_.used->choppiness, configuration_.tolerance_m,
                                      sea::fold_search(waves_.budget)};
    sea::SurfaceSheets sheets(*surface_, point.time_us);
    CountingSheets counted(sheets, count);
    sea::surface_at(point, options, sea::LagrangianField(field), &counted);
    return count;
}

bool ConfiguredSea::answers_as_served() const {
    return surface_ && !configuration_.fixed_point_steps &&
           configuration_.tolerance_m == Configuration{}.tolerance_m;
}

sea::Answer ConfiguredSea::answer(sea::QueryPoint point) const {
    point.time_us = shown_us_;
    return answers_as_served() ? surface_->answer(point) : solved(point);
}

void ConfiguredSea::answer(std::span<const sea::QueryPoint> points,
                           std::span<sea::Answer> answers) const {
    std::vector<sea::QueryPoint> shown(points.begin(), points.end());
    for (sea::QueryPoint& point : shown)
        point.time_us = shown_us_;
    sea::MixedMaps mixed;
    if (answers_as_served())
        surface_->answer(shown, answers, {.mixed = &mixed});
    else
        std::transform(shown.begin(), shown.end(), answers.begin(),
                       [&](const sea::QueryPoint& point) { return solved(point); });
}

} // namespace seaway::bench
