// SPDX-License-Identifier: Apache-2.0
#include "server/scene_difference.h"

#include <map>
#include <set>
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

/// Rows of a text of several lines are values of its key.
std::vector<Line> lines_of(const std::string& text) {
    std::vector<Line> lines;
    std::map<std::string, int, std::less<>> arrays; // how many tables each has had
    std::string table, path;
    std::istringstream rest(text);
    for (std::string line; std::getline(rest, line);) {
        if (line.starts_with("[[")) {
            const std::string name = line.substr(2, line.find(']') - 2);
            table = fmt::format("{}.{}.", name, arrays[name]++);
        } else if (line.starts_with("[")) {
            table = line.substr(1, line.find(']') - 1) + ".";
        } else if (const std::size_t equals = line.find(" = "); equals != std::string::npos) {
            path = table + line.substr(0, equals);
            lines.push_back({path, line.substr(equals + 3)});
        } else if (!line.empty()) {
            lines.push_back({path, line});
        }
    }
    return lines;
}

} // namespace

std::vector<SceneDifference> scene_differences(const std::string& before,
                                               const std::string& after) {
    std::multiset<std::pair<std::string, std::string>> held;
    const std::vector<Line> old = lines_of(before), now = lines_of(after);
    for (const Line& line : old)
        held.emplace(line.path, line.value);
    std::vector<const Line*> fresh;
    for (const Line& line : now)
        if (const auto same = held.find({line.path, line.value}); same != held.end())
            held.erase(same);
        else
            fresh.push_back(&line);
    std::vector<SceneDifference> differences;
    for (const Line* line : fresh) {
        const auto other = held.lower_bound({line->path, {}});
        if (other == held.end() || other->first != line->path) {
            differences.push_back({line->path, std::nullopt, line->value});
            continue;
        }
        differences.push_back({line->path, other->second, line->value});
        held.erase(other);
    }
    for (const Line& line : old)
        if (const auto gone = held.find({line.path, line.value}); gone != held.end()) {
            differences.push_back({line.path, line.value, std::nullopt});
            held.erase(gone);
        }
    return differences;
}

} // namespace seaway::server
