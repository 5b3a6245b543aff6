// SPDX-License-Identifier: Apache-2.0
// A LocalSea in a window.
#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "local/local_sea.h"

namespace seaway::local {

namespace {

using client::PanelRow;
using Clock = std::chrono::steady_clock;

class WavePoints final : public client::Points {
  public:
    explicit WavePoints(client::RebuiltSeaPtr waves) : waves_(std::move(waves)) {}
    sea::Answer answer(const sea::QueryPoint& point) const override {
        return waves_->answer(point, *at(point.time_us));
    }
    bool covers(sea::TimeUs time_us) const override { return sea::in_time_range(time_us); }

  private:
    using Moment = sea::DirectSum::Moment;
    struct Kept {
        sea::TimeUs time_us;
        Moment moment;
    };
    /// A click asks for hundreds of points of one time, which all waves have to be turned to.
    std::shared_ptr<const Moment> at(sea::TimeUs time_us) const {
        const std::scoped_lock lock(mutex_);
        if (!kept_ || kept_->time_us != time_us)
            kept_ = std::make_shared<const Kept>(Kept{time_us, waves_->sum().at_time(time_us)});
        return {kept_, &kept_->moment};
    }

    const client::RebuiltSeaPtr waves_;
    mutable std::mutex mutex_;
    mutable std::shared_ptr<const Kept> kept_;
};

/// Runs from `start_us` on, as clocks do.
class SeenLocalSea final : public client::SeenSea {
  public:
    SeenLocalSea(std::unique_ptr<LocalSea> sea, std::string path, sea::TimeUs start_us)
        : sea_(std::move(sea)), points_(std::make_shared<const WavePoints>(sea_->waves())),
          path_(std::move(path)), start_us_(start_us) {}

    Result<std::optional<Moment>> now() override {
        if (!started_)
            started_ = Clock::now();
        const sea::TimeUs passed_us =
            std::chrono::duration_cast<std::chrono::microseconds>(Clock::now() - *started_).count();
        SEAWAY_TRY_LET(client::SeaFrame frame, sea_->at(start_us_ + passed_us));
        return std::optional<Moment>({std::move(frame), sea_->state(), points_});
    }
    const std::string& name() const override { return path_; }
    std::string reason() const override { return ""; }
    Counts counts() const override {
        return {sea_->counters().keyframes, 0}; // nothing travels
    }
    std::vector<PanelRow> connection(std::optional<double> stale_s) const override {
        return {{"scene", path_},
                {"made by", sea_->description()},
                {"sea shown", stale_s ? client::stale_text(*stale_s) : "now"}};
    }
    std::vector<PanelRow> rates(double keyframes_hz, double, double frames_hz) const override {
        const server::SynthesisCounters counters = sea_->counters();
        return {{"frames", fmt::format("{:.1f} a second", frames_hz)},
                {"keyframes",
                 fmt::format("{:.1f} a second, {} in all", keyframes_hz, counters.keyframes)},
                {"transforms", fmt::format("{} in all", counters.transforms)},
                {"ticks of foam", fmt::format("{} in all", counters.foam_ticks)},
                {"copied out", fmt::format("{} keyframes", counters.copies)}};
    }

  private:
    const std::unique_ptr<LocalSea> sea_;
    const client::PointsPtr points_;
    const std::string path_;
    const sea::TimeUs start_us_;
    std::optional<Clock::time_point> started_; ///< by the first frame
};

} // namespace

client::OpenSea open_in_a_window(server::RunningSeaPtr sea, const client::ViewOptions& options) {
    return [sea = std::move(sea), path = options.scene,
            start_us = sea::us_from_seconds(options.time_s.value_or(0))](
               const std::shared_ptr<gpu::Device>& device)
               -> Result<std::unique_ptr<client::SeenSea>> {
        SEAWAY_TRY_LET(std::unique_ptr<LocalSea> made, LocalSea::create(sea, device));
        return std::unique_ptr<client::SeenSea>(
            std::make_unique<SeenLocalSea>(std::move(made), path, start_us));
    };
}

} // namespace seaway::local
