// SPDX-License-Identifier: Apache-2.0
#include "tests/support/allocations.h"

#include <cstdint>
#include <cstdlib>
#include <new>

namespace {

thread_local std::size_t allocations = 0;
thread_local std::size_t most_bytes = SIZE_MAX;

bool counted(std::size_t bytes) {
    ++allocations;
    return bytes <= most_bytes;
}

} // namespace

void* operator new(std::size_t bytes) {
    if (void* memory = counted(bytes) ? std::malloc(bytes > 0 ? bytes : 1) : nullptr)
        return memory;
    throw std::bad_alloc();
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
    const auto a = static_cast<std::size_t>(alignment);
    if (void* memory = counted(bytes) ? std::aligned_alloc(a, (bytes + a - 1) / a * a) : nullptr)
        return memory;
    throw std::bad_alloc();
}
// As algorithms that can do without ask for theirs: what one of these replaces has to be freed by it.
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
    return counted(bytes) ? std::malloc(bytes > 0 ? bytes : 1) : nullptr;
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

void refuse_larger_allocations(std::size_t bytes) {
    most_bytes = bytes;
}

} // namespace seaway::tests
