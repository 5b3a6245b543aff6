// SPDX-License-Identifier: Apache-2.0
// MetricsText: counters and gauges as Prometheus reads them (text format 0.0.4): a family's help and type once, then its values.
//
//     MetricsText text("seaway_net_");
//     text.one("sessions", "gauge", "WebSocket sessions open", 3);
//     text.family("queries_total", "counter", "Queries, by reason");
//     text.value({{"reason", "full"}}, 7);
//
// Names, labels and their values are our own words: nothing is escaped. Not thread-safe.
#pragma once

#include <initializer_list>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace seaway::server {

class MetricsText {
  public:
    using Label = std::pair<std::string_view, std::string_view>;

    /// `prefix` stands before every name.
    explicit MetricsText(std::string prefix = "seaway_") : prefix_(std::move(prefix)) {}

    /// Begins a family; its values come next.
    void family(std::string_view name, std::string_view type, std::string_view help) {
        family_ = prefix_ + std::string(name);
        fmt::format_to(out(), "# HELP {0} {1}\n# TYPE {0} {2}\n", family_, help, type);
    }
    /// `part` of a histogram: "_bucket", "_sum", "_count".
    template <class Number>
    void value(std::initializer_list<Label> labels, Number value, std::string_view part = "") {
        text_ += family_;
        text_ += part;
        char before = '{';
        for (const auto& [label, is] : labels)
            fmt::format_to(out(), "{}{}=\"{}\"", std::exchange(before, ','), label, is);
        fmt::format_to(out(), "{} {}\n", labels.size() > 0 ? "}" : "", value);
    }
    /// A family of one value.
    template <class Number>
    void one(std::string_view name, std::string_view type, std::string_view help, Number is) {
        family(name, type, help);
        value({}, is);
    }
    /// A counter by one label, whose values are keys of a map.
    template <class Map>
    void each(std::string_view name, std::string_view label, std::string_view help,
              const Map& values) {
        family(name, "counter", help);
        for (const auto& [key, is] : values)
            value({{label, fmt::format("{}", key)}}, is);
    }

    std::string take() { return std::move(text_); }

  private:
    std::back_insert_iterator<std::string> out() { return std::back_inserter(text_); }

    const std::string prefix_;
    std::string family_; ///< with its prefix
    std::string text_;
};

} // namespace seaway::server
