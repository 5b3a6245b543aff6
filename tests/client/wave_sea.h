// SPDX-License-Identifier: Apache-2.0
// A sea of a few known waves in two cascades behind a Host: keyframes and answers come from the
// direct sum, so that what a client makes of them can be held against the truth.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <numbers>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "protocol/messages.h"
#include "protocol/spectrum_codec.h"
#include "sea/surface/below.h"
#include "sea/waves/probes.h"
#include "sea/waves/quantised_spectrum.h"
#include "sea/waves/reference.h"
#include "server/host/host.h"
#include "tests/support/eventually.h"

namespace seaway::tests {

/// Keyframes lie at whole multiples of these.
inline constexpr sea::TimeUs wave_intervals_us[] = {200'000, 100'000};
inline constexpr int wave_map_size = 32;
/// Codec bounds of heights and displacements, m, and of their rates, m/s.
inline constexpr float wave_codec_m = 0.0005f;
inline constexpr float wave_codec_mps = 0.005f;

struct KnownWave {
    std::size_t cascade;
    int nx, ny;
    double amplitude_m, phase_rad;
};

/// Of two cascades. None of the waves is near `shortest_of_both_m`, where one ends and the other begins.
inline sea::RealizationPtr known_waves(const std::array<double, 2>& lengths_m,
                                       double shortest_of_both_m,
                                       std::initializer_list<KnownWave> waves) {
    auto sea = std::make_shared<sea::Realization>();
    for (const double length_m : lengths_m) {
        sea::CascadeModes modes;
        modes.spec = {length_m, wave_map_size};
        modes.band = {sea->cascades.empty() ? 0 : 2 * std::numbers::pi / shortest_of_both_m,
                      modes.spec.nyquist_radpm()};
        modes.h0.resize(wave_map_size * wave_map_size);
        modes.rate.resize(modes.h0.size());
        sea->cascades.push_back(std::move(modes));
    }
    for (const KnownWave& wave : waves) {
        sea::CascadeModes& modes = sea->cascades[wave.cascade];
        const double step = modes.spec.wavenumber_step_radpm();
        const double k_radpm = step * std::hypot(wave.nx, wave.ny);
        const auto at = [&](int nx, int ny) {
            const int ix = (nx + wave_map_size) % wave_map_size;
            const int iy = (ny + wave_map_size) % wave_map_size;
            return static_cast<std::size_t>(iy * wave_map_size + ix);
        };
        modes.h0[at(wave.nx, wave.ny)] = std::polar(0.5 * wave.amplitude_m, wave.phase_rad);
        const sea::Rate rate = sea::rate_from_omega(std::sqrt(9.81 * k_radpm));
        modes.rate[at(wave.nx, wave.ny)] = rate;
        modes.rate[at(-wave.nx, -wave.ny)] = rate;
    }
    return sea;
}

inline sea::RealizationPtr few_waves() {
    return known_waves(
        {160.0, 29.0}, 20.0,
        {{0, 2, 1, 0.8, 0.3}, {0, 3, -1, 0.3, 2.0}, {1, 2, 3, 0.04, 1.0}, {1, -1, 3, 0.03, 4.0}});
}

class WaveSea : public server::Host {
  public:
    explicit WaveSea(sea::RealizationPtr waves = few_waves()) : sea_(std::move(waves)) {}

    /// Fields that it can give; whoever asks for others gets the rest.
    std::atomic<sea::FieldSet> offered = sea::surface_fields | sea::FieldSet{sea::Field::slope_x};
    std::atomic<bool> answer_queries = true;
    std::atomic<bool> knows_below =
        true; ///< else depths are passed over, as by a server that is older
    std::atomic<bool> knows_choice = true; ///< of waves; else it is passed over, likewise
    std::atomic<int> fetches = 0;
    std::atomic<int> queries = 0;
    std::atomic<int> exact_queries = 0;             ///< of them
    mutable std::atomic<float> wished_error_m = -1; ///< of the last who subscribed
    std::atomic<int> late_ms =
        0; ///< it looks at its clock, and answers, this much later than asked

    sea::Answer truth(const sea::QueryPoint& point) const {
        sea::WaterBelow unused;
        sea::Answer answer = truth(point, sea::all_cascades, 0, unused);
        answer.flags &= ~std::uint32_t{sea::answer_dry};
        return answer;
    }
    sea::Answer truth(const sea::QueryPoint& point, std::uint32_t cascades, double z_m,
                      sea::WaterBelow& water) const {
        const sea::DirectSum::Moment moment = sum_.at_time(point.time_us, cascades);
        const sea::InverseOptions options{sea_->choppiness, 1e-9, 5.0};
        sea::Answer answer = sea::water_at(point, z_m, options, moment, water);
        answer.error_m += 1e-9;
        return answer;
    }

    server::KeyframeTiles keyframe(int cascade, std::int64_t n, sea::FieldSet fields) const {
        auto made = std::make_shared<sea::Keyframe>();
        const auto c = static_cast<std::size_t>(cascade);
        made->epoch = epoch;
        made->cascade = cascade;
        made->time_us = n * wave_intervals_us[c];
        made->size = wave_map_size;
        made->length_m = sea_->cascades[c].spec.length_m;
        made->fields = fields;
        made->values.resize(made->plane_size() * static_cast<std::size_t>(fields.size()));
        const sea::DirectSum::Moment moment = single_[c].at_time(made->time_us);
        const double spacing_m = sea_->cascades[c].spec.spacing_m();
        for (int y = 0; y < wave_map_size; ++y)
            for (int x = 0; x < wave_map_size; ++x) {
                const sea::LagrangianPoint point = moment.at(x * spacing_m, y * spacing_m);
                for (const sea::Field field : fields)
                    made->plane(field)[static_cast<std::size_t>(y * wave_map_size + x)] =
                        static_cast<float>(sea::value_of(point, field));
            }
        server::KeyframeTiles tiles{made, {}, 0};
        for (const sea::Field field : fields)
            tiles.codec_error.push_back(sea::info(field).time_rate ? wave_codec_mps : wave_codec_m);
        return tiles;
    }

    // ---- Host ------------------------------------------------------------------------------

    sea::TimeUs sea_time_us() const override {
        std::this_thread::sleep_for(std::chrono::milliseconds(late_ms));
        return start_us_ + std::chrono::duration_cast<std::chrono::microseconds>(
                               std::chrono::steady_clock::now() - started_)
                               .count();
    }
    sea::SeaTime sea_time() const override {
        sea::SeaTime time = sea_time_us();
        time.unsure_us = unsure_us;
        return time;
    }
    std::vector<server::SharedBytes> sea_state_messages() const override {
        protocol::SeaStateValues state;
        state.epoch = told_epoch;
        for (std::size_t c = 0; c < sea_->cascades.size(); ++c)
            state.cascades.push_back({.length_m = sea_->cascades[c].spec.length_m,
                                      .size = wave_map_size,
                                      .k_lo_radpm = sea_->cascades[c].band.k_lo_radpm,
                                      .k_hi_radpm = sea_->cascades[c].band.k_hi_radpm,
                                      .interval_us = wave_intervals_us[c]});
        state.height_error_m = 0.01;
        state.start_time_us = told_from_us;
        state.requested = {2.5, 9.5, 7.75, 8.25, 260, 31, 0.02};
        state.realised = {2.42, 9.25, 7.5, 8, 247, 29, 0.019};
        // Waves of at most 3 lattice steps on 32 points miss 2 (3/32)^4 of 1.2 m in space, and
        // less in time: 0.2 mm; doubled for the displacement's share.
        state.interpolation_error_m = 0.0004;
        state.interpolation_displacement_m = 0.0004;
        state.interpolation_strain = 0.0004;
        state.displacement_reach_m = 1.5 * state.realised.hs_m;
        state.probes = sea::make_probes(sum_, state.start_time_us);
        state.probe_error_m = sea::probe_error_m;
        if (state_change)
            state_change(state);
        std::vector<server::SharedBytes> messages;
        if (told_pace)
            messages.push_back(std::make_shared<const protocol::Bytes>(protocol::pace(*told_pace)));
        messages.push_back(std::make_shared<const protocol::Bytes>(protocol::sea_state(state)));
        return messages;
    }
    server::Demand grant(const server::Demand& wish,
                         std::optional<server::SessionId> = {}) const override {
        wished_error_m = wish.error_m;
        server::Demand grant = wish;
        grant.cascades &= 3u;
        grant.fields = given(wish.fields);
        grant.error_m = 0.01f;
        return grant;
    }
    void fetch(server::FetchRequest request, Fetched done) override {
        ++fetches;
        std::this_thread::sleep_for(std::chrono::milliseconds(late_ms));
        if (request.times_us.empty())
            request.times_us = {sea_time_us(), sea_time_us() + wave_intervals_us[0]};
        std::vector<server::KeyframeTiles> out;
        for (int cascade = 0; cascade < 2; ++cascade) {
            if (!request.demand.wants(cascade))
                continue;
            const sea::TimeUs interval_us = wave_intervals_us[cascade];
            std::set<std::int64_t> wanted;
            for (const sea::TimeUs time_us : request.times_us) {
                const sea::TimeUs rest_us = ((time_us % interval_us) + interval_us) % interval_us;
                wanted.insert((time_us - rest_us) / interval_us);
                wanted.insert((time_us - rest_us) / interval_us + 1);
            }
            for (const std::int64_t n : wanted)
                out.push_back(keyframe(cascade, n, given(request.demand.fields)));
        }
        done(server::FetchedPart{std::move(out)});
    }
    void query(server::QueryBatch batch, Queried done) override {
        ++queries;
        std::this_thread::sleep_for(std::chrono::milliseconds(late_ms));
        exact_queries += batch.exact;
        server::QueryAnswers out;
        out.epoch = epoch;
        std::uint32_t felt = 0;
        for (std::size_t c = 0; c < sea_->cascades.size(); ++c)
            if (!knows_choice || batch.looking.feels(c, sea_->cascades[c].band.k_lo_radpm))
                felt |= 1u << c;
        if (knows_choice && batch.looking != sea::Looking{})
            out.cascades = felt;
        if (knows_below)
            out.below.resize(batch.z_m.size());
        for (std::size_t i = 0; i < batch.points.size(); ++i) {
            sea::WaterBelow unused;
            const double z_m = batch.z_m.empty() ? 0 : batch.z_m[i];
            out.answers.push_back(
                truth(batch.points[i], felt, z_m, out.below.empty() ? unused : out.below[i]));
            if (out.below.empty())
                out.answers.back().flags &= ~std::uint32_t{sea::answer_dry};
            out.answers.back().flags |= batch.exact ? sea::answer_exact : 0u;
        }
        if (answer_queries)
            done(std::move(out));
    }
    /// Its waves in chunks of one block; `spectrum_change` may spoil them.
    Result<server::GrantedSpectrum> spectrum(const server::SpectrumRequest& request) override {
        const sea::QuantisedSpectrum waves = sea::quantise(*sea_, {0.001});
        auto made = std::make_shared<server::EncodedSpectrum>();
        made->epoch = epoch;
        const auto add = [&](protocol::Bytes bytes) {
            made->messages.push_back(std::make_shared<const protocol::Bytes>(std::move(bytes)));
        };
        add(protocol::spectrum({.epoch = epoch,
                                .chunks = static_cast<std::uint32_t>(waves.blocks.size()),
                                .steps = waves.steps,
                                .dispersion = {9.81, 0.0, sea::deep_water_m}}));
        for (std::uint32_t n = 0; n < waves.blocks.size(); ++n) {
            sea::WaveBlock block = waves.blocks[n];
            if (spectrum_change)
                spectrum_change(block);
            add(protocol::spectrum_chunk(epoch, n, waves.left[n],
                                         protocol::encode_spectrum({&block, 1})));
        }
        return server::GrantedSpectrum{0.001f, 1.0f, request.wish.fields, "", {made}};
    }
    std::function<void(sea::WaveBlock&)> spectrum_change = {};
    /// Of what is told of the sea; set before anybody connects.
    std::function<void(protocol::SeaStateValues&)> state_change = {};
    std::atomic<std::uint32_t> told_epoch = epoch; ///< of the sea that runs
    sea::TimeUs told_from_us = -sea::time_us_max;  ///< the start of that, before anybody connects
    std::atomic<sea::TimeUs> unsure_us = 0;        ///< for how long it has doubted it
    std::optional<sea::Pace> told_pace = {};       ///< that holds; set while nobody connects

    std::string state_json() const override { return "{}"; }
    std::string plan_json() const override { return "{}"; }
    std::string metrics_text() const override { return ""; }
    server::Health health() const override { return {}; }

    static constexpr std::uint32_t epoch = 3;

  private:
    sea::FieldSet given(sea::FieldSet wanted) const { return wanted & offered.load(); }
    static sea::RealizationPtr only(const sea::Realization& sea, std::size_t cascade) {
        auto one = std::make_shared<sea::Realization>(sea);
        one->cascades = {sea.cascades[cascade]};
        return one;
    }

    const sea::RealizationPtr sea_;
    const sea::DirectSum sum_{sea_};
    const std::vector<sea::DirectSum> single_{sea::DirectSum(only(*sea_, 0)),
                                              sea::DirectSum(only(*sea_, 1))};
    const sea::TimeUs start_us_ = 1'000'000'000;
    const std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
};

} // namespace seaway::tests
