// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/hash.h"
#include "sea/certificate/certificate.h"

namespace seaway::sea {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* format_name = "seaway certificate 1";
constexpr std::size_t rows_max = 4096;
constexpr int depth_max = 16; ///< a certificate is 4 deep
constexpr double infinite = std::numeric_limits<double>::infinity();

/// JSON has no infinity: null is deep water.
Json or_null(double value) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json json_of(const SeaPoint& p) {
    return {{"hs_m", p.hs_m},
            {"tp_s", p.tp_s},
            {"depth_m", or_null(p.depth_m)},
            {"choppiness", p.choppiness},
            {"wind_speed_10m_mps", p.wind_speed_10m_mps}};
}

Json json_of(const MeasuredError& m) {
    return {{"sea", m.sea},
            {"seed", m.seed},
            {"hs_m", m.hs_m},
            {"rms_m", m.rms_m},
            {"p99_m", m.p99_m},
            {"max_m", m.max_m},
            {"waves_left_out_m", m.waves_left_out_m},
            {"total_rms_m", m.total_rms_m},
            {"total_m", m.total_m},
            {"slope_rms", m.slope_rms}};
}

std::string checksum(const Json& content) {
    return hex_hash(content.dump(-1, ' ', false, Json::error_handler_t::replace));
}

/// Reads keys of one object and keeps the first error, which names the key by its path.
class Reader {
  public:
    Reader(const Json& object, std::string path, std::string& error)
        : object_(object), path_(std::move(path)), error_(error) {
        if (!object.is_object())
            fail("", "an object is needed");
    }

    double number(const char* key, double low, double high) {
        const Json* value = find(key);
        if (value == nullptr)
            return low;
        if (!value->is_number() || !(value->get<double>() >= low && value->get<double>() <= high)) {
            fail(key, fmt::format("{} is not allowed; allowed: a number {:g} .. {:g}",
                                  shown(*value), low, high));
            return low;
        }
        return value->get<double>();
    }
    double length(const char* key) { return number(key, 0.0, 1e6); }
    double number_or_infinity(const char* key, double low, double high) {
        const Json* value = find(key);
        return value != nullptr && value->is_null() ? infinite : number(key, low, high);
    }
    std::string text(const char* key) {
        constexpr std::size_t text_bytes_max = 4096;
        const Json* value = find(key);
        if (value == nullptr)
            return {};
        const auto control = [](char c) { return static_cast<unsigned char>(c) < 0x20; };
        const std::string text = value->is_string() ? value->get<std::string>() : "\n";
        if (text.size() <= text_bytes_max && std::none_of(text.begin(), text.end(), control))
            return text; // it may become part of a line of a log
        fail(key, fmt::format("{} is not allowed; allowed: one line of at most {} bytes",
                              shown(*value), text_bytes_max));
        return {};
    }
    bool flag(const char* key) {
        const Json* value = find(key);
        if (value != nullptr && !value->is_boolean())
            fail(key, fmt::format("{} is not allowed; allowed: true, false", shown(*value)));
        return value != nullptr && value->is_boolean() && value->get<bool>();
    }
    std::uint64_t whole(const char* key) {
        const Json* value = find(key);
        if (value != nullptr && !value->is_number_unsigned())
            fail(key, fmt::format("{} is not allowed; allowed: a whole number", shown(*value)));
        return value != nullptr && value->is_number_unsigned() ? value->get<std::uint64_t>() : 0;
    }
    Reader object(const char* key) {
        static const Json empty = Json::object();
        const Json* value = find(key);
        return {value != nullptr ? *value : empty, at(key), error_};
    }
    /// Calls f(Reader) for each object of a list.
    template <class F>
    void each(const char* key, std::size_t least, const F& f) {
        const Json* value = find(key);
        if (value == nullptr)
            return;
        if (!value->is_array() || value->size() < least || value->size() > rows_max)
            return fail(key, fmt::format("a list of {} .. {} is needed", least, rows_max));
        for (std::size_t i = 0; i < value->size(); ++i)
            f(Reader((*value)[i], fmt::format("{}[{}]", at(key), i + 1), error_));
    }
    const Json* optional(const char* key) {
        const auto found = object_.is_object() ? object_.find(key) : object_.end();
        return found == object_.end() || found->is_null() ? nullptr : &*found;
    }
    void fail(const char* key, const std::string& what) {
        if (error_.empty())
            error_ = fmt::format("{}: {}", at(key), what);
    }
    const Json& json() const { return object_; }

  private:
    const Json* find(const char* key) {
        if (!object_.is_object())
            return nullptr;
        const auto found = object_.find(key);
        if (found != object_.end())
            return &*found;
        fail(key, "missing");
        return nullptr;
    }
    std::string at(const char* key) const {
        return path_.empty() ? std::string(key)
               : *key == 0   ? path_
                             : fmt::format("{}.{}", path_, key);
    }
    static std::string shown(const Json& value) {
        return value.dump(-1, ' ', true, Json::error_handler_t::replace).substr(0, 60);
    }

    const Json& object_;
    std::string path_;
    std::string& error_;
};

SeaPoint read_point(Reader reader) {
    SeaPoint p{};
    p.hs_m = reader.number("hs_m", 0, 1e6);
    p.tp_s = reader.number("tp_s", 0, 1e6);
    p.depth_m = reader.number_or_infinity("depth_m", 0, 1e9);
    p.choppiness = reader.number("choppiness", 0, 10);
    p.wind_speed_10m_mps = reader.number("wind_speed_10m_mps", 0, 1e3);
    return p;
}

MeasuredError read_measured(Reader reader) {
    MeasuredError m;
    m.sea = reader.text("sea");
    m.seed = reader.whole("seed");
    m.hs_m = reader.length("hs_m");
    m.rms_m = reader.length("rms_m");
    m.p99_m = reader.length("p99_m");
    m.max_m = reader.length("max_m");
    m.waves_left_out_m = reader.length("waves_left_out_m");
    m.total_rms_m = reader.length("total_rms_m");
    m.total_m = reader.length("total_m");
    m.slope_rms = reader.length("slope_rms");
    return m;
}

void read_configuration(Reader reader, Certificate& c) {
    c.configuration_hash = reader.text("hash");
    c.height_error_m = reader.number("height_error_m", 1e-5, 1.0);
    c.streams = reader.flag("streams");
    reader.each("cascades", 1, [&c](Reader tile) {
        c.cascades.push_back(
            {tile.number("length_m", 0.1, 1e6), static_cast<int>(tile.number("size", 16, 2048))});
    });
}

void read_place(Reader reader, Certificate& c) {
    c.machine = reader.text("machine");
    c.device = reader.text("device");
    c.driver = reader.text("driver");
    c.compiler = reader.text("compiler");
    c.commit = reader.text("commit");
    c.date_utc = reader.text("date_utc");
    c.command = reader.text("command");
}

Certificate read(Reader& reader) {
    Certificate c;
    Reader promise = reader.object("promise");
    c.promised_m = promise.number("height_error_m", 1e-6, 1e3);
    c.percentile = promise.number("percentile", 50, 99.9);
    if (promise.optional("slope_error") != nullptr)
        c.promised_slope = promise.number("slope_error", 1e-6, 100);
    read_configuration(reader.object("configuration"), c);
    Reader spectrum = reader.object("spectrum");
    c.spectrum_hash = spectrum.text("hash");
    Reader envelope = reader.object("envelope");
    c.envelope = {read_point(envelope.object("low")), read_point(envelope.object("high"))};
    reader.each("measured", 1, [&c](Reader row) { c.measured.push_back(read_measured(row)); });
    if (reader.optional("beside_finer_waves_m") != nullptr)
        c.beside_finer_waves_m = reader.length("beside_finer_waves_m");
    Reader costs = reader.object("costs");
    if (costs.json().is_object())
        for (const auto& [name, value] : costs.json().items())
            c.costs.emplace_back(name, costs.number(name.c_str(), 0, 1e15));
    if (const Json* rows = reader.optional("runners_up"); rows != nullptr && rows->is_array())
        for (const Json& row : *rows)
            if (row.is_string() && c.runners_up.size() < rows_max)
                c.runners_up.push_back(row.get<std::string>());
    read_place(reader.object("place"), c);
    return c;
}

} // namespace

std::string to_json(const Certificate& c) {
    Json cascades = Json::array(), measured = Json::array(), costs = Json::object();
    for (const CascadeSpec& cascade : c.cascades)
        cascades.push_back({{"length_m", cascade.length_m}, {"size", cascade.size}});
    for (const MeasuredError& m : c.measured)
        measured.push_back(json_of(m));
    for (const auto& [name, value] : c.costs)
        costs[name] = value;
    Json json = {
        {"format", format_name},
        {"promise",
         {{"height_error_m", c.promised_m},
          {"percentile", c.percentile},
          {"slope_error", c.promised_slope ? Json(*c.promised_slope) : Json(nullptr)}}},
        {"configuration",
         {{"hash", c.configuration_hash},
          {"height_error_m", c.height_error_m},
          {"streams", c.streams},
          {"cascades", cascades}}},
        {"spectrum", {{"hash", c.spectrum_hash}}},
        {"envelope", {{"low", json_of(c.envelope.low)}, {"high", json_of(c.envelope.high)}}},
        {"measured", measured},
        {"beside_finer_waves_m",
         c.beside_finer_waves_m ? Json(*c.beside_finer_waves_m) : Json(nullptr)},
        {"costs", costs},
        {"runners_up", c.runners_up},
        {"place",
         {{"machine", c.machine},
          {"device", c.device},
          {"driver", c.driver},
          {"compiler", c.compiler},
          {"commit", c.commit},
          {"date_utc", c.date_utc},
          {"command", c.command}}}};
    json["checksum"] = checksum(json);
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

Result<Certificate> parse_certificate(const std::string& text, const std::string& name) {
    bool deep = false; // what is shown of it, or summed up, takes stack for each depth
    Json json = Json::parse(
        text,
        [&](int depth, Json::parse_event_t, Json&) { return !(deep = deep || depth > depth_max); },
        false);
    if (deep)
        return Error{fmt::format("{} has objects or lists within one another more than {} deep",
                                 name, depth_max)};
    if (json.is_discarded() || !json.is_object())
        return Error{fmt::format("{} is not JSON that begins with an object", name)};
    std::string error;
    Reader reader(json, "", error);
    const std::string format = reader.text("format"), stated = reader.text("checksum");
    if (error.empty() && format != format_name)
        error = fmt::format("format: \"{}\" is not allowed; allowed: \"{}\"", format, format_name);
    Certificate certificate = read(reader);
    if (!error.empty())
        return Error{fmt::format("{}: {}", name, error)};
    Json content = json;
    content.erase("checksum");
    if (checksum(content) != stated)
        return Error{fmt::format("{}: checksum: the content was changed after it was measured "
                                 "({} is stated, {} it is)",
                                 name, stated, checksum(content))};
    return certificate;
}

} // namespace seaway::sea
