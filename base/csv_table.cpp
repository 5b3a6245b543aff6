// SPDX-License-Identifier: Apache-2.0
#include "base/csv_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <limits>

#include <fmt/format.h>

#include "base/normal_number.h"

namespace seaway {

namespace {

constexpr double largest = std::numeric_limits<double>::max();

} // namespace

std::optional<double> number_in(std::string_view field, double limit) {
    if (field.starts_with('+') && !field.starts_with("+-")) // from_chars does not read it
        field.remove_prefix(1);
    double value = 0.0;
    const auto [end, problem] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (problem != std::errc() || end != field.data() + field.size() || !(std::abs(value) <= limit))
        return std::nullopt;
    return normal_or_zero(value);
}

Result<bool> next_line(std::istream& in, std::string& line) {
    line.clear();
    for (int c = in.get(); c != std::istream::traits_type::eof(); c = in.get()) {
        if (c == '\n')
            return true;
        if (line.size() == csv_line_bytes_max)
            return Error{fmt::format("the line has more than {} bytes", csv_line_bytes_max)};
        line += static_cast<char>(c);
    }
    // Of standard input std::cin says no more than that it ended, whatever ended it.
    if (in.bad() || (&in == &std::cin && std::ferror(stdin) != 0))
        return Error{"cannot be read to its end"};
    return !line.empty();
}

std::string_view without_mark(std::string_view text) {
    constexpr std::string_view mark = "\xef\xbb\xbf";
    return text.starts_with(mark) ? text.substr(mark.size()) : text;
}

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view blank = " \t\r";
    const std::size_t first = text.find_first_not_of(blank);
    if (first == std::string_view::npos)
        return {};
    return text.substr(first, text.find_last_not_of(blank) - first + 1);
}

std::vector<std::string_view> split_csv(std::string_view line) {
    std::vector<std::string_view> fields;
    for (;;) {
        const std::size_t comma = line.find(',');
        fields.push_back(trimmed(line.substr(0, comma)));
        if (comma == std::string_view::npos)
            return fields;
        line.remove_prefix(comma + 1);
    }
}

std::optional<std::size_t> CsvTable::column(std::string_view title) const {
    const auto found = std::find(columns.begin(), columns.end(), title);
    if (found == columns.end())
        return std::nullopt;
    return static_cast<std::size_t>(found - columns.begin());
}

Error CsvTable::error(std::size_t row, const std::string& what) const {
    return {fmt::format("{}:{}: {}", name, lines.at(row), what)};
}

Result<CsvTable> parse_csv(std::string_view text, const std::string& name, std::size_t rows_max) {
    CsvTable table;
    table.name = name;
    text = without_mark(text);
    for (int line = 1; !text.empty(); ++line) {
        const std::size_t end = text.find('\n');
        const std::string_view content = trimmed(text.substr(0, end));
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
        if (content.empty() || content.front() == '#')
            continue;
        const std::vector<std::string_view> fields = split_csv(content);
        if (table.columns.empty()) {
            if (std::all_of(fields.begin(), fields.end(), [](std::string_view field) {
                    return number_in(field, largest).has_value();
                }))
                return Error{fmt::format("{}:{}: no header: the first line must name the columns, "
                                         "but it holds numbers",
                                         name, line)};
            table.columns.assign(fields.begin(), fields.end());
            continue;
        }
        if (fields.size() != table.columns.size())
            return Error{fmt::format("{}:{}: {} fields, but the header names {}", name, line,
                                     fields.size(), table.columns.size())};
        if (table.rows.size() == rows_max)
            return Error{fmt::format("{}:{}: more than {} rows", name, line, rows_max)};
        std::vector<double>& row = table.rows.emplace_back();
        for (std::size_t c = 0; c < fields.size(); ++c) {
            const std::optional<double> value = number_in(fields[c], largest);
            if (!value)
                return Error{fmt::format("{}:{}: {} = '{}' is not a finite number", name, line,
                                         table.columns[c], fields[c])};
            row.push_back(*value);
        }
        table.lines.push_back(line);
    }
    if (table.rows.empty())
        return Error{fmt::format("{}: no rows; a header and at least one row are needed", name)};
    return table;
}

} // namespace seaway
