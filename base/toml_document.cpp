// SPDX-License-Identifier: Apache-2.0
#include "base/toml_document.h"

#include <algorithm>
#include <sstream>

#include <fmt/format.h>

#include "base/nearest.h"
#include "base/normal_number.h"
#include "base/toml_header.h"

namespace seaway {

namespace {

std::string shown(const toml::node& node) {
    if (const auto* value = node.as_string())
        return '"' + value->get() + '"';
    if (const auto* value = node.as_integer())
        return fmt::format("{}", value->get());
    if (const auto* value = node.as_floating_point())
        return fmt::format("{}", value->get());
    if (const auto* value = node.as_boolean())
        return value->get() ? "true" : "false";
    return node.is_table() ? "a table" : node.is_array() ? "an array" : "a date";
}

/// Integers are fine where a number is asked for.
std::optional<double> as_number(const toml::node& node) {
    if (const auto* value = node.as_integer())
        return static_cast<double>(value->get());
    if (const auto* value = node.as_floating_point())
        return normal_or_zero(value->get());
    return std::nullopt;
}

/// What is written here is read by functions that call themselves a level, and ended so: a text of 24 KB could have
/// more levels than a thread has stack. toml++ bounds brackets (256) and no dotted key.
constexpr int brackets_max = 32;
constexpr int key_parts_max = 8;

/// Walks a TOML text as far as comments, strings, brackets and dots go.
class Lexer {
  public:
    explicit Lexer(std::string_view text) : text_(text) {
        if (text_.substr(0, 3) == "\xEF\xBB\xBF")
            text_.remove_prefix(3);
    }
    /// The line of the first fault, and what it is.
    std::optional<std::pair<int, std::string>> first_fault() {
        while (!text_.empty()) {
            const char c = text_.front();
            if (c == '#') {
                skip_to("\n", false);
                dots_ = 0;
            } else if (c == '"' || c == '\'') {
                skip_string();
            } else if (is_strange(c)) {
                return std::pair(
                    line_, fmt::format("byte 0x{:02x} is not allowed here; outside of strings and "
                                       "comments there is printable ASCII alone",
                                       static_cast<unsigned char>(c)));
            } else {
                note(c);
                take(1);
            }
            if (brackets_ > brackets_max)
                return std::pair(
                    line_, fmt::format("more than {} brackets within each other", brackets_max));
            if (dots_ >= key_parts_max)
                return std::pair(line_, fmt::format("a key of more than {} parts", key_parts_max));
        }
        return std::nullopt;
    }

  private:
    /// toml++ 3.3 does not survive all bytes beyond ASCII outside of strings and comments.
    static bool is_strange(char c) {
        const auto byte = static_cast<unsigned char>(c);
        return byte >= 0x7F || (byte < 0x20 && c != '\t' && c != '\n' && c != '\r');
    }
    /// A key ends where its value, the next one or the next line begins; numbers have a dot at most.
    void note(char c) {
        if (c == '[' || c == '{')
            ++brackets_;
        else if (c == ']' || c == '}')
            --brackets_;
        if (c == '.')
            ++dots_;
        else if (std::string_view("=,[]{}\n").find(c) != std::string_view::npos)
            dots_ = 0;
    }
    void take(std::size_t count) {
        count = std::min(count, text_.size());
        line_ += static_cast<int>(
            std::count(text_.begin(), text_.begin() + static_cast<long>(count), '\n'));
        text_.remove_prefix(count);
    }
    /// Past the next `end` that no backslash hides; what is not closed runs to the end.
    void skip_to(std::string_view end, bool escapes) {
        while (!text_.empty() && text_.substr(0, end.size()) != end)
            take(escapes && text_.front() == '\\' ? 2 : 1);
        take(end.size());
    }
    void skip_string() {
        const std::string_view quote = text_.substr(0, 1);
        const std::string triple(3, quote.front());
        const bool escapes = quote == "\"";
        if (text_.substr(0, 3) != triple) {
            const std::string one(quote);
            take(1);
            skip_to(one, escapes);
            return;
        }
        take(3);
        skip_to(triple, escapes);
        // Up to two more quotes belong to the string's end.
        for (int i = 0; i < 2 && !text_.empty() && text_.front() == triple.front(); ++i)
            take(1);
    }

    std::string_view text_;
    int line_ = 1;
    int brackets_ = 0;
    int dots_ = 0;
};

} // namespace

Result<TomlDocument> TomlDocument::parse(std::string_view text, const std::string& name) {
    if (const auto fault = Lexer(text).first_fault())
        return Error{fmt::format("{}:{}: {}", name, fault->first, fault->second)};
    toml::parse_result parsed = toml::parse(text);
    if (!parsed)
        return Error{fmt::format("{}:{}: {}", name, parsed.error().source().begin.line,
                                 parsed.error().description())};
    return TomlDocument(std::make_shared<const toml::table>(std::move(parsed).table()));
}

void TomlErrors::add(unsigned line, const std::string& what) {
    if (!first_)
        first_ = Error{fmt::format("{}:{}: {}", document_, line, what)};
}

bool TomlTable::has(std::string_view key) const {
    return table_.contains(key);
}

bool TomlTable::is_array(std::string_view key) const {
    const toml::node* node = table_.get(key);
    return node != nullptr && node->is_array();
}

bool TomlTable::is_text(std::string_view key) const {
    const toml::node* node = table_.get(key);
    return node != nullptr && node->is_string();
}

bool TomlTable::is_empty_array(std::string_view key) const {
    return is_array(key) && table_.get(key)->as_array()->empty();
}

std::string TomlTable::path(std::string_view key) const {
    return name_.empty() ? std::string(key) : fmt::format("{}.{}", name_, key);
}

const toml::node* TomlTable::find(std::string_view key) {
    asked_.emplace_back(key);
    return table_.get(key);
}

void TomlTable::bad_value(std::string_view key, const std::string& value,
                          const std::string& allowed) {
    fail(key, fmt::format("{} is not allowed; allowed: {}", value, allowed));
}

unsigned TomlTable::line_of(std::string_view key) const {
    const toml::node* node = table_.get(key);
    return (node != nullptr ? node->source() : table_.source()).begin.line;
}

void TomlTable::fail(std::string_view key, const std::string& what) {
    errors_.add(line_of(key), fmt::format("{}: {}", path(key), what));
}

void TomlTable::require(std::string_view key) {
    if (!has(key))
        fail(key, "missing");
}

void TomlTable::refuse(std::string_view key, const std::string& why) {
    if (find(key) != nullptr)
        fail(key, why);
}

bool TomlTable::number(std::string_view key, double& out, Range range) {
    const toml::node* node = find(key);
    if (node == nullptr)
        return false;
    const std::optional<double> value = as_number(*node);
    if (!value || !range.contains(*value)) {
        bad_value(key, shown(*node), fmt::format("a number {} .. {}", range.lo, range.hi));
        return false;
    }
    out = *value;
    return true;
}

bool TomlTable::integer(std::string_view key, std::int64_t& out, std::int64_t lo, std::int64_t hi) {
    const toml::node* node = find(key);
    if (node == nullptr)
        return false;
    const auto* value = node->as_integer();
    if (value == nullptr || value->get() < lo || value->get() > hi) {
        bad_value(key, shown(*node), fmt::format("a whole number {} .. {}", lo, hi));
        return false;
    }
    out = value->get();
    return true;
}

bool TomlTable::flag(std::string_view key, bool& out) {
    const toml::node* node = find(key);
    if (node == nullptr)
        return false;
    if (const auto* value = node->as_boolean())
        out = value->get();
    else
        bad_value(key, shown(*node), "true | false");
    return node->is_boolean();
}

bool TomlTable::text(std::string_view key, std::string& out) {
    const toml::node* node = find(key);
    if (node == nullptr)
        return false;
    if (const auto* value = node->as_string())
        out = value->get();
    else
        bad_value(key, shown(*node), "a string");
    return node->is_string();
}

bool TomlTable::text_or_instant(std::string_view key, std::string& out) {
    const toml::node* node = table_.get(key);
    const toml::value<toml::date_time>* value = node != nullptr ? node->as_date_time() : nullptr;
    if (value == nullptr)
        return text(key, out);
    asked_.emplace_back(key);
    const toml::date_time& at = value->get();
    if (!at.offset || at.offset->minutes != 0 || at.time.nanosecond != 0) {
        bad_value(key, "this date", "whole seconds of UTC, as 2026-06-21T18:30:00Z");
        return false;
    }
    out = fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", at.date.year, at.date.month,
                      at.date.day, at.time.hour, at.time.minute, at.time.second);
    return true;
}

bool TomlTable::triple(std::string_view key, std::array<double, 3>& out, Range range) {
    const toml::node* node = find(key);
    if (node == nullptr)
        return false;
    const toml::array* list = node->as_array();
    std::array<double, 3> values{};
    bool fine = list != nullptr && list->size() == values.size();
    for (std::size_t i = 0; fine && i < values.size(); ++i) {
        const std::optional<double> value = as_number(*list->get(i));
        fine = value && range.contains(*value);
        values[i] = value.value_or(0);
    }
    if (!fine) {
        bad_value(key, list != nullptr ? "the array" : shown(*node),
                  fmt::format("three numbers {} .. {} in brackets", range.lo, range.hi));
        return false;
    }
    out = values;
    return true;
}

bool TomlTable::number_or_pair(std::string_view key, double& x, double& y, Range range) {
    const toml::node* node = table_.get(key);
    const toml::array* pair = node != nullptr ? node->as_array() : nullptr;
    if (pair == nullptr) {
        if (!number(key, x, range))
            return false;
        y = x;
        return true;
    }
    asked_.emplace_back(key);
    const auto component = [&](std::size_t i) {
        return pair->size() == 2 ? as_number(*pair->get(i)) : std::nullopt;
    };
    const std::optional<double> east = component(0);
    const std::optional<double> north = component(1);
    if (!east || !north || !range.contains(*east) || !range.contains(*north)) {
        bad_value(key, "the array",
                  fmt::format("a number {0} .. {1}, or [x, y] of such", range.lo, range.hi));
        return false;
    }
    x = *east;
    y = *north;
    return true;
}

namespace {

void flatten(const toml::table& table, const std::string& above, std::vector<TomlAssignment>& out) {
    for (const auto& [key, node] : table) {
        const std::string path =
            above.empty() ? std::string(key.str()) : fmt::format("{}.{}", above, key.str());
        if (const toml::table* sub = node.as_table()) {
            flatten(*sub, path, out);
            continue;
        }
        std::ostringstream text;
        node.visit([&text](const auto& value) { text << value; });
        out.push_back({path, text.str()});
    }
}

} // namespace

bool TomlTable::assignments(std::string_view key, std::vector<TomlAssignment>& out) {
    const toml::node* node = find(key);
    if (node == nullptr)
        return false;
    std::vector<TomlAssignment> found;
    if (const toml::table* sub = node->as_table())
        flatten(*sub, "", found);
    if (found.empty()) {
        bad_value(key, node->is_table() ? "an empty table" : shown(*node),
                  "values by their paths, as { sea.system.0.wind_speed_10m_mps = 24 }");
        return false;
    }
    out = std::move(found);
    return true;
}

std::optional<TomlTable> TomlTable::table(std::string_view key) {
    const toml::node* node = find(key);
    if (node == nullptr)
        return std::nullopt;
    if (const toml::table* sub = node->as_table())
        return TomlTable(*sub, path(key), errors_);
    bad_value(key, shown(*node), fmt::format("a table, [{}]", path(key)));
    return std::nullopt;
}

std::vector<TomlTable> TomlTable::tables(std::string_view key, int count_max) {
    std::vector<TomlTable> subs;
    const toml::node* node = find(key);
    if (node == nullptr)
        return subs;
    const toml::array* array = node->as_array();
    if (array == nullptr || (!array->empty() && !array->is_array_of_tables())) {
        bad_value(key, shown(*node), fmt::format("tables, each [[{}]]", path(key)));
        return subs;
    }
    if (array->size() > static_cast<std::size_t>(count_max)) {
        bad_value(key, fmt::format("{} of them", array->size()),
                  fmt::format("at most {}", count_max));
        return subs;
    }
    for (std::size_t i = 0; i < array->size(); ++i)
        subs.emplace_back(*array->get(i)->as_table(), fmt::format("{}[{}]", path(key), i + 1),
                          errors_);
    return subs;
}

void TomlTable::finish() {
    for (const auto& [key, node] : table_)
        if (std::find(asked_.begin(), asked_.end(), key.str()) == asked_.end())
            errors_.add(
                (key.source().begin ? key.source() : node.source()).begin.line,
                fmt::format("{}: unknown key{}", path(key.str()), nearest_of(key.str(), asked_)));
}

} // namespace seaway
