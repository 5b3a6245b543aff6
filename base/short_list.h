// SPDX-License-Identifier: Apache-2.0
// ShortList: a vector of N elements at most that has them within itself, for lists of which every one is short and which are
// made where nothing may be allocated.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <initializer_list>
#include <utility>

#include "base/check.h"

namespace seaway {

template <class T, std::size_t N>
class ShortList {
  public:
    ShortList() = default;
    ShortList(std::initializer_list<T> items) {
        for (const T& item : items)
            push_back(item);
    }

    T& emplace_back(T item) {
        SEAWAY_CHECK(count_ < N, "a short list has room for all that is put there");
        return items_[count_++] = std::move(item);
    }
    void push_back(T item) { emplace_back(std::move(item)); }
    void clear() {
        for (; count_ > 0; --count_)
            items_[count_ - 1] = T{};
    }

    std::size_t size() const { return count_; }
    bool empty() const { return count_ == 0; }
    T* data() { return items_.data(); }
    const T* data() const { return items_.data(); }
    T* begin() { return data(); }
    T* end() { return data() + count_; }
    const T* begin() const { return data(); }
    const T* end() const { return data() + count_; }
    T& operator[](std::size_t i) { return items_[i]; }
    const T& operator[](std::size_t i) const { return items_[i]; }
    T& front() { return items_[0]; }
    const T& front() const { return items_[0]; }

    friend bool operator==(const ShortList& a, const ShortList& b) {
        return std::equal(a.begin(), a.end(), b.begin(), b.end());
    }
    friend bool operator<(const ShortList& a, const ShortList& b) {
        return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
    }

  private:
    std::array<T, N> items_{};
    std::size_t count_ = 0;
};

} // namespace seaway
