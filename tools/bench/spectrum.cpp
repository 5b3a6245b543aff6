// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/spectrum.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>

#include <fmt/format.h>

#include "base/elapsed.h"
#include "base/worse.h"
#include "client/rebuilt/received_spectrum.h"
#include "protocol/spectrum_codec.h"
#include "sea/native/native_runner.h"
#include "server/publish/spectrum_store.h"
#include "server/simulation/running_sea.h"

namespace seaway::bench {

namespace {

constexpr double day_s = 86'400;

/// What a client has to know of the sea beside its waves.
client::SeaStatePtr state_of(const server::RunningSea& sea) {
    auto state = std::make_shared<client::SeaState>();
    for (const sea::CascadeModes& modes : sea.realization->cascades)
        state->cascades.push_back({.length_m = modes.spec.length_m,
                                   .size = modes.spec.size,
                                   .k_lo_radpm = modes.band.k_lo_radpm,
                                   .k_hi_radpm = modes.band.k_hi_radpm,
                                   .interval_us = 1});
    state->choppiness_x = sea.realization->choppiness.x;
    state->choppiness_y = sea.realization->choppiness.y;
    state->displacement_reach_m = sea.budget.displacement_reach_m;
    state->rms_strain = sea.budget.rms_strain;
    return state;
}

/// Takes the messages as a client does; prints how much is missed as they come.
Result<client::RebuiltSeaPtr> received(const server::RunningSea& sea,
                                       const server::EncodedSpectrum& encoded) {
    protocol::MessageReader reader(protocol::Sender::server);
    SEAWAY_TRY_LET(const wire::Message* first, reader.read(*encoded.messages[0]));
    client::ReceivedSpectrum spectrum(state_of(sea), protocol::head(*first->body_as_Spectrum()));
    std::size_t bytes = encoded.messages[0]->size();
    for (std::size_t n = 1; n < encoded.messages.size(); ++n) {
        SEAWAY_TRY_LET(const wire::Message* message, reader.read(*encoded.messages[n]));
        const wire::SpectrumChunk& chunk = *message->body_as_SpectrumChunk();
        SEAWAY_TRY_LET(
            const std::vector<sea::WaveBlock> blocks,
            protocol::decode_spectrum({chunk.payload()->data(), chunk.payload()->size()}));
        const sea::SpectrumLeft left = protocol::left(chunk);
        SEAWAY_TRY(spectrum.add(left, blocks));
        bytes += encoded.messages[n]->size();
        fmt::print("  {:>9} {:>10.4f} {:>10.4f} {:>10.5f}\n", bytes, left.height_m,
                   left.displacement_m, left.slope);
    }
    return spectrum.sea();
}

struct Worst {
    double answer_m = 0;        ///< above world points
    double share_of_stated = 0; ///< of error_m, there
    double height_m = 0;        ///< undisplaced
    double slope = 0;
    double map_height_m = 0; ///< the largest of each cascade's map, added up
    double map_slope = 0;
};

/// Of the undisplaced sea and of answers.
void compare_points(const server::RunningSea& sea, const client::RebuiltSea& own,
                    sea::TimeUs time_us, std::span<const sea::QueryPoint> points, Worst& worst) {
    const sea::DirectSum::Moment then = sea.truth->at_time(time_us),
                                 mine = own.sum().at_time(time_us);
    std::vector<sea::Answer> answers(points.size());
    own.answer(points, answers, {});
    for (std::size_t i = 0; i < points.size(); ++i) {
        const sea::LagrangianPoint a = then.at(points[i].x_m, points[i].y_m);
        const sea::LagrangianPoint b = mine.at(points[i].x_m, points[i].y_m);
        worst.height_m = worse(worst.height_m, std::abs(a.height - b.height));
        worst.slope = std::max(
            {worst.slope, std::abs(a.slope_x - b.slope_x), std::abs(a.slope_y - b.slope_y)});
        const sea::Answer exact = sea::surface_at(
            points[i], {sea.realization->choppiness, 1e-9, sea::fold_search(sea.budget)}, then);
        if ((exact.flags | answers[i].flags) & sea::answer_folded)
            continue;
        const double off_m = std::abs(exact.height_m - answers[i].height_m);
        worst.answer_m = worse(worst.answer_m, off_m);
        worst.share_of_stated = std::max(worst.share_of_stated, off_m / answers[i].error_m);
    }
}

/// Whole maps of the difference.
class DifferenceMaps {
  public:
    static Result<DifferenceMaps> create(const sea::Realization& sea, const sea::Realization& own) {
        DifferenceMaps maps;
        for (std::size_t c = 0; c < sea.cascades.size(); ++c) {
            sea::CascadeModes modes = sea.cascades[c];
            for (std::size_t i = 0; i < modes.h0.size(); ++i)
                modes.h0[i] -= own.cascades[c].h0[i];
            SEAWAY_TRY_LET(sea::NativeTransform transform,
                           sea::NativeTransform::create(modes, sea.choppiness));
            maps.transforms_.push_back(std::move(transform));
            maps.planes_.emplace_back(3 * modes.h0.size());
        }
        return maps;
    }

    void compare(const sea::Realization& sea, sea::NativeRunner& runner, sea::TimeUs time_us,
                 Worst& worst) {
        const sea::FieldSet fields{sea::Field::height, sea::Field::slope_x, sea::Field::slope_y};
        std::vector<sea::NativeTask> tasks;
        for (std::size_t c = 0; c < transforms_.size(); ++c)
            tasks.push_back({&transforms_[c], sea.phase_time(time_us), fields, planes_[c]});
        runner.run(tasks);
        double height_m = 0, slope = 0;
        for (const std::vector<float>& planes : planes_) {
            const auto points = static_cast<std::ptrdiff_t>(planes.size() / 3);
            const auto largest = [](auto begin, auto end) {
                const auto [low, high] = std::minmax_element(begin, end);
                return static_cast<double>(std::max(-*low, *high));
            };
            height_m += largest(planes.begin(), planes.begin() + points);
            slope += std::max(largest(planes.begin() + points, planes.begin() + 2 * points),
                              largest(planes.begin() + 2 * points, planes.end()));
        }
        worst.map_height_m = std::max(worst.map_height_m, height_m);
        worst.map_slope = std::max(worst.map_slope, slope);
    }

  private:
    std::vector<sea::NativeTransform> transforms_;
    std::vector<std::vector<float>> planes_;
};

Result<Worst> measure(const server::RunningSea& sea, const client::RebuiltSea& own,
                      const SpectrumOptions& options) {
    SEAWAY_TRY_LET(DifferenceMaps maps, DifferenceMaps::create(*sea.realization, own.sum().sea()));
    sea::NativeRunner runner;
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> place(-1e4, 1e4);
    std::uniform_real_distribution<double> time_s(0, day_s);
    Worst worst;
    for (int t = 0; t < options.times; ++t) {
        const sea::TimeUs time_us = sea::us_from_seconds(time_s(random));
        std::vector<sea::QueryPoint> points;
        for (int p = 0; p < options.places; ++p)
            points.push_back({place(random), place(random), time_us});
        compare_points(sea, own, time_us, points, worst);
        maps.compare(*sea.realization, runner, time_us, worst);
    }
    return worst;
}

} // namespace

Result<void> run_spectrum(const SpectrumOptions& options) {
    SEAWAY_TRY_LET(const sea::Scene scene, sea::read_scene(options.scene));
    SEAWAY_TRY_LET(const server::RunningSeaPtr sea, server::make_running_sea(scene, 1));
    server::SpectrumStore store;
    const auto start = std::chrono::steady_clock::now();
    SEAWAY_TRY_LET(const server::GrantedSpectrum grant,
                   store.grant({sea->epoch, sea->realization, scene.sea.dispersion(),
                                sea->budget.height_error_m},
                               {static_cast<float>(options.error_m),
                                static_cast<float>(options.slope_error), sea::surface_fields}));
    const double made_s = seconds_since(start);
    const server::EncodedSpectrum& encoded = *grant.spectra.front();
    fmt::print(
        "asked {:g} m and {:g}, granted {:g} m and {:.4g}{}{}\n  {:>9} {:>10} {:>10} {:>10}\n",
        options.error_m, options.slope_error, grant.error_m, grant.slope_error,
        grant.why.empty() ? "" : ": ", grant.why, "bytes", "left, m", "sideways", "slope");
    SEAWAY_TRY_LET(const client::RebuiltSeaPtr own, received(*sea, encoded));
    fmt::print("  {} bytes in {} messages, made in {:.3f} s\n", encoded.bytes,
               encoded.messages.size(), made_s);
    SEAWAY_TRY_LET(const Worst worst, measure(*sea, *own, options));
    fmt::print("largest errors at {} times of 24 h, {} places each\n"
               "  answer {:.5f} m ({:.2f} of its bound), height {:.5f} m, slope {:.5f}\n"
               "  whole maps, cascades added up: height {:.5f} m, slope {:.5f}\n",
               options.times, options.places, worst.answer_m, worst.share_of_stated, worst.height_m,
               worst.slope, worst.map_height_m, worst.map_slope);
    return {};
}

} // namespace seaway::bench
