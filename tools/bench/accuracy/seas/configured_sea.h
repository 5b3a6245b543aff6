// SPDX-License-Identifier: Apache-2.0
// A sea computed as a configuration says: its device makes the maps, the codec writes and reads them,
// its rules sample them. What that takes is counted on the way.
//
// For one thread. Holds the keyframes around the last time.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "base/result.h"
#include "sea/surface/answer.h"
#include "sea/surface/maps/keyframe.h"
#include "sea/surface/surface.h"
#include "sea/waves/reference.h"
#include "server/device/synthesizer.h"
#include "tools/bench/accuracy/seas/configuration.h"
#include "tools/bench/accuracy/seas/naive.h"
#include "tools/bench/accuracy/seas/tile_stream.h"
#include "tools/bench/accuracy/seas/waves.h"

namespace seaway::bench {

/// Devices by name, made once.
class Devices {
  public:
    Result<server::Synthesizer*> get(const Configuration& configuration);

  private:
    std::map<std::pair<std::string, bool>, std::unique_ptr<server::Synthesizer>> made_;
};

class ConfiguredSea {
  public:
    static Result<std::unique_ptr<ConfiguredSea>>
    create(const sea::Scene& scene, const Configuration& configuration, Devices& devices);

    /// Of waves that were drawn already, with the configuration's tiles and its budget.
    static Result<std::unique_ptr<ConfiguredSea>>
    create(Waves waves, const Configuration& configuration, Devices& devices);

    /// Goes to a time; until then nothing may be asked.
    Result<void> go_to(sea::TimeUs time_us);

    /// Of the time gone to. Times of the points are not looked at.
    sea::Answer answer(sea::QueryPoint point) const;
    /// Of points that are asked for together, at a time that nobody asked for before: as a server or a client answers them where
    /// the rules are Seaway's own.
    void answer(std::span<const sea::QueryPoint> points, std::span<sea::Answer> answers) const;
    sea::LagrangianPoint at(double x_m, double y_m) const;
    /// Of one cascade alone. Maps only.
    sea::LagrangianPoint at(int cascade, double x_m, double y_m) const;
    /// How often the sea is evaluated for the answer there, a search for sheets included. Maps and
    /// Seaway's own rules only.
    int evaluations(sea::QueryPoint point) const;
    /// The last time up to this one that has a keyframe of a cascade.
    sea::TimeUs keyframe_before_us(int cascade, sea::TimeUs time_us) const;
    /// The time that answers are of: earlier than the one gone to by the latency.
    sea::TimeUs shown_us() const { return shown_us_; }

    const Waves& waves() const { return waves_; }
    const Configuration& configuration() const { return configuration_; }
    /// Of no keyframes where maps are not coded.
    CodingCost coding(std::size_t cascade) const {
        return stream_ ? stream_->costs()[cascade] : CodingCost{};
    }

  private:
    ConfiguredSea(Waves waves, Configuration configuration, server::Synthesizer& device);
    Result<sea::KeyframePtr> keyframe(int cascade, sea::TimeUs time_us);
    Result<server::NewKeyframePtr> synthesized(int cascade, sea::TimeUs time_us,
                                               sea::FieldSet fields);
    Result<void> go_to_maps();
    void go_to_sum();
    bool product_rules() const {
        return configuration_.space == SpaceRule::spline &&
               configuration_.time == TimeRule::hermite;
    }
    bool answers_as_served() const;
    sea::Answer solved(const sea::QueryPoint& point) const;

    Waves waves_;
    Configuration configuration_;
    server::Synthesizer& device_;
    std::unique_ptr<TileStream> stream_; ///< null: maps are not coded
    std::map<std::pair<int, sea::TimeUs>, sea::KeyframePtr> keyframes_; ///< cascade, time
    std::map<std::pair<int, sea::TimeUs>, sea::SplineMapPtr> splines_;
    sea::TimeUs shown_us_ = 0;
    std::unique_ptr<sea::Surface> surface_;        ///< Seaway's own rules
    std::vector<sea::Surface> surface_of_cascade_; ///< likewise, of each alone
    std::vector<NaiveCascade> naive_;              ///< any other rules
    std::unique_ptr<sea::DirectSum> sum_;
    std::unique_ptr<sea::DirectSum::Moment> moment_;
};

} // namespace seaway::bench
