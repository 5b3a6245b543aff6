// SPDX-License-Identifier: Apache-2.0
#include "server/scene_difference.h"

#include <map>
#include <sstream>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace seaway::server {
namespace {

struct Line {
    std::string path;
    std::string value;
};

std::vector<Line> lines_of(const std::string& text) {
    std::vector<Line> lines;
    std::map<std::string, int, std::less<>> arrays; // how many tables each has had
    std::string table;
    std::istringstream rest(text);
    for (std::string line; std::getline(rest, line);) {
        if (line.starts_with("[[")) {
            const std::string name = line.substr(2, line.find(']') - 2);
            table = fmt::format("{}.{}.", name, arrays[name]++);
        } else if (line.starts_with("[")) {
            table = line.substr(1, line.find(']') - 1) + ".";
        } else if (const std::size_t equals = line.find(" = "); equals != std::string::npos) {
            lines.push_back({table + line.substr(0, equals), line.substr(equals + 3)});
        } else if (!line.empty()) {
            lines.push_back({table + line, {}});
        }
    }
    return lines;
}

} // namespace

std::vector<SceneDifference> scene_differences(const std::string& before,
                                               const std::string& after) {
    std::map<std::string, std::string> held;
    const std::vector<Line> old = lines_of(before);
    for (const Line& line : old)
        held.emplace(line.path, line.value);
    std::vector<SceneDifference> differences;
    for (const Line& line : lines_of(after)) {
        const auto same = held.find(line.path);
        if (same == held.end())
            differences.push_back({line.path, std::nullopt, line.value});
        else if (same->second != line.value)
            differences.push_back({line.path, same->second, line.value});
        if (same != held.end())
            held.erase(same);
    }
    for (const Line& line : old)
        if (const auto gone = held.find(line.path); gone != held.end())
            differences.push_back({line.path, line.value, std::nullopt});
    return differences;
}

} // namespace seaway::server
