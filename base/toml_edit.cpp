// SPDX-License-Identifier: Apache-2.0
#include "base/toml_edit.h"

#include <charconv>
#include <sstream>

#include <fmt/format.h>

#include "base/toml_document.h"
#include "base/toml_header.h"

namespace seaway {

namespace {

constexpr const char* value_key = "value";

/// The document "value = ..." of one value.
Result<TomlDocument> value_document(const std::string& value) {
    return TomlDocument::parse(fmt::format("{} = {}\n", value_key, value), "the value");
}

std::string as_string(std::string_view text) {
    std::string out = "\"";
    for (const char c : text)
        out += c == '"' || c == '\\' ? std::string{'\\', c} : std::string(1, c);
    return out + '"';
}

std::vector<std::string> segments_of(std::string_view path) {
    std::vector<std::string> segments(1);
    for (const char c : path)
        if (c == '.')
            segments.emplace_back();
        else
            segments.back() += c;
    return segments;
}

/// Member of a table, or element of an array; null where there is none.
toml::node* child_of(toml::node& node, const std::string& segment) {
    if (toml::table* table = node.as_table())
        return table->get(segment);
    toml::array* array = node.as_array();
    std::size_t index = 0;
    const char* end = segment.data() + segment.size();
    const auto [read_to, fault] = std::from_chars(segment.data(), end, index);
    return array && fault == std::errc{} && read_to == end ? array->get(index) : nullptr;
}

/// Null where a path leads nowhere.
toml::table* table_at(toml::table& root, std::span<const std::string> segments) {
    toml::node* node = &root;
    for (std::size_t i = 0; node && i < segments.size(); ++i)
        node = child_of(*node, segments[i]);
    return node ? node->as_table() : nullptr;
}

Result<void> set(toml::table& root, const TomlAssignment& assignment) {
    const auto wrong = [&assignment](const std::string& why) {
        return Error{fmt::format("{} = {}: {}", assignment.path, assignment.value, why)};
    };
    const std::vector<std::string> segments = segments_of(assignment.path);
    toml::node* node = &root;
    std::string walked;
    for (std::size_t i = 0; i + 1 < segments.size(); ++i) {
        walked += (i ? "." : "") + segments[i];
        node = child_of(*node, segments[i]);
        if (!node)
            return wrong(fmt::format("there is no {}", walked));
    }
    toml::table* table = node->as_table();
    if (!table || segments.back().empty())
        return wrong("is no path to a value; give one as sea.system.0.from_deg");
    const Result<TomlDocument> value = value_document(assignment.value);
    if (!value)
        return wrong("is not a value of TOML");
    const toml::node* held = value->table().get(value_key);
    if (value->table().size() != 1 || !held)
        return wrong("is more than one value");
    held->visit([&](const auto& one) { table->insert_or_assign(segments.back(), one); });
    return {};
}

void erase(toml::table& root, const std::string& path) {
    const std::vector<std::string> segments = segments_of(path);
    if (toml::table* table = table_at(root, std::span(segments).first(segments.size() - 1)))
        table->erase(segments.back());
}

} // namespace

Result<TomlAssignment> parse_toml_assignment(std::string_view text) {
    const std::size_t equals = text.find('=');
    if (equals == std::string_view::npos || equals == 0)
        return Error{fmt::format("'{}' is no assignment; give PATH=VALUE", text)};
    TomlAssignment assignment{std::string(text.substr(0, equals)),
                              std::string(text.substr(equals + 1))};
    const Result<TomlDocument> value = value_document(assignment.value);
    if (!value || value->table().size() != 1)
        assignment.value = as_string(assignment.value);
    return assignment;
}

Result<std::string> with_toml_values(std::string_view text, const std::string& name,
                                     std::span<const TomlAssignment> values,
                                     std::span<const std::string> without) {
    SEAWAY_TRY_LET(const TomlDocument document, TomlDocument::parse(text, name));
    toml::table root = document.table();
    for (const std::string& path : without)
        erase(root, path);
    for (const TomlAssignment& assignment : values)
        SEAWAY_TRY(set(root, assignment));
    std::ostringstream out;
    out.precision(17);
    out << toml::toml_formatter{root, toml::toml_formatter::default_flags &
                                          ~toml::format_flags::allow_literal_strings};
    return out.str();
}

std::vector<std::string> toml_keys(std::string_view text, std::string_view path) {
    std::vector<std::string> keys;
    const Result<TomlDocument> document = TomlDocument::parse(text, "the text");
    if (!document)
        return keys;
    toml::table root = document->table();
    if (const toml::table* table = table_at(root, segments_of(path)))
        for (const auto& [key, value] : *table)
            keys.emplace_back(key.str());
    return keys;
}

} // namespace seaway
