// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "sea/scene/scene.h"
#include "sea/scene/scene_names.h"

namespace seaway::sea {

namespace {

/// Lines "key = value"; doubles in the shortest form that reads back the same.
class Writer {
  public:
    void line(std::string_view text) { out_ += fmt::format("{}\n", text); }
    template <class T>
    void value(std::string_view key, const T& v) {
        out_ += fmt::format("{} = {}\n", key, v);
    }
    void text(std::string_view key, std::string_view v) {
        out_ += fmt::format("{} = \"{}\"\n", key, v);
    }
    /// A table of numbers: no quotes and no backslashes in it, as its reader sees to.
    void block(std::string_view key, std::string_view v) {
        out_ += fmt::format("{} = '''\n{}'''\n", key, v);
    }
    std::string take() { return std::move(out_); }

  private:
    std::string out_;
};

void write(Writer& out, const SpreadingModel& model) {
    out.text("spreading", name_of(model.kind));
    if (has_exponent(model.kind))
        out.value("spreading_exponent", model.exponent);
    if (is_blend(model.kind))
        out.value("narrow_share", model.narrow_share);
    out.value("swell", model.swell);
    out.value("isotropic", model.isotropic);
}

void write(Writer& out, const WindSea& sea) {
    out.text("spectrum", name_of(sea.spectrum));
    if (sea.wind_speed_19m5_mps)
        out.value("wind_speed_19m5_mps", *sea.wind_speed_19m5_mps);
    else
        out.value("wind_speed_10m_mps", sea.wind_speed_10m_mps);
    out.value("from_deg", bearing_from_towards(sea.towards_rad));
    if (sea.spectrum == SpectrumKind::jonswap || sea.spectrum == SpectrumKind::tma) {
        out.value("fetch_m", sea.fetch_m);
        out.value("gamma", sea.gamma);
    }
    if (sea.spectrum == SpectrumKind::phillips) {
        if (sea.significant_height_m)
            out.value("significant_height_m", *sea.significant_height_m);
        else
            out.value("phillips_constant", sea.phillips_constant);
        out.value("phillips_upwind", sea.phillips_upwind);
    }
    write(out, sea.spreading);
}

void write(Writer& out, const Swell& swell) {
    out.text("spectrum", name_of(swell.spectrum));
    out.value("significant_height_m", swell.significant_height_m);
    out.value("peak_period_s", swell.peak_period_s);
    out.value("from_deg", bearing_from_towards(swell.towards_rad));
    if (swell.spectrum != SpectrumKind::bretschneider)
        out.value("gamma", swell.gamma);
    write(out, swell.spreading);
}

void write(Writer& out, const MeasuredSea& sea) {
    out.block("data", sea.csv);
    if (sea.coefficients)
        out.text("coefficients", name_of(*sea.coefficients));
    if (sea.spectrum && !sea.spectrum->has_directions()) {
        out.value("from_deg", bearing_from_towards(sea.towards_rad));
        write(out, sea.spreading);
    }
}

void write(Writer& out, const ExplicitModes& system) {
    out.value("length_m", system.length_m);
    std::string csv = "nx,ny,amplitude_m,phase_rad\n";
    for (const ExplicitMode& mode : system.modes)
        csv += fmt::format("{},{},{},{}\n", mode.nx, mode.ny, mode.amplitude_m, mode.phase_rad);
    out.block("data", csv);
}

std::string list_of(const std::vector<SineByHand>& waves) {
    const bool speeds = waves.front().speed_mps > 0.0;
    std::string csv = "wavelength_m,amplitude_m,from_deg,phase_rad";
    csv += speeds ? ",speed_mps\n" : "\n";
    for (const SineByHand& wave : waves) {
        csv += fmt::format("{},{},{},{}", wave.wavelength_m, wave.amplitude_m,
                           bearing_from_towards(wave.towards_rad), wave.phase_rad);
        csv += speeds ? fmt::format(",{}\n", wave.speed_mps) : std::string("\n");
    }
    return csv;
}

void write(Writer& out, const SineRamps& ramps) {
    out.text("shape", name_of(ramps.kind));
    out.value("length_m", ramps.length_m);
    if (ramps.kind == SineKind::exponential) {
        out.value("sharpness", ramps.sharpness);
        out.value("drag", ramps.drag);
    }
    if (!ramps.by_hand.empty()) {
        out.block("data", list_of(ramps.by_hand));
        return;
    }
    out.value("count", ramps.count);
    out.value("amplitude_m", ramps.amplitude_m);
    out.value("wavelength_m", ramps.wavelength_m);
    out.value("amplitude_ratio", ramps.amplitude_ratio);
    out.value("wavenumber_ratio", ramps.wavenumber_ratio);
    out.value("from_deg", bearing_from_towards(ramps.towards_rad));
    out.value("direction_step_deg", degrees_of(ramps.direction_step_rad));
    out.value("direction_spread_deg", degrees_of(ramps.direction_spread_rad));
    out.value("normalise", ramps.normalise);
    if (ramps.kind != SineKind::gerstner)
        out.value("speed_ratio", ramps.speed_ratio);
}

void write(Writer& out, const SeaState& sea) {
    out.line("[sea]");
    out.value("seed", sea.seed);
    out.value("depth_m", sea.depth_m);
    out.value("choppiness", fmt::format("[{}, {}]", sea.choppiness.x, sea.choppiness.y));
    out.value("gravity_mps2", sea.gravity_mps2);
    out.value("surface_tension", sea.surface_tension);
    out.value("loop_period_s", sea.loop_period_s);
    out.value("height_scale", sea.height_scale);
    out.value("short_wave_fade_m", sea.short_wave_fade_m);
    out.value("wavenumber_min_radpm", sea.wavenumber_min_radpm);
    out.value("wavenumber_max_radpm", sea.wavenumber_max_radpm);
    for (const WaveSystem& system : sea.systems) {
        out.line("\n[[sea.system]]");
        out.text("type", system_names[system.index()]);
        std::visit([&out](const auto& s) { write(out, s); }, system);
    }
}

} // namespace

namespace {

/// The degrees near `guess` that `back` turns into exactly this angle: conversion there and back
/// may be off by a few last bits. Short decimals first.
template <class F>
double exact_degrees(double guess, double angle_rad, const F& back) {
    const double rounded = std::round(guess * 1e9) / 1e9;
    if (back(rounded) == angle_rad)
        return rounded;
    double up = guess;
    double down = guess;
    for (int step = 0; step < 64; ++step) {
        if (back(up) == angle_rad)
            return up;
        if (back(down) == angle_rad)
            return down;
        up = std::nextafter(up, 1e9);
        down = std::nextafter(down, -1e9);
    }
    return guess;
}

} // namespace

double bearing_from_towards(double towards_rad) {
    double bearing = 270.0 - towards_rad * (180.0 / pi);
    bearing -= 360.0 * std::floor(bearing / 360.0);
    return exact_degrees(bearing, towards_rad, towards_from_bearing);
}

double mean_from_deg(const SeaStatistics& sea) {
    return sea.significant_height_m > 0.0 ? bearing_from_towards(sea.mean_towards_rad) : 0.0;
}

double degrees_of(double angle_rad) {
    return exact_degrees(angle_rad * (180.0 / pi), angle_rad,
                         [](double degrees) { return degrees * (pi / 180.0); });
}

std::string to_toml(const Scene& scene) {
    Writer out;
    write(out, scene.sea);
    for (const CascadeSpec& cascade : scene.cascades) {
        out.line("\n[[cascade]]");
        out.value("length_m", cascade.length_m);
        out.value("size", cascade.size);
    }
    out.line("\n[effects]");
    out.text("displacement", scene.effects.choppy ? "choppy" : "height");
    out.value("slopes", scene.effects.slopes);
    out.value("foam", scene.effects.foam);
    out.line("\n[foam]");
    if (scene.foam.threshold)
        out.value("threshold", *scene.foam.threshold);
    else
        out.text("coverage", "observed");
    out.value("decay_s", scene.foam.decay_s);
    out.value("gain_per_s", scene.foam.gain_per_s);
    out.value("bias", scene.foam.bias);
    if (scene.water != Water{}) { // not known to clients before there was one
        out.line("\n[water]");
        out.text("type", name_of(scene.water.type));
        const auto& [red, green, blue] = scene.water.bottom_albedo;
        out.value("bottom_albedo", fmt::format("[{}, {}, {}]", red, green, blue));
    }
    out.line("\n[accuracy]");
    if (scene.accuracy.preset)
        out.text("preset", name_of(*scene.accuracy.preset));
    out.value("height_error_m", scene.accuracy.height_error_m);
    if (!scene.accuracy.certificate.name.empty())
        out.text("certificate", scene.accuracy.certificate.name);
    for (const WeatherChange& change : scene.weather) {
        out.line("\n[[weather]]");
        out.value("at_s", change.at_s);
        out.value("over_s", change.over_s);
        for (const TomlAssignment& value : change.set)
            out.value("set." + value.path, value.value);
    }
    return out.take();
}

} // namespace seaway::sea
