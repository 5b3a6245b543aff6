// SPDX-License-Identifier: Apache-2.0
// The real fields that a cascade can be asked for, one table row each.
//
// Every linear field is the inverse transform of m(k) h(k,t) or m(k) dh/dt(k,t), where m is a real
// combination of a few functions of k, times i for odd derivatives. The table holds those numbers;
// CPU and GPU both work from it and know no field by name. Maps carry no choppiness: D is the
// displacement at choppiness 1, and whoever moves points multiplies by it (sea/surface).
//
// The number of a field is its identity on the wire and in files: bit n of a set of fields, the
// value of Tile.field. It is frozen: never change a number, never reuse one. A new map is a new row
// at the end, linear or not, with the next number; the enum of protocol/seaway.fbs and the table of
// docs/protocol.md repeat it, and tests hold the three together. Thread-safe: constants only.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <string_view>

#include "base/check.h"
#include "sea/basics/lagrangian_point.h"

namespace seaway::sea {

/// Frozen numbers: never change one, never reuse one.
enum class Field : std::uint8_t {
    height = 0,              ///< eta, m
    displacement_x = 1,      ///< D_x, m, east
    displacement_y = 2,      ///< D_y, m, north
    height_rate = 3,         ///< d eta / dt, m/s
    displacement_x_rate = 4, ///< d D_x / dt, m/s
    displacement_y_rate = 5, ///< d D_y / dt, m/s
    slope_x = 6,             ///< d eta / dX, 1
    slope_y = 7,             ///< d eta / dY, 1
    strain_xx = 8,           ///< d D_x / dX, 1
    strain_yy = 9,           ///< d D_y / dY, 1
    strain_xy = 10,          ///< d D_x / dY = d D_y / dX, 1
    jacobian = 11,           ///< det(I + choppiness grad D) of this cascade alone, 1; not linear
    foam = 12,               ///< foam history, 1; state of the server, not linear
};

/// Functions of k = (kx, ky) that multipliers are made of.
enum class Basis : std::uint8_t {
    one,
    kx_over_k,
    ky_over_k,
    kx,
    ky,
    kxx_over_k,
    kyy_over_k,
    kxy_over_k
};

/// Kernels transform linear fields; the others are made from them.
enum class Kind : std::uint8_t { linear, derived };

struct FieldInfo {
    Field field;
    std::string_view name; ///< as on the wire, in metrics and in file channels
    std::string_view unit;
    Kind kind;
    Basis basis;    ///< of a linear field, as the three that follow
    double weight;  ///< factor of the basis function
    bool imaginary; ///< multiply by +i
    bool time_rate; ///< of dh/dt instead of h
    /// Where direct sums and generators of waves leave its value; null for derived fields.
    double LagrangianPoint::*at_point;
};

// D = +i k/|k| coth(kd) h: crests sharpen with x = X + lambda D (traps T27).
inline constexpr std::array field_table{
    FieldInfo{Field::height, "height", "m", Kind::linear, Basis::one, 1, false, false,
              &LagrangianPoint::height},
    FieldInfo{Field::displacement_x, "displacement_x", "m", Kind::linear, Basis::kx_over_k, 1, true,
              false, &LagrangianPoint::displacement_x},
    FieldInfo{Field::displacement_y, "displacement_y", "m", Kind::linear, Basis::ky_over_k, 1, true,
              false, &LagrangianPoint::displacement_y},
    FieldInfo{Field::height_rate, "height_rate", "m/s", Kind::linear, Basis::one, 1, false, true,
              &LagrangianPoint::height_rate},
    FieldInfo{Field::displacement_x_rate, "displacement_x_rate", "m/s", Kind::linear,
              Basis::kx_over_k, 1, true, true, &LagrangianPoint::displacement_x_rate},
    FieldInfo{Field::displacement_y_rate, "displacement_y_rate", "m/s", Kind::linear,
              Basis::ky_over_k, 1, true, true, &LagrangianPoint::displacement_y_rate},
    FieldInfo{Field::slope_x, "slope_x", "1", Kind::linear, Basis::kx, 1, true, false,
              &LagrangianPoint::slope_x},
    FieldInfo{Field::slope_y, "slope_y", "1", Kind::linear, Basis::ky, 1, true, false,
              &LagrangianPoint::slope_y},
    FieldInfo{Field::strain_xx, "strain_xx", "1", Kind::linear, Basis::kxx_over_k, -1, false, false,
              &LagrangianPoint::strain_xx},
    FieldInfo{Field::strain_yy, "strain_yy", "1", Kind::linear, Basis::kyy_over_k, -1, false, false,
              &LagrangianPoint::strain_yy},
    FieldInfo{Field::strain_xy, "strain_xy", "1", Kind::linear, Basis::kxy_over_k, -1, false, false,
              &LagrangianPoint::strain_xy},
    FieldInfo{Field::jacobian, "jacobian", "1", Kind::derived, Basis::one, 0, false, false,
              nullptr},
    FieldInfo{Field::foam, "foam", "1", Kind::derived, Basis::one, 0, false, false, nullptr},
};
inline constexpr int field_count = static_cast<int>(field_table.size());

inline constexpr const FieldInfo& info(Field field) {
    return field_table[static_cast<std::size_t>(field)];
}

inline constexpr bool is_linear(Field field) {
    return info(field).kind == Kind::linear;
}

/// The value of a linear field at a point.
inline double value_of(const LagrangianPoint& point, Field field) {
    SEAWAY_CHECK(is_linear(field), "a derived field is not a value of one point");
    return point.*info(field).at_point;
}

/// Every row stands at its number, and every linear field has its value at a point.
static_assert([] {
    for (int n = 0; n < field_count; ++n) {
        const FieldInfo& row = field_table[static_cast<std::size_t>(n)];
        if (static_cast<int>(row.field) != n ||
            (row.kind == Kind::linear) != (row.at_point != nullptr))
            return false;
    }
    return field_count <= 32; // a set of fields is 32 bits on the wire
}());

/// A set of fields; a plain value, iterable by number. On the wire: `bits`.
class FieldSet {
  public:
    constexpr FieldSet() = default;
    constexpr FieldSet(std::initializer_list<Field> fields) {
        for (Field field : fields)
            insert(field);
    }
    /// Bits of fields that are not known are left out.
    static constexpr FieldSet from_bits(std::uint32_t bits) {
        FieldSet set;
        set.bits_ = bits & static_cast<std::uint32_t>((std::uint64_t{1} << field_count) - 1u);
        return set;
    }
    constexpr std::uint32_t bits() const { return bits_; }
    constexpr bool contains(Field field) const { return (bits_ >> static_cast<int>(field)) & 1u; }
    constexpr bool contains(FieldSet other) const { return (bits_ & other.bits_) == other.bits_; }
    constexpr void insert(Field field) { bits_ |= 1u << static_cast<int>(field); }
    /// Of these, the ones that `other` contains too.
    constexpr FieldSet& operator&=(FieldSet other) {
        bits_ &= other.bits_;
        return *this;
    }
    constexpr FieldSet& operator|=(FieldSet other) {
        bits_ |= other.bits_;
        return *this;
    }
    friend constexpr FieldSet operator|(FieldSet a, FieldSet b) { return a |= b; }
    constexpr FieldSet without(FieldSet less) const { return from_bits(bits_ & ~less.bits_); }
    friend constexpr FieldSet operator&(FieldSet a, FieldSet b) { return a &= b; }
    friend constexpr bool operator==(FieldSet, FieldSet) = default;
    constexpr int size() const { return std::popcount(bits_); }
    constexpr bool empty() const { return bits_ == 0; }

    /// Position of a contained field among the contained ones, by number.
    constexpr int index_of(Field field) const {
        return std::popcount(bits_ & ((1u << static_cast<int>(field)) - 1u));
    }

    class Iterator {
      public:
        constexpr explicit Iterator(std::uint32_t rest) : rest_(rest) {}
        constexpr Field operator*() const { return static_cast<Field>(std::countr_zero(rest_)); }
        constexpr Iterator& operator++() {
            rest_ &= rest_ - 1u;
            return *this;
        }
        friend constexpr bool operator==(Iterator, Iterator) = default;

      private:
        std::uint32_t rest_;
    };
    constexpr Iterator begin() const { return Iterator(bits_); }
    constexpr Iterator end() const { return Iterator(0); }

  private:
    std::uint32_t bits_ = 0;
};

inline constexpr FieldSet all_fields = FieldSet::from_bits(~0u);

/// Every linear field; field_table says which.
inline constexpr FieldSet linear_fields = [] {
    FieldSet linear;
    for (const FieldInfo& row : field_table)
        if (row.kind == Kind::linear)
            linear.insert(row.field);
    return linear;
}();
inline constexpr int linear_field_count = linear_fields.size();

/// What the Jacobian is made of, and what foam looks at.
inline constexpr FieldSet strain_fields{Field::strain_xx, Field::strain_yy, Field::strain_xy};

/// Maps whose time rates are maps, too.
struct ValueAndRate {
    Field value;
    Field rate;
};
inline constexpr std::array rate_table{
    ValueAndRate{Field::height, Field::height_rate},
    ValueAndRate{Field::displacement_x, Field::displacement_x_rate},
    ValueAndRate{Field::displacement_y, Field::displacement_y_rate}};

/// What a sampler needs for heights in time with choppy displacement (sea/surface).
inline constexpr FieldSet surface_fields{
    Field::height,      Field::displacement_x,      Field::displacement_y,
    Field::height_rate, Field::displacement_x_rate, Field::displacement_y_rate};

/// The maps whose rates these are.
inline constexpr FieldSet values_of_rates(FieldSet rates) {
    FieldSet values;
    for (const auto& [value, rate] : rate_table)
        if (rates.contains(rate))
            values.insert(value);
    return values;
}

/// What follows, wave by wave, from a map of this field alone: displacements from heights, their rates from its rate.
inline constexpr FieldSet following(Field field) {
    if (field == Field::height)
        return {Field::displacement_x, Field::displacement_y};
    if (field == Field::height_rate)
        return {Field::displacement_x_rate, Field::displacement_y_rate};
    return {};
}
/// All that follow from these, but for what is among them.
inline constexpr FieldSet following(FieldSet fields) {
    FieldSet all;
    for (const Field field : fields)
        all |= following(field);
    return all;
}

} // namespace seaway::sea
