// SPDX-License-Identifier: Apache-2.0
// Result<T>: a value or an Error. No exception crosses a room; what can fail says so in its type.
// GCC 12 has no std::expected; the names here are its names.
//
//     Result<Scene> read(const Path& path) {
//         SEAWAY_TRY(check(path));                              // Result<void>
//         SEAWAY_TRY_LET(const std::string text, load(path));   // Result<std::string>
//         return parse(text);
//     }
//
// A room whose errors are told apart has an enum of their kinds. Nobody acts on the text of a
// message:
//
//     return Error{Failure::not_held, "no keyframes around 12 s"};
//     if (error.is(Failure::not_held)) ...
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "base/check.h"

namespace seaway {

/// A value of any room's enum of kinds, or none. Kinds of different rooms are never equal.
class ErrorKind {
  public:
    constexpr ErrorKind() = default;
    template <class Kind>
    requires(std::is_enum_v<Kind>) constexpr ErrorKind(Kind kind)
        : room_(&room<Kind>), value_(static_cast<int>(kind)) {}

    constexpr bool operator==(const ErrorKind&) const = default;

    /// The kind if it is one of this enum.
    template <class Kind>
    constexpr std::optional<Kind> as() const {
        return room_ == &room<Kind> ? std::optional(static_cast<Kind>(value_)) : std::nullopt;
    }

  private:
    template <class Kind>
    static inline char room = 0; ///< its address stands for the enum

    const char* room_ = nullptr;
    int value_ = 0;
};

/// Why something could not be done, in one line a user can act on, and of which kind it is where
/// somebody acts on that.
struct Error {
    Error(std::string why) : message(std::move(why)) {}
    Error(ErrorKind which, std::string why) : message(std::move(why)), kind(which) {}

    bool is(ErrorKind which) const { return kind == which; }

    std::string message;
    ErrorKind kind;
    /// Of what may be asked again: not before. 0: nothing is known.
    std::uint32_t retry_after_ms = 0;
};

template <class T>
class [[nodiscard]] Result {
  public:
    Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
    Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

    bool has_value() const { return state_.index() == 0; }
    explicit operator bool() const { return has_value(); }

    T& value() & {
        SEAWAY_CHECK(has_value(), "Result read without looking for an error");
        return *std::get_if<0>(&state_);
    }
    const T& value() const& { return const_cast<Result*>(this)->value(); }
    T&& value() && { return std::move(value()); }
    T& operator*() & { return value(); }
    const T& operator*() const& { return value(); }
    T&& operator*() && { return std::move(*this).value(); }
    T* operator->() { return &value(); }
    const T* operator->() const { return &value(); }

    const Error& error() const {
        SEAWAY_CHECK(!has_value(), "error() of a Result that holds a value");
        return *std::get_if<1>(&state_);
    }

  private:
    std::variant<T, Error> state_;
};

/// Success without a value, or an Error.
template <>
class [[nodiscard]] Result<void> {
  public:
    Result() = default;
    Result(Error error) : error_(std::move(error)) {}

    bool has_value() const { return !error_; }
    explicit operator bool() const { return has_value(); }
    const Error& error() const {
        SEAWAY_CHECK(!has_value(), "error() of a Result that holds a value");
        return *error_;
    }

  private:
    std::optional<Error> error_;
};

} // namespace seaway

/// Returns the error of a Result from the function around it; goes on if there is none.
#define SEAWAY_TRY(expression)                                                                     \
    do {                                                                                           \
        if (const auto& seaway_tried = (expression); !seaway_tried) [[unlikely]]                   \
            return seaway_tried.error();                                                           \
    } while (false)

/// Declares a variable with the value of a Result, or returns its error.
#define SEAWAY_TRY_LET(declaration, expression)                                                    \
    SEAWAY_TRY_LET_NAMED(declaration, expression, SEAWAY_JOIN(seaway_tried_, __LINE__))
#define SEAWAY_TRY_LET_NAMED(declaration, expression, result)                                      \
    auto result = (expression);                                                                    \
    if (!result) [[unlikely]]                                                                      \
        return result.error();                                                                     \
    declaration = *std::move(result)
#define SEAWAY_JOIN(a, b) SEAWAY_JOIN_EXPANDED(a, b)
#define SEAWAY_JOIN_EXPANDED(a, b) a##b
