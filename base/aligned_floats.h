// SPDX-License-Identifier: Apache-2.0
// A block of floats for vector loads: aligned to a page, large ones to huge pages, which save most
// of the address translations of column passes and of look-ups here and there. Only what is used of a block is held.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace seaway {

struct FreeFloats {
    void operator()(float* p) const { std::free(p); }
};
using AlignedFloats = std::unique_ptr<float[], FreeFloats>;

/// Of any content. Throws std::bad_alloc.
inline AlignedFloats allocate_floats(std::size_t count) {
    constexpr std::size_t page = 4096, huge_page = 2u << 20;
    const std::size_t alignment = count * sizeof(float) >= huge_page / 2 ? huge_page : page;
    const std::size_t bytes = (count * sizeof(float) / alignment + 1) * alignment;
    auto* p = static_cast<float*>(std::aligned_alloc(alignment, bytes));
    if (p == nullptr)
        throw std::bad_alloc();
#if defined(MADV_HUGEPAGE)
    // A hint: whether it is taken changes speed only. Not for a rest that a huge page would be too much for.
    const std::size_t whole = count * sizeof(float) + huge_page / 2;
    if (alignment == huge_page)
        madvise(p, whole / huge_page * huge_page, MADV_HUGEPAGE);
#endif
    return AlignedFloats(p);
}

} // namespace seaway
