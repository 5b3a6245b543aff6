// SPDX-License-Identifier: Apache-2.0
// MapValues: the values of a keyframe's maps, in memory of its own or lent, as by a device whose memory is read in place.
// As std::vector<float> in what it offers; whoever makes it longer gets memory of its own. A copy owns its values.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "base/large_vector.h"

namespace seaway::sea {

class MapValues {
  public:
    using Floats = LargeVector<float>;

    MapValues() = default;
    MapValues(Floats own) : own_(std::move(own)), values_(own_) {}
    MapValues(const std::vector<float>& values) : MapValues(Floats(values.begin(), values.end())) {}
    /// `keeper` is let go with the values: until then they stay where they are.
    static MapValues lent(std::span<float> values, std::shared_ptr<const void> keeper) {
        MapValues made;
        made.values_ = values;
        made.keeper_ = std::move(keeper);
        return made;
    }

    MapValues(const MapValues& other) : MapValues(Floats(other.begin(), other.end())) {}
    MapValues(MapValues&& other) noexcept
        : own_(std::move(other.own_)), values_(std::exchange(other.values_, {})),
          keeper_(std::move(other.keeper_)) {}
    MapValues& operator=(MapValues other) noexcept {
        own_ = std::move(other.own_);
        values_ = std::exchange(other.values_, {});
        keeper_ = std::move(other.keeper_);
        return *this;
    }
    ~MapValues() = default;

    bool is_lent() const { return keeper_ != nullptr; }
    /// Memory of its own, given away; empty where it was lent.
    Floats take() {
        values_ = {};
        keeper_ = nullptr;
        return std::exchange(own_, {});
    }

    std::size_t size() const { return values_.size(); }
    bool empty() const { return values_.empty(); }
    float* data() { return values_.data(); }
    const float* data() const { return values_.data(); }
    float* begin() { return values_.data(); }
    float* end() { return values_.data() + values_.size(); }
    const float* begin() const { return values_.data(); }
    const float* end() const { return values_.data() + values_.size(); }
    float& operator[](std::size_t i) { return values_[i]; }
    const float& operator[](std::size_t i) const { return values_[i]; }

    void resize(std::size_t size) {
        change([&](Floats& own) { own.resize(size); });
    }
    void assign(std::size_t size, float value) {
        change([&](Floats& own) { own.assign(size, value); });
    }
    void clear() { take(); }
    /// `at` must be end().
    template <class Iterator>
    void insert(const float*, Iterator first, Iterator last) {
        change([&](Floats& own) { own.insert(own.end(), first, last); });
    }
    void insert(const float*, std::size_t count, float value) {
        change([&](Floats& own) { own.insert(own.end(), count, value); });
    }

    friend bool operator==(const MapValues& a, const MapValues& b) {
        return std::equal(a.begin(), a.end(), b.begin(), b.end());
    }

  private:
    template <class Change>
    void change(const Change& change) {
        if (keeper_ != nullptr) {
            own_.assign(values_.begin(), values_.end());
            keeper_ = nullptr;
        }
        change(own_);
        values_ = own_;
    }

    Floats own_;
    std::span<float> values_; ///< own_, or lent
    std::shared_ptr<const void> keeper_;
};

} // namespace seaway::sea
