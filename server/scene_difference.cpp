// SPDX-License-Identifier: Apache-2.0
#include "server/scene_difference.h"

#include <deque>
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
    const std::vector<Line> old = lines_of(before), now = lines_of(after);
    std::multiset<std::pair<std::string, std::string>> fresh; // what was not there before
    for (const Line& line : now)
        fresh.emplace(line.path, line.value);
    std::map<std::string, std::deque<const Line*>> gone; // in the order of the text
    for (const Line& line : old)
        if (const auto kept = fresh.find({line.path, line.value}); kept != fresh.end())
            fresh.erase(kept);
        else
            gone[line.path].push_back(&line);
    std::vector<SceneDifference> differences;
    for (const Line& line : now) {
        const auto one = fresh.find({line.path, line.value});
        if (one == fresh.end())
            continue;
        fresh.erase(one);
        std::deque<const Line*>& before_it = gone[line.path];
        differences.push_back({line.path, std::nullopt, line.value});
        if (before_it.empty())
            continue;
        differences.back().before = before_it.front()->value;
        before_it.pop_front();
    }
    for (const Line& line : old)
        if (std::deque<const Line*>& left = gone[line.path];
            !left.empty() && left.front() == &line) {
            differences.push_back({line.path, line.value, std::nullopt});
            left.pop_front();
        }
    return differences;
}

} // namespace seaway::server
