// SPDX-License-Identifier: Apache-2.0
// Numbers by lot, the same with every library.
#pragma once

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <random>

namespace seaway::tests {

class Draw {
  public:
    explicit Draw(std::uint64_t seed) : engine_(seed) {}

    /// [low, high)
    double uniform(double low, double high) {
        return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
    }
    double log_uniform(double low, double high) {
        return std::exp(uniform(std::log(low), std::log(high)));
    }
    std::uint64_t below(std::uint64_t end) { return engine_() % end; }
    int whole(int first, int last) {
        return first + static_cast<int>(below(static_cast<std::uint64_t>(last - first + 1)));
    }
    template <class T>
    T one_of(std::initializer_list<T> values) {
        return values.begin()[below(values.size())];
    }

  private:
    std::mt19937_64 engine_;
};

} // namespace seaway::tests
