// SPDX-License-Identifier: Apache-2.0
// Strict reading of TOML that people write, as scenes and looks: every key is asked for once with its range, what
// nobody asked for is an error that names the key that is nearest to it.
//
//     const Result<TomlDocument> document = TomlDocument::parse(text, name);
//     TomlErrors errors(name);
//     TomlTable root = document->root(errors);
//     if (auto table = root.table("air"))
//         table->number("visibility_m", visibility_m, {200, 280e3}), table->finish();
//     root.finish();
//     if (errors.first()) ...   // "look.toml:3: air.visibility_m: 1 is not allowed; allowed: a number 200 .. 280000"
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/toml_edit.h"

namespace toml {
inline namespace v3 {
class node;
class table;
} // namespace v3
} // namespace toml

namespace seaway {

/// Allowed values, both ends included; NaN is never allowed.
struct Range {
    double lo;
    double hi;
    bool contains(double value) const { return value >= lo && value <= hi; }
};

/// Keeps the first error of a document.
class TomlErrors {
  public:
    explicit TomlErrors(std::string document) : document_(std::move(document)) {}
    void add(unsigned line, const std::string& what);
    const std::optional<Error>& first() const { return first_; }

  private:
    std::string document_;
    std::optional<Error> first_;
};

class TomlTable {
  public:
    /// `name` is the table as a user writes it: "sea", "sea.system[2]".
    TomlTable(const toml::table& table, std::string name, TomlErrors& errors)
        : table_(table), name_(std::move(name)), errors_(errors) {}

    bool has(std::string_view key) const;
    bool is_array(std::string_view key) const;
    bool is_text(std::string_view key) const;
    bool is_empty_array(std::string_view key) const;

    /// Leave `out` as it is where the key is absent. True if it was read.
    bool number(std::string_view key, double& out, Range range);
    bool integer(std::string_view key, std::int64_t& out, std::int64_t lo, std::int64_t hi);
    bool flag(std::string_view key, bool& out);
    bool text(std::string_view key, std::string& out);
    /// A text, or TOML's own date and time of UTC, as 2026-06-21T18:30:00Z.
    bool text_or_instant(std::string_view key, std::string& out);
    /// A number for both, or [x, y].
    bool number_or_pair(std::string_view key, double& x, double& y, Range range);
    /// [a, b, c].
    bool triple(std::string_view key, std::array<double, 3>& out, Range range);
    /// Values by their paths below this table, as TOML writes them: set = { sea.depth_m = 20 } is "sea.depth_m" and
    /// "20". One at least.
    bool assignments(std::string_view key, std::vector<TomlAssignment>& out);
    template <class E>
    using Choice = std::pair<std::string_view, E>;
    template <class E>
    bool choice(std::string_view key, E& out, std::initializer_list<Choice<E>> choices) {
        return choice(key, out, std::span<const Choice<E>>(choices.begin(), choices.size()));
    }
    template <class E>
    bool choice(std::string_view key, E& out,
                std::span<const Choice<std::type_identity_t<E>>> choices) {
        std::string value;
        if (!text(key, value))
            return false;
        std::string allowed;
        for (const auto& [name, result] : choices) {
            if (name == value) {
                out = result;
                return true;
            }
            allowed += (allowed.empty() ? "" : " | ") + std::string(name);
        }
        bad_value(key, '"' + value + '"', allowed);
        return false;
    }
    /// Where the key stands in the text; where it is absent, the table.
    unsigned line_of(std::string_view key) const;
    /// Sub-tables; empty where absent.
    std::optional<TomlTable> table(std::string_view key);
    std::vector<TomlTable> tables(std::string_view key, int count_max);

    void require(std::string_view key);
    /// The key is known, but not here: an error that says why, where it is given.
    void refuse(std::string_view key, const std::string& why);
    void bad_value(std::string_view key, const std::string& value, const std::string& allowed);
    void fail(std::string_view key, const std::string& what);
    /// Reports the first key that nobody asked for.
    void finish();

  private:
    const toml::node* find(std::string_view key);
    std::string path(std::string_view key) const;

    const toml::table& table_;
    std::string name_;
    TomlErrors& errors_;
    std::vector<std::string> asked_;
};

/// A text that was parsed; its tables refer to it.
class TomlDocument {
  public:
    /// Outside of strings and comments a text is printable ASCII. `name` is quoted in errors.
    static Result<TomlDocument> parse(std::string_view text, const std::string& name);

    TomlTable root(TomlErrors& errors) const { return {*table_, "", errors}; }
    const toml::table& table() const { return *table_; }

  private:
    explicit TomlDocument(std::shared_ptr<const toml::table> table) : table_(std::move(table)) {}

    std::shared_ptr<const toml::table> table_;
};

} // namespace seaway
