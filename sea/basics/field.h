// SPDX-License-Identifier: Apache-2.0
// The real fields that a cascade can be asked for, one table row each.
//
// Every linear field is the inverse transform of m(k) h(k,t) or m(k) dh/dt(k,t), where m is a real
// combination of a few functions of k, times i for odd derivatives. The table holds those numbers;
// CPU and GPU both work from it and know no field by name. Maps carry no choppiness: D is the
// displacement at choppiness 1, and whoever moves points multiplies by it (sea/surface).
//
// A new map is a new row here. Thread-safe: constants only.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <string_view>

namespace seaway::sea {

enum class Field : std::uint8_t {
    height,              ///< eta, m
    displacement_x,      ///< D_x, m, east
    displacement_y,      ///< D_y, m, north
    height_rate,         ///< d eta / dt, m/s
    displacement_x_rate, ///< d D_x / dt, m/s
    displacement_y_rate, ///< d D_y / dt, m/s
    slope_x,             ///< d eta / dX, 1
    slope_y,             ///< d eta / dY, 1
    strain_xx,           ///< d D_x / dX, 1
    strain_yy,           ///< d D_y / dY, 1
    strain_xy,           ///< d D_x / dY = d D_y / dX, 1
    jacobian,            ///< det(I + choppiness grad D) of this cascade alone, 1; not linear
    foam,                ///< foam history, 1; state of the server, not linear
};
inline constexpr int field_count = 13;
inline constexpr int linear_field_count = 11; ///< the fields before `jacobian`

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

struct FieldInfo {
    Field field;
    std::string_view name; ///< as on the wire, in metrics and in file channels
    std::string_view unit;
    Basis basis;
    double weight;  ///< factor of the basis function
    bool imaginary; ///< multiply by +i
    bool time_rate; ///< of dh/dt instead of h
};

// D = +i k/|k| h: crests sharpen with x = X + lambda D (traps T27).
inline constexpr std::array<FieldInfo, field_count> field_table{{
    {Field::height, "height", "m", Basis::one, 1, false, false},
    {Field::displacement_x, "displacement_x", "m", Basis::kx_over_k, 1, true, false},
    {Field::displacement_y, "displacement_y", "m", Basis::ky_over_k, 1, true, false},
    {Field::height_rate, "height_rate", "m/s", Basis::one, 1, false, true},
    {Field::displacement_x_rate, "displacement_x_rate", "m/s", Basis::kx_over_k, 1, true, true},
    {Field::displacement_y_rate, "displacement_y_rate", "m/s", Basis::ky_over_k, 1, true, true},
    {Field::slope_x, "slope_x", "1", Basis::kx, 1, true, false},
    {Field::slope_y, "slope_y", "1", Basis::ky, 1, true, false},
    {Field::strain_xx, "strain_xx", "1", Basis::kxx_over_k, -1, false, false},
    {Field::strain_yy, "strain_yy", "1", Basis::kyy_over_k, -1, false, false},
    {Field::strain_xy, "strain_xy", "1", Basis::kxy_over_k, -1, false, false},
    {Field::jacobian, "jacobian", "1", Basis::one, 0, false, false},
    {Field::foam, "foam", "1", Basis::one, 0, false, false},
}};

inline constexpr const FieldInfo& info(Field field) {
    return field_table[static_cast<std::size_t>(field)];
}

inline constexpr bool is_linear(Field field) {
    return static_cast<int>(field) < linear_field_count;
}

/// A set of fields; a plain value, iterable in table order. On the wire: `bits`.
class FieldSet {
  public:
    constexpr FieldSet() = default;
    constexpr FieldSet(std::initializer_list<Field> fields) {
        for (Field field : fields)
            insert(field);
    }
    static constexpr FieldSet from_bits(std::uint32_t bits) {
        FieldSet set;
        set.bits_ = bits & ((1u << field_count) - 1u);
        return set;
    }
    constexpr std::uint32_t bits() const { return bits_; }
    constexpr bool contains(Field field) const { return (bits_ >> static_cast<int>(field)) & 1u; }
    constexpr bool contains(FieldSet other) const { return (bits_ & other.bits_) == other.bits_; }
    constexpr void insert(Field field) { bits_ |= 1u << static_cast<int>(field); }
    constexpr FieldSet& operator|=(FieldSet other) {
        bits_ |= other.bits_;
        return *this;
    }
    friend constexpr FieldSet operator|(FieldSet a, FieldSet b) { return a |= b; }
    friend constexpr bool operator==(FieldSet, FieldSet) = default;
    constexpr int size() const { return std::popcount(bits_); }
    constexpr bool empty() const { return bits_ == 0; }

    /// Position of a contained field among the contained ones, in table order.
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

/// What a sampler needs for heights in time with choppy displacement (sea/surface).
inline constexpr FieldSet surface_fields{
    Field::height,      Field::displacement_x,      Field::displacement_y,
    Field::height_rate, Field::displacement_x_rate, Field::displacement_y_rate};

} // namespace seaway::sea
