// SPDX-License-Identifier: Apache-2.0
// Strict reading of one TOML table: every key is asked for once with its range, what nobody asked
// for is an error. Used by the scene reader only.
#pragma once

// toml++ 3.3 meets some malformed texts ("[$") with a failed assertion, or with NDEBUG with
// undefined behaviour. With both off it takes its own error paths; the fuzzer walks them.
#undef NDEBUG
#define TOML_ASSERT(expr) static_assert(true)
#define TOML_EXCEPTIONS 0
#include <toml++/toml.h>

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/result.h"

namespace seaway::sea {

/// Allowed values, both ends included; NaN is never allowed.
struct Range {
    double lo;
    double hi;
    bool contains(double value) const { return value >= lo && value <= hi; }
};

/// Outside of strings and comments a scene is printable ASCII: the error at the first byte that is
/// not. toml++ 3.3 does not survive all others there.
std::optional<Error> find_strange_byte(std::string_view text, const std::string& document);

/// Keeps the first error of a document.
class TomlErrors {
  public:
    explicit TomlErrors(std::string document) : document_(std::move(document)) {}
    void add(const toml::source_region& where, const std::string& what);
    const std::optional<Error>& first() const { return first_; }
    const std::string& document() const { return document_; }

  private:
    std::string document_;
    std::optional<Error> first_;
};

class TomlTable {
  public:
    /// `name` is the table as a user writes it: "sea", "sea.system[2]".
    TomlTable(const toml::table& table, std::string name, TomlErrors& errors)
        : table_(table), name_(std::move(name)), errors_(errors) {}

    bool has(std::string_view key) const { return table_.contains(key); }

    /// Leave `out` as it is where the key is absent. True if it was read.
    bool number(std::string_view key, double& out, Range range);
    bool integer(std::string_view key, std::int64_t& out, std::int64_t lo, std::int64_t hi);
    bool flag(std::string_view key, bool& out);
    bool text(std::string_view key, std::string& out);
    /// A number for both, or [x, y].
    bool number_or_pair(std::string_view key, double& x, double& y, Range range);
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
    /// Sub-tables; empty where absent.
    std::optional<TomlTable> table(std::string_view key);
    std::vector<TomlTable> tables(std::string_view key, int count_max);

    void require(std::string_view key);
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

} // namespace seaway::sea
