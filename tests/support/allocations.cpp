// SPDX-License-Identifier: Apache-2.0
#include "tests/support/allocations.h"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <new>

namespace {

constexpr std::size_t never = std::numeric_limits<std::size_t>::max();

thread_local std::size_t allocations = 0;
thread_local std::size_t fails_at = never; ///< this one

bool count_one() {
    return allocations++ != fails_at;
}

void* aligned(std::size_t alignment, std::size_t bytes) {
    void* memory = nullptr;
    return count_one() && ::posix_memalign(&memory, std::max(alignment, sizeof(void*)), bytes) == 0
               ? memory
               : nullptr;
}

} // namespace

// Asio takes memory for handlers so.
extern "C" __attribute__((visibility("default"))) void* aligned_alloc(std::size_t alignment,
                                                                      std::size_t bytes) noexcept {
    return aligned(alignment, bytes);
}

void* operator new(std::size_t bytes) {
    if (void* memory = count_one() ? std::malloc(bytes > 0 ? bytes : 1) : nullptr)
        return memory;
    throw std::bad_alloc();
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
    if (void* memory = aligned(static_cast<std::size_t>(alignment), bytes))
        return memory;
    throw std::bad_alloc();
}
// As algorithms that can do without ask for theirs: what one of these replaces has to be freed by it.
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
    return count_one() ? std::malloc(bytes > 0 ? bytes : 1) : nullptr;
}
void operator delete(void* memory) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
    std::free(memory);
}

namespace seaway::tests {

std::size_t allocations_of_this_thread() {
    return allocations;
}

NoMemoryOnce::NoMemoryOnce(std::size_t after) {
    fails_at = allocations + after;
}

NoMemoryOnce::~NoMemoryOnce() {
    fails_at = never;
}

} // namespace seaway::tests
