// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/effects.h"

#include <memory>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/quantile.h"
#include "server/device/device_choice.h"
#include "server/simulation/effect_costs.h"
#include "tools/bench/accuracy/journal.h"
#include "tools/bench/accuracy/result_file.h"
#include "tools/bench/streamed_demand.h"

namespace seaway::bench {

using server::EffectInfo;
using server::RunningSeaPtr;

namespace {

constexpr sea::TimeUs lap_us = 2'000'000;

/// One row of the table: for one second of sea.
struct EffectCost {
    std::string what;
    std::string name;
    std::string cascade;
    Spent alone;
    Spent marginal; ///< on top of the rest of its cascade, or of all
};

/// Demands that are measured in turns, and what each lap of each took.
class Laps {
  public:
    Laps(RunningSeaPtr sea, server::Synthesizer& device, server::FoamMaps foam)
        : sea_(std::move(sea)), device_(device), foam_(std::move(foam)) {}

    /// Its number.
    std::size_t add(std::vector<sea::FieldSet> fields) {
        demands_.push_back(
            std::make_unique<StreamedDemand>(sea_, device_, std::move(fields), foam_));
        return demands_.size() - 1;
    }
    /// One lap that does not count, then those that do.
    Result<void> run(int rounds) {
        laps_.assign(demands_.size(), {});
        for (int round = -1; round < rounds; ++round)
            for (std::size_t d = 0; d < demands_.size(); ++d) {
                SEAWAY_TRY_LET(const Spent spent, demands_[d]->run(lap_us));
                if (round >= 0)
                    laps_[d].push_back(spent);
            }
        return {};
    }
    /// Of one second: medians of times, means of what is counted.
    Spent a_second(std::size_t demand) const {
        const std::vector<Spent>& laps = laps_[demand];
        const auto median_of = [&](double Spent::*time) {
            std::vector<double> times;
            for (const Spent& lap : laps)
                times.push_back(lap.*time);
            return median(std::move(times));
        };
        Spent sum;
        for (const Spent& lap : laps)
            sum += lap;
        Spent one = sum / static_cast<double>(laps.size());
        one.maps_s = median_of(&Spent::maps_s);
        one.stream_s = median_of(&Spent::stream_s);
        return one / sea::seconds_from_us(lap_us);
    }

  private:
    RunningSeaPtr sea_;
    server::Synthesizer& device_;
    server::FoamMaps foam_;
    std::vector<std::unique_ptr<StreamedDemand>> demands_;
    std::vector<std::vector<Spent>> laps_;
};

std::string name_of_cascade(const server::RunningSea& sea, std::size_t c) {
    const sea::CascadeSpec& spec = sea.realization->cascades[c].spec;
    return fmt::format("{:g} m of {}", spec.length_m, spec.size);
}

/// Everything that there is, and each effect of each cascade alone and left out.
Result<std::vector<EffectCost>> measure_everything(const RunningSeaPtr& sea,
                                                   server::Synthesizer& device, int rounds) {
    SEAWAY_TRY(device.set_sea(sea->realization, 1));
    SEAWAY_TRY_LET(server::FoamMaps foam, foam_at_start(sea, device));
    Laps laps(sea, device, std::move(foam));
    const std::size_t cascades = sea->realization->cascades.size();
    const auto only = [&](std::size_t c, sea::FieldSet fields) {
        std::vector<sea::FieldSet> all(cascades);
        all[c] = fields;
        return laps.add(all);
    };
    const std::size_t everything = laps.add(std::vector(cascades, sea->offered));
    std::vector<std::size_t> whole;
    for (std::size_t c = 0; c < cascades; ++c) {
        whole.push_back(only(c, sea->offered));
        for (const EffectInfo& effect : server::effect_table()) {
            const sea::FieldSet fields = server::fields_of(effect, sea->offered);
            only(c, fields);
            only(c, sea->offered.without(fields));
        }
    }
    SEAWAY_TRY(laps.run(rounds));
    std::vector<EffectCost> rows{{"everything", "", "", laps.a_second(everything), {}}};
    rows[0].marginal = rows[0].alone;
    for (std::size_t c = 0; c < cascades; ++c) {
        const std::string cascade = name_of_cascade(*sea, c);
        const Spent all = laps.a_second(whole[c]);
        rows.push_back({"cascade", "", cascade, all, all});
        std::size_t next = whole[c];
        for (const EffectInfo& effect : server::effect_table()) {
            const Spent alone = laps.a_second(++next), rest = laps.a_second(++next);
            rows.push_back({"effect", std::string(effect.name), cascade, alone, all - rest});
        }
    }
    return rows;
}

Result<EffectCost> measure_asked(const RunningSeaPtr& sea, server::Synthesizer& device,
                                 const EffectsOptions& options) {
    SEAWAY_TRY_LET(const sea::FieldSet fields, fields_asked(options.ask, sea->offered));
    SEAWAY_TRY(device.set_sea(sea->realization, 1));
    SEAWAY_TRY_LET(server::FoamMaps foam, foam_at_start(sea, device));
    Laps laps(sea, device, std::move(foam));
    laps.add(std::vector(sea->realization->cascades.size(), fields));
    SEAWAY_TRY(laps.run(options.rounds));
    std::vector<std::string_view> names;
    for (const EffectInfo& effect : server::effect_table())
        if (!server::fields_of(effect, fields).empty())
            names.push_back(effect.name);
    const Spent spent = laps.a_second(0);
    return EffectCost{"asked", fmt::format("{}", fmt::join(names, " ")), "", spent, spent};
}

std::string csv_row(const EffectCost& row) {
    std::string text = fmt::format("{},{},{}", row.what, row.name, row.cascade);
    for (const Spent& s : {row.alone, row.marginal})
        text += fmt::format(",{:.4g},{:.4g},{:.4g},{:.4g},{:.4g}", s.keyframes, s.transforms,
                            1e3 * s.maps_s, 1e3 * s.stream_s, 1e-3 * s.bytes);
    return text + "\n";
}

Result<void> write_csv(const std::string& path, const EffectsOptions& options,
                       const std::string& device, const std::vector<EffectCost>& rows) {
    std::string text = fmt::format("# seaway-bench effects --scene {} on {}; {}; commit {}\n"
                                   "# of one second of sea: alone, and on top of the rest\n"
                                   "what,effect,cascade",
                                   options.scene, device, machine_name(), commit_name());
    for (const char* prefix : {"", "more_"})
        text +=
            fmt::format(",{0}keyframes,{0}transforms,{0}maps_ms,{0}stream_ms,{0}kilobytes", prefix);
    text += "\n";
    for (const EffectCost& row : rows)
        text += csv_row(row);
    return write_result(path, text);
}

void print_table(const std::string& device, const std::vector<EffectCost>& rows) {
    fmt::print("{}\nfor one second of sea, CPU time; on top of the rest:\n\n{:<10} {:<10} {:<14} "
               "{:>11} {:>9} {:>10} {:>10}\n",
               device, "", "", "", "transforms", "maps ms", "stream ms", "kB");
    for (const EffectCost& row : rows)
        fmt::print("{:<10} {:<10} {:<14} {:>11.1f} {:>9.3f} {:>10.3f} {:>10.1f}\n", row.what,
                   row.what == "asked" ? "" : row.name, row.cascade, row.marginal.transforms,
                   1e3 * row.marginal.maps_s, 1e3 * row.marginal.stream_s,
                   1e-3 * row.marginal.bytes);
}

} // namespace

Result<sea::FieldSet> fields_asked(const std::vector<std::string>& names, sea::FieldSet offered) {
    sea::FieldSet fields;
    for (const std::string& name : names) {
        const auto table = server::effect_table();
        const auto found = std::find_if(table.begin(), table.end(),
                                        [&](const EffectInfo& e) { return e.name == name; });
        if (found == table.end()) {
            std::vector<std::string_view> known;
            for (const EffectInfo& effect : table)
                known.push_back(effect.name);
            return Error{fmt::format("--ask: no effect is called \"{}\"; there are {}", name,
                                     fmt::join(known, ", "))};
        }
        const sea::FieldSet of_this = server::fields_of(*found, offered);
        if (of_this.empty())
            return Error{fmt::format("--ask: the scene does not allow \"{}\"", name)};
        fields |= of_this;
    }
    return names.empty() ? offered : fields;
}

Result<void> run_effects(const EffectsOptions& options) {
    SEAWAY_TRY_LET(const sea::Scene scene, sea::read_scene(options.scene));
    SEAWAY_TRY_LET(const RunningSeaPtr as_written, server::make_running_sea(scene, 1));
    SEAWAY_TRY(fields_asked(options.ask, as_written->offered)); // before anything takes time
    const std::string path = options.out + "/effects.csv";
    SEAWAY_TRY(check_result(path));
    sea::Scene all_effects = scene;
    all_effects.effects = {.choppy = true, .slopes = true, .foam = true};
    SEAWAY_TRY_LET(const RunningSeaPtr whole, server::make_running_sea(all_effects, 1));
    SEAWAY_TRY_LET(const auto device, server::make_synthesizer(options.device));
    SEAWAY_TRY_LET(std::vector<EffectCost> rows,
                   measure_everything(whole, *device, options.rounds));
    SEAWAY_TRY_LET(const EffectCost asked, measure_asked(as_written, *device, options));
    rows.push_back(asked);
    std::rotate(rows.begin() + 1, rows.end() - 1, rows.end());
    print_table(device->description(), rows);
    return write_csv(path, options, device->description(), rows);
}

} // namespace seaway::bench
