// SPDX-License-Identifier: Apache-2.0
// A block of floats for vector loads: aligned to a page, large ones to huge pages, which save most
// of the address translations of column passes and of look-ups here and there. Only what is used of a block is held, and a large one
// goes back to the system at once (base/large_vector.h says why).
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace seaway {

struct FreeFloats {
    void* mapped = nullptr; ///< of the system's own: where it begins
    std::size_t mapped_bytes = 0;

    void operator()(float* p) const {
#if defined(__linux__)
        if (mapped != nullptr) {
            ::munmap(mapped, mapped_bytes);
            return;
        }
#endif
        std::free(p);
    }
};
using AlignedFloats = std::unique_ptr<float[], FreeFloats>;

/// Of any content. Throws std::bad_alloc.
inline AlignedFloats allocate_floats(std::size_t count) {
    constexpr std::size_t page = 4096, huge_page = 2u << 20;
    const std::size_t bytes = count * sizeof(float);
#if defined(__linux__)
    if (bytes >= huge_page / 2) {
        const std::size_t mapped_bytes = ((bytes + huge_page - 1) / huge_page + 1) * huge_page;
        void* const mapped = ::mmap(nullptr, mapped_bytes, PROT_READ | PROT_WRITE,
                                    MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
        if (mapped == MAP_FAILED)
            throw std::bad_alloc();
        const auto begin = reinterpret_cast<std::uintptr_t>(mapped);
        auto* const first =
            reinterpret_cast<float*>((begin + huge_page - 1) / huge_page * huge_page);
        // A hint: whether it is taken changes speed only. Not for a rest that a huge page would be too much for.
        ::madvise(first, (bytes + huge_page / 2) / huge_page * huge_page, MADV_HUGEPAGE);
        return AlignedFloats(first, FreeFloats{mapped, mapped_bytes});
    }
#endif
    auto* p = static_cast<float*>(std::aligned_alloc(page, (bytes / page + 1) * page));
    if (p == nullptr)
        throw std::bad_alloc();
    return AlignedFloats(p);
}

} // namespace seaway
