// SPDX-License-Identifier: Apache-2.0
// A block of floats that starts at a page, for vector loads and few address translations.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>

namespace seaway::sea::native {

struct FreeFloats {
    void operator()(float* p) const { std::free(p); }
};
using AlignedFloats = std::unique_ptr<float[], FreeFloats>;

inline AlignedFloats allocate_floats(std::size_t count) {
    constexpr std::size_t page = 4096;
    const std::size_t bytes = (count * sizeof(float) + page) / page * page;
    auto* p = static_cast<float*>(std::aligned_alloc(page, bytes));
    if (p == nullptr)
        throw std::bad_alloc();
    return AlignedFloats(p);
}

} // namespace seaway::sea::native
