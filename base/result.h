// SPDX-License-Identifier: Apache-2.0
// Result<T>: a value or an Error. No exception crosses a room; what can fail says so in its type.
// GCC 12 has no std::expected; the names here are its names.
//
//     Result<Scene> scene = read_scene(path);
//     if (!scene) return scene.error();
//     use(*scene);
#pragma once

#include <string>
#include <utility>
#include <variant>

#include "base/check.h"

namespace seaway {

/// Why something could not be done, in one line a user can act on.
struct Error {
    std::string message;
    int code = 0; ///< for programs: a room that sorts its errors says here which kind; else 0
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
    Result(Error error) : error_(std::move(error)), ok_(false) {}

    bool has_value() const { return ok_; }
    explicit operator bool() const { return ok_; }
    const Error& error() const {
        SEAWAY_CHECK(!ok_, "error() of a Result that holds a value");
        return error_;
    }

  private:
    Error error_;
    bool ok_ = true;
};

} // namespace seaway
