// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/effects.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <vector>

#include <fmt/format.h>

#include "server/device/device_choice.h"
#include "server/simulation/effect_costs.h"
#include "server/simulation/effect_plan.h"
#include "server/simulation/foam_maps.h"
#include "server/simulation/running_sea.h"
#include "tools/bench/timing.h"
#include "tools/plot/plot.h"

namespace seaway::bench {

using server::EffectInfo;
using server::KeyframeRequest;
using server::RunningSeaPtr;
using server::Synthesizer;

namespace {

/// One row of the table.
struct Row {
    std::string what; ///< "effect" or "cascade"
    std::string name;
    double alone_ms;
    double marginal_ms; ///< what leaving it out of everything saves
    int transforms;     ///< of one keyframe of every cascade, alone
};

class EffectsBench {
  public:
    EffectsBench(RunningSeaPtr sea, Synthesizer& device)
        : sea_(std::move(sea)), device_(device), foam_(*sea_),
          all_cascades_((1u << sea_->realization->cascades.size()) - 1u) {}

    std::vector<Row> measure(int rounds);
    double everything_ms() const { return everything_ms_; }

  private:
    /// Keyframes of these fields of these cascades, at a new time each call.
    void synthesize(std::uint32_t cascades, sea::FieldSet fields) {
        std::vector<KeyframeRequest> requests;
        time_us_ += 1'000'003;
        for (int c = 0; c < static_cast<int>(sea_->realization->cascades.size()); ++c)
            if ((cascades >> c) & 1u)
                requests.push_back({c, time_us_, server::with_foam_inputs(fields)});
        if (requests.empty() || fields.empty())
            return;
        const Result<std::vector<server::NewKeyframePtr>> made = device_.synthesize(requests);
        SEAWAY_CHECK(made.has_value(), made ? "" : made.error().message);
        if (fields.contains(sea::Field::foam))
            for (const server::NewKeyframePtr& keyframe : *made) {
                const auto same = [&](sea::TimeUs) { return Result<sea::KeyframePtr>(keyframe); };
                SEAWAY_CHECK(foam_.fill(keyframe, same).has_value(), "foam");
            }
    }

    Variant variant(std::uint32_t cascades, sea::FieldSet fields) {
        return {"", [this, cascades, fields] { synthesize(cascades, fields); }};
    }

    RunningSeaPtr sea_;
    Synthesizer& device_;
    server::FoamMaps foam_;
    std::uint32_t all_cascades_;
    sea::TimeUs time_us_ = 0;
    double everything_ms_ = 0;
};

std::vector<Row> EffectsBench::measure(int rounds) {
    const sea::FieldSet offered = sea_->offered;
    std::vector<Row> rows;
    std::vector<Variant> variants{variant(all_cascades_, offered)};
    for (const EffectInfo& effect : server::effect_table()) {
        const sea::FieldSet fields = server::fields_of(effect, offered);
        if (fields.empty())
            continue;
        rows.push_back({"effect", std::string(effect.name), 0, 0,
                        server::transforms_for(fields) *
                            static_cast<int>(sea_->realization->cascades.size())});
        variants.push_back(variant(all_cascades_, fields));
        variants.push_back(
            variant(all_cascades_, sea::FieldSet::from_bits(offered.bits() & ~fields.bits())));
    }
    for (std::size_t c = 0; c < sea_->realization->cascades.size(); ++c) {
        const sea::CascadeSpec& spec = sea_->realization->cascades[c].spec;
        rows.push_back({"cascade", fmt::format("{} m, {}", spec.length_m, spec.size), 0, 0,
                        server::transforms_for(offered)});
        variants.push_back(variant(1u << c, offered));
        variants.push_back(variant(all_cascades_ & ~(1u << c), offered));
    }
    interleave(variants, rounds);
    everything_ms_ = 1e3 * variants[0].median_s();
    for (std::size_t r = 0; r < rows.size(); ++r) {
        rows[r].alone_ms = 1e3 * variants[1 + 2 * r].median_s();
        rows[r].marginal_ms = everything_ms_ - 1e3 * variants[2 + 2 * r].median_s();
    }
    return rows;
}

void print_table(const std::string& device, double everything_ms, const std::vector<Row>& rows) {
    fmt::print("{}\none keyframe of every cascade with everything: {:.3f} ms\n\n", device,
               everything_ms);
    fmt::print("{:<8} {:<14} {:>10} {:>9} {:>12} {:>11}\n", "", "", "transforms", "alone ms",
               "marginal ms", "of all");
    for (const Row& row : rows)
        fmt::print("{:<8} {:<14} {:>10} {:>9.3f} {:>12.3f} {:>10.0f} %\n", row.what, row.name,
                   row.transforms, row.alone_ms, row.marginal_ms,
                   100 * row.alone_ms / everything_ms);
}

Result<void> write_csv(const std::string& path, const std::string& device, double everything_ms,
                       const std::vector<Row>& rows) {
    std::ofstream file(path);
    file << fmt::format("# {}, everything {:.4f} ms, medians of interleaved rounds\n", device,
                        everything_ms)
         << "what,name,transforms,alone_ms,marginal_ms\n";
    for (const Row& row : rows)
        file << fmt::format("{},\"{}\",{},{:.5f},{:.5f}\n", row.what, row.name, row.transforms,
                            row.alone_ms, row.marginal_ms);
    if (!file.flush())
        return Error{"cannot write " + path};
    return {};
}

Result<void> draw(const std::string& path, const std::string& device, double everything_ms,
                  const std::vector<Row>& rows) {
    plot::Canvas canvas(1100, 560);
    const double count = static_cast<double>(rows.size());
    double highest = everything_ms;
    for (const Row& row : rows)
        highest = std::max(highest, row.alone_ms);
    plot::Chart chart(canvas, {80, 60, 1070, 480},
                      {"", -0.5, count - 0.5, plot::Scale::linear, 100},
                      {"ms a keyframe of every cascade", 0.0, 1.15 * highest});
    chart.draw_grid();
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const auto x = static_cast<double>(i);
        chart.bar(x - 0.17, rows[i].alone_ms, 30, plot::series_color(0));
        chart.bar(x + 0.17, std::max(rows[i].marginal_ms, 0.0), 30, plot::series_color(1));
        chart.note({x, 0.0}, {0, 40}, rows[i].name, {.align = plot::Align::centre});
    }
    const plot::Point ends[] = {{-0.5, everything_ms}, {count - 0.5, everything_ms}};
    chart.curve(ends, {plot::series_color(2), 1.5}, "everything");
    chart.curve({}, {plot::series_color(0), 8}, "alone");
    chart.curve({}, {plot::series_color(1), 8}, "on top of the rest");
    chart.draw_frame();
    chart.draw_legend(plot::Corner::top_right);
    canvas.text({80, 34}, "What effects and cascades cost: " + device, {});
    return canvas.write_png(path);
}

} // namespace

Result<void> run_effects(const EffectsOptions& options) {
    const Result<sea::Scene> scene = sea::read_scene(options.scene);
    if (!scene)
        return scene.error();
    const Result<RunningSeaPtr> sea = server::make_running_sea(*scene, 1);
    if (!sea)
        return sea.error();
    SEAWAY_TRY_LET(const auto device, server::make_synthesizer(options.device));
    SEAWAY_TRY(device->set_sea((*sea)->realization, 1));
    EffectsBench bench(*sea, *device);
    const std::vector<Row> rows = bench.measure(options.rounds);
    const std::string name = device->description();
    print_table(name, bench.everything_ms(), rows);
    std::error_code failed;
    std::filesystem::create_directories(options.out, failed);
    SEAWAY_TRY(write_csv(options.out + "/effects.csv", name, bench.everything_ms(), rows));
    return draw(options.out + "/effects.png", name, bench.everything_ms(), rows);
}

} // namespace seaway::bench
