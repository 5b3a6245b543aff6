// SPDX-License-Identifier: Apache-2.0
// A page in Prometheus' text format, read by its own rules: what the writer gets wrong is seen.
#pragma once

#include <cmath>
#include <map>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

namespace seaway::tests {

struct MetricsPage {
    std::map<std::string, double> values;     ///< by name, labels included
    std::map<std::string, std::string> types; ///< by name without labels
};

/// What `promtool check metrics` finds fault with in a name, in its own words; empty: nothing. After
/// Prometheus' promlint (client_golang, prometheus/testutil/promlint/validations).
inline std::string fault_of(const std::string& name, const std::string& kind) {
    const auto has_word = [&](const std::string& word) {
        return ("_" + name + "_").find("_" + word + "_") != std::string::npos;
    };
    for (const char* type : {"counter", "gauge", "summary", "histogram"})
        if (has_word(type))
            return "metric name should not include type";
    for (const char* unit :
         {"s", "ms", "us", "ns", "sec", "b", "kb", "mb", "gb", "tb", "pb", "m", "h", "d"})
        if (has_word(unit))
            return "metric names should not contain abbreviated units";
    for (const std::string unit : {"minutes", "hours", "days", "weeks", "kelvins", "fahrenheit",
                                   "inches", "yards", "miles", "bits", "calories", "pounds"})
        if (has_word(unit))
            return "use base unit";
    for (const std::string prefix : {"pico", "nano", "micro", "milli", "centi", "deci", "hecto",
                                     "kilo", "kibi", "mega", "mibi", "giga", "gibi", "tera"})
        for (const char* unit : {"seconds", "bytes", "meters", "metres", "grams", "joules", "volts",
                                 "amperes", "bits"})
            if (has_word(prefix + unit))
                return "use base unit";
    for (const char* suffix : {"_bucket", "_count", "_sum"})
        if (name.ends_with(suffix))
            return "reserved for histograms and summaries";
    for (const char c : name)
        if (!(c >= 'a' && c <= 'z') && !(c >= '0' && c <= '9') && c != '_')
            return "metric names should be written in 'snake_case'";
    if ((kind == "counter") != name.ends_with("_total"))
        return "counters alone have the suffix _total";
    return {};
}

/// Every line counts: one that is no comment and no sample fails, and so does a name said twice, a
/// sample before its type, a type without help before it, and what promtool would complain about.
inline MetricsPage read_metrics(const std::string& text) {
    MetricsPage page;
    std::istringstream in(text);
    std::string helped;
    // Samples of a histogram have a word behind its name.
    const auto base_of = [&page](const std::string& sample) {
        const std::string name = sample.substr(0, sample.find('{'));
        for (const char* suffix : {"_bucket", "_sum", "_count"})
            if (name.ends_with(suffix))
                if (const std::string base = name.substr(0, name.rfind('_'));
                    page.types.contains(base) && page.types.at(base) == "histogram")
                    return base;
        return name;
    };
    for (std::string line; std::getline(in, line);) {
        std::istringstream words(line);
        std::string name, kind;
        if (line.starts_with("# TYPE ")) {
            words >> kind >> kind >> name >> kind;
            EXPECT_TRUE(page.types.emplace(name, kind).second) << line;
            EXPECT_TRUE(kind == "counter" || kind == "gauge" || kind == "histogram") << line;
            EXPECT_EQ(fault_of(name, kind), "") << line;
            EXPECT_EQ(helped, name) << "no help text";
            continue;
        }
        if (line.starts_with("# HELP ")) {
            words >> kind >> kind >> helped >> kind;
            EXPECT_FALSE(words.fail()) << line << ": no help text";
            continue;
        }
        double value = 0;
        words >> name >> value;
        EXPECT_TRUE(!words.fail() && words.eof()) << line;
        EXPECT_TRUE(page.values.emplace(name, value).second) << line;
        EXPECT_EQ(helped, base_of(name)) << "samples of a name stand together";
        EXPECT_EQ(page.types.count(base_of(name)), 1u) << line;
    }
    return page;
}

/// One figure of a page, by its name with its labels; -1 if it is not there.
inline double figure_of(const std::string& text, const std::string& name) {
    const std::size_t at = text.find("\n" + name + " ");
    return at == std::string::npos ? -1 : std::stod(text.substr(at + name.size() + 2));
}

/// The page has these samples, to rounding, and no others.
inline void expect_metrics(const MetricsPage& page, const std::map<std::string, double>& expected) {
    for (const auto& [name, value] : expected) {
        const auto found = page.values.find(name);
        ASSERT_NE(found, page.values.end()) << name;
        EXPECT_NEAR(found->second, value, 1e-12 * std::abs(value)) << name;
    }
    for (const auto& [name, value] : page.values)
        EXPECT_EQ(expected.count(name), 1u) << name << " is not known to this test";
}

} // namespace seaway::tests
