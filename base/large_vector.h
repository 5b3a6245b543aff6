// SPDX-License-Identifier: Apache-2.0
// LargeVector: a std::vector whose large blocks come from the system and go back to it at once. Of malloc, a large block that is freed
// raises the size from which it does the same, to that of maps; then these lie in its arenas, from several threads, between what is
// longer lived: a client held three times what it used, for good, once it had seen a sea of larger maps. A library cannot set
// that for the program that it runs in.
//
// A new block costs its page faults, some 0.2 ms a megabyte: for maps, not for what is made in each call.
#pragma once

#include <cstddef>
#include <new>
#include <vector>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace seaway {

namespace large {

/// From here on a block is the system's own.
inline constexpr std::size_t bytes_min = std::size_t{128} << 10;

inline void* take(std::size_t bytes) {
#if defined(__linux__)
    if (bytes >= bytes_min) {
        void* const block =
            ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (block == MAP_FAILED)
            throw std::bad_alloc();
        return block;
    }
#endif
    return ::operator new(bytes);
}
inline void give(void* block, std::size_t bytes) noexcept {
#if defined(__linux__)
    if (bytes >= bytes_min) {
        ::munmap(block, bytes);
        return;
    }
#endif
    ::operator delete(block);
}

template <class T>
struct Allocator {
    using value_type = T;

    Allocator() = default;
    template <class U>
    Allocator(const Allocator<U>&) {}

    T* allocate(std::size_t count) {
        if (count > static_cast<std::size_t>(-1) / 2 / sizeof(T))
            throw std::bad_array_new_length();
        return static_cast<T*>(take(count * sizeof(T)));
    }
    void deallocate(T* block, std::size_t count) noexcept { give(block, count * sizeof(T)); }
    template <class U>
    bool operator==(const Allocator<U>&) const {
        return true;
    }
};

} // namespace large

template <class T>
using LargeVector = std::vector<T, large::Allocator<T>>;

} // namespace seaway
