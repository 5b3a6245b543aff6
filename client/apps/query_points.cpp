// SPDX-License-Identifier: Apache-2.0
#include "client/apps/query_points.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <iostream>

#include <fmt/format.h>

#include "base/text_file.h"
#include "client/link/failure.h"
#include "sea/surface/answer.h"

namespace seaway::client {
namespace {

constexpr std::array<std::string_view, 3> columns{"x_m", "y_m", "t_s"};

bool is_header(const std::vector<std::string_view>& fields) {
    return fields.size() >= 2 && fields.size() <= columns.size() &&
           std::equal(fields.begin(), fields.end(), columns.begin());
}

/// Two or three fields to a place.
Result<Place> to_place(const std::vector<std::string_view>& fields) {
    std::array<double, 3> values{};
    for (std::size_t i = 0; i < fields.size(); ++i) {
        const double limit = i < 2 ? sea::position_max_m : sea::time_max_s;
        const std::optional<double> value = number_in(fields[i], limit);
        if (!value)
            return failed(Failure::bad_argument,
                          fmt::format("{} = '{}': not a number between {:g} and {:g}", columns[i],
                                      fields[i], -limit, limit));
        values[i] = *value;
    }
    Place place{values[0], values[1], std::nullopt};
    if (fields.size() == 3)
        place.time_s = values[2];
    return place;
}

} // namespace

Result<Place> parse_place(std::string_view text) {
    const std::vector<std::string_view> fields = split_csv(text);
    if (fields.size() != 2)
        return failed(Failure::bad_argument,
                      fmt::format("'{}' is not X,Y (metres east and north)", text));
    return to_place(fields);
}

Result<std::vector<Place>> read_places(std::istream& in, const std::string& name,
                                       std::size_t points_max, RowTimes times) {
    std::vector<Place> places;
    std::string line;
    for (int number = 1;; ++number) {
        const Result<bool> more = next_line(in, line);
        if (!more)
            return failed(Failure::bad_argument,
                          fmt::format("{}:{}: {}", name, number, more.error().message));
        if (!*more)
            break;
        if (trimmed(line).empty())
            continue;
        const std::vector<std::string_view> fields =
            split_csv(number == 1 ? without_mark(line) : line);
        if (places.empty() && is_header(fields))
            continue;
        if (fields.size() != 3 && (fields.size() != 2 || times == RowTimes::needed))
            return failed(Failure::bad_argument,
                          fmt::format("{}:{}: {} fields, expected {}x_m,y_m,t_s", name, number,
                                      fields.size(),
                                      times == RowTimes::needed ? "" : "x_m,y_m or "));
        const Result<Place> place = to_place(fields);
        if (!place)
            return failed(Failure::bad_argument,
                          fmt::format("{}:{}: {}", name, number, place.error().message));
        if (places.size() == points_max)
            return failed(Failure::bad_argument,
                          fmt::format("{}:{}: more than {} points", name, number, points_max));
        places.push_back(*place);
    }
    return places;
}

Result<std::vector<Place>> read_places(const std::string& path, RowTimes times) {
    if (path == "-")
        return read_places(std::cin, "standard input", csv_points_max, times);
    if (const Result<void> regular = check_regular_file(path); !regular)
        return failed(Failure::bad_argument,
                      fmt::format("cannot read points '{}': {}", path, regular.error().message));
    std::ifstream file(path);
    return read_places(file, path, csv_points_max, times);
}

} // namespace seaway::client
