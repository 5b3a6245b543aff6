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

/// Every line counts: one that is no comment and no sample fails, and so does a name said twice, a
/// sample before its type, and a counter that is not called so.
inline MetricsPage read_metrics(const std::string& text) {
    MetricsPage page;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) {
        std::istringstream words(line);
        std::string name, kind;
        if (line.starts_with("# TYPE ")) {
            words >> kind >> kind >> name >> kind;
            EXPECT_TRUE(page.types.emplace(name, kind).second) << line;
            EXPECT_EQ(kind, name.ends_with("_total") ? "counter" : "gauge") << line;
            continue;
        }
        if (line.starts_with("# HELP "))
            continue;
        double value = 0;
        words >> name >> value;
        EXPECT_TRUE(!words.fail() && words.eof()) << line;
        EXPECT_TRUE(page.values.emplace(name, value).second) << line;
        EXPECT_EQ(page.types.count(name.substr(0, name.find('{'))), 1u) << line;
    }
    return page;
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
