// SPDX-License-Identifier: Apache-2.0
// What the files of the C interface share: a client, and how results become codes. Not for programs: they see seaway.h.
#pragma once

// What the headers declare is seen from outside the library, where all else is hidden.
#pragma GCC visibility push(default)
#include "client/seaway.h"
#include "client/seaway_engine.h"
#pragma GCC visibility pop

#include <algorithm>
#include <cstring>
#include <exception>
#include <limits>
#include <memory>
#include <mutex>
#include <new>
#include <span>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "client/client.h"
#include "client/link/failure.h"
#include "client/questions.h"
#include "protocol/limits.h"

struct seaway_client {
    std::shared_ptr<seaway::client::Questions> questions =
        std::make_shared<seaway::client::Questions>();
    std::mutex watch_mutex; ///< held while it is called
    seaway_status_watch watch = nullptr;
    void* user = nullptr;
    std::unique_ptr<seaway::client::Client>
        client; ///< first to go: its events call watch and questions
};

// The two structs are the library's own ones, field for field, so that points need no copy.
static_assert(sizeof(seaway_point) == sizeof(seaway::sea::QueryPoint) &&
              offsetof(seaway_point, y_m) == offsetof(seaway::sea::QueryPoint, y_m) &&
              offsetof(seaway_point, time_us) == offsetof(seaway::sea::QueryPoint, time_us));

namespace seaway::client::c {

inline constexpr double timeout_default_s = 10, timeout_max_s = 86400;

/// A wish that is as small as that is none of 0, which leaves the choice to the server.
inline float wish_of(double value) {
    const auto narrow = static_cast<float>(value);
    return value > 0 ? std::max(narrow, std::numeric_limits<float>::min()) : narrow;
}
/// No struct of any library has more: a size above it was never set, and that many bytes may not be there to look at.
inline constexpr uint32_t struct_bytes_max = 4096;
inline thread_local std::string last_error;

inline seaway_code fail(seaway_code code, std::string why) {
    last_error = std::move(why);
    return code;
}

/// Of what may be thrown at any moment, too.
inline seaway_code fail(seaway_code code, const char* why) noexcept {
    try {
        last_error = why;
    } catch (const std::bad_alloc&) {
        last_error.clear();
    }
    return code;
}

inline seaway_code fail(const Error& error) {
    const int code = static_cast<int>(failure_of(error));
    static_assert(static_cast<int>(Failure::not_understood) == SEAWAY_NOT_UNDERSTOOD);
    const bool known =
        (code > SEAWAY_OK && code < SEAWAY_INTERNAL) || code == SEAWAY_NOT_UNDERSTOOD;
    return fail(known ? static_cast<seaway_code>(code) : SEAWAY_INTERNAL, error.message);
}

/// Runs a body that returns a Result<void>; nothing may be thrown into C.
template <class Body>
seaway_code guarded(const Body& body) {
    try {
        last_error.clear();
        const Result<void> done = body();
        return done ? SEAWAY_OK : fail(done.error());
    } catch (const std::bad_alloc&) {
        return fail(SEAWAY_INTERNAL, "out of memory");
    } catch (const std::exception& problem) {
        return fail(SEAWAY_INTERNAL, problem.what());
    }
}

inline Error bad(std::string why) {
    return failed(Failure::bad_argument, std::move(why));
}

/// `what`: a number as its header calls it. NaN is in no range.
inline Result<void> in_range(std::string_view what, double value, double least, double most) {
    if (value >= least && value <= most)
        return {};
    return bad(fmt::format("{} is {}: it must be {} to {}", what, value, least, most));
}

inline Result<void> is_flag(std::string_view what, std::uint32_t value) {
    if (value <= 1)
        return {};
    return bad(fmt::format("{} is {}: it must be 0 or 1", what, value));
}

/// 0 leaves the choice to the server.
inline Result<void> unset_or_in_range(std::string_view what, double value, double least,
                                      double most) {
    if (value == 0 || (value >= least && value <= most))
        return {};
    return bad(fmt::format("{} is {}: it must be 0 or {} to {}", what, value, least, most));
}

/// What a stream may be asked for, by members of the struct `name`.
inline Result<protocol::TileWish> tile_limits(std::string_view name, double error_m,
                                              double rate_hz_max, std::uint32_t size_max) {
    using namespace protocol;
    const auto member = [name](std::string_view its) { return fmt::format("{}.{}", name, its); };
    SEAWAY_TRY(in_range(member("error_m"), error_m, 0, double{limits::error_m_max}));
    SEAWAY_TRY(unset_or_in_range(member("rate_hz_max"), rate_hz_max, double{limits::rate_hz_min},
                                 double{limits::rate_hz_max}));
    SEAWAY_TRY(
        unset_or_in_range(member("size_max"), size_max, limits::size_min, limits::map_side_max));
    TileWish wish;
    wish.error_m = wish_of(error_m);
    wish.rate_hz_max = static_cast<float>(rate_hz_max);
    wish.size_max = static_cast<int>(size_max);
    return wish;
}

/// How long a call waits, s.
inline Result<double> patience(std::string_view what, double timeout_s) {
    SEAWAY_TRY(in_range(what, timeout_s, 0, timeout_max_s));
    return timeout_s == 0 ? timeout_default_s : timeout_s;
}

inline Result<std::uint32_t> credit_of(std::string_view what, std::uint32_t credit) {
    SEAWAY_TRY(in_range(what, credit, 0, protocol::limits::credit_max));
    return credit == 0 ? std::uint32_t{protocol::limits::credit_default} : credit;
}

inline std::span<const sea::QueryPoint> as_points(const seaway_point* points, size_t count) {
    return {reinterpret_cast<const sea::QueryPoint*>(points), count};
}

inline void put(std::span<const sea::Answer> answers, seaway_answer* out) {
    for (const sea::Answer& answer : answers) {
        out->height_m = answer.height_m;
        for (int axis = 0; axis < 3; ++axis) {
            out->normal[axis] = answer.normal[axis];
            out->velocity_mps[axis] = answer.velocity_mps[axis];
        }
        out->error_m = answer.error_m;
        out->flags = answer.flags;
        out->reserved = 0;
        ++out;
    }
}

/// What a caller gave that may know an older or a newer library: what it has not got is 0, and what this library does not
/// know must be. `least`: bytes that the first version had.
template <class Struct>
Result<Struct> sized(const Struct* given, std::size_t least, const char* name) {
    Struct made{};
    if (!given)
        return made;
    if (given->size < least || given->size > struct_bytes_max)
        return bad(fmt::format("{}: size is {}: it must be sizeof({}), {} here, never above {}",
                               name, given->size, name, sizeof(Struct), struct_bytes_max));
    const auto* bytes = reinterpret_cast<const unsigned char*>(given);
    for (std::size_t i = sizeof(Struct); i < given->size; ++i)
        if (bytes[i] != 0)
            return bad(fmt::format("{}: this library does not know what is set at its byte {}: "
                                   "its own has {}",
                                   name, i, sizeof(Struct)));
    std::memcpy(&made, given, std::min<std::size_t>(given->size, sizeof(Struct)));
    return made;
}

/// Which waves count; null: all.
Result<Looking> looking_of(const seaway_looking* looking);

/// Has the caller room for it? `least`: bytes that the first version had.
template <class Struct>
Result<void> has_room(const Struct* to, std::size_t least, const char* name) {
    if (!to)
        return bad(fmt::format("{} must not be null", name));
    if (to->size < least || to->size > struct_bytes_max)
        return bad(fmt::format("{}.size is {}: it must be sizeof({})", name, to->size, name));
    return {};
}

/// Fills in as much as the caller has room for.
template <class Struct>
Result<void> give(Struct value, Struct* to, std::size_t least, const char* name) {
    SEAWAY_TRY(has_room(to, least, name));
    value.size = static_cast<uint32_t>(std::min<std::size_t>(to->size, sizeof(Struct)));
    std::memcpy(to, &value, value.size);
    return {};
}

/// Structs that a caller may know fewer members of, one after the other.
template <class Struct>
class Out {
  public:
    Out(Struct* to, std::size_t stride)
        : to_(reinterpret_cast<unsigned char*>(to)), stride_(stride) {}
    void put(const Struct& one) {
        std::memcpy(to_, &one, std::min(stride_, sizeof(one)));
        to_ += stride_;
    }

  private:
    unsigned char* to_;
    std::size_t stride_;
};

/// More are meant by nobody: a size that wrapped, or was never set.
inline constexpr std::size_t points_max = std::numeric_limits<std::uint32_t>::max();

inline Result<void> count_fits(const char* call, std::size_t count) {
    if (count <= points_max)
        return {};
    return bad(fmt::format("{}: count is {}: it must be 0 to {}", call, count, points_max));
}

/// What each call about points needs; `to` is where its answers go, `name` what that is called.
inline Result<void> points_given(const char* call, const seaway_client* client,
                                 const seaway_point* points, std::size_t count, const void* to,
                                 const char* name) {
    if (!client || (count > 0 && (!points || !to)))
        return bad(fmt::format("{}: client, points and {} must not be null", call, name));
    return count_fits(call, count);
}

/// Of structs that begin with an answer.
inline Result<void> stride_fits(std::size_t stride, const char* call, const char* name) {
    if (stride >= sizeof(seaway_answer))
        return {};
    return bad(fmt::format("{}: stride is {}: it must be sizeof({})", call, stride, name));
}

} // namespace seaway::client::c
